//! Simulations whose precision is only known at run time.

use crate::automatic::{Automatic, Cause, Substeps, divided, longest_automatic};
use crate::crossings::{WentThrough, crossings, went_through};
use msd_core::elements::Element;
use msd_core::methods::Solved;
use msd_core::obstacles::Obstacle;
use msd_core::stability::Estimator;
use msd_core::{
    Contacts, Energy, Error, Integrator, Interaction, Ledger, Momentum, Progress, RowImpulse,
    Scene, Settings, Shell, Simulation, Vector, Witness,
};
use msd_scene::schema::Solver;
use msd_scene::{AnyState, Loaded, Precision, Wind};
use serde::Serialize;

/// The most work of a step that someone waits for, evaluations of springs and particles: a fraction
/// of a second.
const MOST_WORK: u64 = 100_000_000;
/// The evaluations of all forces that a step of the largest scene may take all the same.
const LEAST_EVALUATIONS: u64 = 600;

/// A state with the data that its particles do not hold.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Positions and velocities.
    pub state: AnyState,
    /// Steps taken up to here.
    pub steps: u64,
    /// Energy taken away up to here.
    pub ledger: Ledger,
    /// Substeps per step, which a return restores where they are automatic.
    pub substeps: u32,
    /// The impulses from which shells start the next substep.
    pub impulses: Vec<RowImpulse>,
}

/// A simulation in either precision, whose substeps may be automatic.
#[derive(Clone, Debug)]
pub enum Runner {
    /// Single precision.
    F32(Simulation<f32>, Substeps),
    /// Double precision.
    F64(Simulation<f64>, Substeps),
}

/// Evaluates an expression on the simulation inside a [`Runner`], whatever its precision.
///
/// `on!(runner, simulation => simulation.time())`
#[macro_export]
macro_rules! on {
    ($runner:expr, $simulation:ident => $value:expr) => {
        match $runner {
            $crate::Runner::F32($simulation, _) => $value,
            $crate::Runner::F64($simulation, _) => $value,
        }
    };
}

/// Failures of contact between bodies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Touched {
    /// Number of possible tunnellings of bodies since the start; see
    /// [`Ledger::passes`](msd_core::Ledger::passes).
    pub passes: u64,
    /// Pairs of triangles that cross now, of surfaces that meet; see [`crossings`].
    pub crossings: u64,
    /// The bodies that were seen to go through each other since the start.
    pub went_through: Vec<WentThrough>,
}

impl Runner {
    /// Makes a loaded file ready: a scene to run from its start, a saved run to go on.
    ///
    /// # Errors
    /// See [`Simulation::new`] and [`Simulation::resume`].
    pub fn open(loaded: &Loaded) -> Result<Self, Error> {
        Runner::open_with(loaded, loaded.solver())
    }

    /// Makes it ready with another solver.
    ///
    /// # Errors
    /// See [`Runner::open`].
    pub fn open_with(loaded: &Loaded, solver: Solver) -> Result<Self, Error> {
        let mut runner = Runner::open_lazily(loaded, solver)?;
        runner.substeps_mut().is_lazy = false;
        if runner.is_open() {
            runner.choose()?;
        }
        Ok(runner)
    }

    /// The same, but for automatic substeps. Here and after each change of springs, masses or
    /// settings they keep their number until the next step begins, or [`Runner::prepare`] has
    /// chosen them.
    ///
    /// # Errors
    /// See [`Runner::open`].
    pub fn open_lazily(loaded: &Loaded, solver: Solver) -> Result<Self, Error> {
        let Solver { settings, precision, automatic } = solver;
        let Some(progress) = &loaded.progress else {
            let mut runner = Runner::new(&loaded.scene, settings, precision)?;
            runner.substeps_mut().is_lazy = true;
            runner.set_wind(loaded, loaded.wind());
            runner.set_automatic(automatic)?;
            return Ok(runner);
        };
        let mut runner = Runner::resume(&loaded.scene, progress, precision)?;
        runner.substeps_mut().is_lazy = true;
        runner.set_wind(loaded, loaded.wind());
        if automatic && loaded.automatic {
            runner.resume_automatic(&progress.queue);
        } else {
            runner.set_automatic(automatic)?;
        }
        if settings != progress.settings {
            runner.set_settings(settings)?;
        }
        Ok(runner)
    }

