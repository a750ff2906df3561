//! The law of a spring and a damper in parallel: its force, its energy and its derivative.

use crate::number::{Real, Vector};
use crate::pack::{Number, dot, zip};

/// Rest length, metres, stiffness, newtons per metre, and damping, newton seconds per metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law<R> {
    /// Length without force, metres.
    pub rest: R,
    /// Stiffness k, newtons per metre.
    pub stiffness: R,
    /// Damping b along the spring, newton seconds per metre.
    pub damping: R,
}

impl<R: Real> Law<R> {
    /// The same in double precision.
    #[inline(always)]
    pub fn to_f64(self) -> Law<f64> {
        let [rest, stiffness, damping] = [self.rest, self.stiffness, self.damping].map(R::to_f64);
        Law { rest, stiffness, damping }
    }
}

/// The force on the end `there` of a spring, newtons, and the power that its damper dissipates,
/// watts. The force on the end `here` is the opposite.
///
/// With d from there to here, L = |d|, u = d/L and v the velocity of here as seen from there:
/// f = (k (L − rest) + b v·u) u. A spring whose ends coincide has no direction and pulls nothing.
/// A damper takes no notice of motions so slow that the numbers would be subnormal, see
/// [`Real::FAINTEST`]. Each end is a position and a velocity.
///
/// A difference is taken from here to there, since a processor reads the subtrahend, not the
/// minuend, on the way. One select serves springs that are absent, cut or without direction. A
/// position that is NaN or infinite gets past it; such a step is undone as a whole.
#[inline(always)]
pub fn pull<N: Number, const DAMPED: bool>(
    [x, v]: [[N; 3]; 2],
    [x_there, v_there]: [[N; 3]; 2],
    law: Law<N>,
    is_there: N::Mask,
) -> ([N; 3], N) {
    let d = zip(x, x_there, |a, b| a - b);
    let square = dot(d, d);
    let constant = |value| square.splat(value);
    let zero = constant(N::Scalar::ZERO);
    let length = square.sqrt();
    let inverse = constant(N::Scalar::ONE) / length;
    let tension = (length - law.rest) * law.stiffness * inverse;
    let on = constant(N::Scalar::SHORTEST_SQUARED).is_at_most(square) & is_there;
    let (scale, power) = if DAMPED {
        let motion = dot(d, zip(v, v_there, |a, b| a - b));
        let is_faint = motion.abs().is_less(constant(N::Scalar::FAINTEST));
        let along = N::select(is_faint, zero, motion);
        let drag = (along * law.damping) * (inverse * inverse);
        (N::select(on, tension + drag, zero), N::select(on, along * drag, zero))
    } else {
        (N::select(on, tension, zero), zero)
    };
    ([d[0] * scale, d[1] * scale, d[2] * scale], power)
}

/// Projects a spring of stiffness k h² and damping b h, as XPBD does. Returns the impulse on the
/// end here times h, the opposite of that on the end there, and the sum of all of the substep.
///
/// Each end is its position at the start of the substep and its displacement since. The weights w
/// are reciprocal masses. With d from here to there, L = |d|, u = d/L and s the difference of the
/// displacements, the impulse times h is this number times u:
///
/// (k h² (L − rest) + b h u·s − sum) / (1 + (k h² + b h) (w + w'))
///
/// A spring whose ends coincide has no direction and is left alone, as is one that is cut.
#[inline(always)]
pub(crate) fn project<N: Number>(
    [[x, way], [x_there, way_there]]: [[[N; 3]; 2]; 2],
    law: Law<N>,
    weights: [N; 2],
    (sum, is_there): (N, N::Mask),
) -> ([N; 3], N) {
    let parted = zip(way_there, way, |b, a| b - a);
    let across = zip(zip(x_there, x, |b, a| b - a), parted, |start, way| start + way);
    let square = dot(across, across);
    let (zero, one) = (square.zero(), square.one());
    let length = square.sqrt();
    let inverse = one / length;
    let u = [across[0] * inverse, across[1] * inverse, across[2] * inverse];
    let yielding = one + (law.stiffness + law.damping) * (weights[0] + weights[1]);
    let pull = law.stiffness * (length - law.rest) + law.damping * dot(u, parted) - sum;
    let on = square.splat(N::Scalar::SHORTEST_SQUARED).is_at_most(square) & is_there;
    let pull = N::select(on, pull / yielding, zero);
    let u = [N::select(on, u[0], zero), N::select(on, u[1], zero), N::select(on, u[2], zero)];
    ([u[0] * pull, u[1] * pull, u[2] * pull], sum + pull)
}

/// The elastic energy of a spring of some length, joules: k (length − rest)² / 2.
#[inline(always)]
pub fn energy(length: f64, law: Law<f64>) -> f64 {
    let stretch = length - law.rest;
    0.5 * law.stiffness * stretch * stretch
}

/// The derivative of the force of a spring about a motion.
///
/// A small displacement w of here as seen from there changes the force by k u (u·w) + (T/L) (w − u
/// (u·w)), T being the tension of the spring and its damper. Stretched, it also resists a sideways
/// motion, as a string does. A small velocity changes it by b u (u·w). The turn of a damper with
/// its spring is left out: that part is not symmetric. The fast twin is in `matrix.rs`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tangent<R: Real> {
    /// Unit vector of the spring; zero where it has no direction.
    pub direction: R::Vec3,
    /// Stiffness along the spring, newtons per metre.
    pub along: R,
    /// Stiffness across it, newtons per metre; negative where it pushes.
    pub across: R,
    /// Damping along it, newton seconds per metre.
    pub damping: R,
}

impl<R: Real> Tangent<R> {
    /// The derivative about the way from there to here, metres, and a velocity of here as seen from
    /// there, metres per second.
    pub fn new([d, v]: [R::Vec3; 2], law: Law<R>) -> Self {
        let square = d.dot(d);
        let has_direction = R::SHORTEST_SQUARED <= square;
        if !has_direction {
            return Tangent::default();
        }
        let length = Real::sqrt(square);
        let inverse = R::ONE / length;
        let direction = d * inverse;
        let tension = law.stiffness * (length - law.rest) + law.damping * direction.dot(v);
        let (across, damping) = (tension * inverse, law.damping);
        Tangent { direction, along: law.stiffness, across, damping }
    }

    /// The products of stiffness and damping with a relative motion.
    pub fn products(&self, relative: R::Vec3) -> [R::Vec3; 2] {
        let along = self.direction * self.direction.dot(relative);
        [along * self.along + (relative - along) * self.across, along * self.damping]
    }
}
