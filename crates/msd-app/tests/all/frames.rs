//! Helpers of the tests of the window's logic: a scene in a session, and frames.

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, RawInput, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::input::{read_pointer, take_commands};
use msd_app::panel::{self, theme};
use msd_app::session::Session;
use msd_app::viewer::Viewer;
use msd_scene::Loaded;

pub const FRAME: f64 = 1.0 / 60.0;

pub fn loaded(name: &str) -> Loaded {
    msd_scene::open(name).expect("a built-in scene")
}

pub fn session(name: &str) -> Session {
    let mut session = Session::new(loaded(name)).expect("a valid scene");
    // The first frame after a start takes no steps.
    session.advance(0.0, &|| 0.0);
    session
}

/// Runs frames of a sixtieth of a second on a machine with steps without cost.
pub fn run(session: &mut Session, frames: usize) {
    (0..frames).for_each(|_| {
        // Slightly more than a step: sums of 1/60 fall short of whole steps by rounding.
        session.advance(FRAME + 1e-9, &|| 0.0);
    });
}

/// Runs a frame of the window, without time.
pub fn frame(ui: &mut egui::Ui, viewer: &mut Viewer) {
    read_pointer(ui.ctx(), viewer);
    panel::show(ui, viewer);
}

/// Returns a window of a viewer with a size in points, without a display.
pub fn window(viewer: Viewer, size: impl Into<Vec2>) -> Harness<'static, Viewer> {
    let mut harness = Harness::builder().with_size(size.into()).build_ui_state(frame, viewer);
    theme::apply(&harness.ctx);
    harness.run_steps(3);
    harness
}

/// Clicks a control by its name.
pub fn click(harness: &mut Harness<'_, Viewer>, role: Role, label: &str) {
    harness.get_by_role_and_label(role, label).click();
    harness.run_steps(3);
}

/// Runs a frame in which a text is typed, key by key, as the window passes it on: shortcuts first,
/// the rest to egui.
pub fn type_in(harness: &mut Harness<'_, Viewer>, text: &str, key: Key) {
    let modifiers = Modifiers::NONE;
    let pressed = Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
    let events =
        if text.is_empty() { vec![pressed] } else { vec![pressed, Event::Text(text.into())] };
    let mut input = RawInput { events, ..RawInput::default() };
    let typing = harness.state().takes_keys(&harness.ctx);
    for command in take_commands(&mut input, typing) {
        harness.state_mut().command(command);
    }
    input.events.into_iter().for_each(|event| harness.event(event));
    harness.run_steps(2);
}