    /// The current run, to be saved, or to go on from here.
    pub fn to_loaded(&self, name: &str, title: &str) -> Loaded {
        let (mut scene, progress) = self.progress();
        let wind = self.substeps().gusts;
        if let Some((wind, calm)) = wind {
            scene.world.force = calm + wind.mean().force(0.0);
        }
        Loaded {
            title: title.into(),
            automatic: self.is_automatic(),
            precision: self.precision(),
            wind,
            progress: Some(Box::new(progress)),
            ..Loaded::new(name, scene, self.settings())
        }
    }

    /// Checks a scene and makes it ready to run.
    ///
    /// # Errors
    /// See [`Simulation::new`].
    pub fn new(scene: &Scene, settings: Settings, precision: Precision) -> Result<Self, Error> {
        Ok(match precision {
            Precision::F32 => Runner::F32(Simulation::new(scene, settings)?, Substeps::default()),
            Precision::F64 => Runner::F64(Simulation::new(scene, settings)?, Substeps::default()),
        })
    }

    /// The same, which frees the rows of the scene on the way.
    ///
    /// # Errors
    /// See [`Simulation::new`].
    pub fn from_scene(scene: Scene, settings: Settings, to: Precision) -> Result<Self, Error> {
        let substeps = Substeps::default();
        Ok(match to {
            Precision::F32 => Runner::F32(Simulation::from_scene(scene, settings)?, substeps),
            Precision::F64 => Runner::F64(Simulation::from_scene(scene, settings)?, substeps),
        })
    }

    /// Makes a run go on that was taken down by [`Runner::progress`].
    ///
    /// # Errors
    /// See [`Simulation::resume`].
    pub fn resume(scene: &Scene, progress: &Progress, precision: Precision) -> Result<Self, Error> {
        Ok(match precision {
            Precision::F32 => {
                Runner::F32(Simulation::resume(scene, progress)?, Substeps::default())
            }
            Precision::F64 => {
                Runner::F64(Simulation::resume(scene, progress)?, Substeps::default())
            }
        })
    }

    /// Takes down the run: the current rows of its scene, and how far it is.
    pub fn progress(&self) -> (Scene, Progress) {
        on!(self, simulation => simulation.progress())
    }

    /// The precision it runs in.
    pub fn precision(&self) -> Precision {
        match self {
            Runner::F32(..) => Precision::F32,
            Runner::F64(..) => Precision::F64,
        }
    }

    /// The same simulation in another precision, each number rounded once.
    ///
    /// # Errors
    /// See [`Simulation::convert`].
    pub fn convert(&self, precision: Precision) -> Result<Self, Error> {
        let substeps = *self.substeps();
        let mut runner = match precision {
            Precision::F32 => Runner::F32(on!(self, simulation => simulation.convert())?, substeps),
            Precision::F64 => Runner::F64(on!(self, simulation => simulation.convert())?, substeps),
        };
        runner.forget();
        Ok(runner)
    }

    /// Lets a wind come in gusts over a run of a loaded scene; a steady wind is a uniform force.
    pub fn set_wind(&mut self, loaded: &Loaded, wind: Wind) {
        let calm = loaded.force_in(Wind::default(), 0.0);
        self.substeps_mut().gusts = wind.is_gusty().then_some((wind, calm));
    }

    /// Lets the wind come in no gusts.
    pub fn calm(&mut self) {
        self.substeps_mut().gusts = None;
    }

    /// The uniform force that gusts have set before the last step; `None` where the wind is steady.
    pub fn gust(&self) -> Option<Interaction> {
        self.substeps().gusts?;
        let value = on!(self, simulation => simulation.model().force().to_f64());
        Some(Interaction::SetForce { value })
    }

    /// Advances by one step; automatic substeps are renewed before it where it is time to, and
    /// doubled, up to 1000, while shells may cross in it.
    ///
    /// # Errors
    /// See [`Simulation::step`].
    pub fn step(&mut self) -> Result<(), Error> {
        if let Some((wind, calm)) = self.substeps().gusts {
            self.queue(Interaction::SetForce { value: calm + wind.force(self.time()) })?;
        }
        if self.automatic().is_some_and(Automatic::is_due) {
            self.apply_queued()?;
        }
        self.choose()?;
        if self.is_automatic() && !self.integrator().is_adaptive() {
            return self.step_without_passes();
        }
        on!(self, simulation => simulation.step())
    }

