//! The clipboard of a page, which the browser sees to when it pastes.

use super::page::tell;
use egui::OutputCommand;
use winit::event::WindowEvent;

/// The clipboard of a page.
pub(in crate::window) struct PageClipboard;

impl PageClipboard {
    /// The clipboard of the page that a window is on.
    pub(in crate::window) fn of<T>(_: &T) -> Self {
        PageClipboard
    }

    /// Hands what a frame copied to the page.
    pub(in crate::window) fn copy(&mut self, commands: &[OutputCommand]) -> Result<(), String> {
        for command in commands {
            if let OutputCommand::CopyText(text) = command {
                tell("copy", text);
            }
        }
        Ok(())
    }

    /// Does nothing: a browser tells of what is pasted.
    pub(in crate::window) fn offer(&mut self, _: &WindowEvent, _: &mut egui_winit::State) {}
}
