//! Changes of the material of bodies while they move: springs, bends, volumes and masses at once.

use crate::elements::{Resists, Rows};
use crate::number::Real;
use crate::scene::check::check_mass;
use crate::system::Model;

/// A number of the material of a body.
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

/// Multiplies a number of the material of bodies. A mass that would not fit keeps its value.
pub(super) fn scale<R: Real>(
    model: &mut Model<R>,
    rows: Rows,
    (number, factor): (MaterialNumber, f64),
) {
    let (springs, bends, masses) = match number {
        MaterialNumber::Young => (factor, factor, 1.0),
        MaterialNumber::Thickness => (factor, factor * factor * factor, factor),
        MaterialNumber::Density => (1.0, 1.0, factor),
    };
    if springs != 1.0 {
        model.change(&rows, &|resists, constants| {
            let factor = if resists == Resists::Bending { bends } else { springs };
            constants.map(|value| times(value, factor))
        });
    }
    if masses != 1.0 {
        for particle in rows.0 {
            let mass = model.masses[particle].to_f64() * masses;
            // A removed particle has no mass.
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
pub(super) fn damp<R: Real>(model: &mut Model<R>, rows: &Rows, time: f64) {
    model.change(rows, &|_, [k, _]| [k, times(k, time)]);
}

/// A product that stays finite.
fn times<R: Real>(value: R, factor: f64) -> R {
    let product = R::of(value.to_f64() * factor);
    product.min(R::LARGEST).max(-R::LARGEST)
}
