//! Energy, momentum, and lengths of springs. All sums are in `f64`.
//!
//! [`Ledger`] counts the energy dissipated since the start; [`Moduli`] are those of the springs, as
//! if they were a uniform material.

mod ledger;
mod moduli;

pub use ledger::Ledger;
pub use moduli::Moduli;

use crate::columns::{LANES, RECORD};
use crate::elements::Element;
use crate::number::{Real, Vector, at_level};
use crate::obstacles::Placed;
use crate::system::{Columns, Model};
use core::ops::Range;
use fearless_simd::Level;
use glam::DVec3;

/// The energy of a system, joules.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Energy {
    /// Of motion: Σ m v² / 2.
    pub kinetic: f64,
    /// In the springs, Σ k (length − rest)² / 2, in the bends, Σ k s² / 2, in the volumes,
    /// Σ Λ V0 e² / 2.
    pub elastic: f64,
    /// In the uniform fields, gravity and the uniform force: −Σ (m g + f)·x; zero at the origin.
    pub gravitational: f64,
    /// Of user-defined elements, by [`Element::energy`].
    #[cfg_attr(feature = "serde", serde(default))]
    pub own: f64,
    /// Dissipated since the start by dampers, drag and contact, see [`Ledger`]. The work of user
    /// input (grabs, pushes, changed stiffness) is not counted anywhere.
    pub dissipated: f64,
    /// Supplied since the start by moving solids, moving pins and user-defined elements; not
    /// negative. Energy that moving pins take back counts as dissipated.
    #[cfg_attr(feature = "serde", serde(default))]
    pub supplied: f64,
}

impl Energy {
    /// The energy of the state, joules: kinetic, elastic, gravitational and of user-defined
    /// elements.
    pub fn mechanical(&self) -> f64 {
        self.kinetic + self.elastic + self.gravitational + self.own
    }

    /// The mechanical energy plus the dissipated and minus the supplied energy, joules: constant in
    /// an exact run without user input.
    pub fn total(&self) -> f64 {
        self.mechanical() + self.dissipated - self.supplied
    }
}

/// Measures the energy of a state, nothing dissipated, and by how much rounding every coordinate
/// and speed once can change it, joules.
///
/// With δ the rounding of a coordinate, ε times its size or times its fall in a `substep` onto its
/// support, and that of its distance from the middle of a solid, the latter is k δ (|stretch| + δ)
/// of a spring, bend or volume, m |g| δ + ε m v² of a particle, and 2 ε E of a user-defined
/// element.
pub(crate) fn energy_and_rounding<R: Real>(
    model: &Model<R>,
    state: &Columns<R>,
    (time, substep): (f64, f64),
    level: Level,
) -> (Energy, f64) {
    let moment = model.moment(level, state.motion(&model.slots, time));
    let own = model.own.energy(&moment.motion);
    let masses = model.mass_column.as_chunks::<LANES>().0;
    let [positions, velocities] =
        [&state.positions, &state.velocities].map(|column| column.as_chunks::<RECORD>().0);
    let mut sums = ParticleSums::default();
    at_level!(level, _simd => {
        for ((masses, x), v) in masses.iter().zip(positions).zip(velocities) {
            sums.add(masses, x, v);
        }
    });
    let total = |lanes: [f64; LANES]| lanes.iter().sum::<f64>();
    let [kinetic, mass, count] = [sums.kinetic, sums.mass, sums.count].map(total);
    let far = sums.far.into_iter().fold(0.0, Real::max);
    let gravitational = model.fields.potential(sums.moments.map(total), sums.places.map(total));
    let mut energy = Energy { kinetic, gravitational, own, ..Energy::default() };
    let (mut pull, mut total_stiffness) = (0.0, 0.0);
    for kind in model.inner() {
        let [stored, pulls, stiffness] = kind.energy_and_pulls(&moment);
        energy.elastic += stored;
        pull += pulls;
        total_stiffness += stiffness;
    }
    let epsilon = R::EPSILON.to_f64();
    let [gravity, force] = [model.gravity(), model.force()].map(|field| {
        let field = field.to_f64();
        Real::sqrt(field.dot(field))
    });
    let delta = epsilon * Real::max(far, gravity * substep * substep);
    let delta = delta + f64::EPSILON * farthest_on_solids(model, far, time);
    let rounding = delta * (gravity * mass + force * count + pull + delta * total_stiffness);
    (energy, rounding + 2.0 * epsilon * (kinetic + own.abs()))
}

