//! A running scene and all interactions with it: the logic of the window, without a window.
//!
//! [`Session`] is the one object that acts. Its parts are separate types, which know at most a
//! [`Run`] and the parts above them; read them in the order below. Each displayed value is a
//! [`Reading`] of the run, or carries its [`Revision`]: no value outlives a change of its source.

mod run;
mod clock;
mod throttle;
mod trace;
mod energy;
mod stability_light;
mod live_error;
mod material;
mod touches;
mod solver;
mod hands;
mod recording;
mod failure;
mod trade;
mod past;
mod parts;
mod twin;
mod watching;

pub use clock::{BUDGET, Frame, Pace};
pub use failure::RunFailure;
pub use hands::MOST_HELD;
pub use live_error::{ErrorNow, ErrorReading, WINDOW as ERROR_WINDOW};
pub use material::{LookEdit, LookValues, Material, MaterialEdit, MaterialValues, MixedValue};
pub use msd_scene::Wind;
pub use parts::Parts;
pub use past::{Deed, Mark, MarkKind};
pub use run::{DeviceRun, Reading, Revision, Run};
pub use solver::MOST_SUBSTEPS;
pub use throttle::Throttle;
pub use touches::{TouchEdit, TouchValues, shells_of};
pub use trace::{Sample, Trace, WINDOW as TRACE_WINDOW};
#[cfg(target_arch = "wasm32")]
pub(crate) use trade::{
    Drive, Note, Order, RetryTask, SearchTask, SoundnessTask, StudyTask, Task, TermsTask, drive,
};
pub use trade::{
    FormerTerms, Report, STUDY_DURATION, STUDY_MANNERS, Search, StudyFrom, Trade, choice_of,
};
pub use twin::Twin;

use clock::Clock;
use energy::EnergyReadings;
use failure::WaysOut;
use glam::DVec3;
use hands::Grab;
use live_error::LiveErrorMeter;
use material::{is_look, is_of_looks};
use msd_core::stability::Estimator;
use msd_core::{Energy, Error, Interaction, Scene, Settings, Vector};
use msd_run::recording::Event;
use msd_run::rescue::{Offer, Origin, debris};
use msd_run::{History, Moment, Runner, Watch, on};
use msd_scene::Loaded;
use msd_study::space::{Space, known};
use past::{Timeline, Undo};
use recording::SessionRecording;
use stability_light::StabilityLight;
use std::fmt::Display;
use trade::subject;
use watching::Counts;

/// Most interactions at once that are recorded one by one. The springs of a body of a material have
/// their values in thousands of ranges; the current state of the run is no longer than these.
const MOST_EVENTS: usize = 200;

/// A scene that runs and pauses, and that the user rewinds, grabs, tunes and records.
#[derive(Debug)]
pub struct Session {
    loaded: Loaded,
    run: Run,
    clock: Clock,
    paused: bool,
    history: History,
    material: Material,
    grab: Grab,
    /// The wind, from the edits or the scene, and whether it acts on the run.
    wind: Wind,
    is_blowing: bool,
    energy: EnergyReadings,
    stability_light: StabilityLight,
    /// Predicts for automatic substeps.
    estimator: Estimator,
    /// Estimates the error while the user wants it.
    live_error: Option<LiveErrorMeter>,
    /// Problems of the run.
    watch: Watch,
    counts: Counts,
    recording: SessionRecording,
    /// Reason why the run paused by itself.
    failure: Option<RunFailure>,
    ways_out: WaysOut,
    trade: Trade,
    timeline: Timeline,
    undo: Undo,
    parts: Parts,
    /// Steps at the last change that moved the limit of stability.
    limit_of: u64,
    /// A copy of the run with other settings, while the user wants it.
    twin: Option<Box<Twin>>,
    /// Error of the spacing of the scene, if a study has measured it.
    space: Option<Space>,
    /// The last refusal, for the status line.
    refusal: Option<String>,
    gpu: run::GpuSwitch,
}

