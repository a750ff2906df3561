//! The fused sweep: adds the springs and moves each record as soon as its force is whole.
//!
//! The columns of a large lattice leave the caches. Passes that set forces, add springs and move
//! particles stream them three times in a substep; this sweep streams them once. A step of the
//! sweep (see [`super::layout`]) adds the springs of a record to higher numbers. Those to lower
//! numbers came before, so its force is whole, and no later step reads its position: the steps of
//! the halo, which read the ends of segments, come first.
//!
//! Every particle sums in the order of the passes, so the bits are the same. Parts run in turn.

use super::Springs;
use super::layout::{Band, Layout, Piece};
use super::share::{GroupWork, SpringWork, sums};
use super::sweep::{Ends, StepMotion, StepSums, add_rows, fetch, is_far, motion};
use crate::columns::threads::merge_in_turn;
use crate::columns::{LANES, RECORD, load, store};
use crate::elements::fields::Fields;
use crate::number::{Real, at_level};
use crate::pack::{Pack, zip};
use core::ops::Range;
use fearless_simd::{Level, Simd};

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

/// Records that are moved before their power is summed: near the processor, it is in no column.
const TOGETHER: usize = 128;

/// How far a sweep has come.
#[derive(Default)]
struct Front {
    group: usize,
    piece: usize,
    /// The next step, counted in the band, and the next row.
    step: usize,
    row: usize,
}

impl<R: Real> Springs<R> {
    /// Whether a sweep may move all particles: each block has segments, no spring joins two blocks,
    /// and no particle gets forces from two parts of a block before its own.
    pub(crate) fn can_move(&self) -> bool {
        let Layout { bands, pieces, extras, .. } = &self.layout;
        let is_ordered = |pair: &[Piece]| {
            let [piece, next] = [&pair[0], &pair[1]];
            let band = &bands[piece.band];
            let is_whole = piece.first == 0 || piece.band != next.band;
            is_whole || band.reach * RECORD <= piece.numbers.len()
        };
        extras.is_empty()
            && bands.iter().all(|band| band.halo.is_some())
            && pieces.windows(2).all(is_ordered)
    }

    /// Overwrites forces with those of fields and springs, and moves all particles by a kick and a
    /// drift; returns the power that the springs dissipate at the start, watts.
    pub(crate) fn move_particles(
        &self,
        level: Level,
        work: &mut SpringWork<R>,
        moving: &mut Moving<'_, R>,
    ) -> f64 {
        let SpringWork { power, groups } = work;
        let Some(group) = groups.first_mut() else { return 0.0 };
        // One halo serves all parts, as they run in turn.
        let mut halo = [core::mem::take(&mut group.ahead), core::mem::take(&mut group.burnt)];
        let mut front = Front::default();
        let records = moving.positions.len() / RECORD;
        let mut run = |numbers: Range<usize>| {
            let (records, mut lanes) = (numbers.start / LANES..numbers.end / LANES, [0.0; LANES]);
            for first in records.clone().step_by(TOGETHER) {
                let last = records.end.min(first + TOGETHER);
                let power = &mut power[..(last - first) * LANES];
                let [ahead, burnt] = &mut halo;
                let mut work = SweepWork { groups, ahead, burnt, power };
                let numbers = first * RECORD..last * RECORD;
                self.sweep_to(level, (&mut front, numbers), &mut work, moving);
                lanes = at_level!(level, _simd => sums(lanes, power));
            }
            lanes.iter().sum::<f64>()
        };
        // Cut as the column of power is.
        let power = merge_in_turn(0..records * LANES, &mut run, &|low, high| low + high);
        [groups[0].ahead, groups[0].burnt] = halo;
        if self.is_damped() { power } else { 0.0 }
    }

