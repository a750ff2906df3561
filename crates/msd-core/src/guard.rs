//! Has a run left the world, where, and at what step would it not have?

use crate::error::Divergence;
use crate::real::{Real, Vector};
use crate::settings::Settings;
use crate::stability::Estimator;
use crate::system::{Model, State};

/// The first particle that is outside the world, or the velocity of which is not finite.
pub(crate) fn first_outside<R: Real>(model: &Model<R>, state: &State<R>) -> Option<usize> {
    // A comparison that a NaN fails: it is not inside.
    let inside = |position: &R::Vec3| position.extent() <= model.extent;
    let finite = |velocity: &R::Vec3| velocity.extent().to_f64().is_finite();
    let mut rows = state.positions.iter().zip(&state.velocities);
    rows.position(|(x, v)| !inside(x) || !finite(v))
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
