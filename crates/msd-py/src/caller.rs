//! The monitor of long work: a callable receives progress, and Ctrl-C cancels it.

use crate::errors::{core_error, error};
use msd_study::monitor::{Halt, Monitor, Progress};
use pyo3::prelude::*;
use std::time::{Duration, Instant};

/// Longest time between two interrupts of long work.
const TURN: Duration = Duration::from_millis(40);

/// A monitor that passes progress on to a callable, and cancels at Ctrl-C or where that raises.
pub struct Caller<'a> {
    callable: Option<&'a Py<PyAny>>,
    raised: Option<PyErr>,
    looked: Instant,
}

impl<'a> Caller<'a> {
    pub fn new(callable: Option<&'a Py<PyAny>>) -> Self {
        Caller { callable, raised: None, looked: Instant::now() }
    }

    /// Returns whether no signal came and nothing was raised.
    pub fn may_go_on(&mut self) -> bool {
        if self.raised.is_none() && TURN < self.looked.elapsed() {
            self.looked = Instant::now();
            self.raised = Python::attach(|py| py.check_signals()).err();
        }
        self.raised.is_none()
    }

    /// Returns the exception of the callable or of a signal.
    pub fn raised(self) -> Option<PyErr> {
        self.raised
    }

    /// Returns the result of the work, or the exception that ended it.
    pub fn outcome<T>(&mut self, py: Python<'_>, done: Result<T, Halt>) -> PyResult<T> {
        match (self.raised.take(), done) {
            (Some(raised), _) => Err(raised),
            (None, Ok(done)) => Ok(done),
            (None, Err(Halt::Refused(error))) => Err(core_error(py, error)),
            (None, Err(Halt::Cancelled | Halt::Deadline)) => {
                Err(error(py, "it ended before anything was tried; give it more time"))
            }
        }
    }
}

impl Monitor for Caller<'_> {
    fn report(&mut self, progress: Progress) {
        if let (Some(callable), None) = (self.callable, &self.raised) {
            let heard = Python::attach(|py| callable.call1(py, (progress.words(),)).map(drop));
            self.raised = heard.err();
        }
    }

    fn proceed(&mut self) -> Result<(), Halt> {
        if self.may_go_on() { Ok(()) } else { Err(Halt::Cancelled) }
    }
}
