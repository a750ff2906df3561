//! Boxes over the 3D view that a user opens and closes: the gallery and the guide.

mod gallery;
mod guide;

use crate::viewer::Viewer;
use egui::Ui;

/// Shows those that are open.
pub(super) fn show(ui: &Ui, viewer: &mut Viewer) {
    gallery::show(ui, viewer);
    guide::show(ui, viewer);
}