    /// Moves the particles of some numbers, those behind the front.
    fn sweep_to(
        &self,
        level: Level,
        (front, numbers): (&mut Front, Range<usize>),
        work: &mut SweepWork<'_, R>,
        moving: &mut Moving<'_, R>,
    ) {
        let layout = &self.layout;
        while let Some(piece) = layout.pieces.get(front.piece) {
            let band = &layout.bands[piece.band];
            if numbers.end <= band.numbers.start {
                return;
            }
            if front.step == 0 && numbers.contains(&band.numbers.start) {
                // No step writes the power of the record in front of the first.
                work.power[(band.numbers.start - numbers.start) / 3..][..LANES].fill(R::ZERO);
            }
            if front.step == piece.first && piece.is_part {
                work.groups[front.group].later.fill(R::ZERO);
            }
            let records = (numbers.end - band.numbers.start) / RECORD - 1;
            let last = piece.first + piece.steps.len();
            let end = last.min(band.halo.unwrap_or(0) + records);
            let run = Run { band, piece, steps: front.step..end, row: front.row };
            let part = work.of(front.group, (band, piece), numbers.start);
            let input = (layout, &*self.values);
            front.row = match (self.is_damped(), piece.is_part) {
                (true, true) => at_level!(level, simd => {
                    move_steps::<_, R, true, true>(simd, input, run, part, moving)
                }),
                (true, false) => at_level!(level, simd => {
                    move_steps::<_, R, true, false>(simd, input, run, part, moving)
                }),
                (false, true) => at_level!(level, simd => {
                    move_steps::<_, R, false, true>(simd, input, run, part, moving)
                }),
                (false, false) => at_level!(level, simd => {
                    move_steps::<_, R, false, false>(simd, input, run, part, moving)
                }),
            };
            front.step = end;
            if end < last {
                return;
            }
            front.piece += 1;
            front.group += usize::from(front.piece == layout.groups[front.group].end);
            front.step = layout.pieces.get(front.piece).map_or(0, |next| next.first);
        }
    }
}

/// Scratch of a sweep, see [`super::sweep::Sums`]. The power is that of the numbers in turn.
struct SweepWork<'a, R: Real> {
    groups: &'a mut [GroupWork<R>],
    ahead: &'a mut [R],
    burnt: &'a mut [R],
    power: &'a mut [R],
}

impl<R: Real> SweepWork<'_, R> {
    /// The scratch of a piece in a group; `first` is the first of the numbers in turn.
    fn of(&mut self, group: usize, (band, piece): (&Band, &Piece), first: usize) -> RunWork<'_, R> {
        let SweepWork { groups, ahead, burnt, power } = self;
        let (before, here) = groups.split_at_mut(group);
        let from_before: &[R] = match before.last() {
            Some(before) if piece.is_part && 0 < piece.first => {
                let behind = band.numbers.end - piece.numbers.start;
                &before.later[..behind.min(band.reach * RECORD)]
            }
            _ => &[],
        };
        RunWork { ahead, burnt, power, first, later: &mut here[0].later, from_before }
    }
}

/// Some steps of a piece, counted in the band, and their first row.
struct Run<'a> {
    band: &'a Band,
    piece: &'a Piece,
    steps: Range<usize>,
    row: usize,
}

/// Scratch of some steps.
struct RunWork<'a, R> {
    ahead: &'a mut [R],
    burnt: &'a mut [R],
    /// The power of the records from the number `first` on.
    power: &'a mut [R],
    first: usize,
    /// The forces on the next part, and those of the part before on this one.
    later: &'a mut [R],
    from_before: &'a [R],
}

/// Sums that are added to a record of a block in parts after its own, in this order.
struct Late<'a, R> {
    /// The forces of the part before, from the first record of this part on.
    from_before: &'a [R],
    /// Forces and power at the ends of segments, seen from the next lane.
    ahead: &'a [R],
    burnt: &'a [R],
}

impl<R: Real> Late<'_, R> {
    /// Adds them to force and power of a part of the record at a number of its part, which is at
    /// that end of a segment.
    #[inline(always)]
    fn add<S: Simd>(
        &self,
        simd: S,
        ([at, part], segment_end): ([usize; 2], Option<usize>),
        (mut force, mut power): ([Pack<S, R>; 3], Pack<S, R>),
    ) -> ([Pack<S, R>; 3], Pack<S, R>) {
        if at < self.from_before.len() {
            let more = load(simd, &self.from_before[at..], part);
            force = zip(force, more, |f, more| f + more);
        }
        if let Some(end) = segment_end {
            let more = load(simd, &self.ahead[(1 + end) * RECORD + 1..], part);
            force = zip(force, more, |f, more| f + more);
            let more = &self.burnt[(1 + end) * LANES + 1 + part..][..Pack::<S, R>::LEN];
            power = power + Pack::from_slice(simd, more);
        }
        (force, power)
    }
}

