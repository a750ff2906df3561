//! The progress of a long command, on the standard error.

use crate::cli::failure::{is_quiet, note};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// After so long the user wonders what is being done.
const PATIENCE: Duration = Duration::from_secs(1);

/// Says what is being done if it takes long: if this is not dropped within a second.
pub struct SlowNotice {
    _dropped: Sender<()>,
}

impl SlowNotice {
    /// Begins to wait.
    pub fn new(what: String) -> Self {
        SlowNotice::after(PATIENCE, move || note(&format!("{what} ...")))
    }

    fn after(patience: Duration, notice: impl FnOnce() + Send + 'static) -> Self {
        let (sender, receiver) = channel();
        std::thread::spawn(move || {
            if receiver.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
                notice();
            }
        });
        SlowNotice { _dropped: sender }
    }
}

/// A line that says what is being done; silent where the standard error is no terminal.
pub struct Bar(ProgressBar);

impl Bar {
    /// Shows an empty line.
    pub fn new() -> Self {
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed} {msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Bar(bar)
    }

    /// Says what is being done now.
    pub fn tell(&self, message: &str) {
        self.0.set_message(message.to_owned());
    }

    /// Clears the line.
    pub fn end(&self) {
        self.0.finish_and_clear();
    }
}

/// How far steps that are counted are, with an estimate of the rest; shown after a second, and only
/// on a terminal.
pub struct Steps {
    bar: ProgressBar,
    shown: bool,
}

impl Steps {
    /// So many of what is done.
    pub fn new(count: u64, what: &str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::hidden());
        let template = "{msg} {wide_bar} {percent} % {elapsed}, about {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        Steps { bar, shown: is_quiet() }
    }

    /// Says that so many are done.
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
            move || announced.store(true, Ordering::Relaxed)
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
