//! Display loss while the window is open: the run is saved.
//!
//! The X11 library prints a line and exits the program, in the middle of a call. A thread-local
//! value of the main thread then saves the run: its `drop` runs during the exit.

use super::super::{Arrival, Shell, kept};
use super::preferences_file;
use super::scale::SIZE;
use std::cell::RefCell;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::rc::Rc;
use winit::application::ApplicationHandler;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::ActiveEventLoop;
use winit::window::WindowId;

thread_local! {
    static KEEPER: Keeper = const { Keeper(RefCell::new(None)) };
}

/// Saves the run of a window that is open when the program exits.
struct Keeper(RefCell<Option<Rc<RefCell<Shell>>>>);

impl Drop for Keeper {
    fn drop(&mut self) {
        let Some(shell) = self.0.take() else { return };
        // A second fault here cannot be reported.
        let keep = || shell.try_borrow_mut().ok().map(|mut shell| shell.leave());
        if let Ok(Some(kept)) = catch_unwind(AssertUnwindSafe(keep)) {
            tell(&format!("the display was lost; {kept}"));
        }
    }
}

impl Shell {
    /// Stores recording, preferences and run after a loss of the display, and returns the message
    /// about the run. The window can no longer report its size.
    pub(super) fn leave(&mut self) -> String {
        let size = self.viewer.preferences.size.unwrap_or(SIZE);
        let scale = self.context.zoom_factor() / self.host.stretch;
        preferences_file::write(self.viewer.remember(size, scale));
        self.viewer.session.stop_recording();
        kept(&self.viewer)
    }
}

/// Guards a window from now on.
pub(super) fn watch(shell: &Rc<RefCell<Shell>>) {
    KEEPER.with(|keeper| keeper.0.replace(Some(shell.clone())));
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let is_of_winit = panic.location().is_some_and(|at| at.file().contains("winit"));
        if !is_of_winit || !is_loss(panic.payload()) {
            return hook(panic);
        }
        let display = std::env::var("DISPLAY").unwrap_or_default();
        tell(&format!("the connection to display {display} was lost"));
        // During a frame, the program exits at its end, see [`Lent`].
        let is_idle =
            |keeper: &Keeper| keeper.0.borrow().as_ref().is_none_or(|it| it.try_borrow().is_ok());
        if KEEPER.with(is_idle) {
            end();
        }
    }));
}

/// Ends the guard of a window that closes normally.
pub(super) fn unwatch() {
    KEEPER.with(|keeper| keeper.0.take());
}

/// Returns whether winit panics because of the display loss, if it notices the loss first.
fn is_loss(payload: &(dyn std::any::Any + Send)) -> bool {
    panic_text(payload).contains("Connection(")
}

/// Exits the program, as the X11 library does: the rest of the window cannot be closed normally.
fn end() -> ! {
    std::process::exit(1)
}

fn tell(line: &str) {
    writeln!(std::io::stderr(), "{line}").ok();
}

/// Returns the message of a panic in one line.
pub(super) fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    plain(text.unwrap_or("a library of the window system is missing"))
}

/// Returns one line without the location in winit's source, which does not help the user.
pub(super) fn plain(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    let told = line.rsplit_once("rs:").and_then(|(_, rest)| rest.split_once(": "));
    told.map_or(line, |(_, rest)| rest).trim_end_matches('.').to_owned()
}

/// A window that is lent to the event loop, call by call.
pub(super) struct Lent(pub(super) Rc<RefCell<Shell>>);

impl Lent {
    fn lend(&self, act: impl FnOnce(&mut Shell)) {
        let done = catch_unwind(AssertUnwindSafe(|| act(&mut self.0.borrow_mut())));
        match done {
            Ok(()) => {}
            Err(payload) if is_loss(&*payload) => end(),
            Err(payload) => resume_unwind(payload),
        }
    }
}

impl ApplicationHandler<Arrival> for Lent {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        self.lend(|shell| shell.resumed(event_loop));
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, arrival: Arrival) {
        self.lend(|shell| shell.user_event(event_loop, arrival));
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        self.lend(|shell| shell.window_event(event_loop, id, event));
    }

    fn new_events(&mut self, event_loop: &ActiveEventLoop, cause: StartCause) {
        self.lend(|shell| shell.new_events(event_loop, cause));
    }

    fn exiting(&mut self, event_loop: &ActiveEventLoop) {
        self.lend(|shell| shell.exiting(event_loop));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_in_the_source_is_left_out() {
        let text = "os error at /home/u/winit/src/linux/mod.rs:765: neither A nor B is set.";
        assert_eq!(plain(text), "neither A nor B is set");
        assert_eq!(
            plain("Library libx.so could not be loaded."),
            "Library libx.so could not be loaded"
        );
    }
}
