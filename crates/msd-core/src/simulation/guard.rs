//! The guard against divergence: where a state left the world, and a substep that is stable.
//!
//! A state is outside too where a particle is so fast that its next substep crosses the whole
//! world, or where the step took or gave more energy than a number holds. A method that ends on a
//! kick leaves positions from before it.

use super::Simulation;
use crate::columns::threads::merge_shares;
use crate::contact::ending::Substep;
use crate::contact::found::When;
use crate::error::{Divergence, Error};
use crate::methods::{Done, Failure, Scratch};
use crate::number::{Real, Vector, at_level};
use crate::stability::Estimator;
use crate::system::state::check_motions;
use crate::system::{Columns, Model};
use fearless_simd::{Level, Simd, SimdBase, SimdMask};

impl<R: Real> Simulation<R> {
    /// Moves particles inside an obstacle out of it, as a contact does.
    pub(super) fn leave_obstacles(&mut self) {
        self.scratch.forces.fill(R::ZERO);
        let substep = Substep::instant(self.time());
        let Scratch { forces, contacts, .. } = &mut self.scratch;
        let when = When { time: substep.time, settles: substep.evaluated.settles() };
        self.model.find(self.level, &self.state.positions, when, contacts);
        self.model.resolve(self.level, &mut self.state, (forces, contacts), substep);
    }

    /// Checks that the state is inside the world; `inside` says so in words.
    pub(super) fn check_state(&self, inside: &'static str) -> Result<(), Error> {
        let motions = self.model.slots.places().map(|at| self.state.get(at));
        check_motions(motions, self.model.extent, inside)
    }

    /// Refuses a step that a method gave up, and a state outside the world.
    pub(super) fn guard(&self, done: &Done) -> Result<(), Error> {
        let (step, time) = (self.steps + 1, self.time());
        let outside = match done.failure {
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
            None => self.first_outside().or_else(|| (!done.is_finite()).then(|| self.fastest())),
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

    /// The first particle that is outside the world, or would cross all of it in a substep.
    fn first_outside(&self) -> Option<usize> {
        let extent = self.model.extent;
        let crossing = 2.0 * extent.to_f64() / self.settings.substep();
        // An adaptive method divides its step by itself.
        let is_adaptive = self.own_method.is_none() && self.settings.integrator.is_adaptive();
        let speed = if is_adaptive { R::LARGEST } else { R::of(crossing).min(R::LARGEST) };
        first_outside(self.level, &self.model, &self.state, [extent, speed])
    }

    /// The particle with the largest component of a velocity.
    fn fastest(&self) -> usize {
        let speed = |at| self.state.get(at).1.extent();
        let places = self.model.slots.places().map(speed).enumerate();
        let faster = |a: (usize, R), b: (usize, R)| if a.1 < b.1 { b } else { a };
        places.reduce(faster).map_or(0, |(particle, _)| particle)
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

/// The first particle a coordinate or a speed of which is beyond its bound.
fn first_outside<R: Real>(
    level: Level,
    model: &Model<R>,
    state: &Columns<R>,
    [extent, speed]: [R; 2],
) -> Option<usize> {
    let columns = (&*state.positions, &*state.velocities);
    // All at once first: faster than stopping at the first particle outside, as there hardly ever
    // is one.
    let is_inside = |share| is_share_within(level, [extent, speed], share);
    if merge_shares(columns, &is_inside, &|low, high| low & high) {
        return None;
    }
    let within = |vector: R::Vec3, bound: R| {
        let [x, y, z] = vector.components();
        (x.abs() <= bound) & (y.abs() <= bound) & (z.abs() <= bound)
    };
    model.slots.places().position(|at| {
        let (position, velocity) = state.get(at);
        !(within(position, extent) && within(velocity, speed))
    })
}

fn is_share_within<R: Real>(level: Level, [extent, speed]: [R; 2], (x, v): (&[R], &[R])) -> bool {
    at_level!(level, simd => is_within(simd, x, extent) & is_within(simd, v, speed))
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
