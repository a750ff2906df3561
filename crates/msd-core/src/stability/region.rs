//! Stability regions of the integrators: the oscillators that each keeps bounded, up to which
//! substep.
//!
//! One substep of a method takes the oscillator x'' + c x' + w² x = 0 from (x, h v) to a new pair
//! by a 2x2 matrix that depends on W = h² w² and Z = h c alone. It is stable while no eigenvalue of
//! the matrix is larger than one. The regions, exact:
//!
//! * One-step methods multiply a motion e^(λt) by a polynomial R(hλ), λ² + c λ + w² = 0: explicit
//!   Euler 1 + z, RK4 the exponential series up to z⁴/24, Dormand-Prince up to z⁵/120 and then
//!   z⁶/600 (Hairer, Nørsett and Wanner, 1993). Jury's conditions on explicit Euler give W ≤ Z and
//!   2 Z ≤ 4 + W. RK4 reaches 2 √2 on the imaginary axis and 2.785 on the real one, Dormand-Prince
//!   1.0 and 3.31.
//! * Symplectic Euler has trace 2 − W − Z and determinant 1 − Z: an eigenvalue leaves through −1,
//!   where W/4 + Z/2 = 1.
//! * Velocity Verlet is the same without damping. With it the first substep of a step knows one
//!   acceleration and the others two, so that the limit depends on the number of substeps. The
//!   matrix of a whole step decides.
//!
//! Implicit methods and XPBD keep every oscillator bounded at any step.

use crate::number::Real;

/// More substeps of a step than this change a limit by less than a thousandth.
pub(crate) const MANY: u32 = 64;

/// One motion of a system: x'' + c x' + w² x = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mode {
    /// w², per second squared.
    pub stiffness: f64,
    /// c, per second.
    pub damping: f64,
}

impl Mode {
    pub(crate) fn of([stiffness, damping]: [f64; 2]) -> Mode {
        Mode { stiffness, damping }
    }

    pub(crate) fn add(&mut self, stiffness: f64, damping: f64) {
        self.stiffness += stiffness;
        self.damping += damping;
    }

    pub(crate) fn times(self, factor: f64) -> Mode {
        Mode { stiffness: self.stiffness * factor, damping: self.damping * factor }
    }

    /// The larger stiffness and the larger damping of two.
    pub(crate) fn larger(self, other: Mode) -> Mode {
        Mode {
            stiffness: self.stiffness.max(other.stiffness),
            damping: self.damping.max(other.damping),
        }
    }

    /// The substep that symplectic Euler bears: W/4 + Z/2 = 1. The others are not far from it.
    pub(crate) fn scale(self) -> f64 {
        let half = 0.5 * self.damping;
        // The stable form of the root: the sum has no cancellation.
        2.0 / (half + Real::sqrt(half * half + self.stiffness))
    }

    /// h² w²/4 + h c/2 of a substep of h seconds: 1 at the longest that is stable with symplectic
    /// Euler. Of two systems at once it is at most the sum of both (Weyl, 1912).
    pub fn share(self, h: f64) -> f64 {
        0.25 * h * h * self.stiffness + 0.5 * h * self.damping
    }

    /// The largest stable substep, seconds: 0 where none is stable, infinite where every one is.
    ///
    /// That of Dormand-Prince is where stability rather than its tolerance would set its step.
    pub fn largest_substep(self, region: impl Into<Region>, substeps: u32) -> f64 {
        let region = region.into();
        if self.scale() == f64::INFINITY || region == Region::Everything {
            return f64::INFINITY;
        }
        let stable = |h: f64| is_stable(region, substeps, h * h * self.stiffness, h * self.damping);
        first_unstable(0.3 * self.scale(), 1.05, 40, stable)
    }
}

/// The oscillators that a method keeps bounded, by how it takes a linear system through a step.
///
/// A user-defined [`Method`](crate::methods::Method) names its region for the prediction of the
/// stable step: the polynomial of a one-step method, or that of the built-in method whose substep
/// is the same on a linear system.
///
/// ```
/// use msd_core::stability::{Mode, Region};
///
/// // Heun's method of third order: the exponential series up to z³/6.
/// let heun = Region::Polynomial(&[1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0]);
/// let mode = Mode { stiffness: 100.0, damping: 0.0 };
/// assert!((mode.largest_substep(heun, 1) - 3f64.sqrt() / 10.0).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Region {
    /// Of a one-step method, which multiplies a motion e^(λt) by a polynomial of z = hλ in every
    /// substep: its coefficients, from that of 1 on.
    ///
    /// Those of an explicit Runge-Kutta method of order p are the exponential series up to z^p/p!;
    /// each stage beyond p adds one of its own.
    Polynomial(&'static [f64]),
    /// Of methods that move positions by the new velocities: h²w²/4 + hc/2 ≤ 1.
    ///
    /// It serves leapfrog and its relatives too, damped ones where the damper sees the velocity
    /// from before its kick.
    SymplecticEuler,
    /// Of velocity Verlet, with its prediction of the velocity that dampers see.
    VelocityVerlet,
    /// Of methods under which no motion grows at any substep.
    Everything,
}

