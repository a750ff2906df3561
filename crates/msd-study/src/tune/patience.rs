//! The patience of one who follows a search.

use crate::measure::leave::Halt;
use crate::measure::reference::Wish;
use crate::study::conduct::{Follower, Progress};
use web_time::{Duration, Instant};

/// The part of the patience after which a reference is not tightened further, of the processor.
const REFERENCE: f64 = 0.3;
/// Where the follower lets it wait for longer than this, that is a pause, which takes no patience.
const PAUSE: Duration = Duration::from_secs(1);

/// A follower, and since when it is waited for, pauses left out.
pub(super) struct Hurried<'a> {
    follower: &'a mut dyn Follower,
    since: Instant,
}

impl<'a> Hurried<'a> {
    /// One whose patience begins now.
    pub(super) fn new(follower: &'a mut dyn Follower) -> Self {
        Hurried { follower, since: Instant::now() }
    }

    /// How a reference is to be made for it.
    pub(super) fn wish(&self, duration: f64, uncertainty: f64) -> Wish {
        let wish = Wish { duration, uncertainty, ..Wish::default() };
        Wish { patience: wish.patience.min(REFERENCE * self.follower.patience()), ..wish }
    }

    pub(super) fn hear(&mut self, progress: Progress) {
        self.follower.hear(progress);
    }

    fn is_late(&self) -> bool {
        self.follower.patience() < self.since.elapsed().as_secs_f64()
    }

    /// Whether the work goes on.
    pub(super) fn goes_on(&mut self) -> bool {
        let asked = Instant::now();
        let goes_on = self.follower.goes_on();
        let waited = asked.elapsed();
        if PAUSE < waited {
            self.since += waited;
        }
        goes_on && !self.is_late()
    }

    /// Why it does not: whether the follower ended it or the time is over.
    pub(super) fn reason(&self, halt: Halt) -> Halt {
        if halt == Halt::Stopped && self.is_late() { Halt::Late } else { halt }
    }
}
