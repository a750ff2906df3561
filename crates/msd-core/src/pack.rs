//! Numbers of laws. A law of physics is a function over [`Number`] without branches: the same
//! function computes with one number and with a [`Pack`] of them, to the same bits.

use crate::number::Real;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};
use fearless_simd::{ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdMask};

/// A number of a law: one, or as many as a register holds.
///
/// Every operation is a single IEEE 754 operation, correctly rounded, on each of them.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// One of the numbers.
    type Scalar: Real;
    /// An answer for each of the numbers.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;

    /// As many numbers that are all this one.
    fn splat(self, value: Self::Scalar) -> Self;
    /// As many zeros.
    #[inline(always)]
    fn zero(self) -> Self {
        self.splat(Self::Scalar::ZERO)
    }
    /// As many ones.
    #[inline(always)]
    fn one(self) -> Self {
        self.splat(Self::Scalar::ONE)
    }
    /// Half of it.
    #[inline(always)]
    fn half(self) -> Self {
        self * self.splat(Self::Scalar::HALF)
    }
    /// The square root.
    fn sqrt(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// Whether it is less than another; a NaN never is.
    fn is_less(self, other: Self) -> Self::Mask;
    /// Whether it is less than another or equal; a NaN never is.
    fn is_at_most(self, other: Self) -> Self::Mask;
    /// One number where the mask is set, another elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The smaller of two numbers.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(other.is_less(self), other, self)
    }
    /// The larger of two numbers.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(self.is_less(other), other, self)
    }
}

impl<R: Real> Number for R {
    type Scalar = R;
    type Mask = bool;

    #[inline(always)]
    fn splat(self, value: R) -> R {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> R {
        Real::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> R {
        Real::abs(self)
    }
    #[inline(always)]
    fn is_less(self, other: R) -> bool {
        self < other
    }
    #[inline(always)]
    fn is_at_most(self, other: R) -> bool {
        self <= other
    }
    #[inline(always)]
    fn select(mask: bool, yes: R, no: R) -> R {
        if mask { yes } else { no }
    }
}

/// A register of at most sixteen numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pack<S: Simd, R: Real>(R::Native<S>);

/// An answer for each number of a register.
pub(crate) type PackMask<S, R> = <Pack<S, R> as Number>::Mask;

impl<S: Simd, R: Real> Pack<S, R> {
    /// Number of its lanes.
    pub(crate) const LEN: usize = <R::Native<S> as SimdBase<S>>::LEN;

    /// Numbers that are all one.
    #[inline(always)]
    pub(crate) fn new(simd: S, value: R) -> Self {
        Pack(R::Native::<S>::splat(simd, value))
    }

    /// Reads as many numbers as it has.
    #[inline(always)]
    pub(crate) fn from_slice(simd: S, from: &[R]) -> Self {
        Pack(R::Native::<S>::from_slice(simd, from))
    }

    /// Overwrites as many numbers as it has.
    #[inline(always)]
    pub(crate) fn store_slice(self, to: &mut [R]) {
        self.0.store_slice(to);
    }

    /// Answers from bits, that of the first number lowest.
    #[inline(always)]
    pub(crate) fn mask(simd: S, bits: u64) -> PackMask<S, R> {
        PackMask::<S, R>::from_bitmask(simd, bits)
    }
}

macro_rules! impl_operator {
    ($operator:ident, $function:ident) => {
        impl<S: Simd, R: Real> $operator for Pack<S, R> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Pack($operator::$function(self.0, other.0))
            }
        }
    };
}

impl_operator!(Add, add);
impl_operator!(Sub, sub);
impl_operator!(Mul, mul);
impl_operator!(Div, div);

impl<S: Simd, R: Real> Neg for Pack<S, R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Pack(-self.0)
    }
}

impl<S: Simd, R: Real> Number for Pack<S, R> {
    type Scalar = R;
    type Mask = <R::Native<S> as SimdBase<S>>::Mask;

