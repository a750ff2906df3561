//! Errors of a state, compared with the right one at the same time.

use msd_core::glam::DVec3;
use msd_core::{Simulation, State};
use serde::{Deserialize, Serialize};

/// Distance of a run from its reference: each number is the largest of all samples compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Root of the mean square distance of the particles from where they should be, metres.
    pub rms: f64,
    /// Largest distance of a particle from where it should be, metres.
    pub max: f64,
    /// Root of the mean square error of the velocities, metres per second.
    pub velocity: f64,
    /// Distance of the centre of mass from where it should be, metres.
    pub centre: f64,
    /// Error of kinetic, elastic and gravitational energy together, joules.
    pub energy: f64,
    /// Error of the linear momentum, kilogram metres per second.
    pub momentum: f64,
    /// Deepest that a particle was inside a plane, metres.
    pub penetration: f64,
}

impl Errors {
    /// The larger of two, number by number.
    pub fn worse(&self, other: &Errors) -> Errors {
        Errors {
            rms: self.rms.max(other.rms),
            max: self.max.max(other.max),
            velocity: self.velocity.max(other.velocity),
            centre: self.centre.max(other.centre),
            energy: self.energy.max(other.energy),
            momentum: self.momentum.max(other.momentum),
            penetration: self.penetration.max(other.penetration),
        }
    }
}

/// Compares a state of a simulated system with the right one.
///
/// # Panics
/// If one of the states has another number of particles than the system.
pub fn compare(simulation: &Simulation<f64>, state: &State<f64>, right: &State<f64>) -> Errors {
    let model = simulation.model();
    let count = model.particle_count();
    let (mut squares, mut max, mut speeds, mut penetration) = (0.0, 0.0f64, 0.0, 0.0f64);
    for particle in 0..count {
        let off = (state.positions[particle] - right.positions[particle]).length_squared();
        squares += off;
        max = max.max(off);
        speeds += (state.velocities[particle] - right.velocities[particle]).length_squared();
        if !model.is_pinned(particle) {
            let obstacles = model.obstacles();
            for obstacle in (0..obstacles.count()).map(|index| obstacles.get(index)) {
                let gap = obstacle.gap(state.positions[particle], simulation.time());
                penetration = penetration.max(-gap);
            }
        }
    }
    let mechanical = |state| simulation.energy_at(state).total();
    let mass: f64 = model.masses().iter().sum();
    let moment = |vectors: &[DVec3]| -> DVec3 {
        vectors.iter().zip(model.masses()).map(|(&vector, &mass)| vector * mass).sum()
    };
    let centre = |state: &State<f64>| moment(&state.positions) / mass;
    Errors {
        rms: (squares / count as f64).sqrt(),
        max: max.sqrt(),
        velocity: (speeds / count as f64).sqrt(),
        centre: (centre(state) - centre(right)).length(),
        energy: (mechanical(state) - mechanical(right)).abs(),
        momentum: (moment(&state.velocities) - moment(&right.velocities)).length(),
        penetration,
    }
}

/// Root of the mean square distance between the particles of two states, metres.
///
/// # Panics
/// If they have different numbers of particles.
pub fn rms_distance(a: &State<f64>, b: &State<f64>) -> f64 {
    rms_between(&a.positions, &b.positions)
}

/// Root of the mean square distance between as many points here and there, metres.
///
/// # Panics
/// If there are not as many.
pub fn rms_between(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len(), "as many points here and there");
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (*a - *b).length_squared()).sum();
    (squares / a.len().max(1) as f64).sqrt()
}
