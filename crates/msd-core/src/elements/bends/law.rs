//! The law of one bend, straight or curved at rest.

use super::curved::Curved;
use crate::columns::{set_vector, vector};
use crate::elements::stencils::Stencil;
use crate::number::{Real, Vector};
use core::array::from_fn;
use glam::DVec3;

/// The law of a bend, see [`crate::Bend`].
#[derive(Clone, Copy, Debug)]
pub struct BendLaw<R> {
    pub(super) weights: [R; 4],
    /// The sum at rest; 0 for one that is straight.
    pub(super) rest: R,
    pub(super) stiffness: R,
    pub(super) damping: R,
}

impl<R: Real> BendLaw<R> {
    /// The weighted sum of what a function says of its particles, 0 to 3.
    ///
    /// Of differences: positions far from the origin would leave their rounding.
    #[inline(always)]
    pub(super) fn sum(&self, of: impl Fn(usize) -> R::Vec3) -> R::Vec3 {
        let first = of(0);
        let mut sum = R::Vec3::ZERO;
        for end in (1..4).filter(|&end| self.weights[end] != R::ZERO) {
            sum += (of(end) - first) * self.weights[end];
        }
        sum
    }

    /// Its sum and one of its edges, by positions.
    #[inline(always)]
    pub(super) fn bent(&self, of: impl Fn(usize) -> R::Vec3) -> [R::Vec3; 2] {
        let edge = of(1) - of(0);
        [self.sum(of), edge]
    }

    /// The sum in double precision.
    pub(super) fn sum_f64(&self, of: impl Fn(usize) -> DVec3) -> DVec3 {
        let first = of(0);
        (1..4).map(|end| (of(end) - first) * self.weights[end].to_f64()).sum()
    }

    /// How it is bent, by positions, if it is curved at rest.
    #[inline(always)]
    pub(super) fn curved(&self, of: impl Fn(usize) -> R::Vec3) -> Option<Curved<R>> {
        (self.rest != R::ZERO).then(|| Curved::new(self.weights, self.rest, of))
    }

    /// The same in double precision.
    pub(super) fn curved_f64(&self, of: impl Fn(usize) -> DVec3) -> Option<Curved<f64>> {
        let weights = self.weights.map(R::to_f64);
        (self.rest != R::ZERO).then(|| Curved::new(weights, self.rest.to_f64(), of))
    }

    /// The forces Gᵀ k d + p b (p·v) of one that is curved, to be subtracted, and the power of its
    /// damper.
    #[inline(always)]
    pub(super) fn curved_pull(
        &self,
        curved: &Curved<R>,
        v: impl Fn(usize) -> R::Vec3,
    ) -> ([R::Vec3; 4], R) {
        let elastic = curved.parts(curved.off * self.stiffness);
        if self.damping == R::ZERO {
            return (elastic, R::ZERO);
        }
        let along = curved.gradient();
        let rate = dot_parts::<R>(&along, v);
        let drag = rate * self.damping;
        (from_fn(|end| elastic[end] + along[end] * drag), rate * drag)
    }

    /// Its pull by its sum s and the rate of that, k s + b ŝ (ŝ·s'), and the power of its damper.
    ///
    /// Along its direction ŝ alone: against all of s' a damper would brake a bent body that turns.
    #[inline(always)]
    pub(super) fn pull(&self, sum: R::Vec3, rate: R::Vec3) -> (R::Vec3, R) {
        let square = sum.dot(sum);
        let has_direction = R::SHORTEST_SQUARED <= square;
        if !has_direction {
            return (sum * self.stiffness, R::ZERO);
        }
        let along = sum.dot(rate);
        let drag = along * self.damping * (R::ONE / square);
        (sum * (self.stiffness + drag), along * drag)
    }

    /// The product of τ (τ k + b ŝ ŝᵀ) with the sum of a direction, bent by `sum`; see
    /// [`is_straight`].
    #[inline(always)]
    pub(super) fn product(&self, tau: R, [sum, edge]: [R::Vec3; 2], of: R::Vec3) -> R::Vec3 {
        let elastic = of * (tau * tau * self.stiffness);
        if self.damping == R::ZERO {
            return elastic;
        }
        let square = sum.dot(sum);
        let damping = tau * self.damping;
        if is_straight::<R>(square, edge.dot(edge)) {
            return elastic + of * damping;
        }
        elastic + sum * (damping * sum.dot(of) * (R::ONE / square))
    }
}

/// Whether a bend is all but straight, by the squares of its sum and of an edge: its direction is
/// not known yet, as any motion would give it one. Its damping is then taken to act in all.
#[inline(always)]
pub(super) fn is_straight<R: Real>(square: R, edge: R) -> bool {
    let bent = edge * R::of(1e-6) < square && R::SHORTEST_SQUARED <= square;
    !bent
}

