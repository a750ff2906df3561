//! How far is a long command? Told on the standard error, where a person watches.

use super::failure::tell;
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// After so long a person asks what is being done.
const PATIENCE: Duration = Duration::from_secs(1);

/// Does something, and says what if it takes long.
pub fn patiently<T>(what: &str, work: impl FnOnce() -> T) -> T {
    watched(PATIENCE, || tell(&format!("{what} ...")), work)
}

/// Does something, and something else meanwhile if it takes longer than that.
fn watched<T>(patience: Duration, ask: impl FnOnce() + Send, work: impl FnOnce() -> T) -> T {
    let (done, end) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            if end.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
                ask();
            }
        });
        let result = work();
        drop(done);
        result
    })
}

/// A line that says what is being done; silent where nobody watches.
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    #[test]
    fn what_takes_long_is_told_while_it_is_done_and_what_does_not_is_not() {
        let told = AtomicBool::new(false);
        let tell = || told.store(true, Ordering::Relaxed);
        assert_eq!(watched(Duration::from_secs(3600), tell, || 1), 1);
        assert!(!told.load(Ordering::Relaxed));
        let wait = || {
            while !told.load(Ordering::Relaxed) {
                std::thread::yield_now();
            }
        };
        watched(Duration::from_millis(1), tell, wait);
    }
}
