//! Radii of particles as obstacles see them.
//!
//! An obstacle knows the gap of a point; that of a particle is less by its radius.

use crate::columns::threads::split_singles;
use crate::columns::{LANES, single_of, singles_of};
use crate::number::Real;

/// The radii of particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Radii<'a, R> {
    /// That of each slot, metres; empty where all are points.
    pub(crate) column: &'a [R],
    /// The largest.
    pub(crate) largest: R,
}

impl<R: Real> Radii<'_, R> {
    pub(crate) fn split(self, numbers: usize) -> (Self, Self) {
        let (low, high) = split_singles(self.column, numbers);
        (Radii { column: low, ..self }, Radii { column: high, ..self })
    }

    /// That of a particle by its place in the columns of vectors, metres.
    #[inline(always)]
    pub(crate) fn at(&self, place: usize) -> R {
        single_of(self.column, place)
    }

    /// Those of a record.
    #[inline(always)]
    pub(crate) fn of_record(&self, record: usize) -> [R; LANES] {
        singles_of(self.column, record)
    }
}
