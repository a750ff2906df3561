//! Changes of the material of bodies while they move: springs, bends, volumes and masses at once.

use crate::number::Real;
use crate::scene::check::check_mass;
use crate::system::Model;
use core::ops::Range;

/// The particles and the springs of bodies.
type Rows = (Range<usize>, Range<usize>);

/// A number of what a body is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum MaterialNumber {
    /// Young's modulus: the stiffness and the damping of springs, bends and volumes go with it.
    Young,
    /// The thickness of a sheet: springs and masses go with it, bends with its cube.
    Thickness,
    /// The density: masses go with it.
    Density,
}

/// Multiplies a number of what bodies are made of. A mass that would not fit stays as it is.
pub(super) fn scale<R: Real>(
    model: &mut Model<R>,
    (particles, rows): Rows,
    (number, factor): (MaterialNumber, f64),
) {
    let (springs, bends, masses) = match number {
        MaterialNumber::Young => (factor, factor, 1.0),
        MaterialNumber::Thickness => (factor, factor * factor * factor, factor),
        MaterialNumber::Density => (1.0, 1.0, factor),
    };
    if springs != 1.0 {
        model.springs.change(rows, |[k, b]| [k, b].map(|value| times(value, springs)));
        let is_of = |particle: u32| particles.contains(&(particle as usize));
        model.bends.change(is_of, |[k, b]| [k, b].map(|value| times(value, bends)));
        model.volumes.change(is_of, |[k, b]| [k, b].map(|value| times(value, springs)));
    }
    if masses != 1.0 {
        for particle in particles {
            let mass = model.masses[particle].to_f64() * masses;
            // One that was removed has none.
            if model.is_removed(particle) || check_mass::<R>(("interaction", 0), mass).is_err() {
                continue;
            }
            model.masses[particle] = R::of(mass);
            if !model.is_pinned(particle) {
                model.inverse_masses[particle] = R::ONE / model.masses[particle];
            }
        }
    }
}

/// Damps springs, bends and volumes of bodies by their stiffness times a time, seconds.
pub(super) fn damp<R: Real>(model: &mut Model<R>, (particles, rows): Rows, time: f64) {
    let is_of = |particle: u32| particles.contains(&(particle as usize));
    let damped = |[k, _]: [R; 2]| [k, times(k, time)];
    model.springs.change(rows, damped);
    model.bends.change(is_of, damped);
    model.volumes.change(is_of, damped);
}

/// A product that stays finite.
fn times<R: Real>(value: R, factor: f64) -> R {
    let product = R::of(value.to_f64() * factor);
    product.min(R::LARGEST).max(-R::LARGEST)
}
