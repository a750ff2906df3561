//! The pointer over the 3D view: a press begins a gesture that lasts until release.

use super::picking::{Taken, pick_any};
use super::stroke::{crossed, inside};
use crate::viewer::{Action, Command, Gesture, Side, Tool, Viewer};
use egui::{Context, Modifiers, PointerButton, Pos2, Rect};
use msd_core::Vector;
use msd_run::on;

/// Rotation per point of motion, radians: half a turn takes some 400 points.
const TURN: f32 = 0.008;
/// Exponent of the zoom per point of scrolling: a wheel click of 50 points zooms by a seventh.
const ZOOM: f32 = 0.003;

/// The state of the pointer in one frame.
struct Pointer {
    pressed: Option<PointerButton>,
    origin: Option<Pos2>,
    latest: Option<Pos2>,
    down: [bool; 3],
    modifiers: Modifiers,
}

const BUTTONS: [PointerButton; 3] =
    [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle];

/// Applies the input of pointer, wheel and fingers over the 3D view since the last frame.
///
/// Runs before the layout, with the rectangle of the view from the last frame. egui's hit test uses
/// the same one.
pub fn read_pointer(ctx: &Context, viewer: &mut Viewer) {
    read_hands(ctx, viewer);
    let Some(view) = ctx.read_response(Viewer::view_id()) else { return };
    let pointer = ctx.input(|input| Pointer {
        pressed: BUTTONS.into_iter().find(|&button| input.pointer.button_pressed(button)),
        origin: input.pointer.press_origin(),
        latest: input.pointer.latest_pos(),
        down: BUTTONS.map(|button| input.pointer.button_down(button)),
        modifiers: input.modifiers,
    });
    if let (Some(button), Some(origin)) = (pointer.pressed, pointer.origin)
        && viewer.hand.gesture.is_none()
        && view.is_pointer_button_down_on()
    {
        start(viewer, button, origin, pointer.modifiers);
    }
    if view.long_touched() {
        viewer.command(Command::Pin);
    }
    if let Some(touch) = ctx.input(|input| input.multi_touch()) {
        end(viewer);
        viewer.camera.zoom(1.0 / touch.zoom_delta);
        let way = touch.translation_delta / viewer.layout.rect.height();
        viewer.camera.pan(way.x, way.y);
    }
    if let Some(latest) = pointer.latest {
        follow(viewer, latest);
    }
    let is_down = |button| BUTTONS.iter().zip(pointer.down).any(|(&b, down)| b == button && down);
    // After the motion, so that a released object keeps its latest speed.
    if viewer.hand.gesture.is_some_and(|gesture| !is_down(gesture.button)) {
        end(viewer);
    }
    if view.hovered() {
        zoom(ctx, viewer);
    }
    let idle = viewer.hand.gesture.is_none() && view.hovered();
    let at = pointer.latest.filter(|_| idle);
    let taken = at.and_then(|at| pick_at(viewer, viewer.side_at(at), at));
    (viewer.hand.hovered, viewer.hand.hovered_solid) = match taken {
        Some(Taken::Particle(particle)) => (Some(particle), None),
        Some(Taken::Solid(solid, _)) => (None, Some(solid)),
        None => (None, None),
    };
}

/// Passes presses and held buttons or keys to the session, those over the panels too.
fn read_hands(ctx: &Context, viewer: &mut Viewer) {
    let (presses, holds) = ctx.input(|input| {
        let holds = input.pointer.any_down() || !input.keys_down.is_empty();
        (input.pointer.any_pressed(), holds)
    });
    viewer.session.follow_hands(presses, holds || ctx.text_edit_focused());
}

/// Returns the object of one side of the view under a point of the window.
fn pick_at(viewer: &Viewer, side: Side, at: Pos2) -> Option<Taken> {
    pick_any(&viewer.viewport_of(side), viewer.runner_of(side), at)
}

fn start(viewer: &mut Viewer, button: PointerButton, at: Pos2, modifiers: Modifiers) {
    let action = match button {
        PointerButton::Primary if !modifiers.shift => {
            let tool = if modifiers.command { Tool::Select } else { viewer.hand.tool };
            start_tool(viewer, tool, at)
        }
        PointerButton::Middle => Action::Pan,
        _ if modifiers.shift => Action::Pan,
        _ => Action::Orbit,
    };
    viewer.hand.gesture = Some(Gesture { button, last: at, side: viewer.side_at(at), action });
}

fn start_tool(viewer: &mut Viewer, tool: Tool, at: Pos2) -> Action {
    let side = viewer.side_at(at);
    match tool {
        Tool::Select => return Action::Select { from: at },
        Tool::Cut => {
            viewer.hand.stroke.push(at);
            return Action::Cut;
        }
        Tool::Grab => {}
    }
    let Some(taken) = pick_at(viewer, side, at) else {
        return Action::Orbit;
    };
    let viewport = viewer.viewport_of(side);
    let (through, target) = match taken {
        Taken::Particle(particle) => {
            let runner = viewer.runner_of(side);
            let position = on!(runner, simulation => simulation.position(particle).to_f64());
            viewer.session.grab(particle, position);
            (position.as_vec3(), position)
        }
        Taken::Solid(solid, through) => {
            viewer.session.grab_solid(solid);
            (through, viewer.session.grab_target().unwrap_or_default())
        }
    };
    viewer.layout.hint = false;
    Action::Grab { through, offset: target.as_vec3() - viewport.drag_point(at, through) }
}

fn follow(viewer: &mut Viewer, latest: Pos2) {
    let Some(gesture) = &mut viewer.hand.gesture else { return };
    let last = std::mem::replace(&mut gesture.last, latest);
    let gesture = *gesture;
    let viewport = viewer.viewport_of(gesture.side);
    let way = latest - last;
    match gesture.action {
        Action::Orbit => viewer.camera.orbit(way.x * TURN, way.y * TURN),
        Action::Pan => {
            let way = way / viewer.layout.rect.height();
            viewer.camera.pan(way.x, way.y);
        }
        Action::Select { .. } => {}
        Action::Cut if latest == last => {}
        Action::Cut => {
            // Panels hide the springs behind them, so the stroke ends at the edge of the view.
            let [last, latest] = [last, latest].map(|at| viewport.rect.clamp(at));
            viewer.hand.stroke.push(latest);
            let springs = crossed(&viewport, viewer.runner_of(gesture.side), [last, latest]);
            viewer.session.cut(&springs);
        }
        Action::Grab { through, offset } => {
            let target = viewport.drag_point(latest, through) + offset;
            viewer.session.move_grab(target.as_dvec3());
        }
    }
}

fn end(viewer: &mut Viewer) {
    let Some(Gesture { action, last, side, .. }) = viewer.hand.gesture.take() else { return };
    viewer.hand.stroke.clear();
    match action {
        Action::Grab { .. } => viewer.session.release(),
        Action::Select { from } => {
            let viewport = viewer.viewport_of(side);
            let area = Rect::from_two_pos(from, last).intersect(viewport.rect);
            let particles = inside(&viewport, viewer.runner_of(side), area);
            viewer.session.select_group(particles);
            // The next drag moves the chosen group.
            viewer.hand.tool = Tool::Grab;
        }
        Action::Orbit | Action::Pan | Action::Cut => {}
    }
}

fn zoom(ctx: &Context, viewer: &mut Viewer) {
    let (scroll, pinch) = ctx.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
    viewer.camera.zoom((-scroll * ZOOM).exp() / pinch);
}