/// Flow of time in the run, forwards and back.
impl Session {
    /// Starts a scene, running.
    ///
    /// # Errors
    /// The first row or setting of the scene that is out of its domain.
    pub fn new(loaded: Loaded) -> Result<Self, Error> {
        let run = Run::new(run::open(&loaded, loaded.solver())?);
        let watch = Watch::new(run.runner(), &loaded.scene);
        let material = Material::of(&loaded);
        let space = known(&loaded.scene).filter(|space| space.error().is_some());
        let mut session = Session {
            loaded,
            run,
            clock: Clock::default(),
            paused: false,
            history: History::default(),
            material,
            grab: Grab::default(),
            wind: Wind::default(),
            is_blowing: false,
            energy: EnergyReadings::default(),
            stability_light: StabilityLight::default(),
            estimator: Estimator::default(),
            live_error: None,
            watch,
            counts: Counts::default(),
            recording: SessionRecording::default(),
            failure: None,
            ways_out: WaysOut::default(),
            trade: Trade::default(),
            timeline: Timeline::default(),
            undo: Undo::default(),
            parts: Parts::default(),
            limit_of: 0,
            twin: None,
            space,
            refusal: None,
            gpu: run::GpuSwitch::default(),
        };
        session.follow_wind();
        session.material.read(session.run.runner());
        session.energy.sample((&session.run, &mut session.watch));
        Ok(session)
    }

    /// Replaces the scene and all edits of the old one. Pause, speed, error estimate and recording
    /// stay on or off.
    ///
    /// # Errors
    /// See [`Session::new`]; the old scene continues then.
    pub fn open(&mut self, loaded: Loaded) -> Result<(), Error> {
        let mut session = Session::new(loaded)?;
        session.paused = self.paused && self.failure.is_none();
        session.clock.set_speed(self.clock.speed());
        session.set_estimating(self.live_error.is_some());
        session.set_trading(self.trade.is_on());
        session.set_study_paused(self.trade.is_paused());
        session.recording = std::mem::take(&mut self.recording);
        *self = session;
        self.record_start();
        Ok(())
    }

    /// Advances by `real` seconds of wall clock; `stopwatch` gives the seconds spent in this frame.
    pub fn advance(&mut self, real: f64, stopwatch: &impl Fn() -> f64) -> Frame {
        self.undo.pass(real);
        let frame = if self.paused { Frame::default() } else { self.take_steps(real, stopwatch) };
        if self.runner().is_open() {
            self.prepare(stopwatch);
        }
        let passed = Frame { real, ..frame };
        self.energy.follow((&self.run, &mut self.watch), passed, stopwatch);
        self.stability_light.refresh(&self.run, real, stopwatch);
        self.watch_over(passed, stopwatch);
        self.search_ways_out(real, stopwatch);
        self.trade.refresh(&self.run, (&self.loaded, self.steady_force()), real);
        self.take_found();
        frame
    }

    /// Takes the steps that are due.
    fn take_steps(&mut self, real: f64, stopwatch: &impl Fn() -> f64) -> Frame {
        let mut open = self.clock.begin(real, self.runner().settings().step, stopwatch);
        let mut steps = 0;
        while self.prepare(stopwatch)
            && self.is_ready()
            && self.clock.takes_step(&mut open, stopwatch)
            && self.take_step()
        {
            steps += 1;
        }
        let frame = self.clock.end(open, (steps, self.run.revision()), stopwatch);
        if 0.0 < frame.dropped
            && let Some(meter) = &mut self.live_error
        {
            meter.fall_behind();
        }
        frame
    }

