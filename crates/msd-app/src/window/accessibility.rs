//! The window for screen readers and for what presses its buttons, through AccessKit.

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
    /// Tells the desktop that the window can be read, and shows it.
    pub(super) fn make_accessible(&mut self, event_loop: &ActiveEventLoop, window: &Window) {
        if let Some(input) = &mut self.input {
            input.init_accesskit(event_loop, window, self.proxy.clone());
        }
        window.set_visible(true);
    }

    /// Does what a screen reader asks for, in the next frame.
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
