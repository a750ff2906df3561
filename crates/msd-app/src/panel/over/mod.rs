//! Boxes over the 3D view: divergence, gallery, lessons and tour.

mod failure;
mod gallery;
mod lessons;
mod guide;

use crate::viewer::Viewer;
use egui::Ui;

/// Shows the open boxes.
pub(super) fn show(ui: &Ui, viewer: &mut Viewer) {
    failure::show(ui, viewer);
    gallery::show(ui, viewer);
    lessons::show(ui, viewer);
    guide::show(ui, viewer);
}
