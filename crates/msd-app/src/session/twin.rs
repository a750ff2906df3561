//! The twin: a copy of the run that is stepped otherwise, under the same hands.

use super::Session;
use super::run::Run;
use super::trace::WINDOW;
use msd_core::{Error, Interaction, Settings};
use msd_run::replay::as_felt;
use msd_run::rescue::{SOUND, debris};
use msd_run::twin::{Apart, apart};
use msd_run::{History, Runner, on};
use std::collections::VecDeque;

/// The most distances in the plot: about one per pixel.
const SAMPLES: f64 = 400.0;

/// A copy of the run that is stepped otherwise, and how far it has drifted from the run since both
/// were at the same state.
#[derive(Clone, Debug)]
pub struct Twin {
    runner: Runner,
    apart: Apart,
    /// The distances of the last seconds.
    trace: VecDeque<Apart>,
    /// What it may have to go back to, if it blows up.
    history: History,
    /// Why it takes no more steps.
    failure: Option<String>,
}

impl Twin {
    /// Begins at the state of a run, with settings of its own but for the length of a step.
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
                // As far back as debris is looked for, and from there to a distance that was kept.
                let kept = (SOUND + 2.0 * WINDOW / SAMPLES) / self.settings().step;
                self.history.keep(kept.ceil() as usize);
                self.measure(run);
            }
            Err(Error::Diverged(_)) => {
                let (method, time) = (self.runner.integrator(), self.runner.time());
                self.failure = Some(format!("{method} left the world at t = {time:.2} s"));
                self.leave_debris();
            }
            Err(error) => self.failure = Some(error.to_string()),
        }
    }

    /// Goes back to the last distance that is not one of debris, and to the state that it is of.
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
        let time = self.apart.time;
        if self.trace.back().is_none_or(|last| WINDOW / SAMPLES <= time - last.time) {
            self.trace.push_back(self.apart);
        }
        while self.trace.front().is_some_and(|first| first.time < time - WINDOW) {
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

    /// How far it is from the run, both after the same step: the last one that it took, or where it
    /// left the world, the last one that is kept in which it held together.
    pub fn apart(&self) -> Apart {
        self.apart
    }

    /// The distances of the last seconds.
    pub fn trace(&self) -> impl ExactSizeIterator<Item = &Apart> {
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
