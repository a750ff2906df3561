//! Preconditioned conjugate gradients: the change of velocity that cancels a residual.

use crate::columns::{Aligned, LANES, RECORD, vector};
use crate::elements::column;
use crate::number::{Real, Vector, at_level};
use crate::system::Model;
use fearless_simd::Level;

/// When a solve is good enough.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Fraction of the first residual that may be left, in the norm of the preconditioner.
    pub(crate) tolerance: f64,
    /// Iterations at least.
    pub(crate) fewest: usize,
}

/// The end of a solve. Squares are in the norm of the preconditioner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    /// The square of the residuals at the start, and of those at the end; NaN or infinite where a
    /// number was.
    pub(crate) first: f64,
    pub(crate) left: f64,
    pub(crate) iterations: usize,
}

/// The columns of a solve.
#[derive(Clone, Debug)]
pub(crate) struct Solve<R: Real> {
    /// The momentum still missing, kilogram metres per second.
    pub(crate) residuals: Aligned<R>,
    /// The change of velocity found, metres per second.
    pub(crate) changes: Aligned<R>,
    /// The preconditioner: the inverse of the block of each particle, as far as contact leaves it
    /// free, xx, xy and xz in one column, yy, yz and zz in another.
    pub(crate) preconditioner: [Aligned<R>; 2],
    /// The search direction, its product with the matrix, and the residuals times the
    /// preconditioner.
    pub(crate) directions: Aligned<R>,
    pub(crate) products: Aligned<R>,
    steered: Aligned<R>,
    /// Iterations at most.
    most: usize,
}

/// Iterations of one solve at most: bounds the time of a substep.
const MOST: usize = 1000;

impl<R: Real> Solve<R> {
    pub(crate) fn new(model: &Model<R>) -> Self {
        let column = |place| column(&model.slots, place);
        Solve {
            residuals: column(28),
            changes: column(29),
            preconditioner: [column(30), column(31)],
            directions: column(32),
            products: column(33),
            steered: column(34),
            // In exact arithmetic as many as there are unknowns suffice; rounding asks for a few
            // more.
            most: (4 * model.particle_count() + 16).min(MOST),
        }
    }

    /// The square of the residuals in the norm of the preconditioner.
    pub(crate) fn square(&mut self, level: Level) -> f64 {
        let Solve { residuals, preconditioner: [upper, lower], steered, .. } = self;
        at_level!(level, _simd => steer::<R>(residuals, upper, lower, steered))
    }

    /// Lowers the residuals by changing velocities. `first` is the square of residuals to compare
    /// with, if it is larger than that at the start. `hold` takes the held part out of the
    /// residuals, `multiply` overwrites its last argument with the product of the matrix and a
    /// direction.
    ///
    /// A direction in which the preconditioner is singular is never entered: that is how pins and
    /// contacts hold. Sums are in `f64`, one for each lane, so that they depend on nothing but the
    /// layout. Source: Hestenes and Stiefel, 1952; the projection is that of Baraff and Witkin,
    /// 1998, section 5.3, with the symmetry that Ascher and Boxerman, 2003, ask for.
    pub(crate) fn run(
        &mut self,
        level: Level,
        (goal, first): (Goal, f64),
        mut hold: impl FnMut(&mut [R]),
        mut multiply: impl FnMut(&[R], &mut [R]),
    ) -> End {
        let mut left = self.square(level);
        let first = first.max(left);
        let Solve { residuals, changes, preconditioner, directions, products, steered, most } =
            self;
        let [upper, lower] = &*preconditioner;
        directions.fill(R::ZERO);
        let enough = goal.tolerance * goal.tolerance * first;
        let mut keep = R::ZERO;
        let (mut iterations, mut bound) = (0, f64::INFINITY);
        // Stops before a product would spread a NaN or an infinity.
        while left.is_finite() && iterations < *most && (enough < left || iterations < goal.fewest)
        {
            at_level!(level, _simd => turn::<R>(directions, steered, keep));
            multiply(directions, products);
            let curvature = at_level!(level, _simd => dot::<R>(directions, products));
            // Not positive where only rounding is left, or where there was nothing to do; or where
            // a user-defined element repels. Then the step is that of the preconditioner alone:
            // without it, gravity would be lost with the rest.
            let repels = iterations == 0 && curvature < 0.0;
            if !((0.0 < curvature || repels) && 0.0 < left) {
                left += 0.0 * curvature;
                break;
            }
            if repels {
                bound = first;
            }
            let before = left;
            let distance = if repels { R::ONE } else { R::of(left / curvature) };
            at_level!(level, _simd => go::<R>(changes, residuals, directions, products, distance));
            hold(residuals);
            left = at_level!(level, _simd => steer::<R>(residuals, upper, lower, steered));
            keep = R::of(left / before);
            iterations += 1;
        }
        // Where an element repels, residuals may grow.
        End { first, left: if bound < left { bound } else { left }, iterations }
    }