impl<R: Real> Moving<'_, R> {
    /// The part of some records.
    #[inline(always)]
    fn of(&mut self, numbers: Range<usize>) -> Moving<'_, R> {
        Moving {
            positions: &mut self.positions[numbers.clone()],
            velocities: &mut self.velocities[numbers.clone()],
            forces: &mut self.forces[numbers.clone()],
            masses: &self.masses[numbers.start / 3..numbers.end / 3],
            inverse_masses: &self.inverse_masses[numbers],
            fields: self.fields,
            h: self.h,
        }
    }
}

/// Overwrites the forces on a record with those of the fields on its masses.
#[inline(always)]
fn start<S: Simd, R: Real>(simd: S, fields: &Fields<R>, masses: &[R], forces: &mut [R]) {
    for part in (0..LANES).step_by(Pack::<S, R>::LEN) {
        let masses = Pack::from_slice(simd, &masses[part..part + Pack::<S, R>::LEN]);
        store(fields.weights_of(simd, masses), forces, part);
    }
}

/// Takes some steps; returns the row behind their last.
#[inline(always)]
fn move_steps<S: Simd, R: Real, const DAMPED: bool, const PART: bool>(
    simd: S,
    (layout, table): (&Layout, &[R]),
    Run { band, piece, steps, mut row }: Run<'_>,
    work: RunWork<'_, R>,
    moving: &mut Moving<'_, R>,
) -> usize {
    let lanes = Pack::<S, R>::LEN;
    let RunWork { ahead, burnt, power, first, later, from_before } = work;
    let Moving { positions: x, velocities: v, forces: f, masses, inverse_masses, fields, h } =
        moving.of(band.numbers.clone());
    let (halo, len) = (band.halo.unwrap_or(0), band.numbers.len() / RECORD - 1);
    let (is_far, h) = (is_far(x), Pack::new(simd, h));
    let [start_of, end] = [piece.numbers.start, piece.numbers.end];
    let [start_of, end] = [start_of - band.numbers.start, end - band.numbers.start];
    for number in steps {
        let step = layout.steps[piece.steps.start + number - piece.first];
        if number < len {
            let next = 1 + number;
            start(simd, fields, &masses[next * LANES..][..LANES], &mut f[next * RECORD..]);
        }
        if is_far {
            [&*x, &*v, &*f].into_iter().for_each(|column| fetch(column, 0, band.ahead(number)));
        }
        let rows = &layout.rows[row..][..step.rows as usize];
        row += rows.len();
        let (at, carry) = (step.at as usize, if PART { 0 } else { step.carry as usize });
        for part in (0..LANES).step_by(lanes) {
            let from = carry / 3 + carry % 3 + part;
            let mut sums = StepSums {
                pull: load(simd, &ahead[carry..], part),
                heat: Pack::from_slice(simd, &burnt[from..from + lanes]),
            };
            let here = motion::<S, R, DAMPED>(simd, x, v, at, part);
            let mut ends = Ends { forces: &mut *f, first: 0, later: &mut *later, end };
            let motions = StepMotion { columns: [&*x, &*v], here, part };
            let rows = (rows, table);
            add_rows::<_, _, DAMPED, PART>(simd, rows, &motions, &mut sums, &mut ends);
            let StepSums { pull, heat } = sums;
            if number < halo {
                store(pull, &mut ahead[(1 + number) * RECORD..], part);
                heat.store_slice(&mut burnt[(1 + number) * LANES + part..][..lanes]);
                continue;
            }
            let mut sums = (zip(load(simd, &f[at..], part), pull, |f, s| f + s), heat);
            if PART {
                let late = Late { from_before, ahead, burnt };
                let segment_end = number.checked_sub(len);
                sums = late.add(simd, ([at - start_of, part], segment_end), sums);
            }
            let (force, heat) = sums;
            store(force, &mut f[at..], part);
            if DAMPED {
                let to = (band.numbers.start + at - first) / 3 + part;
                heat.store_slice(&mut power[to..to + lanes]);
            }
            let kick = Pack::from_slice(simd, &inverse_masses[at + part..][..lanes]) * h;
            let velocity = zip(load(simd, &v[at..], part), force, |v, f| v + f * kick);
            store(velocity, &mut v[at..], part);
            store(zip(here[0], velocity, |x, v| x + v * h), &mut x[at..], part);
        }
    }
    row
}
