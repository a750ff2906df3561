//! The law of a cell, and its shape: the volume and its gradient, of one cell and of sixteen by the
//! same code.

use crate::number::Real;
use crate::scene::Volume;
use core::array::from_fn;

/// The volume of a cell is a sum over six diagonals of its faces, each from one corner to another.
/// They are those of three faces at corner 0, and those of the three faces at corner 7 that go
/// there.
pub(super) const DIAGONALS: [[usize; 2]; 6] = [[1, 7], [0, 6], [2, 7], [0, 3], [0, 5], [4, 7]];

/// Numbers of some cells side by side, one in each lane.
pub(super) type Numbers<R, const N: usize> = [R; N];
/// Vectors of some cells, by component.
pub(super) type Triple<R, const N: usize> = [Numbers<R, N>; 3];
/// A vector for each of the diagonals.
pub(super) type Six<R, const N: usize> = [Triple<R, N>; 6];

/// The law of a cell at e = V/V0 − 1: it stores Λ V0 f(e), with f = e²/2 for a positive Λ.
///
/// A negative Λ takes away some of the resistance of springs, and must not take away more. There
/// f = (1 + e) e²/(2 q), q = 1 + 5/3 e + 2 e² + e⁴/3. To third order that is 9/2 ((V/V0)^⅓ − 1)²,
/// which in a uniform dilation goes as the springs do. It is 0 in a flat cell and negative in one
/// that is inside out, so that the energy Λ f resists that. It goes to 0 however far a cell is
/// pulled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeLaw<R> {
    pub(super) rest: R,
    pub(super) modulus: R,
    pub(super) damping: R,
    /// 1 over the square of the gradient of the volume of a cube, 3/2 V0^(4/3).
    pub(super) per_square: R,
}

impl<R: Real> VolumeLaw<R> {
    pub(super) fn new(row: &Volume) -> Self {
        let edge = cube_root(row.rest_volume);
        VolumeLaw {
            rest: R::of(row.rest_volume),
            modulus: R::of(row.modulus),
            damping: R::of(row.damping),
            per_square: R::of(1.0 / (1.5 * edge * row.rest_volume)),
        }
    }

    pub(super) fn to_f64(self) -> VolumeLaw<f64> {
        VolumeLaw {
            rest: self.rest.to_f64(),
            modulus: self.modulus.to_f64(),
            damping: self.damping.to_f64(),
            per_square: self.per_square.to_f64(),
        }
    }

    pub(super) fn is_negative(&self) -> bool {
        self.modulus < R::ZERO
    }

    /// e of a volume.
    #[inline(always)]
    pub(super) fn dilation(&self, volume: R) -> R {
        (volume - self.rest) * (R::ONE / self.rest)
    }

    /// f.
    pub(super) fn stored(&self, e: R) -> R {
        let square = R::of(0.5) * (e * e);
        if !self.is_negative() {
            return square;
        }
        square * ((R::ONE + e) / reach(e)[0])
    }

    /// The tension Λ f', pascals.
    #[inline(always)]
    pub(super) fn tension(&self, e: R) -> R {
        if !self.is_negative() {
            return self.modulus * e;
        }
        let per_reach = R::ONE / reach(e)[0];
        self.modulus * ((e * per_reach) * (rise(e)[0] * per_reach))
    }

    /// The slope of the tension, Λ f'', pascals.
    #[inline(always)]
    pub(super) fn slope(&self, e: R) -> R {
        if !self.is_negative() {
            return self.modulus;
        }
        let [q, q_slope] = reach(e);
        let [n, n_slope] = rise(e);
        let per_reach = R::ONE / q;
        let bend = (R::of(2.0) * e * per_reach) * (n * per_reach) * (q_slope * per_reach);
        self.modulus * ((n + e * n_slope) * per_reach * per_reach - bend)
    }