    /// Takes a step with so many substeps that no shells may cross in one, or with the most.
    fn step_without_passes(&mut self) -> Result<(), Error> {
        let settings = self.settings();
        if let Err(error) = self.divide() {
            on!(self, simulation => simulation.set_settings(settings))?;
            return Err(error);
        }
        if self.settings() != settings {
            self.resume_automatic(&[]);
        }
        Ok(())
    }

    fn divide(&mut self) -> Result<(), Error> {
        while !on!(&mut *self, simulation => simulation.step_unless_passing())? {
            let Some(settings) = divided(self.settings()) else {
                return on!(self, simulation => simulation.step());
            };
            on!(&mut *self, simulation => simulation.set_settings(settings))?;
        }
        Ok(())
    }

    /// Bounds the work of each step of an adaptive method, so that a caller waits for at most about
    /// a second; a step that needs more fails. Returns whether a step of any other method, with its
    /// current substeps, stays within that.
    pub fn bound_work(&mut self) -> bool {
        let Settings { integrator, substeps, .. } = self.settings();
        let most = on!(self, simulation => {
            let model = simulation.model();
            let rows = (model.particle_count() + model.ends().len()).max(1) as u64;
            let most = (MOST_WORK / rows).max(LEAST_EVALUATIONS);
            simulation.set_most_evaluations(most);
            most
        });
        let each = if integrator == Integrator::Rk4 { 4 } else { 1 };
        integrator.is_adaptive() || each * u64::from(substeps) <= most
    }

    /// The longest substep that automatic ones may have in the current state, seconds: 0 if no step
    /// is stable, infinite if every step is.
    pub fn longest_automatic_substep(&self) -> f64 {
        on!(self, simulation => longest_automatic(simulation))
    }

    /// Returns whether the run chooses its substeps from the predicted limit of stability.
    pub fn is_automatic(&self) -> bool {
        self.automatic().is_some()
    }

    /// Returns whether automatic substeps are still those of before a change, and are to be chosen
    /// before the next step.
    pub fn is_open(&self) -> bool {
        self.automatic().is_some_and(Automatic::is_open)
    }

    /// Does a piece of choosing automatic substeps, where the next step begins with that; returns
    /// whether there may be more to do. A change of the run in between begins it anew, except for a
    /// motion of held particles.
    ///
    /// # Errors
    /// See [`Simulation::set_settings`].
    pub fn prepare(&mut self, estimator: &mut Estimator) -> Result<bool, Error> {
        let Some((automatic, cause)) = self.wanting() else { return Ok(false) };
        let prepared =
            on!(&mut *self, simulation => automatic.prepared(cause, simulation, estimator))?;
        self.substeps_mut().automatic = Some(prepared);
        Ok(true)
    }

    /// Automatic substeps, where the next step begins with a choice of them, and why.
    fn wanting(&self) -> Option<(Automatic, Cause)> {
        let automatic = self.automatic()?;
        let has_freed = on!(self, simulation => simulation.has_freed_pins());
        Some((automatic, automatic.cause(self.steps(), has_freed)?))
    }

    /// Chooses automatic substeps, where the next step begins with that.
    fn choose(&mut self) -> Result<(), Error> {
        if self.wanting().is_some() {
            let estimator = &mut Estimator::default();
            while self.prepare(estimator)? {}
        }
        Ok(())
    }

    /// Begins to choose substeps from the predicted limit, at once unless the run is lazy, or keeps
    /// their current number from now on.
    ///
    /// # Errors
    /// See [`Simulation::set_settings`].
    pub fn set_automatic(&mut self, automatic: bool) -> Result<(), Error> {
        let open = automatic.then(|| on!(&mut *self, simulation => Automatic::open(simulation)));
        self.substeps_mut().automatic = open;
        if self.substeps().is_lazy { Ok(()) } else { self.choose() }
    }

    /// Its solver: method, settings and whether substeps are automatic.
    pub fn solver(&self) -> Solver {
        let (settings, precision) = (self.settings(), self.precision());
        Solver { settings, precision, automatic: self.is_automatic() }
    }

    /// Changes its solver; in another precision, its state is rounded once.
    ///
    /// # Errors
    /// The first setting that is out of its domain: then nothing is changed.
    pub fn set_solver(&mut self, solver: Solver) -> Result<(), Error> {
        let Solver { settings, precision, automatic } = solver;
        if precision != self.precision() {
            let mut runner = self.convert(precision)?;
            runner.set_solver(solver)?;
            *self = runner;
            return Ok(());
        }
        on!(self, simulation => simulation.set_settings(settings))?;
        self.set_automatic(automatic)
    }

