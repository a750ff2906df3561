//! Energy readings: samples of the last seconds, and energy added by contact.

use super::clock::Frame;
use super::run::{Reading, Revision, Run};
use super::throttle::Throttle;
use super::trace::Trace;
use msd_core::Energy;
use msd_run::Watch;

/// The energy readings of a run. They cost time, so they take a bounded share.
#[derive(Debug, Default)]
pub struct EnergyReadings {
    trace: Trace,
    last: Option<Reading<Balance>>,
    throttle: Throttle,
}

/// The energy at the last reading.
#[derive(Clone, Copy, Debug)]
struct Balance {
    energy: Energy,
    /// Energy added by contact, at the last change of the run and at the last reading, joules.
    contact: [f64; 2],
}

impl EnergyReadings {
    /// Returns the energy samples of the last seconds.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    /// Returns the energy at the last reading, at most a fraction of a second ago during a run;
    /// `None` until a new one after a change.
    pub fn now(&self, run: &Run) -> Option<Energy> {
        self.known(run).map(|balance| balance.energy)
    }

    /// Returns the energy that contact has added since the last change of the run, joules: an error
    /// that shorter substeps reduce. `None` until a new reading.
    pub(crate) fn added_by_contact(&self, run: &Run) -> Option<f64> {
        self.known(run).map(|Balance { contact: [before, now], .. }| now - before)
    }

    fn known(&self, run: &Run) -> Option<&Balance> {
        self.last.as_ref()?.of(run)
    }

    /// Keeps the readings of a revision if the run then changed only its own substeps. The same
    /// state has the same energy, and errors of the method go on accumulating.
    pub(super) fn carry_over(&mut self, from: Revision, run: &Run) {
        if let Some(last) = &mut self.last {
            last.carry_over(from, run);
        }
    }

    /// Reads the energy now and adds it to the trace.
    pub(super) fn sample(&mut self, watched: (&Run, &mut Watch)) {
        let time = watched.0.runner().time();
        let energy = self.read(watched);
        self.trace.push(time, energy);
    }

    fn read(&mut self, (run, watch): (&Run, &mut Watch)) -> Energy {
        // Gusts add energy, so the watch must not compare with earlier readings.
        if run.is_driven() {
            watch.forget_energy();
        }
        let energy = watch.read_energy(run.runner());
        let added = run.runner().contacts().added;
        let before = self.known(run).map_or(added, |balance| balance.contact[0]);
        self.last = Some(Reading::new(Balance { energy, contact: [before, added] }, run));
        energy
    }

    /// Reads the energy after the steps of a frame, or after a change, if the throttle allows it.
    pub(super) fn follow(
        &mut self,
        watched: (&Run, &mut Watch),
        frame: Frame,
        stopwatch: &impl Fn() -> f64,
    ) {
        self.throttle.save(frame.real, frame.spent);
        let time = watched.0.runner().time();
        let is_due = 0 < frame.steps || self.now(watched.0).is_none();
        if !is_due || !self.throttle.is_enough() {
            return;
        }
        let mut throttle = self.throttle;
        let energy = throttle.spend(stopwatch, || self.read(watched));
        self.throttle = throttle;
        if frame.steps == 0 || self.trace.is_due(time) {
            self.trace.push(time, energy);
        }
    }

    /// Drops the samples after a time, as when a step is taken back.
    pub(super) fn rewind(&mut self, time: f64) {
        self.trace.rewind(time);
    }

    /// Drops every sample, as at a restart.
    pub(super) fn clear(&mut self) {
        self.trace.clear();
    }
}
