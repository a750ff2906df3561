//! What does the mouse do in the 3D view? Decided when a button is pressed, held until release.

use crate::gesture::{Action, Gesture};
use crate::viewer::Viewer;
use egui::{PointerButton, Pos2, Response, Ui};

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
pub(crate) fn handle(ui: &Ui, viewer: &mut Viewer, view: &Response) {
    let pointer = ui.input(|input| Pointer {
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
    if let Some(touch) = ui.input(|input| input.multi_touch()) {
        end(viewer);
        viewer.camera.zoom(1.0 / touch.zoom_delta);
        let way = touch.translation_delta / viewer.rect.height();
        viewer.camera.pan(way.x, way.y);
    }
    if let Some(latest) = pointer.latest {
        follow(viewer, latest);
    }
    let is_down = |button| BUTTONS.iter().zip(pointer.down).any(|(&b, down)| b == button && down);
    // After the motion: what was let go of keeps the speed of the last one.
    if viewer.gesture.is_some_and(|gesture| !is_down(gesture.button)) {
        end(viewer);
    }
    if view.hovered() {
        zoom(ui, viewer);
    }
    let idle = viewer.gesture.is_none() && view.hovered();
    let at = pointer.latest.filter(|_| idle);
    viewer.hovered = at.and_then(|at| viewer.lens().pick(viewer.session.runner(), at));
}

fn start(viewer: &mut Viewer, button: PointerButton, at: Pos2, shift: bool) {
    let lens = viewer.lens();
    let wants_hold = button == PointerButton::Primary && !shift;
    let picked = if wants_hold { lens.pick(viewer.session.runner(), at) } else { None };
    let action = match (button, picked) {
        (_, Some(particle)) => {
            let position = viewer.session.position(particle);
            let through = position.as_vec3();
            viewer.session.grab(particle, position);
            viewer.hint = false;
            Action::Hold { through, offset: through - lens.drag_point(at, through) }
        }
        (PointerButton::Middle, _) => Action::Pan,
        _ if shift => Action::Pan,
        _ => Action::Orbit,
    };
    viewer.gesture = Some(Gesture { button, last: at, action });
}

fn follow(viewer: &mut Viewer, latest: Pos2) {
    let lens = viewer.lens();
    let Some(gesture) = &mut viewer.gesture else { return };
    let way = latest - gesture.last;
    gesture.last = latest;
    match gesture.action {
        Action::Orbit => viewer.camera.orbit(way.x * TURN, way.y * TURN),
        Action::Pan => {
            let way = way / viewer.rect.height();
            viewer.camera.pan(way.x, way.y);
        }
        Action::Hold { through, offset } => {
            let target = lens.drag_point(latest, through) + offset;
            viewer.session.move_grab(target.as_dvec3());
        }
    }
}

fn end(viewer: &mut Viewer) {
    if let Some(Gesture { action: Action::Hold { .. }, .. }) = viewer.gesture.take() {
        viewer.session.release();
    }
}

fn zoom(ui: &Ui, viewer: &mut Viewer) {
    let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
    viewer.camera.zoom((-scroll * ZOOM).exp() / pinch);
}
