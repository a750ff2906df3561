//! A running scene and everything that a user does to it: the window's logic without a window.
//!
//! [`Session`] is the one object that acts. Its parts are types of their own, which know a
//! [`Runner`] at most and parts above them; read them in the order below.

mod clock;
mod throttle;
mod trace;
mod energy;
mod stability_light;
mod live_error;
mod material;
mod solver;
mod grab;
mod recording;

pub use clock::{BUDGET, Frame, Pace};
pub use energy::EnergyReadings;
pub use live_error::{ErrorReading, LiveErrorMeter, WINDOW as ERROR_WINDOW};
pub use material::{Material, MaterialEdit, MaterialValues, MixedValue};
pub use solver::{MOST_SUBSTEPS, RunFailure, Tuning};
pub use throttle::Throttle;
pub use trace::{Sample, Trace, WINDOW as TRACE_WINDOW};

use clock::Clock;
use glam::DVec3;
use grab::{Grab, Held};
use msd_core::{Error, Interaction, Select, Vector};
use msd_run::recording::Event;
use msd_run::{History, Runner, on};
use msd_scene::Loaded;
use recording::SessionRecording;
use solver::stable_substeps;
use stability_light::StabilityLight;
use std::fmt::Display;
use std::path::Path;

/// A scene that runs, pauses, goes back, is grabbed, tuned and recorded.
#[derive(Debug)]
pub struct Session {
    loaded: Loaded,
    runner: Runner,
    clock: Clock,
    paused: bool,
    history: History,
    material: Material,
    grab: Grab,
    energy: EnergyReadings,
    stability_light: StabilityLight,
    /// Estimates the error while the user wants it.
    live_error: Option<LiveErrorMeter>,
    recording: SessionRecording,
    /// Why the run paused by itself.
    failure: Option<RunFailure>,
    /// What was refused last, for the status line.
    refusal: Option<String>,
}

/// The run: time passes, forwards or back.
impl Session {
    /// Starts a scene, running.
    ///
    /// # Errors
    /// The first row or setting of the scene that is out of its domain.
    pub fn new(loaded: Loaded) -> Result<Self, Error> {
        let runner = Runner::open(&loaded)?;
        let mut session = Session {
            loaded,
            runner,
            clock: Clock::default(),
            paused: false,
            history: History::default(),
            material: Material::default(),
            grab: Grab::default(),
            energy: EnergyReadings::default(),
            stability_light: StabilityLight::default(),
            live_error: None,
            recording: SessionRecording::default(),
            failure: None,
            refusal: None,
        };
        session.read_material();
        session.energy.sample(&session.runner);
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
        session.set_estimating(self.live_error.is_some());
        session.recording = std::mem::take(&mut self.recording);
        *self = session;
        self.record_start();
        Ok(())
    }

    /// Lets `real` seconds of wall clock pass; `stopwatch` gives the seconds spent in this frame.
    pub fn advance(&mut self, real: f64, stopwatch: &impl Fn() -> f64) -> Frame {
        let mut frame = Frame::default();
        if !self.paused {
            let mut open = self.clock.begin(real, self.runner.settings().step, stopwatch);
            let mut steps = 0;
            while self.clock.takes_step(&mut open, stopwatch) && self.take_step() {
                steps += 1;
            }
            frame = self.clock.end(open, steps, stopwatch);
            if 0.0 < frame.dropped
                && let Some(meter) = &mut self.live_error
            {
                meter.fall_behind();
            }
            self.energy.follow(&self.runner, frame, stopwatch);
        }
        self.stability_light.refresh(&self.runner, real, stopwatch);
        frame
    }

    /// Takes one step and returns whether the run can go on.
    fn take_step(&mut self) -> bool {
        if let Some(motion) = self.grab.held.and_then(|held| held.pin_motion(&self.runner)) {
            self.act(motion);
        }
        let before = self.runner.moment();
        if let Some(meter) = &mut self.live_error {
            meter.before_step(&self.runner);
        }
        if let Err(error) = on!(&mut self.runner, simulation => simulation.step()) {
            self.fail(&error);
            return false;
        }
        if let Some(meter) = &mut self.live_error {
            meter.after_step(&self.runner);
        }
        self.history.push(before);
        self.failure = None;
        let recorded = self.recording.step();
        self.refuse(recorded);
        true
    }

    fn fail(&mut self, error: &Error) {
        self.paused = true;
        self.release();
        self.remeasure();
        let predicted = match error {
            Error::Diverged(divergence) => divergence.stable_substep,
            _ => None,
        };
        let substeps = predicted.and_then(|stable| self.way_out(stable));
        self.failure = Some(RunFailure { text: error.to_string(), substeps });
    }

