//! Columns of numbers in the order of slots, aligned to cache lines.
//!
//! Sixteen particles are a record: sixteen x, then sixteen y, then sixteen z. A column of vectors
//! is records one after the other, a flat slice that a pass walks from end to end. A column of
//! numbers has sixteen of them for each record.

pub mod slots;
pub(crate) mod threads;
pub(crate) mod extent;

use crate::number::Real;
pub use crate::number::{LANES, RECORD};
use crate::pack::Pack;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::{Deref, DerefMut};
use fearless_simd::Simd;

/// Bytes of a cache line, and of a page.
const LINE: usize = 64;
const PAGE: usize = 4096;

/// Numbers that start on a cache line. Derefs to a slice.
///
/// Columns of at least a page start at different places in a page: a load waits for an earlier
/// store to an address that differs by a multiple of 4096 bytes.
#[derive(Debug, Default)]
pub struct Aligned<R> {
    numbers: Vec<R>,
    first: usize,
    len: usize,
    place: usize,
}

impl<R: Real> Aligned<R> {
    /// Makes `len` zeros; columns that are used together have different `place`s.
    pub fn new(len: usize, place: usize) -> Self {
        let (line, page) = (LINE / size_of::<R>(), PAGE / size_of::<R>());
        if len < page {
            let numbers = vec![R::ZERO; len + line];
            // Without an answer, as in Miri, it is correct all the same.
            let first = numbers.as_ptr().align_offset(LINE).min(line);
            return Aligned { numbers, first, len, place };
        }
        let numbers = vec![R::ZERO; len + 2 * page];
        // Five is odd, so that 32 places in turn are all there are, two lines apart.
        let stagger = place * 5 % 32 * 2 * line;
        let first = numbers.as_ptr().align_offset(PAGE).min(page) + stagger;
        Aligned { numbers, first, len, place }
    }
}

impl<R: Real> Clone for Aligned<R> {
    fn clone(&self) -> Self {
        let mut clone = Aligned::new(self.len, self.place);
        clone.copy_from_slice(self);
        clone
    }
}

impl<R> Deref for Aligned<R> {
    type Target = [R];

    #[inline(always)]
    fn deref(&self) -> &[R] {
        &self.numbers[self.first..][..self.len]
    }
}

impl<R> DerefMut for Aligned<R> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [R] {
        &mut self.numbers[self.first..][..self.len]
    }
}

/// The vector at a place of a column.
#[inline(always)]
pub fn vector<R: Real>(column: &[R], at: usize) -> R::Vec3 {
    use crate::number::Vector;
    R::Vec3::from_components([column[at], column[at + LANES], column[at + 2 * LANES]])
}

/// Overwrites the vector at a place of a column.
#[inline(always)]
pub fn set_vector<R: Real>(column: &mut [R], at: usize, value: R::Vec3) {
    use crate::number::Vector;
    [column[at], column[at + LANES], column[at + 2 * LANES]] = value.components();
}

/// Adds to the vector at a place of a column.
#[inline(always)]
pub(crate) fn add_vector<R: Real>(column: &mut [R], at: usize, value: R::Vec3) {
    set_vector(column, at, vector::<R>(column, at) + value);
}

/// The place in a column of numbers that belongs to a place in a column of vectors.
#[inline(always)]
pub fn single(at: usize) -> usize {
    at / RECORD * LANES + at % LANES
}

/// The number of a particle, by its place in the columns of vectors, in a column of a number for
/// each slot; 0 where that is empty.
#[inline(always)]
pub(crate) fn single_of<R: Real>(column: &[R], at: usize) -> R {
    column.get(single(at)).map_or(R::ZERO, |&number| number)
}

/// The numbers of a record in such a column.
#[inline(always)]
pub(crate) fn singles_of<R: Real>(column: &[R], record: usize) -> [R; LANES] {
    match column {
        [] => [R::ZERO; LANES],
        all => *all[record * LANES..].first_chunk().expect("a record"),
    }
}

/// A part of the vectors of the first record of a column, axis by axis.
#[inline(always)]
pub(crate) fn load<S: Simd, R: Real>(simd: S, from: &[R], part: usize) -> [Pack<S, R>; 3] {
    let record: &[R; RECORD] = from.first_chunk().expect("a record");
    let lanes = Pack::<S, R>::LEN;
    let column = |c: usize| Pack::from_slice(simd, &record[c + part..c + part + lanes]);
    [column(0), column(LANES), column(2 * LANES)]
}

/// Overwrites such a part.
#[inline(always)]
pub(crate) fn store<S: Simd, R: Real>(values: [Pack<S, R>; 3], to: &mut [R], part: usize) {
    let record: &mut [R; RECORD] = to.first_chunk_mut().expect("a record");
    for (axis, value) in values.into_iter().enumerate() {
        let at = axis * LANES + part;
        value.store_slice(&mut record[at..at + Pack::<S, R>::LEN]);
    }
}
