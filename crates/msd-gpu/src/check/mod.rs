//! Checks of a device while it runs: the processor takes a step again now and then, and compares.

mod again;
#[cfg(any(target_arch = "wasm32", test))]
mod at_once;
#[cfg(not(target_arch = "wasm32"))]
mod thread;

pub use again::{Difference, first_difference};

use again::Taken;
#[cfg(target_arch = "wasm32")]
use at_once::FrameWorker as Worker;
use msd_core::{Simulation, State};
use std::time::Duration;
#[cfg(not(target_arch = "wasm32"))]
use thread::ThreadWorker as Worker;
use web_time::Instant;

/// Steps from one check to the next, at least.
const EVERY: u64 = 16;

/// Checks of a device, and their times.
#[derive(Debug)]
pub struct Checker {
    worker: Worker,
    /// The steps at the last check.
    last: u64,
    /// When the check that is under way began, or the next one may.
    time: Instant,
    is_busy: bool,
    is_stale: bool,
    checked: u64,
}

impl Checker {
    pub fn new() -> Self {
        let (worker, time) = (Worker::new(), Instant::now());
        Checker { worker, last: 0, time, is_busy: false, is_stale: true, checked: 0 }
    }

    /// The number of steps that were checked.
    pub fn checked(&self) -> u64 {
        self.checked
    }

    /// Notes that the model is not that of the last check any more.
    pub fn renew(&mut self) {
        self.is_stale = true;
    }

    /// Whether the next step is to be checked; the first always is.
    pub fn is_due(&self, steps: u64) -> bool {
        let is_first = self.checked == 0;
        // A state with fewer steps may have been set.
        let is_later = steps < self.last || self.last + EVERY <= steps;
        let is_rested = is_later && self.time <= Instant::now();
        !self.is_busy && (is_first || is_rested)
    }

    /// Begins the check of a step from the state of a simulation to another.
    pub fn begin(&mut self, simulation: &Simulation<f32>, after: &State<f32>) {
        let steps = simulation.steps();
        (self.last, self.time, self.is_busy) = (steps, Instant::now(), true);
        let is_stale = std::mem::take(&mut self.is_stale);
        self.worker.begin(Taken {
            simulation: is_stale.then(|| Box::new(simulation.clone())),
            before: simulation.state(),
            steps,
            after: after.clone(),
        });
    }

    /// The difference that a check has found.
    pub fn result(&mut self) -> Option<Difference> {
        let result = self.worker.result()?;
        self.end(result)
    }

    /// Waits for the check that is under way.
    pub fn wait(&mut self) -> Option<Difference> {
        if !self.is_busy {
            return None;
        }
        let result = self.worker.wait()?;
        self.end(result)
    }

    fn end(&mut self, result: Option<Difference>) -> Option<Difference> {
        let duration = self.time.elapsed().min(Duration::from_secs(60));
        self.time = Instant::now() + Worker::rest_after(duration);
        self.is_busy = false;
        self.checked += 1;
        result
    }
}
