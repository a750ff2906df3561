//! How do many copies of a scene run at once? Sixteen side by side, each as if it were alone.
//!
//! Copies share what is joined to what, the method and the number of substeps; all else is their
//! own: masses, pins, springs, planes, the world, the length of a step and the state. Each keeps
//! the bits of a [`Simulation`] of its own.
//!
//! It pays for single precision, AVX-512, full groups of sixteen and a thousand particles or so: a
//! spring then takes a sixth of its time in the plain loops, and 0.5 (springs that join anything to
//! anything) to 0.9 (a lattice) of that in a simulation. In double precision, and beyond what the
//! cache holds, simulations one after the other are as fast or faster.
//!
//! ```
//! use msd_core::{Ensemble, Material, Scene, Settings, Simulation, shape};
//!
//! # fn main() -> Result<(), msd_core::Error> {
//! let copies: Vec<_> = (1..=16).map(|copy| {
//!     let material = Material { mass: 0.1, stiffness: 50.0 * f64::from(copy), damping: 0.5 };
//!     let scene = Scene::of("cloth", shape::cloth([10, 10], 0.1, material)?);
//!     Simulation::<f32>::new(&scene, Settings::default())
//! }).collect::<Result<_, _>>()?;
//! let mut ensemble = Ensemble::new(&copies)?;
//! for _ in 0..60 {
//!     ensemble.step();
//! }
//! assert_eq!(ensemble.running(), 16);
//! assert!((ensemble.time(15) - 1.0).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```

use crate::error::Error;
use crate::guard;
use crate::integrator::{Explicit, Family};
use crate::kernel::{Groups, Instructions};
use crate::real::Real;
use crate::settings::Settings;
use crate::simulation::Simulation;
use crate::system::{Model, State};
use alloc::vec::Vec;

/// Copies of a scene that differ in numbers, but not in what is joined to what.
///
/// It steps and nothing else: no hand, no force of the caller's but a constant one
/// ([`Ensemble::set_load`]), no count of the energy taken away.
#[derive(Clone, Debug)]
pub struct Ensemble<R: Real = f32> {
    copies: Vec<Copy<R>>,
    groups: Groups<R>,
    substeps: u32,
    /// Steps that copies which still run have taken here.
    taken: u64,
}

/// What a copy has of its own, but for its state.
#[derive(Clone, Debug)]
struct Copy<R: Real> {
    model: Model<R>,
    settings: Settings,
    /// Steps at the start.
    start: u64,
    /// Steps and time at which the length of a step changed last.
    epoch: (u64, f64),
    stopped: Option<Stopped<R>>,
}

/// Where a copy ended.
#[derive(Clone, Debug)]
struct Stopped<R: Real> {
    /// The last good state, and the steps that had been taken to it.
    good: State<R>,
    taken: u64,
    /// The first particle that left the world.
    particle: usize,
}

impl<R: Real> Ensemble<R> {
    /// Makes an ensemble of simulations as they are now.
    ///
    /// # Errors
    /// [`Error::NoCopies`]; [`Error::Unsuited`] for a method that is not explicit, a grab, a push
    /// or a queued interaction; [`Error::Unlike`] for another number of particles, springs between
    /// others, another method or number of substeps than those of the first.
    pub fn new(simulations: &[Simulation<R>]) -> Result<Self, Error> {
        let first = simulations.first().ok_or(Error::NoCopies)?;
        let method = suited(first, 0)?;
        for (copy, simulation) in simulations.iter().enumerate() {
            suited(simulation, copy)?;
            check_alike(first, simulation, copy)?;
        }
        let rows = simulations.iter().map(|s| (s.model(), s.state(), s.settings().substep()));
        let rows: Vec<_> = rows.collect();
        let copy = |simulation: &Simulation<R>| Copy {
            model: simulation.model().clone(),
            settings: simulation.settings(),
            start: simulation.steps(),
            epoch: simulation.epoch,
            stopped: None,
        };
        Ok(Ensemble {
            groups: Groups::new(&rows, method),
            copies: simulations.iter().map(copy).collect(),
            substeps: first.settings().substeps,
            taken: 0,
        })
    }

    /// Advances every copy that still runs by one step of its own length. One that leaves the world
    /// stops at its last good state, see [`Ensemble::error`].
    pub fn step(&mut self) {
        let Ensemble { copies, groups, substeps, taken } = self;
        groups.advance(*substeps);
        while let Some(copy) = groups.outside() {
            let particle = guard::first_outside(&copies[copy].model, &groups.state(copy, false));
            let (good, particle) = (groups.state(copy, true), particle.unwrap_or(0));
            copies[copy].stopped = Some(Stopped { good, taken: *taken, particle });
            groups.stop(copy);
        }
        *taken += 1;
    }

