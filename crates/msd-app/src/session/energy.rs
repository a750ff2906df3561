//! Energy readings: the trace of the last seconds, and what the integrator has added.

use super::clock::Frame;
use super::throttle::Throttle;
use super::trace::Trace;
use msd_core::Witness;
use msd_run::Runner;

/// What is known of the energy of a run. Reading it costs time, so it takes a bounded share.
#[derive(Debug, Default)]
pub struct EnergyReadings {
    trace: Trace,
    /// Watches for energy that the integrator adds.
    witness: Witness,
    throttle: Throttle,
}

impl EnergyReadings {
    /// The energy of the last seconds.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    /// Energy that the integrator has added for good since the user last changed something, joules;
    /// `None` if it added none.
    pub fn gain(&self) -> Option<f64> {
        Some(self.witness.gain()).filter(|&gain| 0.0 < gain)
    }

    /// Reads the energy now.
    pub(crate) fn sample(&mut self, runner: &Runner) {
        let energy = runner.show_to(&mut self.witness);
        self.trace.push(runner.time(), energy);
    }

    /// Reads the energy after the steps of a frame, if that is due and affordable.
    pub(crate) fn follow(&mut self, runner: &Runner, frame: Frame, stopwatch: &impl Fn() -> f64) {
        self.throttle.save(frame.real, frame.spent);
        let is_due = 0 < frame.steps && self.trace.is_due(runner.time());
        if is_due && self.throttle.is_enough() {
            let mut throttle = self.throttle;
            throttle.spend(stopwatch, || self.sample(runner));
            self.throttle = throttle;
        }
    }

    /// Forgets what was watched: state, settings or precision were replaced.
    pub(crate) fn rewatch(&mut self) {
        self.witness.restart();
    }

    /// Forgets the samples after a time, as when a step is taken back.
    pub(crate) fn rewind(&mut self, time: f64) {
        self.trace.rewind(time);
    }

    /// Forgets every sample, as at a restart.
    pub(crate) fn clear(&mut self) {
        self.trace.clear();
    }
}
