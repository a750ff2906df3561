//! Simulations whose precision is only known at run time.

use msd_core::elements::Element;
use msd_core::methods::Solved;
use msd_core::obstacles::Obstacle;
use msd_core::stability::Estimator;
use msd_core::{
    Contacts, Energy, Error, Integrator, Interaction, Ledger, Momentum, Progress, Scene, Settings,
    Simulation, Witness,
};
use msd_scene::{AnyState, Loaded, Precision};

/// A state and what its particles do not tell.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Positions and velocities.
    pub state: AnyState,
    /// Steps taken up to here.
    pub steps: u64,
    /// Energy taken away up to here.
    pub ledger: Ledger,
}

/// A simulation in either precision.
#[derive(Clone, Debug)]
pub enum Runner {
    /// Single precision.
    F32(Simulation<f32>),
    /// Double precision.
    F64(Simulation<f64>),
}

/// Evaluates an expression on the simulation inside a [`Runner`], whatever its precision.
///
/// `on!(runner, simulation => simulation.time())`
#[macro_export]
macro_rules! on {
    ($runner:expr, $simulation:ident => $value:expr) => {
        match $runner {
            $crate::Runner::F32($simulation) => $value,
            $crate::Runner::F64($simulation) => $value,
        }
    };
}

impl Runner {
    /// Makes what was loaded ready: a scene to run from its start, a saved run to go on.
    ///
    /// # Errors
    /// See [`Simulation::new`] and [`Simulation::resume`].
    pub fn open(loaded: &Loaded) -> Result<Self, Error> {
        Runner::open_with(loaded, loaded.settings, loaded.precision)
    }

    /// Makes it ready with another solver.
    ///
    /// # Errors
    /// See [`Runner::open`].
    pub fn open_with(
        loaded: &Loaded,
        settings: Settings,
        precision: Precision,
    ) -> Result<Self, Error> {
        let Some(progress) = &loaded.progress else {
            return Runner::new(&loaded.scene, settings, precision);
        };
        let mut runner = Runner::resume(&loaded.scene, progress, precision)?;
        if settings != progress.settings {
            runner.set_settings(settings)?;
        }
        Ok(runner)
    }

    /// The run as it is now, to be saved, or to go on from here.
    pub fn to_loaded(&self, name: &str, title: &str) -> Loaded {
        let (scene, progress) = self.progress();
        Loaded {
            name: name.into(),
            title: title.into(),
            scene,
            settings: self.settings(),
            precision: self.precision(),
            notes: Vec::new(),
            files: Vec::new(),
            progress: Some(Box::new(progress)),
        }
    }

    /// Checks a scene and makes it ready to run.
    ///
    /// # Errors
    /// See [`Simulation::new`].
    pub fn new(scene: &Scene, settings: Settings, precision: Precision) -> Result<Self, Error> {
        Ok(match precision {
            Precision::F32 => Runner::F32(Simulation::new(scene, settings)?),
            Precision::F64 => Runner::F64(Simulation::new(scene, settings)?),
        })
    }

    /// Makes a run go on that was taken down by [`Runner::progress`].
    ///
    /// # Errors
    /// See [`Simulation::resume`].
    pub fn resume(scene: &Scene, progress: &Progress, precision: Precision) -> Result<Self, Error> {
        Ok(match precision {
            Precision::F32 => Runner::F32(Simulation::resume(scene, progress)?),
            Precision::F64 => Runner::F64(Simulation::resume(scene, progress)?),
        })
    }

    /// Takes down the run: the rows of its scene as they are now, and how far it is.
    pub fn progress(&self) -> (Scene, Progress) {
        on!(self, simulation => simulation.progress())
    }

    /// The precision it runs in.
    pub fn precision(&self) -> Precision {
        match self {
            Runner::F32(_) => Precision::F32,
            Runner::F64(_) => Precision::F64,
        }
    }

    /// The same simulation in another precision, each number rounded once.
    ///
    /// # Errors
    /// See [`Simulation::convert`].
    pub fn convert(&self, precision: Precision) -> Result<Self, Error> {
        Ok(match precision {
            Precision::F32 => Runner::F32(on!(self, simulation => simulation.convert())?),
            Precision::F64 => Runner::F64(on!(self, simulation => simulation.convert())?),
        })
    }