    /// The share of Λ and of the damping at a cell whose gradient has a square g²: 1 for a positive
    /// Λ. Of a negative one less where a cell is deformed, so that springs resist more than it
    /// takes away: 1/(1 + 4/3 e + e² + 8 ρ), where ρ = g²/(3/2 V0^(4/3)) − 1 − 4/3 e is never
    /// negative, and 0 for a cube at rest.
    #[inline(always)]
    pub(super) fn share(&self, e: R, square: R) -> R {
        if !self.is_negative() {
            return R::ONE;
        }
        let linear = R::ONE + e * R::of(4.0 / 3.0);
        let rough = square * self.per_square - linear;
        let rough = if rough < R::ZERO { R::ZERO } else { rough };
        R::ONE / (linear + e * e + rough * R::of(8.0))
    }
}

/// q and its derivative.
#[inline(always)]
fn reach<R: Real>(e: R) -> [R; 2] {
    let (square, four_thirds) = (e * e, R::of(4.0 / 3.0));
    let q = R::ONE + e * R::of(5.0 / 3.0) + square * (R::of(2.0) + square * R::of(1.0 / 3.0));
    [q, R::of(5.0 / 3.0) + e * (R::of(4.0) + square * four_thirds)]
}

/// n in f' = e n/q², and its derivative.
#[inline(always)]
fn rise<R: Real>(e: R) -> [R; 2] {
    let horner = |terms: &[f64]| terms.iter().rev().fold(R::ZERO, |sum, &add| sum * e + R::of(add));
    let n = horner(&[1.0, 7.0 / 3.0, 5.0 / 3.0, 1.0, -1.0 / 3.0, -1.0 / 6.0]);
    [n, horner(&[7.0 / 3.0, 10.0 / 3.0, 3.0, -4.0 / 3.0, -5.0 / 6.0])]
}

/// The cube root of a positive number, by Newton's method: it does without a library.
fn cube_root(value: f64) -> f64 {
    let mut root = Real::sqrt(value);
    for _ in 0..200 {
        let next = (2.0 * root + value / (root * root)) / 3.0;
        if next == root {
            break;
        }
        root = next;
    }
    root
}

/// A cell at a motion: the diagonals of faces, the gradient of the volume by them, and e.
pub(super) struct CellShape<R, const N: usize> {
    pub(super) diagonals: Six<R, N>,
    pub(super) gradient: Six<R, N>,
    pub(super) dilations: Numbers<R, N>,
}

impl<R: Real, const N: usize> CellShape<R, N> {
    #[inline(always)]
    pub(super) fn new(law: &VolumeLaw<R>, diagonals: Six<R, N>) -> Self {
        let twelfth = R::of(1.0 / 12.0);
        let gradient = bilinear(&diagonals, &diagonals).map(|row| scaled(row, &[twelfth; N]));
        // Of degree 3 in all diagonals, and linear in the first two of them together.
        let halves = [0, 1].map(|row| dot(&diagonals[row], &gradient[row]));
        let dilations = from_fn(|lane| law.dilation(halves[0][lane] + halves[1][lane]));
        CellShape { diagonals, gradient, dilations }
    }

    /// The rate of the volume at which its diagonals change.
    #[inline(always)]
    pub(super) fn rate(&self, changes: &Six<R, N>) -> Numbers<R, N> {
        let mut sums = [R::ZERO; N];
        for (slope, change) in self.gradient.iter().zip(changes) {
            let dots = dot(slope, change);
            (0..N).for_each(|lane| sums[lane] += dots[lane]);
        }
        sums
    }

    /// The shares of Λ and of the damping.
    #[inline(always)]
    pub(super) fn shares(&self, law: &VolumeLaw<R>) -> Numbers<R, N> {
        if !law.is_negative() {
            return [R::ONE; N];
        }
        let mut squares = [R::ZERO; N];
        for corner in corners(&self.gradient) {
            let square = dot(&corner, &corner);
            (0..N).for_each(|lane| squares[lane] += square[lane]);
        }
        from_fn(|lane| law.share(self.dilations[lane], squares[lane]))
    }

