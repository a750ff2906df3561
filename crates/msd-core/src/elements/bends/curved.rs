//! The law of two triangles that are bent at rest.

use crate::number::{Real, Vector};
use core::array::from_fn;

/// The part of all that is bent, squared, that must be along the normal for there to be one. At the
/// opposite of the rest there is none.
const LEAST_PART_SQUARED: f64 = 1e-8;

/// The square of the largest ratio of a gradient to that of a flat bend: shells in use are below 2.
const STEEPEST_SQUARED: f64 = 4.0;

/// The current shape of a bend that is curved at rest.
///
/// With e = x1 − x0, f = w2 (x2 − x0) − w3 (x3 − x0), s the weighted sum and m = e × f/|e|,
/// triangles that keep their shape have s = L sin φ n and m = L cos φ n, n being the normal of the
/// two and φ half of the angle between them. So it is off its rest t = tan φ0 by
/// d = (s − t m) cos φ0 = L sin(φ − φ0) n, and along w = (t s + m) cos φ0 = L cos(φ − φ0) n. Where
/// the triangles are folded onto each other n and φ jump, but d² does not: forces are −Gᵀ k d −
/// p b (p·v), with G the change of d with positions and p the gradient of d·ŵ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curved<R: Real> {
    weights: [R; 4],
    /// t, and cos φ0.
    rest: R,
    part: R,
    /// Direction of e; zero where there is none.
    edge: R::Vec3,
    /// 1/|e|, or zero.
    inverse: R,
    across: R::Vec3,
    /// ŵ; zero where there is none.
    normal: R::Vec3,
    /// The part of d across ŵ, by |w|.
    tilt: R::Vec3,
    /// Deviation from its rest, d.
    pub(super) off: R::Vec3,
}

impl<R: Real> Curved<R> {
    /// By weights, the tangent at rest and the positions that a function gives.
    #[inline(always)]
    pub(super) fn new(weights: [R; 4], rest: R, of: impl Fn(usize) -> R::Vec3) -> Self {
        let [sum, edge, across] = sums(weights, of);
        let square = edge.dot(edge);
        let has_edge = R::SHORTEST_SQUARED <= square;
        let inverse = if has_edge { R::ONE / square.sqrt() } else { R::ZERO };
        let (edge, part) = (edge * inverse, R::ONE / (R::ONE + rest * rest).sqrt());
        let lifted = edge.cross(across);
        let off = (sum - lifted * rest) * part;
        let along = (sum * rest + lifted) * part;
        let (square, all) = (along.dot(along), along.dot(along) + off.dot(off));
        let is_there = R::SHORTEST_SQUARED <= square && R::of(LEAST_PART_SQUARED) * all <= square;
        let shrink = if is_there { R::ONE / square.sqrt() } else { R::ZERO };
        let normal = along * shrink;
        let tilt = (off - normal * normal.dot(off)) * shrink;
        Curved { weights, rest, part, edge, inverse, across, normal, tilt, off }
    }

    /// The part of a vector across the edge.
    #[inline(always)]
    fn beside(&self, vector: R::Vec3) -> R::Vec3 {
        vector - self.edge * self.edge.dot(vector)
    }

    /// The changes of s, e, f, the direction of e and m with motions that a function says.
    #[inline(always)]
    fn changes(&self, of: impl Fn(usize) -> R::Vec3) -> [R::Vec3; 5] {
        let [sum, edge, across] = sums(self.weights, of);
        let turn = self.beside(edge) * self.inverse;
        [sum, edge, across, turn, turn.cross(self.across) + self.edge.cross(across)]
    }

    /// The change G v of its deviation, by motions that a function gives.
    #[inline(always)]
    pub(super) fn change(&self, of: impl Fn(usize) -> R::Vec3) -> R::Vec3 {
        let [sum, .., lifted] = self.changes(of);
        (sum - lifted * self.rest) * self.part
    }

    /// The parts of a vector y that particles get, Gᵀ y.
    #[inline(always)]
    pub(super) fn parts(&self, y: R::Vec3) -> [R::Vec3; 4] {
        let y = y * self.part;
        self.spread(y, self.pulls(y * (R::ZERO - self.rest)))
    }