    /// The number of copies.
    pub fn count(&self) -> usize {
        self.copies.len()
    }

    /// The number of copies that still run.
    pub fn running(&self) -> usize {
        self.copies.iter().filter(|copy| copy.stopped.is_none()).count()
    }

    /// Whether a copy still runs.
    ///
    /// # Panics
    /// If there is no such copy; so for all that is asked of one.
    pub fn runs(&self, copy: usize) -> bool {
        self.copies[copy].stopped.is_none()
    }

    /// The state of a copy: the last good one if it has stopped.
    pub fn state(&self, copy: usize) -> State<R> {
        match &self.copies[copy].stopped {
            Some(stopped) => stopped.good.clone(),
            None => self.groups.state(copy, false),
        }
    }

    /// Why a copy has stopped: what [`Simulation::step`] would have said.
    pub fn error(&self, copy: usize) -> Option<Error> {
        let Copy { model, settings, stopped, .. } = &self.copies[copy];
        let Stopped { good, particle, .. } = stopped.as_ref()?;
        let at = (*particle, self.steps(copy) + 1, self.time(copy));
        Some(guard::divergence(model, (good, settings), at).into())
    }

    /// Steps taken by a copy, with those before it came here.
    pub fn steps(&self, copy: usize) -> u64 {
        let Copy { start, stopped, .. } = &self.copies[copy];
        start + stopped.as_ref().map_or(self.taken, |stopped| stopped.taken)
    }

    /// Simulated time of a copy, seconds.
    pub fn time(&self, copy: usize) -> f64 {
        let Copy { epoch: (steps, time), settings, .. } = &self.copies[copy];
        time + (self.steps(copy) - steps) as f64 * settings.step
    }

    /// What a step of a copy reads.
    pub fn model(&self, copy: usize) -> &Model<R> {
        &self.copies[copy].model
    }

    /// How a copy is stepped.
    pub fn settings(&self, copy: usize) -> Settings {
        self.copies[copy].settings
    }

    /// The norms of the velocities of all copies: roots of the sums of the squares of all speeds,
    /// in `f64`. Of a copy that has stopped a number without meaning.
    pub fn speeds(&self) -> Vec<f64> {
        let sums = self.groups.squared_speeds();
        sums.take(self.copies.len()).map(Real::sqrt).collect()
    }

    /// Sets constant forces on the particles of a copy, newtons, added after all others: those of
    /// a [`Simulation::step_with`] that adds the same ones in every step.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for another number of particles.
    pub fn set_load(&mut self, copy: usize, load: &[R::Vec3]) -> Result<(), Error> {
        let (count, expected) = (load.len(), self.copies[copy].model.particle_count());
        if count != expected {
            return Err(Error::WrongLength { what: "load", count, expected });
        }
        self.groups.set_load(copy, load);
        Ok(())
    }

    /// Chooses the instructions of the steps to come, see [`Simulation::set_instructions`].
    pub fn set_instructions(&mut self, instructions: Instructions) {
        self.groups.set_instructions(instructions);
    }
}

/// The method of a simulation that an ensemble can run.
fn suited<R: Real>(simulation: &Simulation<R>, copy: usize) -> Result<Explicit, Error> {
    let unsuited = |reason| Err(Error::Unsuited { copy, reason });
    let Family::Explicit(method) = simulation.settings().integrator.family() else {
        return unsuited("its integrator is not explicit");
    };
    if !simulation.model().grabs().is_empty() || !simulation.model().pushes.is_empty() {
        return unsuited("a hand is on it");
    }
    if !simulation.queued().is_empty() {
        return unsuited("interactions wait for its next step; apply them first");
    }
    Ok(method)
}

fn check_alike<R: Real>(
    first: &Simulation<R>,
    other: &Simulation<R>,
    copy: usize,
) -> Result<(), Error> {
    let (models, settings) =
        ([first, other].map(Simulation::model), [first, other].map(Simulation::settings));
    let alike = [
        ("the number of particles", models[0].particle_count() == models[1].particle_count()),
        ("what the springs join", models[0].ends() == models[1].ends()),
        ("the integrator", settings[0].integrator == settings[1].integrator),
        ("the number of substeps", settings[0].substeps == settings[1].substeps),
    ];
    let unlike = alike.into_iter().find(|&(_, alike)| !alike);
    unlike.map_or(Ok(()), |(what, _)| Err(Error::Unlike { what, copy }))
}