/// Largest distance from the middle of a solid to a particle on it, metres, by the largest
/// coordinate of all. The particle is placed as seen from that middle, whatever its own
/// coordinates, in double precision.
fn farthest_on_solids<R: Real>(model: &Model<R>, far: f64, time: f64) -> f64 {
    // A place with three such coordinates.
    let out = Real::sqrt(3.0) * far;
    let farthest = model.solids().iter().map(|solid| {
        let middle = Placed::new(solid, time).middle;
        let (away, reach) = (Real::sqrt(middle.dot(middle)), solid.shape.reach());
        if away <= out + reach { Real::min(reach, away + out) } else { 0.0 }
    });
    farthest.fold(0.0, Real::max)
}

/// The kinetic energy, joules.
pub(crate) fn kinetic<R: Real>(model: &Model<R>, state: &Columns<R>) -> f64 {
    let velocities = state.velocities.as_chunks::<RECORD>().0;
    let mut lanes = [0.0; LANES];
    for (v, masses) in velocities.iter().zip(model.mass_column.as_chunks::<LANES>().0) {
        for (lane, sum) in lanes.iter_mut().enumerate() {
            let [x, y, z] = [0, LANES, 2 * LANES].map(|axis| v[axis + lane]);
            *sum += (masses[lane] * (x * x + y * y + z * z)).to_f64();
        }
    }
    0.5 * lanes.iter().sum::<f64>()
}

/// Sums over the particles that were not removed, lane by lane.
#[derive(Clone, Copy, Debug, Default)]
struct ParticleSums {
    /// Kinetic energy, joules.
    kinetic: [f64; LANES],
    mass: [f64; LANES],
    count: [f64; LANES],
    /// Of position by axis, metres, and of mass times position.
    places: [[f64; LANES]; 3],
    moments: [[f64; LANES]; 3],
    /// The largest coordinate, metres.
    far: [f64; LANES],
}

impl ParticleSums {
    /// Adds a record. A particle that was removed has no mass.
    #[inline(always)]
    fn add<R: Real>(&mut self, masses: &[R; LANES], x: &[R; RECORD], v: &[R; RECORD]) {
        for lane in 0..LANES {
            let mass = masses[lane].to_f64();
            let is_there = mass != 0.0;
            let [vx, vy, vz] = [0, 1, 2].map(|axis| v[axis * LANES + lane].to_f64());
            let twice = mass * (vx * vx + vy * vy + vz * vz);
            self.kinetic[lane] += if is_there { 0.5 * twice } else { 0.0 };
            self.mass[lane] += mass;
            self.count[lane] += if is_there { 1.0 } else { 0.0 };
            for axis in 0..3 {
                let place = x[axis * LANES + lane].to_f64();
                let place = if is_there { place } else { 0.0 };
                self.places[axis][lane] += place;
                self.moments[axis][lane] += mass * place;
                self.far[lane] = Real::max(self.far[lane], place.abs());
            }
        }
    }
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
pub(crate) fn momentum<R: Real>(model: &Model<R>, state: &Columns<R>) -> Momentum {
    let mut momentum = Momentum::default();
    for (at, mass) in model.slots.places().zip(&model.masses) {
        let (position, velocity) = state.get(at);
        let linear = velocity.to_f64() * mass.to_f64();
        momentum.linear += linear;
        momentum.angular += position.to_f64().cross(linear);
    }
    momentum
}

/// Measures the centre of mass of a range of particles, metres; NaN where all were removed.
pub(crate) fn centre_of_mass<R: Real>(
    model: &Model<R>,
    state: &Columns<R>,
    particles: Range<usize>,
) -> DVec3 {
    let (mut mass, mut moment) = (0.0, DVec3::ZERO);
    for particle in particles {
        let here = model.masses[particle].to_f64();
        let (position, _) = state.get(model.slots.at(particle));
        mass += here;
        moment += position.to_f64() * here;
    }
    moment / mass
}

/// The present length of a spring, metres.
pub(crate) fn length<R: Real>(model: &Model<R>, state: &Columns<R>, spring: usize) -> f64 {
    let [a, b] = model.ends()[spring].map(|end| state.get(model.slots.at(end as usize)).0);
    let across = b.to_f64() - a.to_f64();
    Real::sqrt(across.dot(across))
}
