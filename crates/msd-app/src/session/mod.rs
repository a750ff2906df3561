//! A running scene and everything that a user does to it: the window's logic without a window.
//!
//! [`Session`] is the one object that acts. Its parts are types of their own, which know a [`Run`]
//! at most and parts above them; read them in the order below. What is shown is a [`Reading`] of
//! the run, or carries its [`Revision`]: none outlives a change of what it was computed from.

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
pub use run::{Reading, Revision, Run};
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
use msd_core::{Energy, Error, Interaction, Settings, Vector};
use msd_run::recording::Event;
use msd_run::rescue::{Offer, Origin, debris};
use msd_run::{History, Moment, Runner, Watch, on};
use msd_scene::Loaded;
use msd_study::space::{Space, known};
use past::{Timeline, Undo};
use recording::SessionRecording;
use stability_light::StabilityLight;
use std::fmt::Display;
use watching::Counts;

/// The most that is done at once and recorded one by one: the springs of a body of a material have
/// their values in thousands of runs of rows, and the run as it is then is no longer than they are.
const MOST_EVENTS: usize = 200;

/// A scene that runs, pauses, goes back, is grabbed, tuned and recorded.
#[derive(Debug)]
pub struct Session {
    loaded: Loaded,
    run: Run,
    clock: Clock,
    paused: bool,
    history: History,
    material: Material,
    grab: Grab,
    /// The wind, of the scene or as it was set, and whether it acts on the run.
    wind: Wind,
    is_blowing: bool,
    energy: EnergyReadings,
    stability_light: StabilityLight,
    /// Predicts for automatic substeps.
    estimator: Estimator,
    /// Estimates the error while the user wants it.
    live_error: Option<LiveErrorMeter>,
    /// What goes wrong in the run.
    watch: Watch,
    counts: Counts,
    recording: SessionRecording,
    /// Why the run paused by itself.
    failure: Option<RunFailure>,
    ways_out: WaysOut,
    trade: Trade,
    timeline: Timeline,
    undo: Undo,
    parts: Parts,
    /// Steps at the last change of what automatic substeps follow from.
    limit_of: u64,
    /// Steps beside the run while the user wants it.
    twin: Option<Box<Twin>>,
    /// What the spacing of the scene costs, where a study has found that.
    space: Option<Space>,
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
        };
        session.follow_wind();
        session.material.read(session.run.runner());
        session.energy.sample((&session.run, &mut session.watch));
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
        session.set_trading(self.trade.is_on());
        session.set_study_paused(self.trade.is_paused());
        session.recording = std::mem::take(&mut self.recording);
        *self = session;
        self.record_start();
        Ok(())
    }

    /// Lets `real` seconds of wall clock pass; `stopwatch` gives the seconds spent in this frame.
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

    /// Takes the steps that the clock asks for.
    fn take_steps(&mut self, real: f64, stopwatch: &impl Fn() -> f64) -> Frame {
        let mut open = self.clock.begin(real, self.runner().settings().step, stopwatch);
        let mut steps = 0;
        while self.prepare(stopwatch)
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

    /// Takes one step and returns whether the run can go on.
    fn take_step(&mut self) -> bool {
        self.settle();
        self.before_step();
        let before = self.runner().moment();
        if let Some(meter) = &mut self.live_error {
            meter.before_step(&self.run);
        }
        let (settings, revision) = (self.runner().settings(), self.run.revision());
        let stepped = self.run.step();
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

    /// Pauses at the last state that is no debris.
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

    /// Pauses or goes on. After a divergence it stays paused until something is changed.
    pub fn toggle_pause(&mut self) {
        self.paused = !self.paused;
        self.clock.resume();
    }

    /// Pauses and takes one step.
    pub fn step_forward(&mut self) {
        self.paused = true;
        if let Some(ahead) = self.timeline.ahead().checked_sub(1) {
            return self.look_back(ahead);
        }
        self.take_step();
        self.energy.rewind(self.runner().time());
        self.energy.sample((&self.run, &mut self.watch));
    }

    /// Pauses and returns to the state before the last step; returns whether there was one.
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

    /// Returns to the state of so many steps before; whether there was one. The watch keeps what it
    /// knows of the steps that are taken back.
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

    /// Makes an earlier moment that of now. Automatic substeps are those of then, unless what they
    /// follow from was changed since.
    fn return_to(&mut self, moment: &Moment) -> Result<(), Error> {
        let is_other = moment.steps < self.limit_of;
        self.change_unwatched(|runner| {
            runner.go_back(moment)?;
            if is_other { runner.set_automatic(runner.is_automatic()) } else { Ok(()) }
        })
    }

    /// Records automatic substeps that are others than before, so that a replay chooses nothing.
    fn note_renewal(&mut self, before: Settings) {
        let settings = self.runner().settings();
        if settings != before {
            self.record(&Event::Settings(settings));
        }
    }

    /// Starts again from the first state. Solver, material and world stay as the user set them;
    /// pins and frozen shapes are the scene's again.
    pub fn restart(&mut self) {
        self.restart_from(Origin::Start);
    }

    fn restart_from(&mut self, origin: Origin) {
        let fresh = match self.origins().copy(origin) {
            Ok(fresh) => fresh,
            Err(error) => return self.refusal = Some(error),
        };
        // A run that stopped by itself starts again by itself.
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
    /// Changes the run other than by a step: nothing that was read of it before is shown after.
    fn change<T>(&mut self, change: impl FnOnce(&mut Runner) -> T) -> T {
        let result = self.change_unwatched(change);
        self.watch.change(self.run.runner());
        result
    }

    /// The same, where the watch goes on.
    fn change_unwatched<T>(&mut self, change: impl FnOnce(&mut Runner) -> T) -> T {
        let result = self.run.change(change);
        self.material.read(self.run.runner());
        self.trade.follow(&self.run, (&self.loaded, self.steady_force()));
        result
    }

    /// Does something to the simulation at once; returns whether it was accepted.
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
        // Motions go on by themselves: they are no answer to what was refused.
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

    /// Notes that what was done moves the limit of stability.
    fn note_limit(&mut self, done: &[Interaction]) {
        if done.iter().map(Interaction::effects).any(|effects| effects.springs || effects.masses) {
            self.limit_of = self.runner().steps();
        }
    }

    /// Does several things at once: all, or none where one is refused.
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

/// What can be read of it.
impl Session {
    /// The scene as it was loaded.
    pub fn loaded(&self) -> &Loaded {
        &self.loaded
    }

    /// The simulation.
    pub fn runner(&self) -> &Runner {
        self.run.runner()
    }

    /// Where a particle is, metres.
    pub fn position(&self, particle: usize) -> DVec3 {
        on!(self.runner(), simulation => simulation.position(particle).to_f64())
    }

    /// Whether a particle is pinned.
    pub fn is_pinned(&self, particle: usize) -> bool {
        on!(self.runner(), simulation => simulation.model().is_pinned(particle))
    }

    /// The energy of the last seconds.
    pub fn trace(&self) -> &Trace {
        self.energy.trace()
    }

    /// The energy now; `None` while it is being worked out.
    pub fn energy(&self) -> Option<Energy> {
        self.energy.now(&self.run)
    }

    /// Energy that contact has added since the run was changed last, joules.
    pub fn energy_of_contact(&self) -> Option<f64> {
        self.energy.added_by_contact(&self.run)
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

    /// The ways out of a failure that were found so far.
    pub fn offers(&self) -> &[Offer] {
        if self.failure.is_some() { self.ways_out.offers(&self.run) } else { &[] }
    }

    /// The springs that carry the fastest motion after a failure, the strongest first.
    pub fn fastest_springs(&self) -> &[usize] {
        if self.failure.is_some() { self.ways_out.fastest(&self.run) } else { &[] }
    }

    /// Whether ways out of a failure are being looked for.
    pub fn is_searching(&self) -> bool {
        self.failure.is_some() && self.ways_out.is_searching(&self.run)
    }

    /// Whether something that is shown is being worked out: frames are needed, paused or not.
    pub fn is_working(&self) -> bool {
        let is_counting = self.touches() && self.crossings().is_none();
        let is_reading = self.stability().is_none() || self.energy().is_none() || is_counting;
        is_reading || self.is_searching()
    }

    /// Averages over the last frames; `None` while paused, and before a frame was measured since
    /// the run was changed.
    pub fn pace(&self) -> Option<Pace> {
        self.clock.pace(self.run.revision()).filter(|_| !self.paused)
    }

    /// How many steps can be taken back.
    pub fn steps_back(&self) -> usize {
        self.history.len()
    }

    /// The substep as a share of the longest stable one, and the age of the prediction, seconds of
    /// wall clock; `None` while it is being worked out.
    pub fn stability(&self) -> Option<(f64, f64)> {
        self.stability_light.share(&self.run).map(|share| (share, self.stability_light.age()))
    }

    /// What is known of the error; `None` while the user does not want to know.
    pub fn error(&self) -> Option<ErrorNow<'_>> {
        self.live_error.as_ref().map(|meter| meter.now(&self.run))
    }

    /// What is known of the error of space: of the scene as it was loaded, and so nothing once its
    /// material or its world was changed.
    pub fn space(&self) -> Option<&Space> {
        self.space.as_ref().filter(|_| self.material.set().iter().all(is_of_looks))
    }

    /// What was set of material and world.
    pub fn material(&self) -> &Material {
        &self.material
    }
}
