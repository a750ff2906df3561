//! Files that are dropped onto the window.

use crate::viewer::Viewer;
use egui::RawInput;

/// Opens the files that were dropped since the last frame; of several the last one stays.
///
/// Wayland passes on no dropped files.
pub fn take_drops(input: &RawInput, viewer: &mut Viewer) {
    for file in &input.dropped_files {
        viewer.open_path(file.path());
    }
}
