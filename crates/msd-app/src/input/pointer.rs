//! The pointer over the 3D view: what a press begins goes on until release.

use super::picking::pick;
use crate::viewer::{Action, Command, Gesture, Viewer};
use egui::{Context, PointerButton, Pos2};

/// Turn per point of motion, radians: half a turn over some 400 points.
const TURN: f32 = 0.008;
/// Exponent of the zoom per point of scrolling: a wheel click of 50 points zooms by a seventh.
const ZOOM: f32 = 0.003;

/// The state of the pointer in one frame.
struct Pointer {
    pressed: Option<PointerButton>,
    origin: Option<Pos2>,
    latest: Option<Pos2>,
    down: [bool; 3],
    shift: bool,
}

const BUTTONS: [PointerButton; 3] =
    [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle];

/// Applies what pointer, wheel and fingers did over the 3D view since the last frame.
///
/// Before anything is laid out, so by the place that the view had in the last frame, which is also
/// what egui goes by.
pub fn read_pointer(ctx: &Context, viewer: &mut Viewer) {
    let Some(view) = ctx.read_response(Viewer::view_id()) else { return };
    let pointer = ctx.input(|input| Pointer {
        pressed: BUTTONS.into_iter().find(|&button| input.pointer.button_pressed(button)),
        origin: input.pointer.press_origin(),
        latest: input.pointer.latest_pos(),
        down: BUTTONS.map(|button| input.pointer.button_down(button)),
        shift: input.modifiers.shift,
    });
    if let (Some(button), Some(origin)) = (pointer.pressed, pointer.origin)
        && viewer.gesture.is_none()
        && view.is_pointer_button_down_on()
    {
        start(viewer, button, origin, pointer.shift);
    }
    if view.long_touched() {
        viewer.command(Command::Pin);
    }
    if let Some(touch) = ctx.input(|input| input.multi_touch()) {
        end(viewer);
        viewer.camera.zoom(1.0 / touch.zoom_delta);
        let way = touch.translation_delta / viewer.rect.height();
        viewer.camera.pan(way.x, way.y);
    }
    if let Some(latest) = pointer.latest {
        follow(viewer, latest);
    }
    let is_down = |button| BUTTONS.iter().zip(pointer.down).any(|(&b, down)| b == button && down);
    // After the motion: what is let go keeps the speed of the last one.
    if viewer.gesture.is_some_and(|gesture| !is_down(gesture.button)) {
        end(viewer);
    }
    if view.hovered() {
        zoom(ctx, viewer);
    }
    let idle = viewer.gesture.is_none() && view.hovered();
    let at = pointer.latest.filter(|_| idle);
    viewer.hovered = at.and_then(|at| pick(&viewer.viewport(), viewer.session.runner(), at));
}

fn start(viewer: &mut Viewer, button: PointerButton, at: Pos2, shift: bool) {
    let viewport = viewer.viewport();
    let wants_grab = button == PointerButton::Primary && !shift;
    let picked = if wants_grab { pick(&viewport, viewer.session.runner(), at) } else { None };
    let action = match (button, picked) {
        (_, Some(particle)) => {
            let position = viewer.session.position(particle);
            let through = position.as_vec3();
            viewer.session.grab(particle, position);
            viewer.hint = false;
            Action::Grab { through, offset: through - viewport.drag_point(at, through) }
        }
        (PointerButton::Middle, _) => Action::Pan,
        _ if shift => Action::Pan,
        _ => Action::Orbit,
    };
    viewer.gesture = Some(Gesture { button, last: at, action });
}

fn follow(viewer: &mut Viewer, latest: Pos2) {
    let viewport = viewer.viewport();
    let Some(gesture) = &mut viewer.gesture else { return };
    let way = latest - gesture.last;
    gesture.last = latest;
    match gesture.action {
        Action::Orbit => viewer.camera.orbit(way.x * TURN, way.y * TURN),
        Action::Pan => {
            let way = way / viewer.rect.height();
            viewer.camera.pan(way.x, way.y);
        }
        Action::Grab { through, offset } => {
            let target = viewport.drag_point(latest, through) + offset;
            viewer.session.move_grab(target.as_dvec3());
        }
    }
}

fn end(viewer: &mut Viewer) {
    if let Some(Gesture { action: Action::Grab { .. }, .. }) = viewer.gesture.take() {
        viewer.session.release();
    }
}

fn zoom(ctx: &Context, viewer: &mut Viewer) {
    let (scroll, pinch) = ctx.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
    viewer.camera.zoom((-scroll * ZOOM).exp() / pinch);
}