    /// Substeps that are predicted to be stable, given the longest stable substep of the present
    /// state, seconds.
    fn way_out(&self, stable: f64) -> Option<u32> {
        // The state kept may be far gone; where the scene starts counts as well.
        let at_start = self.fresh_runner().map_or(0.0, |runner| runner.stable_substep());
        stable_substeps(self.runner.settings(), stable.min(at_start))
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
        self.energy.rewind(self.runner.time());
        self.energy.sample(&self.runner);
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
        let recorded = self.recording.back(|| now(&self.loaded, &self.runner));
        self.refuse(recorded);
        self.energy.rewind(self.runner.time());
        self.stability_light.touch();
        self.remeasure();
        true
    }

    /// Starts again from the first state. Solver, material and world stay as the user set them;
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
        self.grab = Grab::default();
        self.material.reset_rest_scale();
        self.history.clear();
        self.energy.clear();
        self.remeasure();
        self.clock.resume();
        self.record_start();
        self.read_material();
        self.energy.sample(&self.runner);
    }

    /// The scene at its start, with the solver and the edits of now.
    fn fresh_runner(&self) -> Result<Runner, Error> {
        let (settings, precision) = (self.runner.settings(), self.runner.precision());
        let mut runner = Runner::open_with(&self.loaded, settings, precision)?;
        for &edit in self.material.kept() {
            runner.queue(edit)?;
        }
        runner.apply_queued()?;
        Ok(runner)
    }

    /// Starts again with as many substeps as were predicted to be stable.
    pub fn restart_stable(&mut self) {
        if let Some(substeps) = self.failure.as_ref().and_then(|failure| failure.substeps) {
            self.tune(Tuning::Substeps(substeps));
            self.restart();
        }
    }

    /// Chooses how fast simulated time runs, 1 for real time.
    pub fn set_speed(&mut self, speed: f64) {
        self.clock.set_speed(speed);
    }

    /// Forgets the wall-clock time up to the next frame, as after the window was hidden.
    pub fn resume(&mut self) {
        self.clock.resume();
    }
}

/// What the user does to the run, between two steps.
impl Session {
    /// Does something to the simulation at once; returns whether it was accepted.
    fn act(&mut self, interaction: Interaction) -> bool {
        let result = on!(&mut self.runner, simulation => {
            simulation.queue(interaction).and_then(|()| simulation.apply_queued())
        });
        self.energy.rewatch();
        let accepted = result.is_ok();
        self.refusal = result.err().map(|error| error.to_string());
        if accepted {
            if let Some(meter) = &mut self.live_error {
                meter.follow(interaction, self.runner.settings());
            }
            self.record(&Event::Act(interaction));
        }
        accepted
    }

    /// Takes a particle with the mouse.
    pub fn grab(&mut self, particle: usize, target: DVec3) {
        self.release();
        let held = on!(&self.runner, simulation => Held::new(simulation.model(), particle, target));
        if self.act(held.interaction()) {
            self.grab = Grab { held: Some(held), selected: Some(particle) };
        }
    }

    /// Moves what the mouse holds.
    pub fn move_grab(&mut self, target: DVec3) {
        let Some(mut held) = self.grab.held else { return };
        held.target = target;
        if self.act(held.interaction()) {
            self.grab.held = Some(held);
        }
    }

    /// Lets go of what the mouse holds; it keeps its velocity.
    pub fn release(&mut self) {
        let Some(Held { particle, .. }) = self.grab.held.take() else { return };
        self.act(Interaction::Release { particle });
        if self.is_pinned(particle) {
            self.act(Interaction::Pin { particle, velocity: DVec3::ZERO });
        }
    }

    /// Lets go and selects nothing.
    pub fn deselect(&mut self) {
        self.release();
        self.grab.selected = None;
    }

    /// Pins a free particle where it is, or frees a pinned one.
    pub fn pin_toggle(&mut self, particle: usize) {
        if self.is_pinned(particle) {
            self.act(Interaction::Unpin { particle });
        } else {
            if self.held() == Some(particle) {
                self.release();
            }
            self.act(Interaction::Pin { particle, velocity: DVec3::ZERO });
        }
        self.grab.selected = Some(particle);
        self.touch();
    }

    /// Makes the present lengths of the selected springs their rest lengths.
    pub fn freeze(&mut self) {
        self.act(Interaction::Freeze { springs: self.material.values().select });
        self.material.reset_rest_scale();
        self.read_material();
    }

    /// Sets a number of the selected bodies, or of the world.
    pub fn edit(&mut self, edit: MaterialEdit) {
        for interaction in self.material.interactions(edit, &self.runner, &self.loaded.scene) {
            if self.act(interaction) {
                self.material.keep(edit, interaction);
            }
        }
        self.read_material();
    }

    /// Chooses what the sliders of the material act on: all, or one body.
    pub fn select(&mut self, select: Select) {
        self.material.select(select);
        self.read_material();
    }

    /// Gives material and world the values of the scene again, and restarts.
    pub fn reset_material(&mut self) {
        self.material.forget();
        self.restart();
    }

