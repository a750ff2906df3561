//! The host of a window: a desktop, or the page of a browser.

use super::Shell;
use super::error::Missing;
use crate::viewer::{Preferences, Viewer};
use msd_render::Gpu;
use winit::event::InnerSizeWriter;
use winit::event_loop::ActiveEventLoop;
use winit::window::{Window, WindowAttributes};

/// The environment of a window.
pub(crate) trait Host: Sized {
    /// Type of its events for the window.
    type Event: 'static;
    /// Whether the program may be terminated without notice.
    const ENDS_UNNOTICED: bool;

    /// Creates the host of a window for a viewer.
    fn new(viewer: &Viewer) -> Self;

    /// Returns the attributes of the window.
    fn attributes(
        viewer: &Viewer,
        event_loop: &ActiveEventLoop,
        attributes: WindowAttributes,
    ) -> WindowAttributes;

    /// Waits for a graphics device, synchronously or in the background.
    fn wait(arrive: impl Future<Output = ()> + 'static);

    /// Receives the new window.
    fn take_window(&mut self, _window: &Window) {}

    /// Receives the graphics device of the window.
    fn take_device(&mut self, _device: &wgpu::Device) {}

    /// Returns the pixels per point, and their ratio to those of winit.
    fn points(&self, window: &Window) -> (f64, f32) {
        (window.scale_factor(), 1.0)
    }

    /// Handles a change of the pixels per point.
    fn rescale(&mut self, _window: &Window, _scale: f64, _writer: InnerSizeWriter) {}

    /// Stores preferences until the next start.
    fn keep(preferences: &Preferences);

    /// Reports why there is no window.
    fn tell_missing(_what: &Missing) {}

    /// Adapts the user input for the panels.
    fn adapted(raw: egui::RawInput, _context: &egui::Context) -> egui::RawInput {
        raw
    }

    /// Updates a film in progress.
    fn follow_film(_viewer: &mut Viewer, _context: &egui::Context) {}

    /// Renders images that are not a part of the window yet.
    fn draw_beside(_viewer: &mut Viewer, _gpu: &Gpu, _context: &egui::Context) {}

    /// Runs before a frame; returns whether it replaces the frame.
    fn precede_frame(shell: &mut Shell) -> bool;

    /// Runs after a frame: stores data that the user would miss.
    fn follow_frame(shell: &mut Shell);

    /// Handles an event of the host.
    fn hear(shell: &mut Shell, event_loop: &ActiveEventLoop, event: Self::Event);
}