    /// Takes one step and returns whether the run can continue.
    fn take_step(&mut self) -> bool {
        self.settle();
        self.before_step();
        let before = self.runner().moment();
        if let Some(meter) = &mut self.live_error {
            meter.before_step(&self.run);
        }
        let (settings, revision) = (self.runner().settings(), self.run.revision());
        let stepped = self.run.step(&before);
        self.note_end_of_device();
        self.energy.carry_over(revision, &self.run);
        self.note_renewal(settings);
        if let Err(error) = stepped {
            self.fail(&error);
            return false;
        }
        if let Some(meter) = &mut self.live_error {
            meter.after_step(&self.run);
        }
        if let Some(twin) = &mut self.twin {
            twin.step(&self.run);
        }
        self.history.push(before);
        self.failure = None;
        let recorded = self.recording.step();
        self.refuse(recorded);
        let runner = self.run.runner();
        self.watch.step(runner);
        self.timeline.look(runner.steps(), runner.contacts().count, self.watch.found());
        true
    }

    /// Pauses in the last state before the run broke into debris.
    fn fail(&mut self, error: &Error) {
        self.paused = true;
        self.release();
        let back = debris(self.run.runner(), &self.history);
        let revision = self.run.revision();
        self.go_back(back);
        self.energy.carry_over(revision, &self.run);
        self.energy.sample((&self.run, &mut self.watch));
        self.stability_light.forget();
        self.timeline.mark(self.runner().steps(), MarkKind::Warning);
        self.failure = Some(RunFailure::new(error, 0 < back, self.runner().time()));
    }

    /// Pauses or resumes. After a divergence the run stays paused until a change.
    pub fn toggle_pause(&mut self) {
        self.paused = !self.paused;
        self.clock.resume();
    }

    /// Pauses and takes one step forward.
    pub fn step_forward(&mut self) {
        self.paused = true;
        if let Some(ahead) = self.timeline.ahead().checked_sub(1) {
            return self.look_back(ahead);
        }
        self.take_step();
        self.energy.rewind(self.runner().time());
        self.energy.sample((&self.run, &mut self.watch));
    }

    /// Pauses and returns to the state before the last step; returns whether one exists.
    pub fn step_back(&mut self) -> bool {
        self.paused = true;
        let (ahead, earlier) = (self.timeline.ahead(), !self.history.is_empty());
        if 0 < ahead {
            self.look_back(ahead + 1);
            return earlier;
        }
        let is_back = self.go_back(1);
        if is_back {
            self.watch.change(self.run.runner());
            self.failure = None;
        }
        is_back
    }

    /// Goes back by a number of steps; returns whether that state exists. The watch keeps its
    /// knowledge of the steps that are taken back.
    fn go_back(&mut self, steps: usize) -> bool {
        let Some(moment) = self.history.nth_back(steps).cloned() else { return false };
        let settings = self.runner().settings();
        if let Err(error) = self.return_to(&moment) {
            self.refusal = Some(error.to_string());
            return false;
        }
        for _ in 0..steps {
            self.history.pop();
            let recorded = self.recording.back(|| recording::now(&self.loaded, self.run.runner()));
            self.refuse(recorded);
        }
        self.note_renewal(settings);
        self.timeline.drop_after(self.runner().steps(), self.runner().contacts().count);
        self.restart_twin();
        self.energy.rewind(self.runner().time());
        true
    }

    /// Makes an earlier state the current one. Its automatic substeps are valid again, unless a
    /// later change moved the limit of stability.
    fn return_to(&mut self, moment: &Moment) -> Result<(), Error> {
        let is_other = moment.steps < self.limit_of;
        self.change_unwatched(|runner| {
            runner.go_back(moment)?;
            if is_other { runner.set_automatic(runner.is_automatic()) } else { Ok(()) }
        })
    }

    /// Records renewed automatic substeps, so that a replay does not choose any.
    fn note_renewal(&mut self, before: Settings) {
        let settings = self.runner().settings();
        if settings != before {
            self.record(&Event::Settings(settings));
        }
    }

    /// Starts again from the first state. The user's solver, material and world stay; pins and
    /// frozen shapes return to those of the scene.
    pub fn restart(&mut self) {
        self.restart_from(Origin::Start);
    }

