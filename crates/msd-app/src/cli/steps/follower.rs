//! One who follows a study or a search on a terminal, until Ctrl-C.

use super::{Bar, Interrupt};
use msd_study::conduct::{Follower, Progress};
use msd_study::quantity::rounded;

/// Shows what is being done, and ends it where the user does not want to wait.
pub struct Patient<'a> {
    /// Where it is shown.
    pub bar: &'a Bar,
    /// Whether the user wants it to end.
    pub interrupt: &'a Interrupt,
    /// Whether the best so far will do where it is ended, as in a search.
    pub is_searching: bool,
}

impl Follower for Patient<'_> {
    fn hear(&mut self, progress: Progress) {
        let Progress { now, done, left, .. } = progress;
        if self.is_searching {
            return self.bar.tell(&now);
        }
        let left =
            left.map_or(String::new(), |left| format!(", at most {} s left", rounded(left, 2)));
        self.bar.tell(&format!("{done} trials done{left}: {now}"));
    }

    fn goes_on(&mut self) -> bool {
        self.is_searching || !self.interrupt.is_asked()
    }

    fn patience(&self) -> f64 {
        if self.is_searching && self.interrupt.is_asked() { 0.0 } else { f64::INFINITY }
    }
}
