//! What is running, how far is it, and what stopped it? The window's logic without a window.

use crate::accuracy::Accuracy;
use crate::clock::{Clock, Frame};
use crate::edits::{Edits, Shown};
use crate::hand::Hold;
use crate::margin::Margin;
use crate::ration::Ration;
use crate::trace::Trace;
use msd_core::stability::Estimator;
use msd_core::{Error, Integrator, Interaction, Settings, Witness};
use msd_lab::history::History;
use msd_lab::recording::Event;
use msd_lab::{Loaded, Recorder, Runner};

/// The most substeps that can be chosen.
pub const MOST_SUBSTEPS: u32 = 1000;

/// Part of the largest stable substep that is aimed at after a divergence: springs that turn and
/// stretch move the limit.
const CAUTION: f64 = 0.8;

/// A running scene and everything a person does to it.
#[derive(Debug)]
pub struct Session {
    pub(crate) loaded: Loaded,
    pub(crate) runner: Runner,
    pub(crate) edits: Edits,
    pub(crate) shown: Shown,
    pub(crate) hold: Option<Hold>,
    /// The particle that buttons and keys act on.
    pub(crate) selected: Option<usize>,
    pub(crate) clock: Clock,
    pub(crate) paused: bool,
    pub(crate) history: History,
    pub(crate) trace: Trace,
    /// Watches for energy that the integrator adds.
    pub(crate) witness: Witness,
    /// Keeps looks at the energy from slowing the motion.
    looks: Ration,
    pub(crate) margin: Margin,
    estimator: Estimator,
    /// Estimates the error while a person asks for it.
    pub(crate) accuracy: Option<Accuracy>,
    /// Writes down what happens while a person asks for it.
    pub(crate) recorder: Option<Recorder>,
    /// The error that paused the run, and how many substeps would have been stable.
    pub(crate) failure: Option<Failure>,
    /// The last thing that was refused, for the status line.
    pub(crate) refusal: Option<String>,
}

/// Why a run stopped.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// What the simulation said.
    pub text: String,
    /// Substeps per step that are predicted to be stable, if any number is.
    pub substeps: Option<u32>,
}

impl Session {
    /// Starts a scene, running.
    ///
    /// # Errors
    /// The first row or setting of the scene that is out of its domain.
    pub fn new(loaded: Loaded) -> Result<Self, Error> {
        let runner = loaded.runner()?;
        let mut session = Session {
            shown: Shown::default(),
            loaded,
            runner,
            edits: Edits::default(),
            hold: None,
            selected: None,
            clock: Clock::default(),
            paused: false,
            history: History::default(),
            trace: Trace::default(),
            witness: Witness::default(),
            looks: Ration::default(),
            margin: Margin::default(),
            estimator: Estimator::default(),
            accuracy: None,
            recorder: None,
            failure: None,
            refusal: None,
        };
        session.refresh();
        session.sample();
        Ok(session)
    }

    /// Replaces the scene and everything done to the old one; whether it is paused, how fast it
    /// runs, whether its error is estimated and whether it is recorded stay.
    ///
    /// # Errors
    /// See [`Session::new`]; the old scene goes on then.
    pub fn open(&mut self, loaded: Loaded) -> Result<(), Error> {
        let mut session = Session::new(loaded)?;
        session.paused = self.paused && self.failure.is_none();
        session.clock.set_speed(self.clock.speed());
        session.set_estimating(self.accuracy.is_some());
        session.recorder = self.recorder.take();
        *self = session;
        self.note_start();
        Ok(())
    }

    /// Lets `real` seconds of wall clock pass; `stopwatch` gives the seconds spent in this frame.
    pub fn advance(&mut self, real: f64, stopwatch: &impl Fn() -> f64) -> Frame {
        let step = self.runner.settings().step;
        let mut frame = Frame::default();
        if !self.paused {
            let mut clock = std::mem::take(&mut self.clock);
            frame = clock.run(real, step, stopwatch, || self.take_step());
            self.clock = clock;
            if 0.0 < frame.dropped
                && let Some(accuracy) = &mut self.accuracy
            {
                accuracy.fall_behind();
            }
            let mut looks = self.looks;
            looks.save(real, frame.spent);
            if 0 < frame.steps && looks.is_enough() && self.trace.is_due(self.time()) {
                looks.spend(stopwatch, || self.sample());
            }
            self.looks = looks;
        }
        if self.margin.is_due(real) {
            let start = stopwatch();
            let stable = self.stable_substep();
            self.margin.set(stable, stopwatch() - start);
        }
        frame
    }

    /// The largest stable substep of the present state, seconds. Only explicit methods have one:
    /// for the others the spectrum is not needed.
    fn stable_substep(&mut self) -> f64 {
        if !Integrator::EXPLICIT.contains(&self.runner.integrator()) {
            return f64::INFINITY;
        }
        self.runner.stable_substep_by(&mut self.estimator)
    }