    /// Goes on with automatic substeps where a saved run left them.
    fn resume_automatic(&mut self, queue: &[Interaction]) {
        let resumed = on!(&mut *self, simulation => Automatic::resumed(simulation, queue));
        self.substeps_mut().automatic = Some(resumed);
    }

    /// Forgets the prediction, as something was changed.
    fn forget(&mut self) {
        self.substeps_mut().automatic = self.automatic().map(Automatic::forgotten);
    }

    fn substeps(&self) -> &Substeps {
        let (Runner::F32(_, substeps) | Runner::F64(_, substeps)) = self;
        substeps
    }

    fn substeps_mut(&mut self) -> &mut Substeps {
        let (Runner::F32(_, substeps) | Runner::F64(_, substeps)) = self;
        substeps
    }

    fn automatic(&self) -> Option<Automatic> {
        self.substeps().automatic
    }

    /// Adds an element of the caller's own; returns its handle.
    pub fn add_element(&mut self, element: impl Element<f32> + Element<f64> + 'static) -> usize {
        self.forget();
        on!(self, simulation => simulation.add_element(element))
    }

    /// Adds an obstacle of the caller's own; returns its handle.
    ///
    /// # Errors
    /// See [`Simulation::add_obstacle`].
    pub fn add_obstacle(
        &mut self,
        obstacle: impl Obstacle<f32> + Obstacle<f64> + 'static,
    ) -> Result<usize, Error> {
        on!(self, simulation => simulation.add_obstacle(obstacle))
    }

    /// Queues an interaction for the start of the next step.
    ///
    /// # Errors
    /// See [`Simulation::queue`].
    pub fn queue(&mut self, interaction: Interaction) -> Result<(), Error> {
        let automatic = self
            .automatic()
            .map(|now| on!(&*self, simulation => now.queued(simulation.model(), &interaction)));
        on!(&mut *self, simulation => simulation.queue(interaction))?;
        self.substeps_mut().automatic = automatic;
        Ok(())
    }

    /// Applies queued interactions without stepping; automatic substeps are chosen anew where those
    /// move the limit of stability, see [`Runner::set_automatic`].
    ///
    /// # Errors
    /// See [`Simulation::apply_queued`].
    pub fn apply_queued(&mut self) -> Result<(), Error> {
        on!(self, simulation => simulation.apply_queued())?;
        let is_due = self.automatic().is_some_and(Automatic::is_due);
        if is_due { self.set_automatic(true) } else { Ok(()) }
    }

    /// Replaces how bodies meet; automatic substeps are chosen anew.
    ///
    /// # Errors
    /// See [`Simulation::set_shells`].
    pub fn set_shells(&mut self, rows: &[Shell]) -> Result<(), Error> {
        on!(&mut *self, simulation => simulation.set_shells(rows))?;
        if self.is_automatic() { self.set_automatic(true) } else { Ok(()) }
    }

    /// Its settings: steps and their parts.
    pub fn settings(&self) -> Settings {
        on!(self, simulation => simulation.settings())
    }

