//! How far is a long command? Told on the standard error, where a person watches.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

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
