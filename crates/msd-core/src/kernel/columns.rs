//! Where do the numbers of a sweep lie? In columns of slots, with room for a slice at either end.

use super::LANES;
use crate::real::Real;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// As many numbers as a slice, aligned to a line of the cache.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Slice<R>(pub(super) [R; LANES]);

/// Columns of one length, one after the other.
///
/// A run reaches at most a slice beyond the particles, so there is one more slice at either end of
/// a column; what is there is read, and masked out.
#[derive(Clone, Debug)]
pub(super) struct Columns<R> {
    /// The columns, and as much as it takes to start them where they should; those of a clone start
    /// anywhere, and may be slower.
    slices: Vec<Slice<R>>,
    /// Numbers before the first column, of all columns, and from one column to the next.
    before: usize,
    count: usize,
    stride: usize,
}

/// Bytes that a processor compares of two addresses, so that a load whose address ends like that of
/// a store on its way waits for it: fifty cycles and more.
const PAGE: usize = 4096;

/// Slices from which on columns are placed, though a third of small ones is gaps then.
const WORTH_PLACING: usize = 16;

impl<R: Real> Columns<R> {
    /// Makes columns of zeros.
    pub(super) fn new(columns: usize, slices: usize) -> Self {
        Columns::made(columns, slices + 2, None)
    }

    /// Makes columns of zeros, which start at a place of a page, in 64ths of one, and at the place
    /// half a page on, in turn.
    ///
    /// Where a sweep reads columns at one place and writes columns a quarter of a page from there,
    /// what it stores does not hold up what its next slices load, unless their springs reach as
    /// far. All columns at a single place would crowd a part of the nearest cache.
    pub(super) fn placed(columns: usize, slices: usize, place: usize) -> Self {
        if slices < WORTH_PLACING {
            return Columns::new(columns, slices);
        }
        let half = PAGE / 2 / size_of::<Slice<R>>();
        let stride = ((slices + 2).div_ceil(half) | 1) * half;
        Columns::made(columns, stride, Some(place * half / 32))
    }

    fn made(columns: usize, stride: usize, place: Option<usize>) -> Self {
        let page = PAGE / size_of::<Slice<R>>();
        let count = columns * stride;
        let room = if place.is_some() { page } else { 0 };
        let slices = vec![Slice([R::ZERO; LANES]); count + room];
        let here = slices.as_ptr().addr() / size_of::<Slice<R>>();
        let before = place.map_or(0, |place| (place + page - here % page) % page);
        let [before, count, stride] = [before, count, stride].map(|slices| slices * LANES);
        Columns { slices, before, count, stride }
    }

    /// A column, one number per slot and maybe more.
    pub(super) fn column(&self, column: usize) -> &[R] {
        let begin = column * self.stride + LANES;
        &self.flat()[begin..begin + self.stride - 2 * LANES]
    }

    /// A column to write to, one number per slot and maybe more.
    pub(super) fn column_mut(&mut self, column: usize) -> &mut [R] {
        let begin = column * self.stride + LANES;
        let end = begin + self.stride - 2 * LANES;
        &mut self.flat_mut()[begin..end]
    }

    fn flat(&self) -> &[R] {
        const { assert!(size_of::<Slice<R>>() == LANES * size_of::<R>(), "a gap") };
        let count = self.slices.len() * LANES;
        // SAFETY: a slice is numbers without a gap.
        let all = unsafe { core::slice::from_raw_parts(self.slices.as_ptr().cast(), count) };
        &all[self.before..][..self.count]
    }

    /// All columns with what is between them.
    pub(super) fn flat_mut(&mut self) -> &mut [R] {
        let count = self.slices.len() * LANES;
        let first = self.slices.as_mut_ptr().cast();
        // SAFETY: a slice is numbers without a gap, as asserted above.
        let all = unsafe { core::slice::from_raw_parts_mut(first, count) };
        &mut all[self.before..][..self.count]
    }

    /// Three columns from one on.
    pub(super) fn three_mut(&mut self, column: usize) -> [&mut [R]; 3] {
        let stride = self.stride;
        let begin = column * stride;
        let (x, rest) = self.flat_mut()[begin..begin + 3 * stride].split_at_mut(stride);
        let (y, z) = rest.split_at_mut(stride);
        [x, y, z].map(|column| &mut column[LANES..stride - LANES])
    }

    /// Copies columns over others.
    pub(super) fn copy(&mut self, columns: Range<usize>, to: usize) {
        let stride = self.stride;
        let from = columns.start * stride..columns.end * stride;
        self.flat_mut().copy_within(from, to * stride);
    }

    /// Whether there are so many columns.
    pub(super) fn has(&self, columns: usize) -> bool {
        self.count == columns * self.stride
    }

    /// Whether no number of three columns is larger than a bound; one that is not a number is.
    pub(super) fn is_within(&self, column: usize, bound: R) -> bool {
        (column..column + 3).fold(true, |within, column| {
            let numbers = self.column(column).iter();
            numbers.fold(within, |within, &number| within & (number.abs() <= bound))
        })
    }

    /// The memory that the columns take, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.slices[..])
    }

    /// The first slot of the first column and the distance to that of the next column.
    pub(super) fn start(&mut self) -> Start<R> {
        let first = self.slices.as_mut_ptr().cast::<R>().wrapping_add(self.before);
        // Beyond the end where there are no columns; nothing is read or written then.
        Start { first: first.wrapping_add(LANES), stride: self.stride }
    }
}

/// Where columns start.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start<R> {
    first: *mut R,
    stride: usize,
}

impl<R: Copy> Start<R> {
    /// The same columns without the first few.
    pub(super) fn from(self, column: usize) -> Self {
        Start { first: self.at(column, 0), ..self }
    }

    /// The number in a slot of a column; one before the first slot is a number below zero, wrapped.
    pub(super) fn at(self, column: usize, slot: usize) -> *mut R {
        self.first.wrapping_add(column * self.stride).wrapping_add(slot)
    }
}
