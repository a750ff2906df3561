//! The guard against divergence: where a state left the world, and a substep that is stable.

use super::Simulation;
use crate::columns::threads::merge_shares;
use crate::error::{Divergence, Error};
use crate::methods::Failure;
use crate::number::{Real, Vector, at_level};
use crate::stability::Estimator;
use crate::system::{Columns, Model};
use fearless_simd::{Level, Simd, SimdBase, SimdMask};

impl<R: Real> Simulation<R> {
    /// Refuses a step that a method gave up, and a state outside the world.
    pub(super) fn guard(&self, failure: Option<Failure>) -> Result<(), Error> {
        let (step, time) = (self.steps + 1, self.time());
        let outside = match failure {
            Some(Failure::Tolerance(particle)) => {
                let tolerance = self.settings.tolerance;
                return Err(Error::Unreachable { tolerance, particle, step, time });
            }
            Some(Failure::Evaluations(done)) => {
                let (most, tolerance) = (self.most_evaluations, self.settings.tolerance);
                return Err(Error::TooManyEvaluations { most, tolerance, done, step, time });
            }
            Some(Failure::Unsolved { residual, iterations }) => {
                return Err(Error::Unsolved { residual, iterations, step, time });
            }
            Some(Failure::NotFinite(particle)) => Some(particle),
            None => first_outside(self.level, &self.model, &self.state),
        };
        let Some(particle) = outside else {
            return Ok(());
        };
        let stable = self.largest_substep_at(&self.good, &mut Estimator::default());
        Err(Error::Diverged(Divergence {
            particle,
            step,
            time,
            substep: self.settings.substep(),
            stable_substep: (stable != 0.0).then_some(stable),
        }))
    }

    /// The largest substep predicted stable about a state, seconds; infinite where the method
    /// chooses its own.
    pub(super) fn largest_substep_at(&self, at: &Columns<R>, estimator: &mut Estimator) -> f64 {
        if self.own_method.is_none() && self.settings.integrator.is_adaptive() {
            return f64::INFINITY;
        }
        let substeps = self.settings.substeps;
        estimator.limit((&self.model, at), self.time(), (self.region(), substeps))
    }
}

/// The first particle that is outside the world, or the velocity of which is not finite.
fn first_outside<R: Real>(level: Level, model: &Model<R>, state: &Columns<R>) -> Option<usize> {
    let (extent, columns) = (model.extent, (&*state.positions, &*state.velocities));
    // All at once first: faster than stopping at the first particle outside, as there hardly ever
    // is one.
    let is_inside = |share| is_share_within(level, extent, share);
    if merge_shares(columns, &is_inside, &|low, high| low & high) {
        return None;
    }
    let within = |vector: R::Vec3, bound: R| {
        let [x, y, z] = vector.components();
        (x.abs() <= bound) & (y.abs() <= bound) & (z.abs() <= bound)
    };
    model.slots.places().position(|at| {
        let (position, velocity) = state.get(at);
        !(within(position, extent) && within(velocity, R::LARGEST))
    })
}

fn is_share_within<R: Real>(level: Level, extent: R, (x, v): (&[R], &[R])) -> bool {
    at_level!(level, simd => is_within(simd, x, extent) & is_within(simd, v, R::LARGEST))
}

/// Whether no number of a column is beyond a bound; a NaN counts as beyond.
#[inline(always)]
fn is_within<S: Simd, R: Real>(simd: S, column: &[R], bound: R) -> bool {
    let bound = R::Native::<S>::splat(simd, bound);
    let mut is_inside = bound.simd_eq(bound);
    for record in column.chunks_exact(R::Native::<S>::LEN) {
        is_inside &= R::Native::<S>::from_slice(simd, record).abs().simd_le(bound);
    }
    is_inside.all_true()
}
