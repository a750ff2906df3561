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
    slices: Vec<Slice<R>>,
    /// Numbers from one column to the next.
    stride: usize,
}

impl<R: Real> Columns<R> {
    /// Makes columns of zeros.
    pub(super) fn new(columns: usize, slices: usize) -> Self {
        let stride = slices + 2;
        Columns { slices: vec![Slice([R::ZERO; LANES]); columns * stride], stride: stride * LANES }
    }

    /// A column, one number per slot.
    pub(super) fn column(&self, column: usize) -> &[R] {
        let begin = column * self.stride + LANES;
        &self.flat()[begin..begin + self.stride - 2 * LANES]
    }

    /// A column to write to, one number per slot.
    pub(super) fn column_mut(&mut self, column: usize) -> &mut [R] {
        let begin = column * self.stride + LANES;
        let end = begin + self.stride - 2 * LANES;
        &mut self.flat_mut()[begin..end]
    }

    fn flat(&self) -> &[R] {
        const { assert!(size_of::<Slice<R>>() == LANES * size_of::<R>(), "a gap") };
        let count = self.slices.len() * LANES;
        // SAFETY: a slice is numbers without a gap.
        unsafe { core::slice::from_raw_parts(self.slices.as_ptr().cast(), count) }
    }

    /// All columns with what is between them.
    pub(super) fn flat_mut(&mut self) -> &mut [R] {
        let count = self.slices.len() * LANES;
        // SAFETY: a slice is numbers without a gap, as asserted above.
        unsafe { core::slice::from_raw_parts_mut(self.slices.as_mut_ptr().cast(), count) }
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
        self.slices.len() * LANES == columns * self.stride
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

    /// Where rows start that lie one after the other in a single column, from one of them on.
    pub(super) fn rows(&mut self, first: usize) -> Start<R> {
        Start { first: self.start().at(0, first * LANES), stride: LANES }
    }

    /// The first slot of the first column and the distance to that of the next column.
    pub(super) fn start(&mut self) -> Start<R> {
        let first = self.slices.as_mut_ptr().cast::<R>();
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
