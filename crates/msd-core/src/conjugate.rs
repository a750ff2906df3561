//! What change of velocity cancels a residual? Found by preconditioned conjugate gradients.

use crate::kernel::Kernel;
use crate::real::Real;
use crate::system::Model;

/// When a solve is good enough.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Fraction of the first residual that may be left, in the norm of the preconditioner.
    pub(crate) tolerance: f64,
    /// Iterations at least.
    pub(crate) fewest: usize,
}

/// Lowers the residual by changing velocities. `first` is the square norm to compare with, that at
/// the start if there is none; it is returned.
///
/// A direction in which the blocks are singular is never entered: that is how pins and contacts
/// hold. Sums are in `f64`, and in an order that depends on the springs alone, not on instructions
/// or threads. Source: Hestenes and Stiefel, 1952; the projection is that of Baraff and Witkin,
/// 1998, section 5.3, with the symmetry that Ascher and Boxerman, 2003, ask for.
pub(crate) fn solve<R: Real>(
    model: &Model<R>,
    kernel: &mut Kernel<R>,
    goal: Goal,
    first: Option<f64>,
) -> f64 {
    let mut left = kernel.aim(model);
    let first = first.unwrap_or(left);
    let enough = goal.tolerance * goal.tolerance * first;
    // In exact arithmetic as many as there are unknowns suffice; rounding asks for a few more.
    let most = (4 * model.particle_count() + 16).min(MOST);
    let mut keep = None;
    for iteration in 0..most {
        if left <= enough && goal.fewest <= iteration {
            break;
        }
        if let Some(keep) = keep {
            kernel.turn_from(model, keep);
        }
        let curvature = kernel.multiply(model);
        // Not positive where rounding is all that is left, or where nothing was to do.
        if !(0.0 < curvature && 0.0 < left) {
            break;
        }
        let before = left;
        left = kernel.descend(model, R::of(left / curvature));
        keep = Some(R::of(left / before));
    }
    first
}

/// Iterations of one solve at most: bounds the time of a substep.
const MOST: usize = 1000;
