//! The columns of a table, and the way from measurements to each.

use crate::measure::machine;
use crate::sweep::measure::{Comparison, Measured};
use crate::sweep::table::{Datum, Kind};
use msd_core::{Integrator, Settings};

pub(super) type Measure = (&'static str, Kind, fn(&Measured) -> Datum);

/// The columns after those of the grid, in their order; `docs/reference/sweeps.md` explains each.
pub(super) const MEASURES: [Measure; 41] = [
    ("integrator", Kind::Text, |m| text(m.settings.integrator)),
    ("precision", Kind::Text, |m| text(m.precision)),
    ("step", Kind::Number, |m| Datum::Number(m.settings.step)),
    ("substeps", Kind::Whole, |m| fixed(m.settings, Datum::Whole(m.settings.substeps.into()))),
    ("substep", Kind::Number, |m| fixed(m.settings, Datum::Number(m.settings.substep()))),
    ("tolerance", Kind::Number, |m| match m.settings.integrator.is_adaptive() {
        true => Datum::Number(m.settings.tolerance),
        false => Datum::Nothing,
    }),
    ("newton", Kind::Whole, |m| match m.settings.integrator.is_implicit() {
        true => Datum::Whole(m.settings.newton.into()),
        false => Datum::Nothing,
    }),
    ("particles", Kind::Whole, |m| Datum::Whole(m.particles as i64)),
    ("springs", Kind::Whole, |m| Datum::Whole(m.springs as i64)),
    ("stable_substep", Kind::Number, |m| Datum::number(m.stable)),
    ("outcome", Kind::Text, |m| text(if m.diverged.is_some() { "diverged" } else { "finished" })),
    ("diverged_time", Kind::Number, |m| {
        m.diverged.as_ref().map_or(Datum::Nothing, |at| Datum::number(at.time))
    }),
    ("diverged_particle", Kind::Whole, |m| {
        m.diverged.as_ref().map_or(Datum::Nothing, |at| Datum::Whole(at.particle as i64))
    }),
    ("duration", Kind::Number, |m| Datum::Number(m.time)),
    ("steps", Kind::Whole, |m| i64::try_from(m.steps).map_or(Datum::Nothing, Datum::Whole)),
    ("cpu_seconds", Kind::Number, |m| Datum::number(m.cpu)),
    ("cpu_per_second", Kind::Number, |m| Datum::number(m.cpu / m.time)),
    ("wall_seconds", Kind::Number, |m| Datum::number(m.wall)),
    ("spring_updates_per_second", Kind::Number, spring_updates),
    ("rms_error", Kind::Number, |m| error(m, |c| c.errors.rms)),
    ("max_error", Kind::Number, |m| error(m, |c| c.errors.max)),
    ("relative_error", Kind::Number, |m| error(m, |c| c.errors.rms / c.size)),
    ("velocity_error", Kind::Number, |m| error(m, |c| c.errors.velocity)),
    ("centre_error", Kind::Number, |m| error(m, |c| c.errors.centre)),
    ("energy_error", Kind::Number, |m| error(m, |c| c.errors.energy)),
    ("momentum_error", Kind::Number, |m| error(m, |c| c.errors.momentum)),
    ("penetration", Kind::Number, |m| error(m, |c| c.errors.penetration)),
    ("size", Kind::Number, |m| error(m, |c| c.size)),
    ("reference_uncertainty", Kind::Number, |m| error(m, |c| c.uncertainty)),
    ("samples", Kind::Whole, |m| {
        m.comparison.map_or(Datum::Nothing, |c| Datum::Whole(c.samples as i64))
    }),
    ("compared_until", Kind::Number, |m| error(m, |c| c.until)),
    ("kinetic", Kind::Number, |m| Datum::number(m.energy.kinetic)),
    ("elastic", Kind::Number, |m| Datum::number(m.energy.elastic)),
    ("gravitational", Kind::Number, |m| Datum::number(m.energy.gravitational)),
    ("dissipated", Kind::Number, |m| Datum::number(m.energy.dissipated)),
    ("supplied", Kind::Number, |m| Datum::number(m.energy.supplied)),
    ("total_energy", Kind::Number, |m| Datum::number(m.energy.total())),
    ("state_hash", Kind::Text, |m| text(format_args!("{:016x}", m.state_hash))),
    ("note", Kind::Text, |m| m.note.clone().map_or(Datum::Nothing, Datum::Text)),
    ("machine", Kind::Text, |_| text(machine::name())),
    ("msd_version", Kind::Text, |_| text(env!("CARGO_PKG_VERSION"))),
];

/// The columns that the processor alone measures: a device takes the steps of many cells at once,
/// and does not add up energy that is dissipated or supplied.
pub(super) const OF_PROCESSOR: [&str; 7] = [
    "cpu_seconds",
    "cpu_per_second",
    "wall_seconds",
    "spring_updates_per_second",
    "dissipated",
    "supplied",
    "total_energy",
];

/// The columns before those of the grid.
pub(super) const HEAD: [(&str, Kind); 3] =
    [("cell", Kind::Whole), ("hash", Kind::Text), ("scene", Kind::Text)];

pub(super) fn text(value: impl std::fmt::Display) -> Datum {
    Datum::Text(value.to_string())
}

/// A value that only methods with a fixed substep have.
fn fixed(settings: Settings, value: Datum) -> Datum {
    if settings.integrator.is_adaptive() { Datum::Nothing } else { value }
}

fn error(measured: &Measured, of: fn(&Comparison) -> f64) -> Datum {
    measured.comparison.as_ref().map_or(Datum::Nothing, |comparison| Datum::number(of(comparison)))
}

/// Springs times force evaluations per second of the processor, as `msd run` counts them; none
/// where that depends on the motion.
fn spring_updates(measured: &Measured) -> Datum {
    let evaluations = match measured.settings.integrator {
        Integrator::Rk4 => 4.0,
        Integrator::DormandPrince | Integrator::BackwardEuler | Integrator::ImplicitMidpoint => {
            return Datum::Nothing;
        }
        _ => 1.0,
    };
    let substeps = measured.steps as f64 * f64::from(measured.settings.substeps);
    Datum::number(substeps * evaluations * measured.springs as f64 / measured.cpu)
}
