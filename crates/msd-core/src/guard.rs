//! Has a run left the world, where, and at what step would it not have?

use crate::error::Divergence;
use crate::real::{Real, Vector};
use crate::settings::Settings;
use crate::stability::Estimator;
use crate::system::{Model, State};

/// The first particle that is outside the world, or the velocity of which is not finite.
pub(crate) fn first_outside<R: Real>(model: &Model<R>, state: &State<R>) -> Option<usize> {
    // A comparison that a NaN fails: it is not inside.
    let within = |vector: &R::Vec3, bound: R| {
        let [x, y, z] = vector.components();
        (x.abs() <= bound) & (y.abs() <= bound) & (z.abs() <= bound)
    };
    let inside = |(x, v): (&R::Vec3, &R::Vec3)| within(x, model.extent) & within(v, R::LARGEST);
    let mut rows = state.positions.iter().zip(&state.velocities);
    // All at once first, which is faster than to stop at one that is hardly ever there.
    if rows.clone().fold(true, |all, row| all & inside(row)) {
        return None;
    }
    rows.position(|row| !inside(row))
}

/// Tells of a particle that left the world in a step that began at a time, from a good state.
pub(crate) fn divergence<R: Real>(
    model: &Model<R>,
    (good, settings): (&State<R>, &Settings),
    (particle, step, time): (usize, u64, f64),
) -> Divergence {
    let stable = largest_step(model, (good, settings), &mut Estimator::default());
    Divergence {
        particle,
        step,
        time,
        substep: settings.substep(),
        stable_substep: (stable != 0.0).then_some(stable),
    }
}

/// The largest substep predicted stable about a state, seconds; any where the method chooses it.
pub(crate) fn largest_step<R: Real>(
    model: &Model<R>,
    (state, settings): (&State<R>, &Settings),
    estimator: &mut Estimator,
) -> f64 {
    let Settings { integrator, substeps, .. } = *settings;
    if integrator.is_adaptive() {
        return f64::INFINITY;
    }
    estimator.limit((model, state), integrator, substeps)
}
