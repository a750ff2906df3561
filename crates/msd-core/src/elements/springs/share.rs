//! Parallel evaluation of springs, in groups of pieces.
//!
//! Forces between parts of a block are added when all parts are done.

use super::Springs;
use super::layout::{Band, Piece};
use super::sweep::{Input, Sums, add_column, add_extras, add_named, add_segments};
use crate::columns::slots::Slots;
use crate::columns::threads::{are_several, for_each_share, join};
use crate::columns::{Aligned, LANES, RECORD};
use crate::number::{POINT, QUAD, Real, at_level};
use alloc::vec::Vec;
use core::ops::Range;
use fearless_simd::Level;

/// Scratch of an evaluation of springs.
#[derive(Clone, Debug)]
pub(crate) struct SpringWork<R: Real> {
    pub(super) power: Aligned<R>,
    /// For each group of pieces.
    pub(super) groups: Vec<GroupWork<R>>,
    /// Forces between the parts of a block in the sweep that moves: see [`super::fused`].
    pub(super) later: Aligned<R>,
}

/// Scratch of the evaluation of a group of pieces; see [`Sums`].
#[derive(Clone, Debug)]
pub(super) struct GroupWork<R: Real> {
    pub(super) ahead: Aligned<R>,
    pub(super) burnt: Aligned<R>,
    later: Aligned<R>,
    points: Aligned<R>,
}

impl<R: Real> SpringWork<R> {
    pub(crate) fn new(springs: &Springs<R>, slots: &Slots) -> Self {
        let (layout, records) = (&springs.layout, slots.record_count());
        let halo = layout.halo();
        let group = |group: &Range<usize>| GroupWork {
            ahead: Aligned::new((halo + 2) * RECORD, 6),
            burnt: Aligned::new((halo + 2) * LANES + LANES, 7),
            later: Aligned::new(layout.kept(group).max(layout.named(group) * QUAD), 11),
            points: Aligned::new(layout.named(group) * POINT, 8),
        };
        SpringWork {
            power: Aligned::new(records * LANES, 5),
            groups: layout.groups.iter().map(group).collect(),
            later: springs.later(),
        }
    }
}

impl<R: Real> GroupWork<R> {
    fn sums<'a>(&'a mut self, forces: &'a mut [R], power: &'a mut [R]) -> Sums<'a, R> {
        let GroupWork { ahead, burnt, later, points } = self;
        Sums { forces, power, ahead, burnt, later, points }
    }
}

/// An evaluation of all springs.
#[derive(Clone, Copy)]
pub(super) struct Sweep<'a, R: Real> {
    pub(super) springs: &'a Springs<R>,
    pub(super) level: Level,
    pub(super) damped: bool,
    pub(super) input: Input<'a, R>,
}

/// Groups of pieces, with their outputs: numbers that are theirs alone.
pub(super) struct Share<'a, R: Real> {
    pub(super) groups: &'a [Range<usize>],
    pub(super) work: &'a mut [GroupWork<R>],
    /// The first number in the columns of vectors.
    pub(super) first: usize,
    pub(super) forces: &'a mut [R],
    pub(super) power: &'a mut [R],
}

impl<R: Real> Share<'_, R> {
    /// Cuts it between two of its groups.
    fn halves(self, pieces: &[Piece]) -> (Self, Self) {
        let Share { groups, work, first, forces, power } = self;
        let half = groups.len() / 2;
        let (low, high) = groups.split_at(half);
        let cut = pieces[high[0].start].numbers.start;
        let (low_work, work) = work.split_at_mut(half);
        let (low_forces, forces) = forces.split_at_mut(cut - first);
        let (low_power, power) = power.split_at_mut((cut - first) / 3);
        let high = Share { groups: high, work, first: cut, forces, power };
        let (work, forces, power) = (low_work, low_forces, low_power);
        (Share { groups: low, work, first, forces, power }, high)
    }
}