    /// Changes velocities by the unscaled directions.
    pub(crate) fn jump(&mut self, level: Level, multiply: &mut impl FnMut(&[R], &mut [R])) {
        let Solve { residuals, changes, directions, products, .. } = self;
        multiply(directions, products);
        at_level!(level, _simd => go::<R>(changes, residuals, directions, products, R::ONE));
    }

    /// Whether any residual is not zero.
    pub(crate) fn is_left(&self, level: Level) -> bool {
        at_level!(level, _simd => is_any(&self.residuals))
    }

    /// The place of the first particle, of those at some places, with a NaN or infinite number.
    pub(crate) fn first_not_finite(
        &self,
        mut places: impl Iterator<Item = usize>,
    ) -> Option<usize> {
        let columns = [&self.residuals, &self.steered, &self.products];
        places.position(|at| {
            let mut vectors = columns.iter().map(|column| vector::<R>(column, at).extent());
            vectors.any(|extent| !extent.to_f64().is_finite())
        })
    }
}

/// Sets the search direction to the preconditioned residuals plus `keep` times the one before.
#[inline(always)]
fn turn<R: Real>(directions: &mut [R], steered: &[R], keep: R) {
    let steered = &steered[..directions.len()];
    for (direction, &steered) in directions.iter_mut().zip(steered) {
        *direction = steered + *direction * keep;
    }
}

/// Moves along a direction.
#[inline(always)]
fn go<R: Real>(
    changes: &mut [R],
    residuals: &mut [R],
    directions: &[R],
    products: &[R],
    distance: R,
) {
    let n = changes.len();
    let (residuals, directions, products) = (&mut residuals[..n], &directions[..n], &products[..n]);
    for i in 0..n {
        changes[i] += directions[i] * distance;
        residuals[i] -= products[i] * distance;
    }
}

/// Overwrites `steered` with the residuals times the preconditioner, and returns the scalar product
/// of both.
#[inline(always)]
fn steer<R: Real>(residuals: &[R], upper: &[R], lower: &[R], steered: &mut [R]) -> f64 {
    let blocks = upper.as_chunks::<RECORD>().0.iter().zip(lower.as_chunks::<RECORD>().0);
    let rows = residuals.as_chunks::<RECORD>().0.iter().zip(steered.as_chunks_mut::<RECORD>().0);
    let mut sums = [0.0; LANES];
    for ((r, p), (upper, lower)) in rows.zip(blocks) {
        for (lane, sum) in sums.iter_mut().enumerate() {
            let [x, y, z] = [lane, LANES + lane, 2 * LANES + lane];
            let (xy, xz, yz) = (upper[y], upper[z], lower[y]);
            p[x] = upper[x] * r[x] + xy * r[y] + xz * r[z];
            p[y] = xy * r[x] + lower[x] * r[y] + yz * r[z];
            p[z] = xz * r[x] + yz * r[y] + lower[z] * r[z];
            *sum += (r[x] * p[x] + r[y] * p[y] + r[z] * p[z]).to_f64();
        }
    }
    sums.iter().sum()
}

/// Whether any number of a column is not zero.
#[inline(always)]
fn is_any<R: Real>(column: &[R]) -> bool {
    let mut any = [0u32; LANES];
    for record in column.as_chunks::<LANES>().0 {
        for (any, number) in any.iter_mut().zip(record) {
            *any |= u32::from(*number != R::ZERO);
        }
    }
    any != [0; LANES]
}

/// The scalar product of two columns.
#[inline(always)]
fn dot<R: Real>(a: &[R], b: &[R]) -> f64 {
    let mut sums = [0.0; LANES];
    for (a, b) in a.as_chunks::<RECORD>().0.iter().zip(b.as_chunks::<RECORD>().0) {
        for (lane, sum) in sums.iter_mut().enumerate() {
            let [x, y, z] = [lane, LANES + lane, 2 * LANES + lane];
            *sum += (a[x] * b[x] + a[y] * b[y] + a[z] * b[z]).to_f64();
        }
    }
    sums.iter().sum()
}
