//! The fused sweep: adds the springs and moves each record as soon as its force is whole.
//!
//! The columns of a large lattice leave the caches. Passes that set forces, add springs and move
//! particles stream them three times in a substep; this sweep streams them once. A step of the
//! sweep (see [`super::layout`]) adds the springs of a record to higher numbers. Those to lower
//! numbers came before, so its force is whole, and no later step reads its position: the steps of
//! the halo, which read the ends of segments, come first.
//!
//! Threads sweep *shares* of a band, runs of records of equal length. Rows that end behind a share
//! are for it what the halo is for the band: threads take these rows of all shares first, while
//! nothing moves. Those of a record are the first of its step, and so its sums wait until the
//! share comes to that step. From then on no thread reads what another writes.
//!
//! Every particle sums in the order of the passes, so the bits are the same, wherever shares end.

mod columns;
mod steps;

use super::Springs;
use super::layout::{Band, Layout, Piece};
use super::share::{GroupWork, SpringWork, sum, sums};
use crate::columns::threads::{self, for_each_part, merge_in_turn, merge_shares};
use crate::columns::{Aligned, LANES, RECORD};
use crate::elements::fields::Fields;
use crate::number::{Real, at_level};
use columns::{Reached, Swept};
use core::ops::Range;
use fearless_simd::Level;
use steps::{Mover, Run, add_steps, move_steps};

/// The columns that a sweep moves by `h` seconds, and those that it reads.
pub(crate) struct Moving<'a, R: Real> {
    pub(crate) positions: &'a mut [R],
    pub(crate) velocities: &'a mut [R],
    /// Overwritten with the forces at the start, newtons.
    pub(crate) forces: &'a mut [R],
    /// A mass for each slot, and its reciprocal three times.
    pub(crate) masses: &'a [R],
    pub(crate) inverse_masses: &'a [R],
    /// Fields without drag.
    pub(crate) fields: &'a Fields<R>,
    pub(crate) h: R,
}

/// Records that move before their power is summed: few, so that it stays in the near caches.
const TOGETHER: usize = 128;

impl<R: Real> Springs<R> {
    /// Whether a sweep may move all particles: each block has segments, no spring joins two blocks,
    /// and no particle gets forces from two parts of a block before its own. Several threads need
    /// blocks that are long enough for two shares.
    pub(crate) fn can_move(&self) -> bool {
        let Layout { bands, pieces, extras, .. } = &self.layout;
        let is_ordered = |pair: &[Piece]| {
            let [piece, next] = [&pair[0], &pair[1]];
            if piece.band != next.band {
                return true;
            }
            let Band { halo, reach, numbers, .. } = &bands[piece.band];
            // Who asks for threads starts them: only large blocks do.
            if numbers.len() < (1 + 2 * reach) * RECORD && threads::are_several() {
                return false;
            }
            // The halo is in the first part, which may be short.
            piece.numbers.len() >= reach * RECORD || piece.first == 0 && *halo <= Some(next.first)
        };
        extras.is_empty()
            && bands.iter().all(|band| band.halo.is_some())
            && pieces.windows(2).all(is_ordered)
    }

    /// Zeros for the forces between parts of any band: see [`Reached`].
    pub(super) fn later(&self) -> Aligned<R> {
        let bands = (0..self.layout.bands.len()).map(|band| self.layout.reached(band));
        let numbers = bands.map(|reached| reached.numbers * (reached.pieces.len() - 1)).max();
        match numbers {
            None | Some(0) => Aligned::default(),
            Some(numbers) => Aligned::new(numbers, 11),
        }
    }

    /// Overwrites forces with those of fields and springs, and moves all particles by a kick and a
    /// drift; returns the power that the springs dissipate at the start, watts.
    pub(crate) fn move_particles(
        &self,
        level: Level,
        work: &mut SpringWork<R>,
        moving: &mut Moving<'_, R>,
    ) -> f64 {
        let Moving { positions, velocities, forces, masses, inverse_masses, fields, h } = moving;
        let mover = Mover { springs: self, level, masses, inverse_masses, fields, h: *h };
        let SpringWork { power, groups, later } = work;
        let mut columns = Swept {
            positions,
            velocities,
            forces,
            later,
            power,
            first: 0,
            power_first: 0,
            reached: Reached { numbers: 0, pieces: &[] },
        };
        if self.is_shared() && threads::are_several() {
            return mover.move_shared(groups, columns);
        }
        let power = mover.move_in_turn(groups, &mut columns);
        if self.is_damped() { power } else { 0.0 }
    }
}

/// How far a sweep of a band has come.
struct Front {
    band: usize,
    piece: usize,
    /// The next step and the next row, counted in the band and in the layout.
    step: usize,
    row: usize,
}

