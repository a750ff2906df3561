//! The progress of a long command, on standard error.

use super::Interrupt;
use crate::cli::failure::{is_quiet, note};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use msd_study::monitor::{Halt, Monitor, Progress};
use msd_study::quantity::rounded;
use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Delay before a command reports its activity.
const PATIENCE: Duration = Duration::from_secs(1);

/// Reports an activity that takes long, unless dropped within a second: on a terminal by a line
/// that counts the seconds and goes when dropped, elsewhere by a note.
pub struct SlowNotice {
    dropped: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl SlowNotice {
    /// Starts the delay.
    pub fn new(what: String) -> Self {
        SlowNotice::after(PATIENCE, move |dropped| {
            if is_quiet() || !stderr().is_terminal() {
                return note(&format!("{what} ..."));
            }
            let line = ticking(ProgressBar::new_spinner(), SPINNER).with_elapsed(PATIENCE);
            line.set_message(what);
            let _ = dropped.recv();
            line.finish_and_clear();
        })
    }

    fn after(patience: Duration, notice: impl FnOnce(&Receiver<()>) + Send + 'static) -> Self {
        let (sender, receiver) = channel();
        let thread = std::thread::spawn(move || {
            if receiver.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
                notice(&receiver);
            }
        });
        SlowNotice { dropped: Some(sender), thread: Some(thread) }
    }
}

impl Drop for SlowNotice {
    /// Waits until its line is cleared.
    fn drop(&mut self) {
        drop(self.dropped.take());
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

const SPINNER: &str = "{spinner} {elapsed} {msg}";

/// Draws a line by a template five times a second.
fn ticking(bar: ProgressBar, template: &str) -> ProgressBar {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// A progress line on the terminal, until Ctrl-C cancels the work; silent if standard error is not
/// a terminal.
pub struct Terminal {
    /// The progress bar.
    pub bar: ProgressBar,
    interrupt: Interrupt,
    show: Show,
}

/// Shows a report on a line.
type Show = fn(&ProgressBar, &Progress);

impl Terminal {
    /// Returns an empty line, which shows the current activity.
    pub fn new() -> Self {
        Terminal::of(ProgressBar::new_spinner(), SPINNER, |bar, progress| {
            let Progress { now, done, left, .. } = progress;
            bar.set_message(match left {
                Some(left) => {
                    format!("{done} trials done, at most {} s left: {now}", rounded(*left, 2))
                }
                None => now.clone(),
            });
        })
    }

    /// Returns a line with another template and another display.
    pub fn of(bar: ProgressBar, template: &str, show: Show) -> Self {
        Terminal { bar: ticking(bar, template), interrupt: Interrupt::catch(), show }
    }
}

impl Monitor for Terminal {
    fn report(&mut self, progress: Progress) {
        (self.show)(&self.bar, &progress);
    }

    fn proceed(&mut self) -> Result<(), Halt> {
        if self.interrupt.is_asked() { Err(Halt::Cancelled) } else { Ok(()) }
    }
}

impl Drop for Terminal {
    /// Clears the line.
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Progress of counted steps, with an estimate of the remaining time; shown after a second, and
/// only on a terminal.
pub struct Steps {
    bar: ProgressBar,
    shown: bool,
}

impl Steps {
    /// Creates the progress of `count` steps of `what`.
    pub fn new(count: u64, what: &str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::hidden());
        let template = "{msg} {wide_bar} {percent} % {elapsed}, about {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        Steps { bar, shown: is_quiet() }
    }

    /// Sets the number of completed steps.
    pub fn tell(&mut self, done: u64) {
        if !self.shown && PATIENCE <= self.bar.elapsed() {
            self.shown = true;
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.set_position(done);
    }
}

impl Drop for Steps {
    /// Clears the line.
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    #[test]
    fn what_takes_long_is_announced_while_it_is_done_and_what_does_not_is_not() {
        let announced = Arc::new(AtomicBool::new(false));
        let announce = || {
            let announced = announced.clone();
            move |_: &Receiver<()>| announced.store(true, Ordering::Relaxed)
        };
        drop(SlowNotice::after(Duration::from_secs(3600), announce()));
        assert!(!announced.load(Ordering::Relaxed));
        let notice = SlowNotice::after(Duration::from_millis(1), announce());
        while !announced.load(Ordering::Relaxed) {
            std::thread::yield_now();
        }
        drop(notice);
    }
}