    /// Changes how the system is stepped; automatic substeps are chosen anew, whatever the settings
    /// say of them.
    ///
    /// # Errors
    /// See [`Simulation::set_settings`].
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), Error> {
        on!(self, simulation => simulation.set_settings(settings))?;
        if self.is_automatic() { self.set_automatic(true) } else { Ok(()) }
    }

    /// The method in use.
    pub fn integrator(&self) -> Integrator {
        self.settings().integrator
    }

    /// A copy of the state.
    pub fn state(&self) -> AnyState {
        match self {
            Runner::F32(simulation, _) => AnyState::F32(simulation.state()),
            Runner::F64(simulation, _) => AnyState::F64(simulation.state()),
        }
    }

    /// Replaces the state, rounding it if it has another precision.
    ///
    /// # Errors
    /// See [`Simulation::set_state`].
    pub fn set_state(&mut self, state: &AnyState, steps: u64) -> Result<(), Error> {
        self.forget();
        match (self, state) {
            (Runner::F32(simulation, _), AnyState::F32(state)) => {
                simulation.set_state(state, steps)
            }
            (Runner::F64(simulation, _), AnyState::F64(state)) => {
                simulation.set_state(state, steps)
            }
            (Runner::F32(simulation, _), AnyState::F64(state)) => {
                simulation.set_state(&state.convert(), steps)
            }
            (Runner::F64(simulation, _), AnyState::F32(state)) => {
                simulation.set_state(&state.convert(), steps)
            }
        }
    }

    /// A copy of the state and all else that a return needs.
    pub fn moment(&self) -> Moment {
        let ledger = on!(self, simulation => simulation.ledger().clone());
        let substeps = self.settings().substeps;
        let impulses = on!(self, simulation => simulation.impulses());
        Moment { state: self.state(), steps: self.steps(), ledger, substeps, impulses }
    }

    /// Returns to an earlier moment of this run.
    ///
    /// # Errors
    /// See [`Simulation::set_state`].
    pub fn go_back(&mut self, moment: &Moment) -> Result<(), Error> {
        self.set_state(&moment.state, moment.steps)?;
        on!(&mut *self, simulation => simulation.set_ledger(moment.ledger.clone()));
        if self.is_automatic() && moment.substeps != self.settings().substeps {
            // As they were then, so that the same steps follow; the next renewal is due by itself.
            let settings = Settings { substeps: moment.substeps, ..self.settings() };
            on!(&mut *self, simulation => simulation.set_settings(settings))?;
            self.resume_automatic(&[]);
        }
        // Of a current substep.
        let longer = f64::from(moment.substeps) / f64::from(self.settings().substeps);
        let scaled = |row: &RowImpulse| RowImpulse {
            push: row.push * longer,
            rub: row.rub * longer,
            ..*row
        };
        let impulses: Vec<RowImpulse> = moment.impulses.iter().map(scaled).collect();
        on!(&mut *self, simulation => simulation.set_impulses(&impulses));
        Ok(())
    }

    /// Contacts with obstacles since the start.
    pub fn contacts(&self) -> Contacts {
        on!(self, simulation => simulation.contacts())
    }

    /// Failures of contact between bodies; `None` where no bodies meet.
    pub fn touched(&self) -> Option<Touched> {
        on!(self, simulation => {
            simulation.model().do_bodies_meet().then(|| Touched {
                passes: simulation.ledger().passes(),
                crossings: crossings(simulation),
                went_through: went_through(simulation),
            })
        })
    }

    /// Number of possible tunnellings of shells since the start.
    pub fn passes(&self) -> u64 {
        on!(self, simulation => simulation.ledger().passes())
    }

    /// The bodies that were seen to go through each other since the start, in the order of time.
    pub fn went_through(&self) -> Vec<WentThrough> {
        on!(self, simulation => went_through(simulation))
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        on!(self, simulation => simulation.steps())
    }

    /// Simulated time, seconds.
    pub fn time(&self) -> f64 {
        on!(self, simulation => simulation.time())
    }

    /// The number of particles.
    pub fn particle_count(&self) -> usize {
        on!(self, simulation => simulation.model().particle_count())
    }

    /// The number of springs.
    pub fn spring_count(&self) -> usize {
        on!(self, simulation => simulation.model().spring_count())
    }

    /// The energy, by its forms.
    pub fn energy(&self) -> Energy {
        on!(self, simulation => simulation.energy())
    }

    /// Lets a witness look at the energy and returns it, see [`Witness::watch`].
    pub fn show_to(&self, witness: &mut Witness) -> Energy {
        on!(self, simulation => witness.watch(simulation))
    }

    /// Convergence of the solves in the last step of an implicit method, see
    /// [`Simulation::solved`].
    pub fn solved(&self) -> Option<Solved> {
        on!(self, simulation => simulation.solved())
    }

    /// Linear and angular momentum.
    pub fn momentum(&self) -> Momentum {
        on!(self, simulation => simulation.momentum())
    }

    /// Predicts the largest stable substep in the current state, seconds: 0 if no step is stable,
    /// infinite if every step is.
    pub fn stable_substep(&self) -> f64 {
        on!(self, simulation => simulation.stable_substep())
    }

    /// Predicts like [`Runner::stable_substep`], in columns that are kept for the next time.
    pub fn stable_substep_by(&self, estimator: &mut Estimator) -> f64 {
        on!(self, simulation => simulation.stable_substep_by(estimator))
    }
}
