//! How far is a long command? Told on the standard error, where a person watches.

use super::failure::tell;
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// After so long a person asks what is being done.
const PATIENCE: Duration = Duration::from_secs(1);

/// Does something, and says what if it takes long.
pub fn patiently<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let (done, end) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            if end.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                tell(&format!("{what} ..."));
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