impl<R: Real> Sweep<'_, R> {
    /// Adds the pull of all springs of a share that fit rows, half of the groups at a time.
    pub(super) fn add_groups(&self, share: Share<'_, R>) {
        let Sweep { level, input, damped, .. } = *self;
        let layout = input.layout;
        if 1 < share.groups.len() && are_several() {
            let (low, high) = share.halves(&layout.pieces);
            join(|| self.add_groups(low), || self.add_groups(high));
            return;
        }
        let Share { groups, work, first, forces, power } = share;
        for (group, work) in groups.iter().zip(work) {
            for piece in &layout.pieces[group.clone()] {
                let numbers = piece.numbers.start - first..piece.numbers.end - first;
                let power = &mut power[numbers.start / 3..numbers.end / 3];
                if piece.rows.is_empty() {
                    power.fill(R::ZERO);
                    continue;
                }
                let sums = work.sums(&mut forces[numbers], power);
                let band = &layout.bands[piece.band];
                let (of, part) = ((band, piece), piece.is_part);
                if damped {
                    at_level!(level, isa => match band.halo {
                        None => add_named::<_, R, true>(isa, of, input, sums),
                        Some(halo) if part => {
                            add_segments::<_, R, true, true>(isa, of, halo, input, sums);
                        }
                        Some(halo) => {
                            add_segments::<_, R, true, false>(isa, of, halo, input, sums);
                        }
                    });
                } else {
                    at_level!(level, isa => match band.halo {
                        None => add_named::<_, R, false>(isa, of, input, sums),
                        Some(halo) if part => {
                            add_segments::<_, R, false, true>(isa, of, halo, input, sums);
                        }
                        Some(halo) => {
                            add_segments::<_, R, false, false>(isa, of, halo, input, sums);
                        }
                    });
                }
            }
        }
    }

    /// Adds the forces that parts have kept: those on later parts, then those on the ends of
    /// segments.
    pub(super) fn add_late_sums(
        &self,
        work: &[GroupWork<R>],
        (forces, power): (&mut [R], &mut [R]),
    ) {
        let layout = self.input.layout;
        let parts = || {
            let groups = layout.groups.iter().zip(work);
            let pieces = groups.map(|(group, work)| (&layout.pieces[group.start], work));
            pieces.filter(|(piece, _)| piece.is_part)
        };
        for (piece, work) in parts() {
            let mut kept = &work.later[..];
            for numbers in layout.outside(piece) {
                let later;
                (later, kept) = kept.split_at(numbers.len());
                self.add_column(later, &mut forces[numbers]);
            }
        }
        for (piece, work) in parts() {
            let Band { numbers, halo, .. } = &layout.bands[piece.band];
            let halo = halo.unwrap_or(0);
            let steps = piece.first.min(halo)..(piece.first + piece.steps.len()).min(halo);
            // The ends of segments, seen from the next lane.
            let (to, from) = (numbers.end - (halo - steps.start) * RECORD, 1 + steps.start);
            let (ahead, burnt) =
                (&work.ahead[from * RECORD + 1..], &work.burnt[from * LANES + 1..]);
            let (count, singles) = (steps.len() * RECORD, steps.len() * LANES);
            self.add_column(&ahead[..count], &mut forces[to..][..count]);
            if self.damped {
                self.add_column(&burnt[..singles], &mut power[to / 3..][..singles]);
            }
        }
    }

    /// Adds one column to another of its length.
    fn add_column(&self, column: &[R], to: &mut [R]) {
        for_each_share((to, column), |(to, column)| {
            at_level!(self.level, _simd => add_column(column, to));
        });
    }

    /// Adds the pull of the springs that fit no row.
    pub(super) fn add_extras(&self, sums: (&mut [R], &mut [R])) {
        let Sweep { level, input, springs, .. } = *self;
        if input.layout.extras.is_empty() {
            return;
        }
        let extras = (&input.layout.extras[..], |spring| springs.law(spring));
        if self.damped {
            at_level!(level, simd => add_extras::<_, R, true>(simd, extras, input, sums));
        } else {
            at_level!(level, simd => add_extras::<_, R, false>(simd, extras, input, sums));
        }
    }
}

/// The sum of a column of numbers: one sum for each lane, then theirs.
#[inline(always)]
pub(super) fn sum<R: Real>(column: &[R]) -> f64 {
    sums([0.0; LANES], column).iter().sum()
}

/// Adds a column of numbers to the sums of the lanes, which stay in registers.
#[inline(always)]
pub(super) fn sums<R: Real>(mut sums: [f64; LANES], column: &[R]) -> [f64; LANES] {
    for record in column.as_chunks::<LANES>().0 {
        for (sum, number) in sums.iter_mut().zip(record) {
            *sum += number.to_f64();
        }
    }
    sums
}
