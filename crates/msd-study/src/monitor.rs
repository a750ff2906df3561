//! Progress reports and cancellation of work that takes long.

use msd_core::Error;
use serde::{Deserialize, Serialize};
use std::fmt;
use web_time::{Duration, Instant};

/// A monitor that waits for longer than this pauses the work: a deadline is later by that.
const PAUSE: Duration = Duration::from_secs(1);

/// Progress of some work.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The current work.
    pub now: String,
    /// Trials, or cells of a sweep, that are done.
    pub done: usize,
    /// Parts that are done, and all of them: methods, each in one precision, or cells of a sweep;
    /// none before they are known.
    pub parts: Option<[usize; 2]>,
    /// Time that the work still takes, at most, seconds; none before it is known.
    pub left: Option<f64>,
}

impl Progress {
    /// The progress of work without parts.
    pub(crate) fn of(now: impl Into<String>) -> Self {
        Progress { now: now.into(), ..Progress::default() }
    }

    /// The number of methods that are done, if it is known, and the current work, in words.
    pub fn words(&self) -> String {
        match self.parts {
            Some([done, all]) => {
                format!("{done} of {all} pairs of method and precision done; {}", self.now)
            }
            None => self.now.clone(),
        }
    }
}

/// A receiver of progress reports, which may cancel the work.
///
/// A closure that takes a [`Progress`] never cancels; `()` ignores the reports as well.
pub trait Monitor {
    /// Receives a report.
    fn report(&mut self, progress: Progress);

    /// Returns whether the work proceeds; called once in a step or so. It may block: that is a
    /// pause.
    ///
    /// # Errors
    /// [`Halt::Cancelled`] or [`Halt::Deadline`], which end the work.
    fn proceed(&mut self) -> Result<(), Halt> {
        Ok(())
    }

    /// Time from the start of the work to its deadline, pauses left out, seconds.
    fn time_limit(&self) -> f64 {
        f64::INFINITY
    }
}

impl<F: FnMut(Progress)> Monitor for F {
    fn report(&mut self, progress: Progress) {
        self(progress);
    }
}

impl Monitor for () {
    fn report(&mut self, _: Progress) {}
}

/// A monitor with a deadline.
pub struct Deadline<'a> {
    monitor: &'a mut dyn Monitor,
    since: Instant,
    limit: f64,
}

impl<'a> Deadline<'a> {
    /// Ends the work after `limit` seconds of wall clock, pauses left out.
    pub fn new(monitor: &'a mut dyn Monitor, limit: f64) -> Self {
        Deadline { monitor, since: Instant::now(), limit }
    }
}

impl Monitor for Deadline<'_> {
    fn report(&mut self, progress: Progress) {
        self.monitor.report(progress);
    }

    fn proceed(&mut self) -> Result<(), Halt> {
        let called = Instant::now();
        self.monitor.proceed()?;
        let waited = called.elapsed();
        if PAUSE < waited {
            self.since += waited;
        }
        let is_late = self.limit < self.since.elapsed().as_secs_f64();
        if is_late { Err(Halt::Deadline) } else { Ok(()) }
    }

    fn time_limit(&self) -> f64 {
        self.limit.min(self.monitor.time_limit())
    }
}

/// The end of work without a result.
#[derive(Clone, Debug, PartialEq)]
pub enum Halt<E = Error> {
    /// The input was refused.
    Refused(E),
    /// The monitor cancelled the work.
    Cancelled,
    /// The deadline passed before there was a result.
    Deadline,
}

impl<E> Halt<E> {
    /// The same with another error in place of a refusal.
    pub(crate) fn map<F>(self, refusal: impl FnOnce(E) -> F) -> Halt<F> {
        match self {
            Halt::Refused(error) => Halt::Refused(refusal(error)),
            Halt::Cancelled => Halt::Cancelled,
            Halt::Deadline => Halt::Deadline,
        }
    }
}

/// A result, or `None` where the input was refused.
pub(crate) fn unless_refused<T>(found: Result<T, Halt>) -> Result<Option<T>, Halt> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(Halt::Refused(_)) => Ok(None),
        Err(halt) => Err(halt),
    }
}

impl<E> From<E> for Halt<E> {
    fn from(error: E) -> Self {
        Halt::Refused(error)
    }
}

impl<E: fmt::Display> fmt::Display for Halt<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Halt::Refused(error) => error.fmt(f),
            Halt::Cancelled => f.write_str("it was cancelled"),
            Halt::Deadline => f.write_str(
                "its time was over before the right motion was known to compare with; from a \
                 calmer state it may be known in time",
            ),
        }
    }
}

impl<E: std::error::Error> std::error::Error for Halt<E> {}
