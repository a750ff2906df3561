//! Hidden layout of the panels, piece by piece. The first layout rasterizes glyphs and, in a
//! browser, compiles code, which takes too long for a single frame.

use super::{energy, live_error, material, run, scenes, solver, status, timeline, trade, twin};
use crate::viewer::Viewer;
use egui::Ui;

/// Pieces that are laid out in one frame each.
const PIECES: [fn(&mut Ui, &mut Viewer); 8] = [
    |ui, viewer| _ = status::show(ui, viewer),
    |ui, viewer| _ = scenes::show(ui, viewer),
    |ui, viewer| {
        run::show(ui, viewer);
        twin::show(ui, viewer);
    },
    |ui, viewer| _ = material::show(ui, viewer),
    |ui, viewer| _ = solver::show(ui, viewer),
    |ui, viewer| {
        trade::switch(ui, viewer);
        live_error::show(ui, viewer);
    },
    |ui, viewer| _ = energy::show(ui, viewer),
    |ui, viewer| _ = timeline::show(ui, viewer),
];

/// Lays out a piece of the panels, and returns whether it exists.
pub fn rehearse(ui: &mut Ui, viewer: &mut Viewer, piece: usize) -> bool {
    PIECES.get(piece).map(|show| show(ui, viewer)).is_some()
}
