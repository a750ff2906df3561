//! The clipboard of the desktop, for text. egui-winit's own way to it also copies pictures, and
//! takes a package with all their formats along; on Wayland it has another way, and keeps it.

use egui::OutputCommand;
use winit::event::{ElementState, WindowEvent};
use winit::keyboard::{Key, ModifiersState, NamedKey};
use winit::raw_window_handle::{HasDisplayHandle, RawDisplayHandle};

/// The clipboard, and the keys that are held.
pub(in crate::window) struct Clipboard {
    /// The clipboard, or why there is none; nothing where egui-winit sees to it.
    text: Option<Result<arboard::Clipboard, String>>,
    held: ModifiersState,
}

impl Clipboard {
    /// The clipboard of the display that a window is on.
    pub(in crate::window) fn of(display: &impl HasDisplayHandle) -> Self {
        let handle = display.display_handle().map(|handle| handle.as_raw());
        let is_wayland = matches!(handle, Ok(RawDisplayHandle::Wayland(_)));
        let text =
            (!is_wayland).then(|| arboard::Clipboard::new().map_err(|error| error.to_string()));
        Clipboard { text, held: ModifiersState::empty() }
    }

    /// Takes over what a frame copied.
    ///
    /// # Errors
    /// A line on why it could not.
    pub(in crate::window) fn copy(&mut self, commands: &[OutputCommand]) -> Result<(), String> {
        let Some(clipboard) = &mut self.text else { return Ok(()) };
        for command in commands {
            let OutputCommand::CopyText(text) = command else { continue };
            let set = clipboard.as_mut().map_err(|why| why.clone());
            set.and_then(|clipboard| clipboard.set_text(text).map_err(|error| error.to_string()))
                .map_err(|why| format!("nothing was copied: {why}"))?;
        }
        Ok(())
    }

    /// Hands over the text that an event is about to paste, before egui-winit reads the event.
    pub(in crate::window) fn offer(&mut self, event: &WindowEvent, input: &mut egui_winit::State) {
        let Some(Ok(clipboard)) = &mut self.text else { return };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_could_not_be_copied_is_told() {
        let text = Some(Err("there is no clipboard".to_owned()));
        let mut clipboard = Clipboard { text, held: ModifiersState::empty() };
        assert_eq!(clipboard.copy(&[]), Ok(()));
        let why = clipboard.copy(&[OutputCommand::CopyText("a link".into())]);
        assert_eq!(why, Err("nothing was copied: there is no clipboard".into()));
    }
}