impl<R: Real> Mover<'_, R> {
    /// Moves all particles on one thread; returns the power.
    fn move_in_turn(&self, groups: &mut [GroupWork<R>], columns: &mut Swept<'_, R>) -> f64 {
        let Some(GroupWork { ahead, burnt, .. }) = groups.first_mut() else { return 0.0 };
        let records = columns.forces.len() / RECORD;
        let power = core::mem::take(&mut columns.power);
        let mut front = self.front(0, 0);
        let mut run = |numbers: Range<usize>| {
            let (records, mut lanes) = (numbers.start / LANES..numbers.end / LANES, [0.0; LANES]);
            for first in records.clone().step_by(TOGETHER) {
                let last = records.end.min(first + TOGETHER);
                let (numbers, power) =
                    (first * RECORD..last * RECORD, &mut power[..(last - first) * LANES]);
                self.move_records(&mut front, (&numbers, power), [ahead, burnt], columns);
                lanes = at_level!(self.level, _simd => sums(lanes, power));
            }
            lanes.iter().sum::<f64>()
        };
        // Cut as the column of power is.
        merge_in_turn(0..records * LANES, &mut run, &|low, high| low + high)
    }

    /// Moves the next records, those of some numbers, from a front in a band on.
    fn move_records(
        &self,
        front: &mut Front,
        (numbers, power): (&Range<usize>, &mut [R]),
        [ahead, burnt]: [&mut [R]; 2],
        columns: &mut Swept<'_, R>,
    ) {
        let layout = &self.springs.layout;
        while let Some(band) = layout.bands.get(front.band) {
            let Range { start, end } = band.numbers;
            if numbers.end <= start {
                return;
            }
            let mut columns = columns.of(&band.numbers, layout.reached(front.band));
            (columns.power, columns.power_first) = (&mut *power, numbers.start);
            if numbers.contains(&start) {
                // No step writes the power of the record in front of the first.
                columns.power[(start - numbers.start) / 3..][..LANES].fill(R::ZERO);
                let (motion, mut sums) = columns.halves();
                self.add_border(front, 0, motion, (&mut sums, [ahead, burnt]));
            }
            let last = numbers.end.min(end);
            self.move_to(front, last - start, (&mut columns, [ahead, burnt]));
            if last < end {
                return;
            }
            *front = self.front(front.band + 1, 0);
        }
    }

    /// Moves all particles on the threads of the pool; returns the power.
    fn move_shared(&self, work: &mut [GroupWork<R>], mut columns: Swept<'_, R>) -> f64 {
        let Layout { bands, pieces, groups, .. } = &self.springs.layout;
        let mut group = 0;
        while let Some(first) = groups.get(group).map(|group| &pieces[group.start]) {
            let others = groups[group..].iter().map(|group| &pieces[group.start]);
            // Parts are groups of their own.
            let count = if first.is_part {
                others.take_while(|piece| piece.band == first.band).count()
            } else {
                others.take_while(|piece| !piece.is_part).count()
            };
            let next = group + count;
            let work = &mut work[group..next];
            if first.is_part {
                let reached = self.springs.layout.reached(first.band);
                let columns = columns.of(&bands[first.band].numbers, reached);
                self.move_in_shares(first.band, work, columns);
            } else {
                let end = pieces[groups[next - 1].end - 1].numbers.end;
                let none = Reached { numbers: 0, pieces: &[] };
                let columns = columns.of(&(first.numbers.start..end), none);
                let cut = |group: usize| pieces[groups[group].start].numbers.start;
                for_each_part(columns, (group, work), &cut, &|group, mut columns, work| {
                    for piece in &pieces[groups[group].clone()] {
                        let columns = columns.of(&piece.numbers, none);
                        self.move_in_shares(piece.band, core::slice::from_mut(work), columns);
                    }
                });
            }
            group = next;
        }
        if !self.springs.is_damped() {
            return 0.0;
        }
        let sum_share = |power: &[R]| at_level!(self.level, _simd => sum(power));
        merge_shares(&*columns.power, &sum_share, &|low, high| low + high)
    }

    /// Moves a band, whose columns these are, in as many shares as there are threads for, and
    /// scratch.
    fn move_in_shares(&self, band: usize, work: &mut [GroupWork<R>], mut columns: Swept<'_, R>) {
        let Band { numbers, halo, .. } = &self.springs.layout.bands[band];
        let (halo, len) = (halo.unwrap_or(0), numbers.len() / RECORD - 1);
        let most = work.len().min(len / halo.max(1)).max(1);
        let shares = most.min(threads::count());
        let work = &mut work[..shares];
        let record = |share: usize| len * share / shares;
        let cut = |share: usize| match share {
            0 => 0,
            _ => (1 + record(share)) * RECORD,
        };
        // See above.
        columns.power[..LANES].fill(R::ZERO);
        let (motion, sums) = columns.halves();
        for_each_part(sums, (0, &mut *work), &cut, &|share, mut columns, work| {
            let GroupWork { ahead, burnt, .. } = work;
            let front = &mut self.front(band, record(share));
            self.add_border(front, record(share), motion, (&mut columns, [ahead, burnt]));
        });
        // What is kept is that of the share before; that of the band, of the last.
        work.rotate_left(1);
        for_each_part(columns, (0, &mut *work), &cut, &|share, mut columns, work| {
            let GroupWork { ahead, burnt, .. } = work;
            let front = &mut self.front(band, halo + record(share));
            let end = columns.first - numbers.start + columns.forces.len();
            self.move_to(front, end, (&mut columns, [ahead, burnt]));
        });
        work.rotate_right(1);
    }

    /// The front of a band in front of a step.
    fn front(&self, band: usize, step: usize) -> Front {
        let Layout { bands, pieces, steps, .. } = &self.springs.layout;
        let is_before = |piece: &Piece| {
            piece.band < band || piece.band == band && piece.first + piece.steps.len() <= step
        };
        let piece = pieces.partition_point(is_before);
        let row = match (pieces.get(piece), bands.get(band)) {
            (Some(piece), Some(band)) => {
                let before = &steps[piece.steps.start..band.steps.start + step];
                piece.rows.start + before.iter().map(|step| step.rows as usize).sum::<usize>()
            }
            _ => 0,
        };
        Front { band, piece, step, row }
    }

    /// Takes all steps in front of `end`, piece by piece, those apart that other parts concern.
    fn take(&self, front: &mut Front, end: usize, mut take: impl FnMut(Run<'_>) -> usize) {
        let Layout { bands, pieces, .. } = &self.springs.layout;
        while front.step < end {
            let piece = &pieces[front.piece];
            let band = &bands[piece.band];
            let last = piece.first + piece.steps.len();
            let got = if piece.first == 0 { 0 } else { piece.first + band.reach };
            let given = (piece.numbers.end - band.numbers.start) / RECORD - 1;
            let next = [got, given, last].into_iter().filter(|&next| front.step < next).min();
            let steps = front.step..next.unwrap_or(last).min(end);
            let is_alone = !piece.is_part || got <= steps.start && steps.end <= given;
            front.step = steps.end;
            front.row = take(Run { band, piece, steps, row: front.row, is_alone });
            front.piece += usize::from(front.step == last);
        }
    }

    /// Adds the springs from records in front of one of the band to it and those behind it, at a
    /// motion of the band. The sums of their steps are kept.
    fn add_border(
        &self,
        front: &mut Front,
        record: usize,
        motion: [&[R]; 2],
        (columns, [ahead, burnt]): (&mut Swept<'_, R>, [&mut [R]; 2]),
    ) {
        let halo = self.springs.layout.bands[front.band].halo.unwrap_or(0);
        self.take(front, record + halo, |run| {
            let sums = (&mut *columns, [&mut *ahead, &mut *burnt]);
            let level = self.level;
            match (self.springs.is_damped(), !run.is_alone) {
                (true, true) => at_level!(level, simd => {
                    add_steps::<_, R, true, true>(simd, self, (run, record), motion, sums)
                }),
                (true, false) => at_level!(level, simd => {
                    add_steps::<_, R, true, false>(simd, self, (run, record), motion, sums)
                }),
                (false, true) => at_level!(level, simd => {
                    add_steps::<_, R, false, true>(simd, self, (run, record), motion, sums)
                }),
                (false, false) => at_level!(level, simd => {
                    add_steps::<_, R, false, false>(simd, self, (run, record), motion, sums)
                }),
            }
        });
    }

    /// Moves the particles in front of a number of the band, with the sums that are kept.
    fn move_to(
        &self,
        front: &mut Front,
        end: usize,
        (columns, [ahead, burnt]): (&mut Swept<'_, R>, [&[R]; 2]),
    ) {
        let halo = self.springs.layout.bands[front.band].halo.unwrap_or(0);
        self.take(front, halo + end / RECORD - 1, |run| {
            let kept = [ahead, burnt];
            let level = self.level;
            match (self.springs.is_damped(), !run.is_alone) {
                (true, true) => at_level!(level, simd => {
                    move_steps::<_, R, true, true>(simd, self, run, columns, kept)
                }),
                (true, false) => at_level!(level, simd => {
                    move_steps::<_, R, true, false>(simd, self, run, columns, kept)
                }),
                (false, true) => at_level!(level, simd => {
                    move_steps::<_, R, false, true>(simd, self, run, columns, kept)
                }),
                (false, false) => at_level!(level, simd => {
                    move_steps::<_, R, false, false>(simd, self, run, columns, kept)
                }),
            }
        });
    }
}
