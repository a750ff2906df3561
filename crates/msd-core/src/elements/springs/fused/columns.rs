//! Columns of a fused sweep, or the same part of each.

use crate::columns::RECORD;
use crate::columns::threads::Split;
use crate::elements::springs::layout::{Layout, Piece};
use crate::number::Real;
use core::ops::Range;

impl Layout {
    /// The forces that parts of a band exert on later parts.
    pub(super) fn reached(&self, band: usize) -> Reached<'_> {
        let first = self.pieces.partition_point(|piece| piece.band < band);
        let end = self.pieces.partition_point(|piece| piece.band <= band);
        Reached { numbers: self.bands[band].reach * RECORD, pieces: &self.pieces[first..end] }
    }
}

/// The numbers that the parts of a band add to behind themselves: so many of each but the last.
/// The forces on them are one column.
#[derive(Clone, Copy)]
pub(super) struct Reached<'a> {
    pub(super) numbers: usize,
    pub(super) pieces: &'a [Piece],
}

impl Reached<'_> {
    /// The place in that column of the first force on a number or behind it.
    pub(super) fn place(&self, number: usize) -> usize {
        let part = self.pieces.partition_point(|piece| piece.numbers.end <= number);
        part.checked_sub(1).map_or(0, |before| {
            let behind = number - self.pieces[before].numbers.end;
            before * self.numbers + behind.min(self.numbers)
        })
    }
}

/// The columns that are swept, or the same part of each. Empty ones are not used.
pub(super) struct Swept<'a, R> {
    pub(super) positions: &'a mut [R],
    pub(super) velocities: &'a mut [R],
    pub(super) forces: &'a mut [R],
    /// Those of the parts of a band on later ones, see [`Reached`].
    pub(super) later: &'a mut [R],
    /// The power of the dampers of each record, watts, from the number `power_first` on.
    pub(super) power: &'a mut [R],
    pub(super) power_first: usize,
    /// The first number in the columns of vectors.
    pub(super) first: usize,
    pub(super) reached: Reached<'a>,
}

impl<R> Swept<'_, R> {
    /// The motion, to be read, and the other columns.
    pub(super) fn halves(&mut self) -> ([&[R]; 2], Swept<'_, R>) {
        let Swept { positions, velocities, forces, later, .. } = self;
        let others = Swept {
            positions: &mut [],
            velocities: &mut [],
            forces,
            later,
            power: &mut [],
            ..*self
        };
        ([positions, velocities], others)
    }

    /// Some of its numbers, which are in one band.
    pub(super) fn of<'a>(
        &'a mut self,
        numbers: &Range<usize>,
        reached: Reached<'a>,
    ) -> Swept<'a, R> {
        let inside = numbers.start - self.first..numbers.end - self.first;
        let singles = inside.start / 3..inside.end / 3;
        Swept {
            positions: &mut self.positions[inside.clone()],
            velocities: &mut self.velocities[inside.clone()],
            forces: &mut self.forces[inside],
            later: self.later,
            power: self.power.get_mut(singles).unwrap_or_default(),
            power_first: numbers.start,
            first: numbers.start,
            reached,
        }
    }
}

impl<R: Real> Split for Swept<'_, R> {
    fn numbers(&self) -> usize {
        self.forces.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let Swept { positions, velocities, forces, later, power, power_first, first, reached } =
            self;
        let middle = first + numbers;
        let moved = numbers.min(positions.len());
        let (low_positions, positions) = positions.split_at_mut(moved);
        let (low_velocities, velocities) = velocities.split_at_mut(moved);
        let (low_forces, forces) = forces.split_at_mut(numbers);
        let (low_later, later) = later.split_at_mut(reached.place(middle) - reached.place(first));
        let (low_power, power) = power.split_at_mut(moved / 3);
        let low = Swept {
            positions: low_positions,
            velocities: low_velocities,
            forces: low_forces,
            later: low_later,
            power: low_power,
            power_first,
            first,
            reached,
        };
        let first = middle;
        let power_first = middle;
        let high =
            Swept { positions, velocities, forces, later, power, power_first, first, reached };
        (low, high)
    }
}