    /// Tension and drag together, pascals, and the power of the damper, watts.
    #[inline(always)]
    pub(super) fn pull(
        &self,
        law: &VolumeLaw<R>,
        rates: Option<&Six<R, N>>,
    ) -> (Numbers<R, N>, Numbers<R, N>) {
        let mut pulls = self.dilations.map(|e| law.tension(e));
        let mut powers = [R::ZERO; N];
        if let Some(rates) = rates {
            let (rates, shares) = (self.rate(rates), self.shares(law));
            let damping = law.damping * (R::ONE / law.rest);
            for lane in 0..N {
                let drag = rates[lane] * damping * shares[lane];
                pulls[lane] += drag;
                powers[lane] = drag * rates[lane];
            }
        }
        (pulls, powers)
    }

    /// The factors of g gᵀ in τ (τ K + D), which stay positive together with those of springs:
    /// K without the turn of g, which is indefinite, as in the matrix of springs.
    #[inline(always)]
    pub(super) fn factors(&self, law: &VolumeLaw<R>, tau: R) -> Numbers<R, N> {
        let factor = tau * (tau * law.modulus + law.damping) * (R::ONE / law.rest);
        self.shares(law).map(|share| share * factor)
    }
}

/// Half the gradient of 12 V by diagonals, which is quadratic in them: at (d, d) the gradient, at
/// (d, c) + (c, d) its change by a change c.
///
/// V of the trilinear map of a cube, after Grandy, 1997.
#[inline(always)]
pub(super) fn bilinear<R: Real, const N: usize>(a: &Six<R, N>, b: &Six<R, N>) -> Six<R, N> {
    let (near, far) = (cross(&a[2], &b[3]), cross(&a[5], &b[1]));
    let side = cross(&a[0], &b[4]);
    [
        sum(&near, &cross(&a[4], &sum(&b[5], &b[3]))),
        sum(&near, &cross(&sum(&a[2], &a[4]), &b[5])),
        sum(&cross(&a[3], &sum(&b[0], &b[1])), &far),
        sum(&cross(&sum(&a[0], &a[1]), &b[2]), &side),
        sum(&far, &cross(&sum(&a[5], &a[3]), &b[0])),
        sum(&cross(&a[1], &sum(&b[2], &b[4])), &side),
    ]
}

/// The sum at each corner of vectors along diagonals: those that end there less those that begin
/// there.
#[inline(always)]
pub(super) fn corners<R: Real, const N: usize>(rows: &Six<R, N>) -> [Triple<R, N>; 8] {
    let mut corners = [[[R::ZERO; N]; 3]; 8];
    for (row, [from, to]) in rows.iter().zip(DIAGONALS) {
        for axis in 0..3 {
            for lane in 0..N {
                corners[from][axis][lane] -= row[axis][lane];
                corners[to][axis][lane] += row[axis][lane];
            }
        }
    }
    corners
}

#[inline(always)]
fn cross<R: Real, const N: usize>(a: &Triple<R, N>, b: &Triple<R, N>) -> Triple<R, N> {
    let part =
        |i: usize, j: usize| from_fn(|lane| a[i][lane] * b[j][lane] - a[j][lane] * b[i][lane]);
    [part(1, 2), part(2, 0), part(0, 1)]
}

#[inline(always)]
pub(super) fn sum<R: Real, const N: usize>(a: &Triple<R, N>, b: &Triple<R, N>) -> Triple<R, N> {
    from_fn(|axis| from_fn(|lane| a[axis][lane] + b[axis][lane]))
}

#[inline(always)]
pub(super) fn scaled<R: Real, const N: usize>(a: Triple<R, N>, by: &Numbers<R, N>) -> Triple<R, N> {
    a.map(|row| from_fn(|lane| row[lane] * by[lane]))
}

#[inline(always)]
pub(super) fn dot<R: Real, const N: usize>(a: &Triple<R, N>, b: &Triple<R, N>) -> Numbers<R, N> {
    from_fn(|lane| a[0][lane] * b[0][lane] + a[1][lane] * b[1][lane] + a[2][lane] * b[2][lane])
}
