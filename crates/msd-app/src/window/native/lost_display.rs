//! A display that goes away while the window is open: the run is kept.
//!
//! The library of X11 prints a line and ends the program, in the middle of a call. What is left to
//! do then is done by a value of the main thread, which is dropped while the program ends.

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

/// Keeps the run of a window that is open when the program ends.
struct Keeper(RefCell<Option<Rc<RefCell<Shell>>>>);

impl Drop for Keeper {
    fn drop(&mut self) {
        let Some(shell) = self.0.take() else { return };
        // Nothing can be told of a second fault in here.
        let keep = || shell.try_borrow_mut().ok().map(|mut shell| shell.leave());
        if let Ok(Some(kept)) = catch_unwind(AssertUnwindSafe(keep)) {
            tell(&format!("the display went away; {kept}"));
        }
    }
}

impl Shell {
    /// Keeps what there is where the display is gone, and returns what became of the run. The
    /// window is not asked for its size any more.
    pub(super) fn leave(&mut self) -> String {
        let size = self.viewer.preferences.size.unwrap_or(SIZE);
        let scale = self.context.zoom_factor() / self.host.stretch;
        preferences_file::write(self.viewer.remember(size, scale));
        self.viewer.session.stop_recording();
        kept(&self.viewer)
    }
}

/// Watches over a window from now on.
pub(super) fn watch(shell: &Rc<RefCell<Shell>>) {
    KEEPER.with(|keeper| keeper.0.replace(Some(shell.clone())));
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let is_of_winit = panic.location().is_some_and(|at| at.file().contains("winit"));
        if !is_of_winit || !is_loss(panic.payload()) {
            return hook(panic);
        }
        let display = std::env::var("DISPLAY").unwrap_or_default();
        tell(&format!("the connection to display {display} is broken"));
        // In the middle of a frame it ends where that does, see [`Lent`].
        let is_idle =
            |keeper: &Keeper| keeper.0.borrow().as_ref().is_none_or(|it| it.try_borrow().is_ok());
        if KEEPER.with(is_idle) {
            end();
        }
    }));
}

/// A window that is closed in order is not watched over any more.
pub(super) fn unwatch() {
    KEEPER.with(|keeper| keeper.0.take());
}

/// Whether winit, where it is the first to meet it, panics as the display is gone.
fn is_loss(payload: &(dyn std::any::Any + Send)) -> bool {
    panic_text(payload).contains("Connection(")
}

/// Ends the program as the library of X11 does: what is left of the window cannot be closed in
/// order.
fn end() -> ! {
    std::process::exit(1)
}

fn tell(line: &str) {
    writeln!(std::io::stderr(), "{line}").ok();
}

/// What a panic says, in one line.
pub(super) fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    plain(text.unwrap_or("a library of the window system is missing"))
}

/// One line without the place in winit's source, which is of no use to the user.
pub(super) fn plain(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    let told = line.rsplit_once("rs:").and_then(|(_, rest)| rest.split_once(": "));
    told.map_or(line, |(_, rest)| rest).trim_end_matches('.').to_owned()
}

/// A window that is lent to the loop of events, call by call.
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
