//! The clipboard of a page; the browser handles pasting.

use super::page::tell;
use egui::OutputCommand;
use winit::event::WindowEvent;

/// The clipboard of a page.
pub(in crate::window) struct PageClipboard;

impl PageClipboard {
    /// Returns the clipboard of the page of a window.
    pub(in crate::window) fn of<T>(_: &T) -> Self {
        PageClipboard
    }

    /// Passes the copied text of a frame to the page.
    pub(in crate::window) fn copy(&mut self, commands: &[OutputCommand]) -> Result<(), String> {
        for command in commands {
            if let OutputCommand::CopyText(text) = command {
                tell("copy", text);
            }
        }
        Ok(())
    }

    /// Does nothing: the browser sends an event with the pasted text.
    pub(in crate::window) fn offer(&mut self, _: &WindowEvent, _: &mut egui_winit::State) {}
}
