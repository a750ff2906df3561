//! The panels before they are shown, piece by piece: the first layout of all of them draws their
//! letters and, in a browser, has their code compiled, which takes too long for one frame.

use super::{energy, live_error, material, run, scenes, solver, status, timeline, trade, twin};
use crate::viewer::Viewer;
use egui::Ui;

/// What is laid out in a frame of its own.
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

/// Lays out a piece of the panels, and returns whether there was one to lay out.
pub fn rehearse(ui: &mut Ui, viewer: &mut Viewer, piece: usize) -> bool {
    PIECES.get(piece).map(|show| show(ui, viewer)).is_some()
}
