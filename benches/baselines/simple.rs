//! The simple kernel: the plain loops over springs, particles and planes, which are the oracle of
//! the compiled kernels and give the same bits.

use msd::core::explicit::{self, Scratch, Substep};
use msd::core::forces::{add_spring_forces, set_external_forces};
use msd::core::integrator::Family;
use msd::core::{Explicit, Model, Motion, Real, Scene, Settings, State, collision};

/// A system that is stepped by plain loops.
pub struct Simple<R: Real> {
    model: Model<R>,
    state: State<R>,
    scratch: Scratch<R>,
    settings: Settings,
    method: Explicit,
}

impl<R: Real> Simple<R> {
    /// Makes a scene ready to be stepped by an explicit method.
    pub fn new(scene: &Scene, settings: Settings) -> Self {
        let Family::Explicit(method) = settings.integrator.family() else {
            panic!("{} is not explicit", settings.integrator);
        };
        let (model, state) = Model::new(scene).expect("a valid scene");
        let scratch = Scratch::new(method, model.particle_count());
        Simple { model, state, scratch, settings, method }
    }

    /// Advances by one step.
    pub fn step(&mut self) {
        let Simple { model, state, scratch, settings, method } = self;
        let h = R::of(settings.substep());
        let inverse_masses = model.inverse_masses();
        let damped = !model.dampings().is_zero() || model.drag() != R::ZERO;
        let mut forces = |motion: Motion<'_, R>, forces: &mut [R::Vec3]| {
            set_external_forces(model, motion, forces) + add_spring_forces(model, motion, forces)
        };
        for substep in 0..settings.substeps {
            let substep = Substep { h, inverse_masses, warm: 0 < substep, damped };
            explicit::advance(*method, substep, state, scratch, &mut forces);
            collision::resolve(model, h, scratch.forces(), state);
        }
    }
}
