//! The host of a window: a desktop, or the page of a browser, each with ways of its own.

use super::Shell;
use super::error::Missing;
use crate::viewer::{Preferences, Viewer};
use msd_render::Gpu;
use winit::event::InnerSizeWriter;
use winit::event_loop::ActiveEventLoop;
use winit::window::{Window, WindowAttributes};

/// Where a window is.
pub(crate) trait Host: Sized {
    /// What it tells the window.
    type Event: 'static;
    /// Whether the program may end there without notice.
    const ENDS_UNNOTICED: bool;

    /// The host of a window that will show a viewer.
    fn new(viewer: &Viewer) -> Self;

    /// The attributes of the window there.
    fn attributes(
        viewer: &Viewer,
        event_loop: &ActiveEventLoop,
        attributes: WindowAttributes,
    ) -> WindowAttributes;

    /// Waits for a graphics device, here or in the background.
    fn wait(arrive: impl Future<Output = ()> + 'static);

    /// Takes note of the window that was made.
    fn take_window(&mut self, _window: &Window) {}

    /// Takes note of the device that the window is drawn with from now on.
    fn take_device(&mut self, _device: &wgpu::Device) {}

    /// Pixels of a point of the window, and how many times as many as winit goes by.
    fn points(&self, window: &Window) -> (f64, f32) {
        (window.scale_factor(), 1.0)
    }

    /// Takes note of other pixels of a point.
    fn rescale(&mut self, _window: &Window, _scale: f64, _writer: InnerSizeWriter) {}

    /// Keeps preferences until the next start.
    fn keep(preferences: &Preferences);

    /// Tells why there is no window.
    fn tell_missing(_what: &Missing) {}

    /// What the user did, as the panels are to read it.
    fn adapted(raw: egui::RawInput, _context: &egui::Context) -> egui::RawInput {
        raw
    }

    /// Follows a film that is being written.
    fn follow_film(_viewer: &mut Viewer, _context: &egui::Context) {}

    /// Draws what is not a part of the window yet.
    fn draw_beside(_viewer: &mut Viewer, _gpu: &Gpu, _context: &egui::Context) {}

    /// Comes before a frame; whether it takes its place.
    fn precede_frame(shell: &mut Shell) -> bool;

    /// Comes after a frame: keeps what the user would miss.
    fn follow_frame(shell: &mut Shell);

    /// Does what the host tells the window.
    fn hear(shell: &mut Shell, event_loop: &ActiveEventLoop, event: Self::Event);
}
