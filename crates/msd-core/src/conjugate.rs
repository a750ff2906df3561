//! What change of velocity cancels a residual? Found by preconditioned conjugate gradients.

use crate::real::{Real, Vector};
use crate::tangent::Tangent;
use alloc::vec;
use alloc::vec::Vec;

/// The columns of a solve.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solve<R: Real> {
    /// Momentum still missing, kilogram metres per second; those of held rows and directions stay.
    pub(crate) residual: Vec<R::Vec3>,
    /// The change of velocity found so far, metres per second.
    pub(crate) change: Vec<R::Vec3>,
    /// What a residual is multiplied with to aim: the inverse of the block of each particle between
    /// projections on the directions in which it is free, columns.
    pub(crate) blocks: Vec<[R::Vec3; 3]>,
    aim: Vec<R::Vec3>,
    direction: Vec<R::Vec3>,
    product: Vec<R::Vec3>,
}

/// When a solve is good enough.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Fraction of the first residual that may be left, in the norm of the preconditioner.
    pub(crate) tolerance: f64,
    /// Iterations at least.
    pub(crate) fewest: usize,
}

impl<R: Real> Solve<R> {
    pub(crate) fn new(count: usize) -> Self {
        let column = || vec![R::Vec3::ZERO; count];
        Solve {
            residual: column(),
            change: column(),
            blocks: vec![[R::Vec3::ZERO; 3]; count],
            aim: column(),
            direction: column(),
            product: column(),
        }
    }

    /// Measures the residual in the norm of the preconditioner, squared: what is left to solve.
    pub(crate) fn aim(&mut self) -> f64 {
        let mut left = 0.0;
        let rows = self.aim.iter_mut().zip(&self.residual).zip(&self.blocks);
        for ((aim, &residual), block) in rows {
            *aim = times::<R>(block, residual);
            left += residual.dot(*aim).to_f64();
        }
        left
    }

    /// Lowers the residual by changing velocities; `first` is the square norm to compare with.
    ///
    /// A direction in which the blocks are singular is never entered: that is how pins and contacts
    /// hold. Sums are in `f64` and in the order of the particles. Source: Hestenes and Stiefel,
    /// 1952; the projection is that of Baraff and Witkin, 1998, section 5.3, with the symmetry that
    /// Ascher and Boxerman, 2003, ask for.
    pub(crate) fn run(
        &mut self,
        (tangent, ends): (&Tangent<R>, &[[u32; 2]]),
        goal: Goal,
        first: f64,
    ) -> usize {
        let mut left = self.aim();
        self.direction.copy_from_slice(&self.aim);
        let enough = goal.tolerance * goal.tolerance * first;
        // In exact arithmetic as many as there are unknowns suffice; rounding asks for a few more.
        let most = (4 * self.change.len() + 16).min(MOST);
        for iteration in 0..most {
            if left <= enough && goal.fewest <= iteration {
                return iteration;
            }
            tangent.set_product(ends, &self.direction, &mut self.product);
            let curvature = dot::<R>(&self.direction, &self.product);
            // Not positive where rounding is all that is left, or where nothing was to do.
            if !(0.0 < curvature && 0.0 < left) {
                return iteration;
            }
            let before = left;
            left = self.descend(R::of(left / curvature));
            let keep = R::of(left / before);
            for (direction, &aim) in self.direction.iter_mut().zip(&self.aim) {
                *direction = aim + *direction * keep;
            }
        }
        most
    }

    fn descend(&mut self, distance: R) -> f64 {
        let mut left = 0.0;
        let directions = self.direction.iter().zip(&self.product);
        let rows = self.change.iter_mut().zip(&mut self.residual).zip(&mut self.aim);
        for ((((change, residual), aim), (&direction, &product)), block) in
            rows.zip(directions).zip(&self.blocks)
        {
            *change += direction * distance;
            *residual -= product * distance;
            *aim = times::<R>(block, *residual);
            left += residual.dot(*aim).to_f64();
        }
        left
    }
}

/// Iterations of one solve at most: bounds the time of a substep.
const MOST: usize = 1000;

fn times<R: Real>(block: &[R::Vec3; 3], vector: R::Vec3) -> R::Vec3 {
    let [x, y, z] = vector.components();
    block[0] * x + block[1] * y + block[2] * z
}

fn dot<R: Real>(a: &[R::Vec3], b: &[R::Vec3]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| a.dot(b).to_f64()).sum()
}
