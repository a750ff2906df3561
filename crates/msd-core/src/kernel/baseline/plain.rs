//! Packs in plain Rust, for targets without registers of more than one number.

use crate::kernel::RECORD;
use crate::kernel::pack::Pack;
use crate::real::Real;
use core::ops::{Add, Div, Mul, Sub};

pub(in crate::kernel) type Single = Plain<f32>;
pub(in crate::kernel) type Double = Plain<f64>;

/// Four numbers in plain Rust.
#[derive(Clone, Copy)]
pub(in crate::kernel) struct Plain<R>([R; 4]);

macro_rules! plain_operator {
    ($trait:ident, $name:ident, $operator:tt) => {
        impl<R: Real> $trait for Plain<R> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Plain(core::array::from_fn(|lane| self.0[lane] $operator other.0[lane]))
            }
        }
    };
}

plain_operator!(Add, add, +);
plain_operator!(Sub, sub, -);
plain_operator!(Mul, mul, *);
plain_operator!(Div, div, /);

// SAFETY of the unsafe functions here: plain Rust runs on every processor, so that only the reads
// and writes need the caller's promise.
impl<R: Real> Pack<R> for Plain<R> {
    const COUNT: usize = 4;
    type Mask = [bool; 4];

    #[inline(always)]
    unsafe fn splat(value: R) -> Self {
        Plain([value; 4])
    }
    #[inline(always)]
    unsafe fn load(from: *const R) -> Self {
        // SAFETY: the caller's promise.
        Plain(unsafe { from.cast::<[R; 4]>().read_unaligned() })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut R) {
        // SAFETY: the caller's promise.
        unsafe { to.cast::<[R; 4]>().write_unaligned(self.0) };
    }
    #[inline(always)]
    unsafe fn mask(bits: u16) -> [bool; 4] {
        core::array::from_fn(|lane| bits >> lane & 1 == 1)
    }
    #[inline(always)]
    fn select(self, mask: [bool; 4], other: Self) -> Self {
        let lane = |lane: usize| if mask[lane] { self.0[lane] } else { other.0[lane] };
        Plain(core::array::from_fn(lane))
    }
    #[inline(always)]
    fn add_where(self, mask: [bool; 4], other: Self) -> Self {
        // To add minus zero changes nothing, not even the sign of a zero.
        self + other.select(mask, Plain([-R::ZERO; 4]))
    }
    #[inline(always)]
    fn less(self, other: Self, within: [bool; 4]) -> [bool; 4] {
        core::array::from_fn(|lane| within[lane] & (self.0[lane] < other.0[lane]))
    }
    #[inline(always)]
    fn not_less(self, other: Self, within: [bool; 4]) -> [bool; 4] {
        #[expect(clippy::neg_cmp_op_on_partial_ord, reason = "true where one is not a number")]
        let not_less = |a: R, b: R| !(a < b);
        core::array::from_fn(|lane| within[lane] & not_less(self.0[lane], other.0[lane]))
    }
    #[inline(always)]
    fn bits(mask: [bool; 4]) -> u16 {
        mask.iter().rev().fold(0, |bits, &lane| bits << 1 | u16::from(lane))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Plain(self.0.map(Real::sqrt))
    }
    #[inline(always)]
    unsafe fn gather(records: *const R, at: *const u32, _: bool) -> [[Self; 3]; 2] {
        let mut columns = [[R::ZERO; 4]; 2 * 3];
        for (component, column) in columns.iter_mut().enumerate() {
            let place = component / 3 * (RECORD / 2) + component % 3;
            for (lane, number) in column.iter_mut().enumerate() {
                // SAFETY: the caller's promise.
                *number = unsafe { *records.add(*at.add(lane) as usize + place) };
            }
        }
        let [x, y, z, vx, vy, vz] = &columns;
        [[x, y, z], [vx, vy, vz]].map(|half| half.map(|&column| Plain(column)))
    }
}
