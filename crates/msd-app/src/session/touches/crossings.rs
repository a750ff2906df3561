//! Crossings of surfaces, counted at a bounded rate, and solids that go through surfaces.

use crate::session::Session;
use crate::session::clock::Frame;
use crate::session::run::{Reading, Run};
use crate::session::throttle::Throttle;
use msd_run::{Pierced, Piercing, Runner, on};

/// The shortest time between two counts of a run that goes on, seconds.
const EVERY: f64 = 0.5;

/// A count of crossings, renewed at a bounded rate, and a watch for solids that go through
/// surfaces.
#[derive(Debug, Default)]
pub struct CrossingCount {
    piercing: Piercing,
    /// Crossings, and the steps of the run when they were counted.
    count: Option<Reading<(u64, u64)>>,
    /// Wall-clock time since then, seconds.
    age: f64,
    throttle: Throttle,
}

impl CrossingCount {
    /// Lets a frame pass, and counts again if it is time to.
    pub(in crate::session) fn refresh(
        &mut self,
        run: &Run,
        frame: Frame,
        stopwatch: &impl Fn() -> f64,
    ) {
        self.piercing.look(run.runner());
        if !touches(run.runner()) {
            return;
        }
        self.age += frame.real.max(0.0);
        self.throttle.save(frame.real, frame.spent);
        let is_due = match self.count.as_ref().and_then(|count| count.of(run)) {
            Some((_, steps)) => *steps != run.runner().steps() && EVERY <= self.age,
            None => true,
        };
        if !is_due || !self.throttle.is_enough() {
            return;
        }
        let touched = self.throttle.spend(stopwatch, || run.runner().touched());
        let count = touched.map(|touched| (touched.crossings, run.runner().steps()));
        self.count = count.map(|count| Reading::new(count, run));
        self.age = 0.0;
    }

    fn of(&self, run: &Run) -> Option<u64> {
        self.count.as_ref().and_then(|count| count.of(run)).map(|count| count.0)
    }
}

fn touches(runner: &Runner) -> bool {
    on!(runner, simulation => simulation.model().do_bodies_meet())
}

impl Session {
    /// Whether any bodies touch each other or themselves.
    pub fn touches(&self) -> bool {
        touches(self.runner())
    }

    /// How often bodies may have crossed since the start.
    pub fn passes(&self) -> u64 {
        self.runner().passes()
    }

    /// Pairs of triangles of surfaces that cross, counted half a second ago or later; `None` while
    /// they are being counted, and where nothing touches.
    pub fn crossings(&self) -> Option<u64> {
        self.crossings.of(&self.run)
    }

    /// The first surface that a solid was seen to go through, in the run up to now.
    pub fn pierced(&self) -> Option<Pierced> {
        let first = self.crossings.piercing.first();
        first.filter(|pierced| pierced.time <= self.runner().time())
    }
}