    #[inline(always)]
    fn splat(self, value: R) -> Self {
        Pack::new(self.0.token(), value)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Pack(self.0.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Pack(self.0.abs())
    }
    #[inline(always)]
    fn is_less(self, other: Self) -> Self::Mask {
        self.0.simd_lt(other.0)
    }
    #[inline(always)]
    fn is_at_most(self, other: Self) -> Self::Mask {
        self.0.simd_le(other.0)
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Pack(mask.select(yes.0, no.0))
    }
}

/// A vector in each lane.
#[inline(always)]
pub(crate) fn splat<S: Simd, R: Real>(simd: S, [x, y, z]: [R; 3]) -> [Pack<S, R>; 3] {
    [Pack::new(simd, x), Pack::new(simd, y), Pack::new(simd, z)]
}

/// A vector made of two, component by component.
#[inline(always)]
pub(crate) fn zip<A: Copy, B: Copy, C>(a: [A; 3], b: [B; 3], f: impl Fn(A, B) -> C) -> [C; 3] {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])]
}

/// The three numbers that a law gives for the axes. It is always inlined, as `array::from_fn` is
/// not: a law is compiled for the instructions of its caller, or it takes three times as long.
#[inline(always)]
pub(crate) fn each<T>(law: impl Fn(usize) -> T) -> [T; 3] {
    [law(0), law(1), law(2)]
}

/// The scalar product, summed in the order of the components.
#[inline(always)]
pub(crate) fn dot<N: Number>(a: [N; 3], b: [N; 3]) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The sum of the sizes of its terms, which bounds its rounding.
#[inline(always)]
pub(crate) fn dot_terms<N: Number>([a, b, c]: [N; 3], [x, y, z]: [N; 3]) -> N {
    (a * x).abs() + (b * y).abs() + (c * z).abs()
}

/// Laws computed for as many as a register holds, against each on its own.
#[cfg(test)]
pub(crate) mod lanes {
    use super::*;
    use crate::number::at_level;
    use fearless_simd::Level;

    /// A law of some numbers that gives others.
    pub(crate) trait Law<const IN: usize, const OUT: usize> {
        fn of<N: Number>(numbers: [N; IN]) -> [N; OUT];
    }

    /// Asserts that a law has the same bits for many as for each, by all instructions.
    pub(crate) fn check<L: Law<IN, OUT>, const IN: usize, const OUT: usize>() {
        for level in [Level::baseline(), Level::new()] {
            at_level!(level, simd => check_by::<_, f32, L, IN, OUT>(simd));
            at_level!(level, simd => check_by::<_, f64, L, IN, OUT>(simd));
        }
    }

    #[inline(always)]
    fn check_by<S: Simd, R: Real, L: Law<IN, OUT>, const IN: usize, const OUT: usize>(simd: S) {
        let count = Pack::<S, R>::LEN;
        let mut state = 1u64;
        let mut coarse = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            // Some are zero and some equal.
            R::of(((state >> 40) % 65) as f64 / 32.0 - 1.0)
        };
        for _ in 0..300 {
            let columns: [[R; 16]; IN] = [[(); 16]; IN].map(|lanes| lanes.map(|()| coarse()));
            let all = L::of(columns.map(|lanes| Pack::from_slice(simd, &lanes[..count])));
            let all = all.map(|pack: Pack<S, R>| {
                let mut lanes = [R::ZERO; 16];
                pack.store_slice(&mut lanes[..count]);
                lanes
            });
            for lane in 0..count {
                let each = L::of(columns.map(|lanes| lanes[lane]));
                for (all, each) in all.into_iter().zip(each) {
                    let is_same = all[lane].to_le_bytes().into_iter().eq(each.to_le_bytes());
                    // Of a NaN the bits do not matter.
                    let are_nan = all[lane].to_f64().is_nan() && each.to_f64().is_nan();
                    assert!(is_same || are_nan, "lane {lane}: {} and {each}", all[lane]);
                }
            }
        }
    }
}
