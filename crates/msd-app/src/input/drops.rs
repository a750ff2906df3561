//! Files dropped onto the window.

use crate::viewer::Viewer;
use egui::RawInput;

/// Opens the files dropped since the last frame; the last of several wins.
///
/// On Wayland no dropped files arrive.
pub fn take_drops(input: &RawInput, viewer: &mut Viewer) {
    for file in &input.dropped_files {
        viewer.open_path(file.path());
    }
}