    /// Advances by one step.
    ///
    /// # Errors
    /// See [`Simulation::step`].
    pub fn step(&mut self) -> Result<(), Error> {
        on!(self, simulation => simulation.step())
    }

    /// Adds an element of the caller's own; returns its handle.
    pub fn add_element(&mut self, element: impl Element<f32> + Element<f64> + 'static) -> usize {
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
        on!(self, simulation => simulation.queue(interaction))
    }

    /// Applies what is queued without stepping.
    ///
    /// # Errors
    /// See [`Simulation::apply_queued`].
    pub fn apply_queued(&mut self) -> Result<(), Error> {
        on!(self, simulation => simulation.apply_queued())
    }

    /// How the system is stepped.
    pub fn settings(&self) -> Settings {
        on!(self, simulation => simulation.settings())
    }

    /// Changes how the system is stepped.
    ///
    /// # Errors
    /// See [`Simulation::set_settings`].
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), Error> {
        on!(self, simulation => simulation.set_settings(settings))
    }

    /// The method in use.
    pub fn integrator(&self) -> Integrator {
        self.settings().integrator
    }

    /// A copy of the state.
    pub fn state(&self) -> AnyState {
        match self {
            Runner::F32(simulation) => AnyState::F32(simulation.state()),
            Runner::F64(simulation) => AnyState::F64(simulation.state()),
        }
    }

    /// Replaces the state, rounding it if it has another precision.
    ///
    /// # Errors
    /// See [`Simulation::set_state`].
    pub fn set_state(&mut self, state: &AnyState, steps: u64) -> Result<(), Error> {
        match (self, state) {
            (Runner::F32(simulation), AnyState::F32(state)) => simulation.set_state(state, steps),
            (Runner::F64(simulation), AnyState::F64(state)) => simulation.set_state(state, steps),
            (Runner::F32(simulation), AnyState::F64(state)) => {
                simulation.set_state(&state.convert(), steps)
            }
            (Runner::F64(simulation), AnyState::F32(state)) => {
                simulation.set_state(&state.convert(), steps)
            }
        }
    }

    /// A copy of what can be returned to.
    pub fn moment(&self) -> Moment {
        let ledger = on!(self, simulation => simulation.ledger());
        Moment { state: self.state(), steps: self.steps(), ledger }
    }

    /// Returns to an earlier moment of this run.
    ///
    /// # Errors
    /// See [`Simulation::set_state`].
    pub fn go_back(&mut self, moment: &Moment) -> Result<(), Error> {
        self.set_state(&moment.state, moment.steps)?;
        on!(self, simulation => simulation.set_ledger(moment.ledger));
        Ok(())
    }

    /// What obstacles did since the start.
    pub fn contacts(&self) -> Contacts {
        on!(self, simulation => simulation.contacts())
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

    /// Where the energy is.
    pub fn energy(&self) -> Energy {
        on!(self, simulation => simulation.energy())
    }

    /// Lets a witness look at the energy and returns it, see [`Witness::watch`].
    pub fn show_to(&self, witness: &mut Witness) -> Energy {
        on!(self, simulation => witness.watch(simulation))
    }

    /// How far the solves of the last step of an implicit method got, see [`Simulation::solved`].
    pub fn solved(&self) -> Option<Solved> {
        on!(self, simulation => simulation.solved())
    }

    /// Linear and angular momentum.
    pub fn momentum(&self) -> Momentum {
        on!(self, simulation => simulation.momentum())
    }

    /// Predicts the largest stable substep at the present state, seconds: 0 if no step is stable,
    /// infinite if every step is.
    pub fn stable_substep(&self) -> f64 {
        on!(self, simulation => simulation.stable_substep())
    }

    /// Predicts like [`Runner::stable_substep`], in columns that are kept for the next time.
    pub fn stable_substep_by(&self, estimator: &mut Estimator) -> f64 {
        on!(self, simulation => simulation.stable_substep_by(estimator))
    }
}
