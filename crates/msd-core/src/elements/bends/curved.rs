//! The law of a bend that is curved at rest.

use crate::number::{Real, Vector};
use core::array::from_fn;

/// How far from flat or folded up the two triangles must be to have a normal: the square of the
/// sine of the angle of the two vectors that span it.
const LEAST_SINE_SQUARED: f64 = 1e-8;

/// A bend that is curved at rest, as it is bent.
///
/// With e = x1 − x0, f = w2 (x2 − x0) − w3 (x3 − x0) and n the direction of e × f, it is off its
/// rest by d = s − z n, z being the weighted sum s at rest. The change of d with positions is a
/// matrix G, and p is the gradient of s·n: forces are −Gᵀ k d − p b (p·v).
#[derive(Clone, Copy, Debug)]
pub(super) struct Curved<R: Real> {
    weights: [R; 4],
    rest: R,
    edge: R::Vec3,
    across: R::Vec3,
    /// Direction of the normal; zero where there is none.
    normal: R::Vec3,
    /// 1/|e × f|, or zero.
    inverse: R,
    /// How far it is off its rest, d.
    pub(super) off: R::Vec3,
}

impl<R: Real> Curved<R> {
    /// By weights, the sum at rest and what a function says are the positions.
    #[inline(always)]
    pub(super) fn new(weights: [R; 4], rest: R, of: impl Fn(usize) -> R::Vec3) -> Self {
        let [sum, edge, across] = sums(weights, of);
        let normal = edge.cross(across);
        let (square, most) = (normal.dot(normal), edge.dot(edge) * across.dot(across));
        let is_flat = R::SHORTEST_SQUARED <= square && R::of(LEAST_SINE_SQUARED) * most <= square;
        let inverse = if is_flat { R::ONE / square.sqrt() } else { R::ZERO };
        let normal = normal * inverse;
        Curved { weights, rest, edge, across, normal, inverse, off: sum - normal * rest }
    }

    /// What is left of a vector across the normal.
    #[inline(always)]
    fn beside(&self, vector: R::Vec3) -> R::Vec3 {
        vector - self.normal * self.normal.dot(vector)
    }

    /// The change of e × f with motions that a function says: of the sum, the edge and f as well.
    #[inline(always)]
    fn changes(&self, of: impl Fn(usize) -> R::Vec3) -> ([R::Vec3; 3], R::Vec3) {
        let [sum, edge, across] = sums(self.weights, of);
        ([sum, edge, across], edge.cross(self.across) + self.edge.cross(across))
    }

    /// The change G v of what it is off, by motions that a function says.
    #[inline(always)]
    pub(super) fn change(&self, of: impl Fn(usize) -> R::Vec3) -> R::Vec3 {
        let ([sum, ..], turn) = self.changes(of);
        sum - self.beside(turn) * (self.rest * self.inverse)
    }

    /// The parts of a vector y that particles get, Gᵀ y.
    #[inline(always)]
    pub(super) fn parts(&self, y: R::Vec3) -> [R::Vec3; 4] {
        let turn = self.turned(y);
        self.spread(y, self.across.cross(turn), turn.cross(self.edge))
    }

    /// The gradient p of s·n by the particles.
    #[inline(always)]
    pub(super) fn gradient(&self) -> [R::Vec3; 4] {
        let turn = self.beside(self.off) * self.inverse;
        self.spread(self.normal, self.across.cross(turn), turn.cross(self.edge))
    }

    /// A pull y along what changes e × f.
    #[inline(always)]
    fn turned(&self, y: R::Vec3) -> R::Vec3 {
        self.beside(y) * (R::ZERO - self.rest * self.inverse)
    }

    /// The parts of particles, by pulls along the sum, the edge and f.
    #[inline(always)]
    fn spread(&self, sum: R::Vec3, edge: R::Vec3, across: R::Vec3) -> [R::Vec3; 4] {
        let [edges, acrosses] = [[-R::ONE, R::ONE, R::ZERO, R::ZERO], shares(self.weights)];
        from_fn(|end| sum * self.weights[end] + edge * edges[end] + across * acrosses[end])
    }

    /// The change of Gᵀ (k d) with motions that a function says: the product of its stiffness.
    pub(super) fn product(&self, stiffness: R, of: impl Fn(usize) -> R::Vec3) -> [R::Vec3; 4] {
        let ([sum, edge, across], turn) = self.changes(of);
        let pull = self.off * stiffness;
        let (tilt, shrink) =
            (self.beside(turn) * self.inverse, self.normal.dot(turn) * self.inverse);
        let change = (sum - tilt * self.rest) * stiffness;
        let beside = self.beside(change)
            - tilt * self.normal.dot(pull)
            - self.normal * tilt.dot(pull)
            - self.beside(pull) * shrink;
        let (turned, turning) = (self.turned(pull), beside * (R::ZERO - self.rest * self.inverse));
        let edges = across.cross(turned) + self.across.cross(turning);
        let acrosses = turning.cross(self.edge) + turned.cross(edge);
        self.spread(change, edges, acrosses)
    }

    /// At most how much each particle changes what it is off, and how stiff its turning makes that
    /// particle beyond the square of these, for a pull of one newton: row sums of magnitudes.
    pub(super) fn bounds(&self) -> [[R; 2]; 4] {
        let length = |vector: R::Vec3| vector.dot(vector).sqrt();
        let (edge, across) = (length(self.edge), length(self.across));
        let (ends, weights) = ([R::ONE, R::ONE, R::ZERO, R::ZERO], shares(self.weights));
        let weights = weights.map(R::abs);
        let total = |numbers: [R; 4]| numbers.into_iter().fold(R::ZERO, |sum, x| sum + x);
        let turns: [R; 4] = from_fn(|end| ends[end] * across + weights[end] * edge);
        let by = self.rest.abs() * self.inverse;
        from_fn(|end| {
            let twice = turns[end] * total(turns) * (R::of(4.0) * self.inverse);
            let crossed = ends[end] * total(weights) + weights[end] * total(ends);
            [self.weights[end].abs() + turns[end] * by, (twice + crossed) * by]
        })
    }
}

/// The parts of particles in f: it is Σ of these times their positions.
#[inline(always)]
fn shares<R: Real>([_, _, c, d]: [R; 4]) -> [R; 4] {
    [d - c, R::ZERO, c, -d]
}

/// The weighted sum, the edge and f of what a function says of particles.
#[inline(always)]
fn sums<R: Real>(weights: [R; 4], of: impl Fn(usize) -> R::Vec3) -> [R::Vec3; 3] {
    let first = of(0);
    let [edge, c, d] = [of(1) - first, of(2) - first, of(3) - first];
    let sum = edge * weights[1] + c * weights[2] + d * weights[3];
    [sum, edge, c * weights[2] - d * weights[3]]
}
