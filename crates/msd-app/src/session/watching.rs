//! The watch over the run, with counts of what crosses and what is inside out in it, which take a
//! bounded share of the time.

use super::Session;
use super::clock::Frame;
use super::run::{Reading, Run};
use super::throttle::Throttle;
use msd_run::{Finding, Watch, on};

/// The shortest time between two counts of a run that goes on, seconds.
const EVERY: f64 = 0.5;

/// When triangles that cross and cells that are inside out were counted.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// The steps of the run when they were counted last.
    last: Option<Reading<u64>>,
    /// Wall-clock time since then, seconds.
    age: f64,
    throttle: Throttle,
}

impl Counts {
    /// Lets a frame pass, and counts again if it is time to.
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
    /// Looks at the run after a frame.
    pub(super) fn watch_over(&mut self, frame: Frame, stopwatch: &impl Fn() -> f64) {
        self.counts.refresh((&self.run, &mut self.watch), frame, stopwatch);
        if let Some(stable) = self.stability_light.stable(&self.run) {
            self.watch.note_limit(self.run.runner(), stable);
        }
        self.watch.look(self.run.runner());
    }

    /// What went wrong in the run up to the state that is shown, in the order in which it was seen.
    pub fn findings(&self) -> Vec<Finding> {
        self.watch.findings(self.runner())
    }

    /// The change of the total energy since the run was changed or handled last, joules; `None`
    /// while it is being worked out.
    pub fn energy_imbalance(&self) -> Option<f64> {
        self.energy().map(|_| self.watch.read().witness.imbalance())
    }

    /// Whether any bodies touch each other or themselves.
    pub fn touches(&self) -> bool {
        on!(self.runner(), simulation => simulation.model().do_bodies_meet())
    }

    /// Pairs of triangles of surfaces that cross, counted half a second ago or later; `None` while
    /// they are being counted, and where nothing touches.
    pub fn crossings(&self) -> Option<u64> {
        self.counts.last.as_ref()?.of(&self.run)?;
        self.watch.read().crossings
    }
}
