//! The watch over the run, with counts of triangle intersections and inverted cells in a bounded
//! share of the time.

use super::Session;
use super::clock::Frame;
use super::run::{Reading, Run};
use super::throttle::Throttle;
use msd_run::{Finding, Watch, on};

/// Shortest time between two counts without a change of the run, seconds.
const EVERY: f64 = 0.5;

/// Times of the counts of intersecting triangles and inverted cells.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Steps of the run at the last count.
    last: Option<Reading<u64>>,
    /// Wall-clock time since then, seconds.
    age: f64,
    throttle: Throttle,
}

impl Counts {
    /// Advances by a frame, and counts again if a count is due.
    fn refresh(
        &mut self,
        (run, watch): (&Run, &mut Watch),
        frame: Frame,
        stopwatch: &impl Fn() -> f64,
    ) {
        self.age += frame.real.max(0.0);
        self.throttle.save(frame.real, frame.spent);
        let steps = run.runner().steps();
        let is_due = match self.last.as_ref().and_then(|last| last.of(run)) {
            Some(&last) => last != steps && EVERY <= self.age,
            None => true,
        };
        if is_due && self.throttle.is_enough() {
            self.throttle.spend(stopwatch, || watch.count(run.runner()));
            (self.last, self.age) = (Some(Reading::new(steps, run)), 0.0);
        }
    }
}

impl Session {
    /// Updates the watch after a frame.
    pub(super) fn watch_over(&mut self, frame: Frame, stopwatch: &impl Fn() -> f64) {
        self.counts.refresh((&self.run, &mut self.watch), frame, stopwatch);
        if let Some(stable) = self.stability_light.stable(&self.run) {
            self.watch.note_limit(self.run.runner(), stable);
        }
        self.watch.look(self.run.runner());
    }

    /// Returns the findings up to the shown state, in order of discovery.
    pub fn findings(&self) -> Vec<Finding> {
        self.watch.findings(self.runner())
    }

    /// Returns the change of the total energy since the run was last changed or grabbed, joules;
    /// `None` until a reading, and after steps of a graphics device, which does not measure what it
    /// dissipates.
    pub fn energy_imbalance(&self) -> Option<f64> {
        let is_measured = !self.energy()?.dissipated.is_nan();
        is_measured.then(|| self.watch.read().witness.imbalance())
    }

    /// Returns whether any bodies collide with each other or themselves.
    pub fn touches(&self) -> bool {
        on!(self.runner(), simulation => simulation.model().do_bodies_meet())
    }

    /// Returns the intersecting pairs of triangles at the last count; counts are at least half a
    /// second apart. `None` until a count, and without colliding bodies.
    pub fn crossings(&self) -> Option<u64> {
        self.counts.last.as_ref()?.of(&self.run)?;
        self.watch.read().crossings
    }
}