    /// The gradient p of d·ŵ by the particles, along which a damper acts.
    ///
    /// It has no bound where ŵ turns in no time, as where the edge shrinks to nothing, and a damper
    /// that stiff makes any substep unstable. So a longer one is shortened, which takes less power.
    #[inline(always)]
    pub(super) fn gradient(&self) -> [R::Vec3; 4] {
        let sum = (self.normal + self.tilt * self.rest) * self.part;
        let all = self.spread(sum, self.pulls((self.tilt - self.normal * self.rest) * self.part));
        let square = |vectors: [R::Vec3; 4]| {
            vectors.into_iter().fold(R::ZERO, |sum, vector| sum + vector.dot(vector))
        };
        let flat = self.weights.into_iter().fold(R::ZERO, |sum, w| sum + w * w);
        let (most, square) = (flat * R::of(STEEPEST_SQUARED), square(all));
        let shrink = if square <= most { R::ONE } else { (most / square).sqrt() };
        all.map(|vector| vector * shrink)
    }

    /// The pulls along e and f of one along m.
    #[inline(always)]
    fn pulls(&self, lifted: R::Vec3) -> [R::Vec3; 2] {
        [self.beside(self.across.cross(lifted)) * self.inverse, lifted.cross(self.edge)]
    }

    /// The parts of particles, by pulls along the sum, e and f.
    #[inline(always)]
    fn spread(&self, sum: R::Vec3, [edge, across]: [R::Vec3; 2]) -> [R::Vec3; 4] {
        let [edges, acrosses] = [[-R::ONE, R::ONE, R::ZERO, R::ZERO], shares(self.weights)];
        from_fn(|end| sum * self.weights[end] + edge * edges[end] + across * acrosses[end])
    }

    /// The change of Gᵀ (k d) with motions that a function says: the product of its stiffness.
    pub(super) fn product(&self, stiffness: R, of: impl Fn(usize) -> R::Vec3) -> [R::Vec3; 4] {
        let [sum, edge, across, turn, lifted] = self.changes(of);
        let by = R::ZERO - self.rest * self.part;
        let change = (sum - lifted * self.rest) * (self.part * stiffness);
        let [edges, acrosses] = self.pulls(change * by);
        // The current pull along m, whose parts change as the edge turns and stretches.
        let pull = self.off * (stiffness * by);
        let (pulled, stretch) = (self.across.cross(pull), self.edge.dot(edge) * self.inverse);
        let turned = turn * self.edge.dot(pulled) + self.edge * turn.dot(pulled);
        let turning = self.beside(across.cross(pull)) - turned - self.beside(pulled) * stretch;
        let pulls = [edges + turning * self.inverse, acrosses + pull.cross(turn)];
        self.spread(change * self.part, pulls)
    }

    /// Bounds of the change of the deviation by each particle, and of the stiffness that its
    /// turning adds to that particle beyond the square of these, for a pull of one newton: row sums
    /// of magnitudes.
    pub(super) fn bounds(&self) -> [[R; 2]; 4] {
        let length = |vector: R::Vec3| vector.dot(vector).sqrt();
        let (across, by) = (length(self.across) * self.inverse, self.rest.abs() * self.part);
        let (ends, weights) = ([R::ONE, R::ONE, R::ZERO, R::ZERO], shares(self.weights));
        let weights = weights.map(R::abs);
        let total = |numbers: [R; 4]| numbers.into_iter().fold(R::ZERO, |sum, x| sum + x);
        from_fn(|end| {
            let turn = ends[end] * across + weights[end];
            // A direction has a second derivative of at most 2/|e|².
            let bent = ends[end] * total(ends) * (across + across);
            let twisted = ends[end] * total(weights) + weights[end] * total(ends);
            let own = self.weights[end].abs() * self.part + turn * by;
            [own, (bent + twisted) * (self.inverse * by)]
        })
    }
}

/// The parts of particles in f: it is Σ of these times their positions.
#[inline(always)]
fn shares<R: Real>([_, _, c, d]: [R; 4]) -> [R; 4] {
    [d - c, R::ZERO, c, -d]
}

/// The weighted sum, the edge and f of the vectors that a function gives for particles.
#[inline(always)]
fn sums<R: Real>(weights: [R; 4], of: impl Fn(usize) -> R::Vec3) -> [R::Vec3; 3] {
    let first = of(0);
    let [edge, c, d] = [of(1) - first, of(2) - first, of(3) - first];
    let sum = edge * weights[1] + c * weights[2] + d * weights[3];
    [sum, edge, c * weights[2] - d * weights[3]]
}
