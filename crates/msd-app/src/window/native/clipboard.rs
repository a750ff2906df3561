//! The clipboard of the desktop, for text. egui-winit's own also copies images, which takes a
//! package with all their formats. On Wayland, egui-winit's separate implementation stays in use.

use egui::OutputCommand;
use winit::event::{ElementState, WindowEvent};
use winit::keyboard::{Key, ModifiersState, NamedKey};
use winit::raw_window_handle::{HasDisplayHandle, RawDisplayHandle};

/// The clipboard, and the pressed modifiers.
pub(in crate::window) struct Clipboard {
    /// The clipboard, or why there is none; `None` if egui-winit handles it.
    text: Option<Result<arboard::Clipboard, String>>,
    held: ModifiersState,
}

impl Clipboard {
    /// Opens the clipboard for the display of a window.
    pub(in crate::window) fn of(display: &impl HasDisplayHandle) -> Self {
        let handle = display.display_handle().map(|handle| handle.as_raw());
        let is_wayland = matches!(handle, Ok(RawDisplayHandle::Wayland(_)));
        let text =
            (!is_wayland).then(|| arboard::Clipboard::new().map_err(|error| error.to_string()));
        Clipboard { text, held: ModifiersState::empty() }
    }

    /// Copies the text of a frame.
    ///
    /// # Errors
    /// A line on why the copy failed.
    pub(in crate::window) fn copy(&mut self, commands: &[OutputCommand]) -> Result<(), String> {
        let Some(clipboard) = &mut self.text else { return Ok(()) };
        for command in commands {
            let OutputCommand::CopyText(text) = command else { continue };
            let set = clipboard.as_mut().map_err(|why| why.clone());
            set.and_then(|clipboard| clipboard.set_text(text).map_err(|error| error.to_string()))
                .map_err(|why| format!("copying failed: {why}"))?;
        }
        Ok(())
    }

    /// Provides the text for an event that may paste, before egui-winit reads the event.
    pub(in crate::window) fn offer(&mut self, event: &WindowEvent, input: &mut egui_winit::State) {
        let Some(Ok(clipboard)) = &mut self.text else { return };
        if let WindowEvent::ModifiersChanged(held) = event {
            self.held = held.state();
        }
        if pastes(event, self.held) {
            // Clears an earlier text if the clipboard does not contain text.
            input.set_clipboard_text(clipboard.get_text().unwrap_or_default());
        }
    }
}

/// Returns whether an event may paste, by the keys that egui-winit knows.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_could_not_be_copied_is_told() {
        let text = Some(Err("there is no clipboard".to_owned()));
        let mut clipboard = Clipboard { text, held: ModifiersState::empty() };
        assert_eq!(clipboard.copy(&[]), Ok(()));
        let why = clipboard.copy(&[OutputCommand::CopyText("a link".into())]);
        assert_eq!(why, Err("copying failed: there is no clipboard".into()));
    }
}