    fn restart_from(&mut self, origin: Origin) {
        let fresh = match self.origins().copy(origin) {
            Ok(fresh) => fresh,
            Err(error) => return self.refusal = Some(error),
        };
        // A run that stopped by itself resumes.
        if self.failure.take().is_some() {
            self.paused = false;
        }
        (self.grab, self.is_blowing) = (Grab::default(), false);
        self.change_unwatched(|runner| *runner = fresh);
        self.watch = Watch::new(self.run.runner(), &self.loaded.scene);
        self.limit_of = 0;
        self.history.clear();
        self.timeline.clear();
        self.undo.clear();
        self.restart_twin();
        self.energy.clear();
        self.clock.resume();
        self.record_start();
        self.energy.sample((&self.run, &mut self.watch));
    }

    /// Sets the speed of simulated time, 1 for real time.
    pub fn set_speed(&mut self, speed: f64) {
        self.clock.set_speed(speed);
    }

    /// Ignores the wall-clock time up to the next frame, as after the window was hidden.
    pub fn resume(&mut self) {
        self.clock.resume();
    }
}

/// Interactions with the run between two steps.
impl Session {
    /// Changes the run other than by a step: all earlier readings become void.
    fn change<T>(&mut self, change: impl FnOnce(&mut Runner) -> T) -> T {
        let result = self.change_unwatched(change);
        self.watch.change(self.run.runner());
        result
    }

    /// Returns the scene at its start with its current values; `None` if particles were removed.
    pub(crate) fn current_scene(&self) -> Option<Scene> {
        let now = (&self.loaded, self.steady_force());
        subject(self.run.runner(), now, StudyFrom::Start)
    }

    /// Does the same without a restart of the watch.
    fn change_unwatched<T>(&mut self, change: impl FnOnce(&mut Runner) -> T) -> T {
        let result = self.run.change(change);
        self.material.read(self.run.runner());
        self.trade.follow(&self.run, (&self.loaded, self.steady_force()));
        result
    }

    /// Applies an interaction at once; returns whether the run accepted it.
    fn act(&mut self, interaction: Interaction) -> bool {
        self.settle();
        let settings = self.runner().settings();
        let is_gust = self.is_blowing && matches!(interaction, Interaction::SetForce { .. });
        let is_motion = is_gust || self.grab.moves(&interaction);
        let result = if is_look(&interaction) {
            self.run.paint(interaction)
        } else if is_motion {
            if let Some(meter) = &mut self.live_error {
                meter.follow(interaction, &self.run);
            }
            self.run.move_held(interaction)
        } else {
            self.change(|runner| run::act(runner, interaction))
        };
        let is_accepted = result.is_ok();
        // Motions arrive without a new action of the user: the message of the last refusal stays.
        if !is_motion || !is_accepted {
            self.refusal = result.err().map(|error| error.to_string());
        }
        if is_accepted {
            self.note_limit(&[interaction]);
            self.record(&Event::Act(interaction));
            self.note_renewal(settings);
            if let Some(twin) = &mut self.twin {
                twin.act(&[interaction], &self.run);
            }
        }
        is_accepted
    }

    /// Notes that interactions may have moved the limit of stability.
    fn note_limit(&mut self, done: &[Interaction]) {
        if done.iter().map(Interaction::effects).any(|effects| effects.springs || effects.masses) {
            self.limit_of = self.runner().steps();
        }
    }

    /// Applies several interactions at once: all, or none if one is refused.
    fn act_all(&mut self, interactions: &[Interaction]) -> bool {
        self.settle();
        let settings = self.runner().settings();
        let result = self.change(|runner| {
            let queued = interactions.iter().try_for_each(|&each| runner.queue(each));
            if queued.is_err() {
                on!(runner, simulation => simulation.clear_queue());
            }
            queued.and_then(|()| runner.apply_queued())
        });
        let is_accepted = result.is_ok();
        self.refusal = result.err().map(|error| error.to_string());
        if is_accepted {
            self.note_limit(interactions);
            if interactions.len() <= MOST_EVENTS {
                interactions.iter().for_each(|&each| self.record(&Event::Act(each)));
                self.note_renewal(settings);
            } else {
                self.record_start();
            }
            if let Some(twin) = &mut self.twin {
                twin.act(interactions, &self.run);
            }
        }
        is_accepted
    }

