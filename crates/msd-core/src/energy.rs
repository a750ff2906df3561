//! Where is the energy, and how much momentum is there? All sums are in `f64`.

use crate::real::{Real, Vector};
use crate::system::{Model, State};
use core::ops::Range;
use glam::DVec3;

/// The energy of a system, joules.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Energy {
    /// Of motion: Σ m v² / 2.
    pub kinetic: f64,
    /// In the springs: Σ k (length − rest)² / 2.
    pub elastic: f64,
    /// In the uniform fields, gravity and the uniform force: −Σ (m g + f)·x; zero at the origin.
    pub gravitational: f64,
    /// Taken away since the start by dampers, drag and contact, see [`crate::ledger`]. What a hand
    /// does (grabs, pushes, moving pins, changed stiffness) is not counted anywhere.
    pub dissipated: f64,
}

impl Energy {
    /// Everything, joules: constant in an exact run that nobody touches.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravitational + self.dissipated
    }
}

/// Measures the energy of a state; `dissipated` is passed through.
pub fn energy<R: Real>(model: &Model<R>, state: &State<R>, dissipated: f64) -> Energy {
    Energy { dissipated, ..energy_and_rounding(model, state).0 }
}

/// Measures the energy of a state, nothing dissipated, and by how much rounding every coordinate
/// and speed once can change it, joules.
///
/// With δ the rounding of a coordinate, ε times its size, the latter is k δ (|stretch| + δ) of a
/// spring, and m |g| δ + ε m v² of a particle. Both from one pass, which costs as much as five
/// or six evaluations of the forces by a compiled kernel.
pub fn energy_and_rounding<R: Real>(model: &Model<R>, state: &State<R>) -> (Energy, f64) {
    let mut energy = Energy::default();
    let (gravity, force) = (model.gravity.to_f64(), model.force.to_f64());
    let (mut mass, mut far) = (0.0, 0.0);
    for ((&own, &position), &velocity) in
        model.masses.iter().zip(&state.positions).zip(&state.velocities)
    {
        let (own, velocity) = (own.to_f64(), velocity.to_f64());
        energy.kinetic += 0.5 * own * velocity.dot(velocity);
        energy.gravitational -= (gravity * own + force).dot(position.to_f64());
        mass += own;
        far = f64::max(far, position.extent().to_f64());
    }
    let (mut pull, mut total_stiffness) = (0.0, 0.0);
    for spring in 0..model.spring_count() {
        let stretch = length(model, state, spring) - model.rest_lengths[spring].to_f64();
        let stiffness = model.stiffnesses.get(spring).to_f64();
        energy.elastic += 0.5 * stiffness * stretch * stretch;
        pull += stiffness * stretch.abs();
        total_stiffness += stiffness;
    }
    let epsilon = R::EPSILON.to_f64();
    let delta = epsilon * far;
    let [gravity, force] = [gravity, force].map(|field| Real::sqrt(field.dot(field)));
    let weight = gravity * mass + force * model.particle_count() as f64;
    let rounding = delta * (weight + pull + delta * total_stiffness);
    (energy, rounding + 2.0 * epsilon * energy.kinetic)
}

/// The momentum of a system.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Momentum {
    /// Linear momentum, kilogram metres per second.
    pub linear: DVec3,
    /// Angular momentum about the origin, kilogram square metres per second.
    pub angular: DVec3,
}

/// Measures linear and angular momentum.
pub fn momentum<R: Real>(model: &Model<R>, state: &State<R>) -> Momentum {
    let mut momentum = Momentum::default();
    for (particle, mass) in model.masses.iter().enumerate() {
        let linear = state.velocities[particle].to_f64() * mass.to_f64();
        momentum.linear += linear;
        momentum.angular += state.positions[particle].to_f64().cross(linear);
    }
    momentum
}

/// Measures the centre of mass of a range of particles, metres.
pub fn centre_of_mass<R: Real>(
    model: &Model<R>,
    state: &State<R>,
    particles: Range<usize>,
) -> DVec3 {
    let (mut mass, mut moment) = (0.0, DVec3::ZERO);
    for particle in particles {
        let here = model.masses[particle].to_f64();
        mass += here;
        moment += state.positions[particle].to_f64() * here;
    }
    moment / mass
}

/// The strain of a spring, (length − rest) / rest; its length in metres where the rest length is 0.
pub fn strain<R: Real>(model: &Model<R>, state: &State<R>, spring: usize) -> f64 {
    let (length, rest) = (length(model, state, spring), model.rest_lengths[spring].to_f64());
    if rest == 0.0 { length } else { (length - rest) / rest }
}

/// The present length of a spring, metres.
pub fn length<R: Real>(model: &Model<R>, state: &State<R>, spring: usize) -> f64 {
    let [a, b] = model.ends[spring].map(|end| state.positions[end as usize].to_f64());
    let across = b - a;
    Real::sqrt(across.dot(across))
}
