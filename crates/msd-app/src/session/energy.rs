//! Energy readings: the trace of the last seconds, and what the integrator has added.

use super::clock::Frame;
use super::run::{Reading, Revision, Run};
use super::throttle::Throttle;
use super::trace::Trace;
use msd_core::{Energy, Witness};

/// What is known of the energy of a run. Reading it costs time, so it takes a bounded share.
#[derive(Debug, Default)]
pub struct EnergyReadings {
    trace: Trace,
    last: Option<Reading<Balance>>,
    throttle: Throttle,
}

/// The energy when it was read last, and what is known of its errors.
#[derive(Clone, Copy, Debug)]
struct Balance {
    energy: Energy,
    /// Watches for energy that the integrator adds.
    witness: Witness,
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

    /// Energy that the integrator has added for good since the run was changed last, joules; `None`
    /// if it added none.
    pub fn gain(&self, run: &Run) -> Option<f64> {
        let gain = self.known(run).map(|balance| balance.witness.gain());
        gain.filter(|&gain| 0.0 < gain)
    }

    /// The change of the total energy since the run was changed or handled last, joules: the error
    /// of the method and of contact in it; `None` while it is being worked out.
    pub fn imbalance(&self, run: &Run) -> Option<f64> {
        self.known(run).map(|balance| balance.witness.imbalance())
    }

    /// That change where it lasts and no account explains it, joules: a rise, or a fall as a
    /// negative number; `None` where there is none.
    pub fn unexplained(&self, run: &Run) -> Option<f64> {
        let witness = &self.known(run)?.witness;
        let change = [witness.surplus(), -witness.loss()];
        change.into_iter().find(|&change| change != 0.0)
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

    /// Reads the energy of a state that a failed run went back to: what the method had added by
    /// then is still there.
    pub(super) fn sample_after(&mut self, from: Revision, run: &Run) {
        self.carry_over(from, run);
        self.sample(run);
    }

    /// Reads the energy now.
    pub(super) fn sample(&mut self, run: &Run) {
        // A change may add energy, and so do gusts: a witness knows nothing of what was before.
        let known = self.known(run).filter(|_| !run.is_driven());
        let mut witness = known.map_or(Witness::default(), |balance| balance.witness);
        let energy = run.runner().show_to(&mut witness);
        let added = run.runner().contacts().added;
        let before = self.known(run).map_or(added, |balance| balance.contact[0]);
        self.trace.push(run.runner().time(), energy);
        self.last = Some(Reading::new(Balance { energy, witness, contact: [before, added] }, run));
    }

    /// Reads the energy after the steps of a frame, or after a change, if that is due and
    /// affordable.
    pub(super) fn follow(&mut self, run: &Run, frame: Frame, stopwatch: &impl Fn() -> f64) {
        self.throttle.save(frame.real, frame.spent);
        let is_due = 0 < frame.steps && self.trace.is_due(run.runner().time());
        if (is_due || self.now(run).is_none()) && self.throttle.is_enough() {
            let mut throttle = self.throttle;
            throttle.spend(stopwatch, || self.sample(run));
            self.throttle = throttle;
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