    /// Changes how the scene is stepped.
    pub fn tune(&mut self, tuning: Tuning) {
        let tuned = tuning.apply(&mut self.runner);
        self.refusal = tuned.as_ref().err().map(Error::to_string);
        if let Ok(event) = tuned {
            self.record(&event);
        }
        self.remeasure();
        self.touch();
    }

    /// Begins or ends to estimate the error; while it is off nothing is copied.
    pub fn set_estimating(&mut self, on: bool) {
        if on != self.live_error.is_some() {
            self.live_error = on.then(LiveErrorMeter::default);
        }
    }

    /// Begins to record from the present state on, into a file that grows. Ends a recording that
    /// was being made.
    pub fn start_recording(&mut self, path: &Path) {
        self.stop_recording();
        let begun = self.recording.begin(path, &now(&self.loaded, &self.runner));
        self.refuse(begun);
    }

    /// Ends the recording, if one is being made.
    pub fn stop_recording(&mut self) {
        if self.recording.is_on() {
            let ended = self.recording.finish(&self.runner);
            self.refusal = ended.err().map(|error| error.to_string());
        }
    }

    /// Shows an error on the status line, if there is one.
    pub fn refuse<E: Display>(&mut self, result: Result<(), E>) {
        if let Err(error) = result {
            self.refusal = Some(error.to_string());
        }
    }

    fn record(&mut self, event: &Event) {
        let recorded = self.recording.event(event);
        self.refuse(recorded);
    }

    /// Records that the run was replaced.
    fn record_start(&mut self) {
        if self.recording.is_on() {
            self.record(&Event::Start(Box::new(now(&self.loaded, &self.runner))));
        }
    }

    fn read_material(&mut self) {
        self.material.read(&self.runner);
        self.touch();
    }

    /// Reports that what a step reads has changed.
    fn touch(&mut self) {
        self.stability_light.touch();
        // The way out that is offered must fit what was set since the run stopped.
        if let Some(failure) = self.failure.take() {
            let stable = self.stability_light.predict(&self.runner);
            let substeps = self.way_out(stable);
            self.failure = Some(RunFailure { substeps, ..failure });
        }
    }

    /// Forgets what was measured: it is of another state or of other settings.
    fn remeasure(&mut self) {
        self.energy.rewatch();
        if let Some(meter) = &mut self.live_error {
            meter.restart();
        }
    }
}

/// What can be read of it.
impl Session {
    /// The scene as it was loaded.
    pub fn loaded(&self) -> &Loaded {
        &self.loaded
    }

    /// The simulation.
    pub fn runner(&self) -> &Runner {
        &self.runner
    }

    /// Where a particle is, metres.
    pub fn position(&self, particle: usize) -> DVec3 {
        on!(&self.runner, simulation => simulation.position(particle).to_f64())
    }

    /// Whether a particle is pinned.
    pub fn is_pinned(&self, particle: usize) -> bool {
        on!(&self.runner, simulation => simulation.model().is_pinned(particle))
    }

    /// The energy of the last seconds, and what the integrator added.
    pub fn energy(&self) -> &EnergyReadings {
        &self.energy
    }

    /// Whether no steps are taken.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Why the run stopped by itself.
    pub fn failure(&self) -> Option<&RunFailure> {
        self.failure.as_ref()
    }

    /// What was refused last.
    pub fn refusal(&self) -> Option<&str> {
        self.refusal.as_deref()
    }

    /// How fast simulated time should run, 1 for real time.
    pub fn speed(&self) -> f64 {
        self.clock.speed()
    }

    /// Averages over the last frames; all 0 while paused.
    pub fn pace(&self) -> Pace {
        if self.paused { Pace::default() } else { self.clock.pace() }
    }

    /// How many steps can be taken back.
    pub fn steps_back(&self) -> usize {
        self.history.len()
    }

    /// The substep as a share of the longest stable one, if that was predicted.
    pub fn stability_share(&self) -> Option<f64> {
        self.stability_light.share(self.runner.settings().substep())
    }

    /// The estimate of the error, while the user wants one.
    pub fn live_error(&self) -> Option<&LiveErrorMeter> {
        self.live_error.as_ref()
    }

    /// What was set of material and world.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// The particle held by the mouse.
    pub fn held(&self) -> Option<usize> {
        self.grab.held.map(|held| held.particle)
    }

    /// Where the mouse pulls the held particle to, metres.
    pub fn grab_target(&self) -> Option<DVec3> {
        self.grab.held.map(|held| held.target)
    }

    /// The particle that buttons and keys act on.
    pub fn selected(&self) -> Option<usize> {
        self.grab.selected
    }

    /// The file that is being recorded into.
    pub fn recording(&self) -> Option<&str> {
        self.recording.name()
    }
}

/// Ends the recording of a window that is closed.
impl Drop for Session {
    fn drop(&mut self) {
        self.stop_recording();
    }
}

/// A run as it is now.
fn now(loaded: &Loaded, runner: &Runner) -> Loaded {
    runner.to_loaded(&loaded.name, &loaded.title)
}
