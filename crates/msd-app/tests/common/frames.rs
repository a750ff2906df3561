//! Shared by the tests of the window's logic: a scene in a session, and frames that pass.
#![allow(dead_code)] // each test binary uses its own part of this file

use msd_app::input::read_pointer;
use msd_app::panel;
use msd_app::session::Session;
use msd_app::viewer::Viewer;
use msd_scene::Loaded;

pub const FRAME: f64 = 1.0 / 60.0;

pub fn loaded(name: &str) -> Loaded {
    msd_scene::open(name).expect("a built-in scene")
}

pub fn session(name: &str) -> Session {
    let mut session = Session::new(loaded(name)).expect("a valid scene");
    // The first frame after a start owes nothing.
    session.advance(0.0, &|| 0.0);
    session
}

/// Lets frames of a sixtieth of a second pass on a machine whose steps cost nothing.
pub fn run(session: &mut Session, frames: usize) {
    (0..frames).for_each(|_| {
        // A hair more than a step: sums of 1/60 fall short of whole steps by rounding.
        session.advance(FRAME + 1e-9, &|| 0.0);
    });
}

/// A frame as the window has it, without time.
pub fn frame(ui: &mut egui::Ui, viewer: &mut Viewer) {
    read_pointer(ui.ctx(), viewer);
    panel::show(ui, viewer);
}