/// A bend, and where the numbers of its particles are.
pub(super) type BendRow<R> = Stencil<BendLaw<R>, 4>;

impl<R: Real> BendRow<R> {
    /// Moves the particles of one that is curved as XPBD does, by h² k and h b: first to where it
    /// is off its rest by less, then against the change of its sum along the normal.
    pub(super) fn project_curved(
        &self,
        curved: &Curved<R>,
        [stiff, damp]: [R; 2],
        inverse_masses: &[R],
        ways: &mut [R::Vec3],
    ) {
        let particles = self.particles.map(|particle| particle as usize);
        let push = |ways: &mut [R::Vec3], parts: [R::Vec3; 4], [stiff, by]: [R; 2]| {
            let square = |end: usize| parts[end].dot(parts[end]) * inverse_masses[particles[end]];
            let squares = (0..4).map(square).fold(R::ZERO, |sum, add| sum + add);
            let pull = stiff * by * (R::ONE / (R::ONE + stiff * squares));
            for (part, &particle) in parts.into_iter().zip(&particles) {
                ways[particle] -= part * (pull * inverse_masses[particle]);
            }
        };
        let square = curved.off.dot(curved.off);
        if R::SHORTEST_SQUARED <= square {
            let length = square.sqrt();
            push(ways, curved.parts(curved.off * (R::ONE / length)), [stiff, length]);
        }
        if damp != R::ZERO {
            let along = curved.gradient();
            let moved = dot_parts::<R>(&along, |end| ways[particles[end]]);
            push(ways, along, [damp, moved]);
        }
    }

    /// The particles that take part, each with its weight.
    pub(super) fn terms(&self) -> impl Iterator<Item = (usize, R)> {
        let pairs =
            self.particles.map(|particle| particle as usize).into_iter().zip(self.law.weights);
        let is_curved = self.law.rest != R::ZERO;
        pairs.filter(move |&(_, weight)| weight != R::ZERO || is_curved)
    }

    /// The vector of one of its particles in a column.
    #[inline(always)]
    pub(super) fn of<'a>(&'a self, column: &'a [R]) -> impl Fn(usize) -> R::Vec3 + 'a {
        |end| vector::<R>(column, self.at[end] as usize)
    }

    /// Subtracts its pull, times its weights, from what is summed.
    #[inline(always)]
    pub(super) fn subtract(&self, pull: R::Vec3, sums: &mut [R]) {
        for (&at, &weight) in self.at.iter().zip(&self.law.weights) {
            if weight != R::ZERO {
                let at = at as usize;
                set_vector(sums, at, vector::<R>(sums, at) - pull * weight);
            }
        }
    }

    /// Subtracts the parts of its particles from what is summed.
    #[inline(always)]
    pub(super) fn subtract_parts(&self, parts: [R::Vec3; 4], sums: &mut [R]) {
        for (&at, part) in self.at.iter().zip(parts) {
            set_vector(sums, at as usize, vector::<R>(sums, at as usize) - part);
        }
    }
}

/// The sum of scalar products of the parts of particles with what a function says of them.
#[inline(always)]
pub(super) fn dot_parts<R: Real>(parts: &[R::Vec3; 4], of: impl Fn(usize) -> R::Vec3) -> R {
    let [a, b, c, d] = from_fn(|end| parts[end].dot(of(end)));
    (a + b) + (c + d)
}

/// Adds the diagonal blocks of τ (τ Gᵀ k G + p b pᵀ) of a bend that is curved at rest.
pub(super) fn add_curved_blocks<R: Real>(
    row: &BendRow<R>,
    curved: &Curved<R>,
    tau: R,
    [upper, lower]: [&mut [R]; 2],
) {
    let (zero, one) = (R::ZERO, R::ONE);
    let units = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    let along = curved.gradient();
    for (end, &at) in row.at.iter().enumerate() {
        // The columns of G for this particle.
        let columns = units
            .map(R::Vec3::from_components)
            .map(|unit| curved.change(|other| if other == end { unit } else { R::Vec3::ZERO }));
        let part = along[end].components();
        let number = |a: usize, b: usize| {
            let elastic = columns[a].dot(columns[b]) * (tau * tau * row.law.stiffness);
            elastic + part[a] * part[b] * (tau * row.law.damping)
        };
        let rows = [[(0, 0), (0, 1), (0, 2)], [(1, 1), (1, 2), (2, 2)]];
        for (column, row) in [&mut *upper, &mut *lower].into_iter().zip(rows) {
            let block = R::Vec3::from_components(row.map(|(a, b)| number(a, b)));
            set_vector(column, at as usize, vector::<R>(column, at as usize) + block);
        }
    }
}
