//! The clipboard of the desktop, for text. egui-winit's own way to it also copies pictures, and
//! takes a package with all their formats along; on Wayland it has another way, and keeps it.

use egui::OutputCommand;
use winit::event::{ElementState, WindowEvent};
use winit::keyboard::{Key, ModifiersState, NamedKey};
use winit::raw_window_handle::{HasDisplayHandle, RawDisplayHandle};

/// The clipboard, and the keys that are held.
pub(super) struct Clipboard {
    /// Nothing where egui-winit sees to it or there is none.
    text: Option<arboard::Clipboard>,
    held: ModifiersState,
}

impl Clipboard {
    /// The clipboard of the display that a window is on.
    pub(super) fn of(display: &impl HasDisplayHandle) -> Self {
        let handle = display.display_handle().map(|handle| handle.as_raw());
        let is_wayland = matches!(handle, Ok(RawDisplayHandle::Wayland(_)));
        let text = if is_wayland { None } else { arboard::Clipboard::new().ok() };
        Clipboard { text, held: ModifiersState::empty() }
    }

    /// Takes over what a frame copied.
    pub(super) fn copy(&mut self, commands: &[OutputCommand]) {
        let Some(clipboard) = &mut self.text else { return };
        for command in commands {
            if let OutputCommand::CopyText(text) = command
                && let Err(error) = clipboard.set_text(text)
            {
                log::error!("the clipboard did not take the text: {error}");
            }
        }
    }

    /// Hands over the text that an event is about to paste, before egui-winit reads the event.
    pub(super) fn offer(&mut self, event: &WindowEvent, input: &mut egui_winit::State) {
        let Some(clipboard) = &mut self.text else { return };
        if let WindowEvent::ModifiersChanged(held) = event {
            self.held = held.state();
        }
        if pastes(event, self.held) {
            // What is no text cannot be pasted, nor what was copied before it.
            input.set_clipboard_text(clipboard.get_text().unwrap_or_default());
        }
    }
}

/// Whether an event may paste, by the keys that egui-winit knows.
fn pastes(event: &WindowEvent, held: ModifiersState) -> bool {
    let WindowEvent::KeyboardInput { event, .. } = event else { return false };
    let is_letter = || match &event.logical_key {
        Key::Character(text) => text.eq_ignore_ascii_case("v") || !text.is_ascii(),
        _ => false,
    };
    event.state == ElementState::Pressed
        && match event.logical_key {
            Key::Named(NamedKey::Paste) => true,
            Key::Named(NamedKey::Insert) => held.shift_key(),
            _ => is_letter() && (held.control_key() || held.super_key()),
        }
}
