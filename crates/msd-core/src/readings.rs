//! What can be measured of a simulation?

use crate::energy::{self, Energy, Momentum};
use crate::integrator::Integrator;
use crate::real::{Real, Vector};
use crate::simulation::Simulation;
use crate::snapshot::Snapshot;
use crate::stability::{self, Estimator, Mode};
use crate::system::State;
use alloc::vec::Vec;
use core::ops::Range;
use glam::DVec3;

impl<R: Real> Simulation<R> {
    /// Predicts the largest stable substep at the present state, seconds: 0 if no step is stable,
    /// infinite if every step is.
    pub fn stable_substep(&self) -> f64 {
        self.stable_substep_by(&mut Estimator::default())
    }

    /// Predicts like [`Simulation::stable_substep`], in columns that are kept for the next time.
    pub fn stable_substep_by(&self, estimator: &mut Estimator) -> f64 {
        self.largest_step_from(&self.state, estimator)
    }

    /// Predicts the largest substep that another method would take stably at the present state,
    /// in steps of so many substeps, seconds: see [`Estimator::limit`].
    pub fn stable_substep_of(&self, integrator: Integrator, substeps: u32) -> f64 {
        stability::limit(&self.model, &self.state, integrator, substeps)
    }

    /// A substep that is stable at every state in which no spring is compressed to nothing,
    /// seconds: see [`stability::guaranteed_limit`].
    pub fn guaranteed_substep(&self, integrator: Integrator) -> f64 {
        stability::guaranteed_limit(&self.model, integrator)
    }

    /// The fastest motion at the present state, taken for a single oscillator: that is exact where
    /// damping goes with stiffness.
    pub fn fastest_mode(&self) -> Mode {
        stability::fastest_mode(&self.model, &self.state)
    }

    /// Where the particles are, metres.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = R::Vec3> + '_ {
        self.state.positions.iter().copied()
    }

    /// How fast the particles move, metres per second.
    pub fn velocities(&self) -> impl ExactSizeIterator<Item = R::Vec3> + '_ {
        self.state.velocities.iter().copied()
    }

    /// Where a particle is, metres.
    pub fn position(&self, particle: usize) -> R::Vec3 {
        self.state.positions[particle]
    }

    /// How fast a particle moves, metres per second.
    pub fn velocity(&self, particle: usize) -> R::Vec3 {
        self.state.velocities[particle]
    }

    /// Overwrites `to` with where the particles are, metres, in single precision.
    pub fn copy_positions(&self, to: &mut Vec<[f32; 3]>) {
        to.clear();
        to.extend(self.positions().map(|position| position.to_f32().to_array()));
    }

    /// What a renderer may see.
    pub fn snapshot(&self) -> Snapshot<'_, R> {
        Snapshot::new(&self.model, &self.state)
    }

    /// Where the energy is.
    pub fn energy(&self) -> Energy {
        self.energy_and_rounding().0
    }

    /// Where the energy is, and by how much rounding every coordinate and speed once can change
    /// it, joules: see [`energy::energy_and_rounding`].
    pub fn energy_and_rounding(&self) -> (Energy, f64) {
        let (energy, rounding) = energy::energy_and_rounding(&self.model, &self.state);
        let dissipated = self.ledger.dissipated(|| energy.total());
        (Energy { dissipated, ..energy }, rounding)
    }

    /// Energy taken away since the start by dampers, drag and contact, joules.
    pub fn dissipated(&self) -> f64 {
        self.ledger.dissipated(|| energy::energy(&self.model, &self.state, 0.0).total())
    }

    /// Where the energy would be in another state of the system, nothing dissipated.
    pub fn energy_at(&self, state: &State<R>) -> Energy {
        energy::energy(&self.model, state, 0.0)
    }

    /// The centre of mass of a range of particles, metres.
    pub fn centre_of_mass(&self, particles: Range<usize>) -> DVec3 {
        energy::centre_of_mass(&self.model, &self.state, particles)
    }

    /// The present length of a spring, metres.
    pub fn length(&self, spring: usize) -> f64 {
        energy::length(&self.model, &self.state, spring)
    }

    /// The strain of a spring, (length − rest) / rest; its length in metres where the rest length
    /// is 0.
    pub fn strain(&self, spring: usize) -> f64 {
        energy::strain(&self.model, &self.state, spring)
    }

    /// Linear and angular momentum.
    pub fn momentum(&self) -> Momentum {
        energy::momentum(&self.model, &self.state)
    }
}