/// The exponential series.
const SERIES: [f64; 6] = [1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0];

impl Region {
    /// The region of explicit Euler: the disc of radius 1 about −1.
    pub const EXPLICIT_EULER: Region = Region::Polynomial(&[1.0, 1.0]);
    /// The region of the classical method of Runge and Kutta.
    pub const RK4: Region = Region::Polynomial(&[1.0, 1.0, SERIES[2], SERIES[3], SERIES[4]]);
    /// The region of the fifth-order method of Dormand and Prince.
    pub const DORMAND_PRINCE: Region =
        Region::Polynomial(&[1.0, 1.0, SERIES[2], SERIES[3], SERIES[4], SERIES[5], 1.0 / 600.0]);

    /// The radius of a half disc about 0, to the left of the imaginary axis, in which every hλ is
    /// stable.
    pub(crate) fn half_disc(self) -> f64 {
        // On an arc |hλ| = r, W is r² and Z goes from 0 to 2 r. The search passes all smaller arcs.
        let is_arc_stable = |r: f64| {
            (0..=ARC)
                .all(|part| is_stable(self, 1, r * r, 2.0 * r * f64::from(part) / f64::from(ARC)))
        };
        0.98 * first_unstable(0.1, 1.05, 20, is_arc_stable)
    }
}

/// Points of an arc at which stability is checked.
const ARC: u32 = 64;

/// Whether one step of `substeps` substeps keeps the oscillator with W = h² w², Z = h c bounded.
pub fn is_stable(region: impl Into<Region>, substeps: u32, w: f64, z: f64) -> bool {
    let ([[a, b], [c, d]], rounds) = match region.into() {
        Region::Everything => return true,
        Region::SymplecticEuler => return 0.25 * w + 0.5 * z <= 1.0,
        // Jury's conditions, since no rounding may pass for damping.
        Region::EXPLICIT_EULER => return w <= z && 2.0 * z <= 4.0 + w,
        Region::Polynomial(factors) => (polynomial(factors, w, z), 1),
        Region::VelocityVerlet => {
            let substeps = substeps.clamp(1, MANY);
            (verlet(substeps, w, z), substeps)
        }
    };
    let (half_trace, determinant) = (0.5 * (a + d), a * d - b * c);
    let discriminant = half_trace * half_trace - determinant;
    let squared = if discriminant < 0.0 {
        determinant
    } else {
        let radius = half_trace.abs() + Real::sqrt(discriminant);
        radius * radius
    };
    // An undamped mode sits on the boundary: room for rounding over the substeps of a step.
    squared <= 1.0 + 1e-9 * f64::from(rounds)
}

/// A polynomial of the matrix ((0, 1), (−W, −Z)), by Horner's rule.
fn polynomial(factors: &[f64], w: f64, z: f64) -> [[f64; 2]; 2] {
    factors.iter().rev().fold([[0.0; 2]; 2], |[x, v], factor| {
        let fall = |column: usize| -w * x[column] - z * v[column];
        [[v[0] + factor, v[1]], [fall(0), fall(1) + factor]]
    })
}

/// The matrix of a step of velocity Verlet, see `methods/explicit.rs`.
fn verlet(substeps: u32, w: f64, z: f64) -> [[f64; 2]; 2] {
    let [[a, c], [b, d]] = [[1.0, 0.0], [0.0, 1.0]].map(|[mut x, mut v]: [f64; 2]| {
        let mut now = -w * x - z * v;
        let mut before = now;
        for _ in 0..substeps {
            v += 0.5 * now;
            x += v;
            (before, now) = (now, -w * x - z * (v + 0.25 * (now + before)));
            v += 0.5 * now;
        }
        [x, v]
    });
    [[a, b], [c, d]]
}

/// The first substep that is not stable, by growing steps from one that should be, then by `rounds`
/// of bisection. It is 0 where none is stable, infinite where even very long ones are; the start
/// itself where it is one of these.
pub(crate) fn first_unstable(
    start: f64,
    ratio: f64,
    rounds: u32,
    stable: impl Fn(f64) -> bool,
) -> f64 {
    let searchable = 0.0 < start && start.is_finite();
    if !searchable {
        return start;
    }
    let (mut low, mut high) = (start, start);
    while !stable(low) {
        (low, high) = (0.7 * low, low);
        if low < 1e-9 * start {
            return 0.0;
        }
    }
    while low == high || stable(high) {
        (low, high) = (high, ratio * high);
        if 1e3 * start < high {
            return f64::INFINITY;
        }
    }
    for _ in 0..rounds {
        let middle = 0.5 * (low + high);
        if stable(middle) { low = middle } else { high = middle }
    }
    low
}
