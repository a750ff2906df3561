//! The twin: a copy of the run that is stepped otherwise, under the same hands.

use super::Session;
use super::run::Run;
use super::trace::WINDOW;
use msd_core::{Error, Interaction, Settings};
use msd_run::replay::as_felt;
use msd_run::twin::{Apart, apart};
use msd_run::{Runner, on};
use std::collections::VecDeque;

/// The most distances in the plot: about one per pixel.
const SAMPLES: f64 = 400.0;

/// A copy of the run that is stepped otherwise, and how far it has drifted from the run since both
/// were at the same state.
#[derive(Clone, Debug)]
pub struct Twin {
    runner: Runner,
    apart: Apart,
    /// Simulated times, seconds, and root mean square distances, metres.
    trace: VecDeque<[f64; 2]>,
    /// Why it takes no more steps.
    failure: Option<String>,
}

impl Twin {
    /// Begins at the state of a run, with settings of its own but for the length of a step.
    pub(super) fn begin(run: &Run, settings: Settings) -> Result<Self, Error> {
        let mut runner = run.runner().clone();
        runner.set_automatic(false)?;
        runner.set_settings(Settings { step: runner.settings().step, ..settings })?;
        let mut twin =
            Twin { runner, apart: Apart::default(), trace: VecDeque::new(), failure: None };
        twin.measure(run);
        Ok(twin)
    }

    /// Takes the step that the run has just taken.
    pub(super) fn step(&mut self, run: &Run) {
        if self.failure.is_some() {
            return;
        }
        super::run::bound(&mut self.runner);
        match self.runner.step() {
            Ok(()) => self.measure(run),
            Err(Error::Diverged(_)) => {
                let (method, time) = (self.runner.integrator(), self.runner.time());
                self.failure = Some(format!(
                    "{method} has left the world at t = {time:.2} s and stopped there"
                ));
            }
            Err(error) => self.failure = Some(error.to_string()),
        }
    }

    /// Does what was done to the run, at once, by a hand as strong as it was there.
    pub(super) fn act(&mut self, interactions: &[Interaction], run: &Run) {
        let substep = run.runner().settings().substep();
        let mut felt = interactions.iter().map(|&each| as_felt(each, substep));
        let queued = felt.try_for_each(|each| self.runner.queue(each));
        if let Err(error) = queued.and_then(|()| self.runner.apply_queued()) {
            self.failure.get_or_insert(error.to_string());
        }
    }

    fn measure(&mut self, run: &Run) {
        self.apart = apart(run.runner(), &self.runner);
        let Apart { time, rms, .. } = self.apart;
        let is_due = |last: &[f64; 2]| WINDOW / SAMPLES <= time - last[0];
        if self.trace.back().is_none_or(is_due) {
            self.trace.push_back([time, rms]);
        }
        while self.trace.front().is_some_and(|first| first[0] < time - WINDOW) {
            self.trace.pop_front();
        }
    }

    /// The copy.
    pub fn runner(&self) -> &Runner {
        &self.runner
    }

    /// How it is stepped.
    pub fn settings(&self) -> Settings {
        self.runner.settings()
    }

    /// How far it is from the run, both after the same step: the last one that it took.
    pub fn apart(&self) -> Apart {
        self.apart
    }

    /// The distances of the last seconds: simulated time, seconds, and root mean square, metres.
    pub fn trace(&self) -> impl ExactSizeIterator<Item = &[f64; 2]> {
        self.trace.iter()
    }

    /// Why it takes no more steps, while the run goes on.
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    /// Where its particles are, metres.
    pub fn positions(&self) -> Vec<[f32; 3]> {
        let mut positions = Vec::new();
        on!(&self.runner, simulation => simulation.snapshot().copy_positions(&mut positions));
        positions
    }
}

/// The twin of a session.
impl Session {
    /// Begins, changes or ends a twin: a copy that is stepped by other settings from here on.
    pub fn set_twin(&mut self, settings: Option<Settings>) {
        let Some(settings) = settings else { return self.twin = None };
        match Twin::begin(&self.run, settings) {
            Ok(twin) => (self.twin, self.refusal) = (Some(Box::new(twin)), None),
            Err(error) => self.refusal = Some(error.to_string()),
        }
    }

    /// Brings the twin, if there is one, to the state of the run.
    pub(super) fn restart_twin(&mut self) {
        let settings = self.twin.as_ref().map(|twin| twin.settings());
        if settings.is_some() {
            self.set_twin(settings);
        }
    }

    /// The run under other settings that steps beside this one, if the user wants it.
    pub fn twin(&self) -> Option<&Twin> {
        self.twin.as_deref()
    }
}
