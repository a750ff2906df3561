//! What does one instruction work on? A [`Pack`]: as many numbers as a register holds.
//!
//! Every operation is the IEEE 754 one, lane by lane, and none is fused with another, so that any
//! lane computes what a plain number would. There are packs of what the target of the build always
//! has ([`super::baseline`]), and of what its processor may have ([`super::x86`]).

use super::columns::Start;
use super::{LANES, RECORD};
use crate::real::{Real, Vector};
use core::ops::{Add, Div, Mul, Sub};

/// A few numbers side by side.
///
/// Packs of a processor's own come into being only through unsafe functions, whose callers promise
/// that the processor has the instructions; that is why the safe ones are sound.
pub(super) trait Pack<R: Real>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// How many: a divisor of [`LANES`].
    const COUNT: usize;
    /// A yes or no for each lane.
    type Mask: Copy;

    /// The same number in every lane.
    ///
    /// # Safety
    /// The processor has the instructions of this pack.
    unsafe fn splat(value: R) -> Self;
    /// The numbers from `from` on.
    ///
    /// # Safety
    /// The processor has the instructions of this pack; that many numbers can be read there.
    unsafe fn load(from: *const R) -> Self;
    /// Writes the numbers from `to` on.
    ///
    /// # Safety
    /// That many numbers can be written there.
    unsafe fn store(self, to: *mut R);
    /// The lowest bits as a mask.
    ///
    /// # Safety
    /// The processor has the instructions of this pack.
    unsafe fn mask(bits: u16) -> Self::Mask;
    /// A pack that is `self` where the mask says so, `other` elsewhere.
    fn select(self, mask: Self::Mask, other: Self) -> Self;
    /// `self + other` where the mask says so, `self` elsewhere.
    fn add_where(self, mask: Self::Mask, other: Self) -> Self;
    /// Where `self < other`, within a mask.
    fn less(self, other: Self, within: Self::Mask) -> Self::Mask;
    /// Where not `self < other`, within a mask: also where one is not a number.
    fn not_less(self, other: Self, within: Self::Mask) -> Self::Mask;
    /// The mask as bits, the first lane lowest.
    fn bits(mask: Self::Mask) -> u16;
    /// The square roots.
    fn sqrt(self) -> Self;

    /// Asks for what will be read soon; any address will do.
    #[inline(always)]
    fn prefetch<T>(address: *const T) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: every processor of this kind has the instruction, and it never fails.
        unsafe {
            use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            _mm_prefetch::<_MM_HINT_T0>(address.cast());
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = address;
    }

    /// Adds each lane to the sum of its own.
    #[inline(always)]
    fn add_to(self, sums: &mut [f64]) {
        let mut lanes = [R::ZERO; LANES];
        // SAFETY: no pack is longer.
        unsafe { self.store(lanes.as_mut_ptr()) };
        for (sum, &lane) in sums.iter_mut().zip(&lanes[..Self::COUNT]) {
            *sum += lane.to_f64();
        }
    }

    /// The first halves of several records, by component, and the second ones if they are wanted.
    ///
    /// # Safety
    /// The processor has the instructions of this pack; [`Pack::COUNT`] places can be read at `at`,
    /// and a record at each such place from `records` on.
    unsafe fn gather(records: *const R, at: *const u32, both: bool) -> [[Self; 3]; 2];

    /// Writes records one after the other from the components of their halves.
    ///
    /// # Safety
    /// [`Pack::COUNT`] records can be written at `records`.
    #[inline(always)]
    unsafe fn scatter(records: *mut R, halves: [[Self; 3]; 2]) {
        let mut columns = [[R::ZERO; LANES]; 3];
        for (half, components) in halves.into_iter().enumerate() {
            for (column, pack) in columns.iter_mut().zip(components) {
                // SAFETY: no pack is longer than a column.
                unsafe { pack.store(column.as_mut_ptr()) };
            }
            for lane in 0..Self::COUNT {
                // SAFETY: the caller's promise.
                let record = unsafe { &mut *records.add(lane * RECORD).cast::<[R; RECORD]>() };
                for (component, column) in columns.iter().enumerate() {
                    record[half * RECORD / 2 + component] = column[lane];
                }
            }
        }
    }
}

