//! The twin: a copy of the run with other settings and the same user input.

use super::Session;
use super::run::Run;
use super::trace::WINDOW;
use msd_core::{Error, Interaction, Settings};
use msd_run::replay::as_felt;
use msd_run::rescue::{SOUND, debris};
use msd_run::twin::{Apart, apart};
use msd_run::{History, Runner, on};
use std::collections::VecDeque;

/// Largest number of distances in the plot: about one per pixel.
const SAMPLES: f64 = 400.0;

/// A copy of the run with other settings, and its distance from the run since they had the same
/// state.
#[derive(Clone, Debug)]
pub struct Twin {
    runner: Runner,
    apart: Apart,
    /// Distances of the last seconds.
    trace: VecDeque<Apart>,
    /// Earlier states, needed after a divergence.
    history: History,
    /// Reason why it takes no more steps.
    failure: Option<String>,
}

impl Twin {
    /// Begins at the state of a run, with other settings but the same length of a step.
    pub(super) fn begin(run: &Run, settings: Settings) -> Result<Self, Error> {
        let mut runner = run.runner().clone();
        runner.set_automatic(false)?;
        runner.set_settings(Settings { step: runner.settings().step, ..settings })?;
        let mut twin = Twin {
            runner,
            apart: Apart::default(),
            trace: VecDeque::new(),
            history: History::default(),
            failure: None,
        };
        twin.measure(run);
        Ok(twin)
    }

    /// Takes the step that the run has just taken.
    pub(super) fn step(&mut self, run: &Run) {
        if self.failure.is_some() {
            return;
        }
        self.runner.bound_work();
        let before = self.runner.moment();
        match self.runner.step() {
            Ok(()) => {
                self.history.push(before);
                // States as far back as debris is possible, plus the interval to a kept distance.
                let kept = (SOUND + 2.0 * WINDOW / SAMPLES) / self.settings().step;
                self.history.keep(kept.ceil() as usize);
                self.measure(run);
            }
            Err(Error::Diverged(_)) => {
                let (method, time) = (self.runner.integrator(), self.runner.time());
                self.failure = Some(format!("{method} diverged at t = {time:.2} s"));
                self.leave_debris();
            }
            Err(error) => self.failure = Some(error.to_string()),
        }
    }

    /// Goes back to the last distance before debris, and to its state.
    fn leave_debris(&mut self) {
        let sound = self.runner.steps() - debris(&self.runner, &self.history) as u64;
        while 1 < self.trace.len() && self.trace.back().is_some_and(|last| sound < last.step) {
            self.trace.pop_back();
        }
        let Some(&last) = self.trace.back() else { return };
        let back = self.runner.steps().saturating_sub(last.step) as usize;
        if let Some(moment) = self.history.nth_back(back)
            && self.runner.go_back(moment).is_ok()
        {
            self.apart = last;
        }
    }

    /// Applies interactions of the run at once, with grabs as strong as in the run.
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
        let time = self.apart.time;
        if self.trace.back().is_none_or(|last| WINDOW / SAMPLES <= time - last.time) {
            self.trace.push_back(self.apart);
        }
        while self.trace.front().is_some_and(|first| first.time < time - WINDOW) {
            self.trace.pop_front();
        }
    }

    /// Returns the copy.
    pub fn runner(&self) -> &Runner {
        &self.runner
    }

    /// Returns its settings.
    pub fn settings(&self) -> Settings {
        self.runner.settings()
    }

    /// Returns its distance from the run after the same step: its last one or, after a divergence,
    /// the last kept one before debris.
    pub fn apart(&self) -> Apart {
        self.apart
    }

    /// Returns the distances of the last seconds.
    pub fn trace(&self) -> impl ExactSizeIterator<Item = &Apart> {
        self.trace.iter()
    }

    /// Returns the reason why it takes no more steps, while the run continues.
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    /// Returns the positions of its particles, metres.
    pub fn positions(&self) -> Vec<[f32; 3]> {
        let mut positions = Vec::new();
        on!(&self.runner, simulation => simulation.snapshot().copy_positions(&mut positions));
        positions
    }
}

/// The twin of a session.
impl Session {
    /// Begins, changes or ends a twin, a copy with other settings from the current state on.
    pub fn set_twin(&mut self, settings: Option<Settings>) {
        let Some(settings) = settings else { return self.twin = None };
        match Twin::begin(&self.run, settings) {
            Ok(twin) => (self.twin, self.refusal) = (Some(Box::new(twin)), None),
            Err(error) => self.refusal = Some(error.to_string()),
        }
    }

    /// Resets the twin, if there is one, to the state of the run.
    pub(super) fn restart_twin(&mut self) {
        let settings = self.twin.as_ref().map(|twin| twin.settings());
        if settings.is_some() {
            self.set_twin(settings);
        }
    }

    /// Returns the twin, if the user compares with one.
    pub fn twin(&self) -> Option<&Twin> {
        self.twin.as_deref()
    }
}