    /// Takes one step and returns whether the run can go on.
    fn take_step(&mut self) -> bool {
        self.move_held_pin();
        let before = self.runner.moment();
        if let Some(accuracy) = &mut self.accuracy {
            accuracy.before_step(&self.runner);
        }
        match self.runner.step() {
            Ok(()) => {
                if let Some(accuracy) = &mut self.accuracy {
                    accuracy.after_step(&self.runner);
                }
                self.history.push(before);
                self.failure = None;
                self.note(Recorder::step);
                true
            }
            Err(error) => {
                self.fail(&error);
                false
            }
        }
    }

    fn fail(&mut self, error: &Error) {
        self.paused = true;
        self.release();
        self.remeasure();
        let predicted = match error {
            Error::Diverged(divergence) => divergence.stable_substep,
            _ => None,
        };
        let substeps = predicted.and_then(|stable| self.needed_substeps(stable));
        self.failure = Some(Failure { text: error.to_string(), substeps });
    }

    /// More substeps than now that are predicted to be stable, given the largest stable substep of
    /// the present state, seconds.
    fn needed_substeps(&self, stable: f64) -> Option<u32> {
        let Settings { step, substeps, .. } = self.runner.settings();
        // The state kept may be far gone; where the scene starts counts as well.
        let at_start = self.fresh_runner().map_or(0.0, |runner| runner.stable_substep());
        let needed = (step / (CAUTION * stable.min(at_start))).ceil();
        let count = (needed <= f64::from(MOST_SUBSTEPS)).then_some((needed as u32).max(1));
        count.filter(|&count| substeps < count)
    }

    fn sample(&mut self) {
        let energy = self.runner.show_to(&mut self.witness);
        self.trace.push(self.time(), energy);
    }

    /// Pauses or goes on. After a divergence it stays paused until something is changed.
    pub fn toggle_pause(&mut self) {
        self.paused = !self.paused;
        self.clock.resume();
    }

    /// Pauses and takes one step.
    pub fn step_forward(&mut self) {
        self.paused = true;
        self.take_step();
        self.trace.rewind(self.time());
        self.sample();
    }

    /// Pauses and returns to the state before the last step; returns whether there was one.
    pub fn step_back(&mut self) -> bool {
        self.paused = true;
        let Some(moment) = self.history.pop() else { return false };
        if let Err(error) = self.runner.go_back(&moment) {
            self.refusal = Some(error.to_string());
            return false;
        }
        self.failure = None;
        self.note_back();
        self.trace.rewind(self.time());
        self.margin.touch();
        self.remeasure();
        true
    }

    /// Starts again from the first state. Solver, material and world stay as the person set them;
    /// pins, rest lengths and frozen shapes are the scene's again.
    pub fn restart(&mut self) {
        match self.fresh_runner() {
            Ok(runner) => self.runner = runner,
            Err(error) => return self.refusal = Some(error.to_string()),
        }
        // A run that stopped by itself starts again by itself.
        if self.failure.take().is_some() {
            self.paused = false;
        }
        (self.hold, self.selected) = (None, None);
        self.shown.rest_scale = 1.0;
        self.history.clear();
        self.trace.clear();
        self.remeasure();
        self.clock.resume();
        self.note_start();
        self.refresh();
        self.sample();
    }

    /// The scene at its start, with the solver and the edits of now.
    fn fresh_runner(&self) -> Result<Runner, Error> {
        let (settings, precision) = (self.runner.settings(), self.runner.precision());
        let mut runner = self.loaded.runner_with(settings, precision)?;
        for &edit in self.edits.kept() {
            runner.queue(edit)?;
        }
        runner.apply_queued()?;
        Ok(runner)
    }

    /// Starts again with as many substeps as were predicted to be stable.
    pub fn restart_stable(&mut self) {
        if let Some(substeps) = self.failure.as_ref().and_then(|failure| failure.substeps) {
            self.set_substeps(substeps);
            self.restart();
        }
    }

    /// Does something to the simulation at once: the window is always between two steps.
    pub(crate) fn act(&mut self, interaction: Interaction) -> bool {
        let result = self.runner.queue(interaction).and_then(|()| self.runner.apply_queued());
        self.witness.restart();
        if result.is_ok()
            && let Some(accuracy) = &mut self.accuracy
        {
            accuracy.hear(interaction, self.runner.settings());
        }
        let done = result.is_ok();
        self.refusal = result.err().map(|error| error.to_string());
        if done {
            self.note_event(Event::Act(interaction));
        }
        done
    }

    /// Makes the present lengths of the chosen springs their rest lengths.
    pub fn freeze(&mut self) {
        self.act(Interaction::Freeze { springs: self.shown.select });
        self.shown.rest_scale = 1.0;
        self.refresh();
    }

    /// Chooses how fast simulated time runs, 1 for real time.
    pub fn set_speed(&mut self, speed: f64) {
        self.clock.set_speed(speed);
    }

    /// Says that what a step reads has changed.
    pub(crate) fn touch(&mut self) {
        self.margin.touch();
        // The way out that is offered must fit what was set since the run stopped.
        if self.failure.is_some() {
            let stable = self.stable_substep();
            let substeps = self.needed_substeps(stable);
            self.failure = self.failure.take().map(|failure| Failure { substeps, ..failure });
        }
    }

    /// Forgets the wall-clock time up to the next frame, as after the window was hidden.
    pub fn resume(&mut self) {
        self.clock.resume();
    }
}
