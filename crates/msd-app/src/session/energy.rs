//! Energy readings: the trace of the last seconds, and what contact has added.

use super::clock::Frame;
use super::run::{Reading, Revision, Run};
use super::throttle::Throttle;
use super::trace::Trace;
use msd_core::Energy;
use msd_run::Watch;

/// What is known of the energy of a run. Reading it costs time, so it takes a bounded share.
#[derive(Debug, Default)]
pub struct EnergyReadings {
    trace: Trace,
    last: Option<Reading<Balance>>,
    throttle: Throttle,
}

/// The energy when it was read last.
#[derive(Clone, Copy, Debug)]
struct Balance {
    energy: Energy,
    /// Energy that contact had added when the run was changed last, and has added by now, joules.
    contact: [f64; 2],
}

impl EnergyReadings {
    /// The energy of the last seconds, each sample with what was set then.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    /// The energy as it was read last, a fraction of a second ago at most while it runs; `None`
    /// while it is being worked out.
    pub fn now(&self, run: &Run) -> Option<Energy> {
        self.known(run).map(|balance| balance.energy)
    }

    /// Energy that contact has added since the run was changed last, by its own account, joules:
    /// an error that a shorter substep lowers; `None` while it is being worked out.
    pub fn added_by_contact(&self, run: &Run) -> Option<f64> {
        self.known(run).map(|Balance { contact: [before, now], .. }| now - before)
    }

    fn known(&self, run: &Run) -> Option<&Balance> {
        self.last.as_ref()?.of(run)
    }

    /// Keeps what was known at a revision, after which the run changed its own substeps alone: the
    /// same state has the same energy, and what a method adds it adds with any of them.
    pub(super) fn carry_over(&mut self, from: Revision, run: &Run) {
        if let Some(last) = &mut self.last {
            last.carry_over(from, run);
        }
    }

    /// Reads the energy now.
    pub(super) fn sample(&mut self, watched: (&Run, &mut Watch)) {
        let time = watched.0.runner().time();
        let energy = self.read(watched);
        self.trace.push(time, energy);
    }

    fn read(&mut self, (run, watch): (&Run, &mut Watch)) -> Energy {
        // Gusts add energy: the watch knows nothing of what was before.
        if run.is_driven() {
            watch.forget_energy();
        }
        let energy = watch.read_energy(run.runner());
        let added = run.runner().contacts().added;
        let before = self.known(run).map_or(added, |balance| balance.contact[0]);
        self.last = Some(Reading::new(Balance { energy, contact: [before, added] }, run));
        energy
    }

    /// Reads the energy after the steps of a frame, or after a change, if that is affordable.
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

    /// Forgets the samples after a time, as when a step is taken back.
    pub(super) fn rewind(&mut self, time: f64) {
        self.trace.rewind(time);
    }

    /// Forgets every sample, as at a restart.
    pub(super) fn clear(&mut self) {
        self.trace.clear();
    }
}
