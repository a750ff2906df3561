//! A display that goes away while the window is open: the run is kept.
//!
//! The library of X11 prints a line and ends the program, in the middle of a call. What is left to
//! do then is done by a value of the main thread, which is dropped while the program ends.

use super::native::panic_text;
use super::{Arrival, Shell};
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
        // In the middle of a frame it ends where that does, see [`Held`].
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

/// A window that is lent to the loop of events, call by call.
pub(super) struct Held(pub(super) Rc<RefCell<Shell>>);

impl Held {
    fn lend(&self, act: impl FnOnce(&mut Shell)) {
        let done = catch_unwind(AssertUnwindSafe(|| act(&mut self.0.borrow_mut())));
        match done {
            Ok(()) => {}
            Err(payload) if is_loss(&*payload) => end(),
            Err(payload) => resume_unwind(payload),
        }
    }
}

impl ApplicationHandler<Arrival> for Held {
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
