//! Parallel evaluation of springs, in groups of pieces.
//!
//! Forces between parts of a block are added when all parts are done.

use super::Springs;
use super::layout::Band;
use super::sweep::{Input, Sums, add_column, add_extras, add_springs};
use crate::columns::slots::Slots;
use crate::columns::threads::{are_several, for_each_share, join, merge_shares};
use crate::columns::{Aligned, LANES, RECORD};
use crate::number::{POINT, QUAD, Real, at_level};
use alloc::vec::Vec;
use core::ops::Range;
use fearless_simd::Level;

/// Scratch of an evaluation of springs.
#[derive(Clone, Debug)]
pub(crate) struct SpringWork<R: Real> {
    power: Aligned<R>,
    /// For each group of pieces.
    groups: Vec<GroupWork<R>>,
}

/// Scratch of the evaluation of a group of pieces; see [`Sums`].
#[derive(Clone, Debug)]
struct GroupWork<R: Real> {
    ahead: Aligned<R>,
    burnt: Aligned<R>,
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
        }
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

/// Groups of pieces, with what they write: numbers that are theirs alone.
struct Share<'a, R: Real> {
    groups: &'a [Range<usize>],
    work: &'a mut [GroupWork<R>],
    /// The first number in the columns of vectors.
    first: usize,
    forces: &'a mut [R],
    power: &'a mut [R],
}

impl<R: Real> Sweep<'_, R> {
    /// Adds the pull of every spring and returns the power that dampers dissipate, watts.
    pub(super) fn run(&self, work: &mut SpringWork<R>, forces: &mut [R]) -> f64 {
        let SpringWork { power, groups: work, .. } = work;
        let groups = &self.input.layout.groups[..];
        let sums = (&mut *forces, &mut **power);
        self.add_groups(Share { groups, work, first: 0, forces: sums.0, power: sums.1 });
        self.add_late_sums(work, (&mut *forces, &mut *power));
        self.add_extras((forces, power));
        if !self.damped {
            return 0.0;
        }
        let sum_share = |power: &[R]| at_level!(self.level, _simd => sum(power));
        merge_shares(&**power, &sum_share, &|low, high| low + high)
    }

    /// Adds the pull of all springs of a share that fit rows, half of the groups at a time.
    fn add_groups(&self, share: Share<'_, R>) {
        let Share { groups, work, first, forces, power } = share;
        let half = groups.len() / 2;
        if half == 0 || !are_several() {
            for (group, work) in groups.iter().zip(work) {
                self.add_group(group.clone(), work, first, (&mut *forces, &mut *power));
            }
            return;
        }
        let (low, high) = groups.split_at(half);
        let cut = self.input.layout.pieces[high[0].start].numbers.start;
        let (low_work, high_work) = work.split_at_mut(half);
        let (low_forces, high_forces) = forces.split_at_mut(cut - first);
        let (low_power, high_power) = power.split_at_mut((cut - first) / 3);
        let (forces, power) = (low_forces, low_power);
        let low = Share { groups: low, work: low_work, first, forces, power };
        let (forces, power) = (high_forces, high_power);
        let high = Share { groups: high, work: high_work, first: cut, forces, power };
        join(|| self.add_groups(low), || self.add_groups(high));
    }

    /// Adds the pull of the springs of a group to columns that start at a number.
    fn add_group(
        &self,
        group: Range<usize>,
        work: &mut GroupWork<R>,
        first: usize,
        (forces, power): (&mut [R], &mut [R]),
    ) {
        let Sweep { level, input, .. } = *self;
        for piece in &input.layout.pieces[group] {
            let numbers = piece.numbers.start - first..piece.numbers.end - first;
            let power = &mut power[numbers.start / 3..numbers.end / 3];
            let forces = &mut forces[numbers];
            let GroupWork { ahead, burnt, later, points } = &mut *work;
            let sums = Sums { forces, power, ahead, burnt, later, points };
            if piece.rows.is_empty() {
                sums.power.fill(R::ZERO);
            } else if self.damped {
                at_level!(level, simd => add_springs::<_, R, true>(simd, piece, input, sums));
            } else {
                at_level!(level, simd => add_springs::<_, R, false>(simd, piece, input, sums));
            }
        }
    }

    /// Adds what parts have kept: forces on later parts, then those on the ends of segments.
    fn add_late_sums(&self, work: &[GroupWork<R>], (forces, power): (&mut [R], &mut [R])) {
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
    fn add_extras(&self, sums: (&mut [R], &mut [R])) {
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
fn sum<R: Real>(column: &[R]) -> f64 {
    let mut sums = [0.0; LANES];
    for record in column.as_chunks::<LANES>().0 {
        for (sum, number) in sums.iter_mut().zip(record) {
            *sum += number.to_f64();
        }
    }
    sums.iter().sum()
}
