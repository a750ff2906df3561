//! Boxes over the 3D view: that of a run that stopped by itself, the gallery and the guide.

mod failure;
mod gallery;
mod guide;

use crate::viewer::Viewer;
use egui::Ui;

/// Shows those that are there.
pub(super) fn show(ui: &Ui, viewer: &mut Viewer) {
    failure::show(ui, viewer);
    gallery::show(ui, viewer);
    guide::show(ui, viewer);
}