/// A number for each lane: the same for all of them, or a row of their own.
pub(super) trait Spread<R: Real>: Copy {
    /// The numbers of the lanes from one on.
    ///
    /// # Safety
    /// The processor has the instructions of the pack; the lanes are within a slice.
    unsafe fn at<P: Pack<R>>(self, lane: usize) -> P;
}

impl<R: Real> Spread<R> for R {
    #[inline(always)]
    unsafe fn at<P: Pack<R>>(self, _: usize) -> P {
        // SAFETY: the caller's promise.
        unsafe { P::splat(self) }
    }
}

impl<R: Real> Spread<R> for &[R; LANES] {
    #[inline(always)]
    unsafe fn at<P: Pack<R>>(self, lane: usize) -> P {
        // SAFETY: the caller's promise.
        unsafe { P::load(self.as_ptr().add(lane)) }
    }
}

const _: () = assert!(RECORD == 8, "a record is positions and velocities, three numbers of four");

/// Three packs: a vector per lane.
#[derive(Clone, Copy)]
pub(super) struct Triple<P> {
    pub(super) x: P,
    pub(super) y: P,
    pub(super) z: P,
}

impl<P> Triple<P> {
    /// The vectors of three components.
    #[inline(always)]
    pub(super) fn of([x, y, z]: [P; 3]) -> Self {
        Triple { x, y, z }
    }

    /// The same vector in every lane.
    ///
    /// # Safety
    /// The processor has the instructions of the pack.
    #[inline(always)]
    pub(super) unsafe fn splat<R: Real>(vector: R::Vec3) -> Self
    where
        P: Pack<R>,
    {
        let [x, y, z] = vector.components();
        // SAFETY: the caller's promise.
        unsafe { Triple { x: P::splat(x), y: P::splat(y), z: P::splat(z) } }
    }

    /// The vectors of three columns from a slot on.
    ///
    /// # Safety
    /// The processor has the instructions of the pack; the columns have these slots.
    #[inline(always)]
    pub(super) unsafe fn load<R: Real>(columns: Start<R>, column: usize, slot: usize) -> Self
    where
        P: Pack<R>,
    {
        // SAFETY: the caller's promise.
        unsafe {
            Triple {
                x: P::load(columns.at(column, slot)),
                y: P::load(columns.at(column + 1, slot)),
                z: P::load(columns.at(column + 2, slot)),
            }
        }
    }

    /// Writes the vectors to three columns from a slot on.
    ///
    /// # Safety
    /// The columns have these slots.
    #[inline(always)]
    pub(super) unsafe fn store<R: Real>(self, columns: Start<R>, column: usize, slot: usize)
    where
        P: Pack<R>,
    {
        // SAFETY: the caller's promise.
        unsafe {
            self.x.store(columns.at(column, slot));
            self.y.store(columns.at(column + 1, slot));
            self.z.store(columns.at(column + 2, slot));
        }
    }

    /// `self + other` where the mask says so, `self` elsewhere.
    #[inline(always)]
    pub(super) fn add_where<R: Real>(self, mask: P::Mask, other: Self) -> Self
    where
        P: Pack<R>,
    {
        Triple {
            x: self.x.add_where(mask, other.x),
            y: self.y.add_where(mask, other.y),
            z: self.z.add_where(mask, other.z),
        }
    }

    /// `self` where the mask says so, `other` elsewhere.
    #[inline(always)]
    pub(super) fn select<R: Real>(self, mask: P::Mask, other: Self) -> Self
    where
        P: Pack<R>,
    {
        Triple {
            x: self.x.select(mask, other.x),
            y: self.y.select(mask, other.y),
            z: self.z.select(mask, other.z),
        }
    }
}

impl<P: Copy + Add<Output = P> + Mul<Output = P>> Triple<P> {
    /// The scalar products, summed in the order of [`crate::real::Vector::dot`].
    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> P {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
}

impl<P: Add<Output = P>> Add for Triple<P> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Triple { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<P: Sub<Output = P>> Sub for Triple<P> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Triple { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<P: Copy + Mul<Output = P>> Mul<P> for Triple<P> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: P) -> Self {
        Triple { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}