    /// Shows an error on the status line, if there is one.
    pub fn refuse<E: Display>(&mut self, result: Result<(), E>) {
        if let Err(error) = result {
            self.refusal = Some(error.to_string());
        }
    }
}

/// Readings of the session.
impl Session {
    /// Returns the scene as loaded.
    pub fn loaded(&self) -> &Loaded {
        &self.loaded
    }

    /// Returns the simulation.
    pub fn runner(&self) -> &Runner {
        self.run.runner()
    }

    /// Returns the position of a particle, metres.
    pub fn position(&self, particle: usize) -> DVec3 {
        on!(self.runner(), simulation => simulation.position(particle).to_f64())
    }

    /// Returns whether a particle is pinned.
    pub fn is_pinned(&self, particle: usize) -> bool {
        on!(self.runner(), simulation => simulation.model().is_pinned(particle))
    }

    /// Returns the energy of the last seconds.
    pub fn trace(&self) -> &Trace {
        self.energy.trace()
    }

    /// Returns the energy at the last reading; `None` until a new one after a change.
    pub fn energy(&self) -> Option<Energy> {
        self.energy.now(&self.run)
    }

    /// Returns the energy that contact has added since the last change of the run, joules.
    pub fn energy_of_contact(&self) -> Option<f64> {
        self.energy.added_by_contact(&self.run)
    }

    /// Returns whether the run is paused.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Returns the reason why the run stopped by itself.
    pub fn failure(&self) -> Option<&RunFailure> {
        self.failure.as_ref()
    }

    /// Returns the last refusal.
    pub fn refusal(&self) -> Option<&str> {
        self.refusal.as_deref()
    }

    /// Returns the target speed of simulated time, 1 for real time.
    pub fn speed(&self) -> f64 {
        self.clock.speed()
    }

    /// Returns the recovery options found so far after a failure.
    pub fn offers(&self) -> &[Offer] {
        if self.failure.is_some() { self.ways_out.offers(&self.run) } else { &[] }
    }

    /// Returns the springs with the fastest motion after a failure, the strongest first.
    pub fn fastest_springs(&self) -> &[usize] {
        if self.failure.is_some() { self.ways_out.fastest(&self.run) } else { &[] }
    }

    /// Returns whether a search for recovery options is in progress.
    pub fn is_searching(&self) -> bool {
        self.failure.is_some() && self.ways_out.is_searching(&self.run)
    }

    /// Returns whether a displayed value is still being computed: it needs frames, paused or not.
    pub fn is_working(&self) -> bool {
        let is_counting = self.touches() && self.crossings().is_none();
        let is_reading = self.stability().is_none() || self.energy().is_none() || is_counting;
        is_reading || self.is_searching()
    }

    /// Returns averages over the last frames; `None` while paused, and before the first frame after
    /// a change of the run.
    pub fn pace(&self) -> Option<Pace> {
        self.clock.pace(self.run.revision()).filter(|_| !self.paused)
    }

    /// Returns the number of steps that can be taken back.
    pub fn steps_back(&self) -> usize {
        self.history.len()
    }

    /// Returns the substep relative to the longest stable one, and the age of the prediction,
    /// seconds of wall clock; `None` until there is a prediction.
    pub fn stability(&self) -> Option<(f64, f64)> {
        self.stability_light.share(&self.run).map(|share| (share, self.stability_light.age()))
    }

    /// Returns the state of the error estimate; `None` while it is off.
    pub fn error(&self) -> Option<ErrorNow<'_>> {
        self.live_error.as_ref().map(|meter| meter.now(&self.run))
    }

    /// Returns the error of space, which belongs to the scene as loaded: `None` after a change of
    /// its material or world.
    pub fn space(&self) -> Option<&Space> {
        self.space.as_ref().filter(|_| self.material.set().iter().all(is_of_looks))
    }

    /// Returns the edits of material and world.
    pub fn material(&self) -> &Material {
        &self.material
    }
}
