//! The window for screen readers and automation, through AccessKit.

use super::{Arrival, Shell};
use egui_winit::accesskit_winit::{Event, WindowEvent};
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

impl From<Event> for Arrival {
    fn from(event: Event) -> Self {
        Arrival::Accessibility(event.window_event)
    }
}

impl Shell {
    /// Announces the window to the accessibility API, then shows it.
    pub(super) fn make_accessible(&mut self, event_loop: &ActiveEventLoop, window: &Window) {
        if let Some(input) = &mut self.input {
            input.init_accesskit(event_loop, window, self.proxy.clone());
        }
        window.set_visible(true);
    }

    /// Handles a request of a screen reader in the next frame.
    pub(super) fn serve(&mut self, wish: WindowEvent) {
        let (Some(window), Some(input)) = (&self.window, &mut self.input) else { return };
        match wish {
            WindowEvent::InitialTreeRequested => self.context.enable_accesskit(),
            WindowEvent::ActionRequested(request) => input.on_accesskit_action_request(request),
            WindowEvent::AccessibilityDeactivated => self.context.disable_accesskit(),
        }
        window.request_redraw();
    }
}
