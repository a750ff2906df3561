//! Steps of a fused sweep: the rows of one record each.

use super::columns::Swept;
use crate::columns::{LANES, RECORD, load, store};
use crate::elements::fields::Fields;
use crate::elements::springs::Springs;
use crate::elements::springs::layout::{AHEAD, Band, Piece};
use crate::elements::springs::sweep::{
    Ends, StepMotion, StepSums, add_rows, fetch, is_far, motion, split_rows,
};
use crate::number::Real;
use crate::pack::{Pack, zip};
use core::ops::Range;
use fearless_simd::{Level, Simd};

/// Bytes of a column from which on the next records are fetched ahead: four columns of more leave
/// the near caches.
const STREAMED_BYTES: usize = 1 << 18;

/// What a sweep reads, beside the motion.
#[derive(Clone, Copy)]
pub(super) struct Mover<'a, R: Real> {
    pub(super) springs: &'a Springs<R>,
    pub(super) level: Level,
    pub(super) masses: &'a [R],
    pub(super) inverse_masses: &'a [R],
    pub(super) fields: &'a Fields<R>,
    pub(super) h: R,
}

/// Some steps of a piece, counted in the band, and their first row.
pub(super) struct Run<'a> {
    pub(super) band: &'a Band,
    pub(super) piece: &'a Piece,
    pub(super) steps: Range<usize>,
    pub(super) row: usize,
    /// Whether they neither give forces to other parts nor move records that get some.
    pub(super) is_alone: bool,
}

/// The piece of a run, and the columns and places that its steps use, by numbers of the band.
struct RunPlaces {
    /// The first number of the columns.
    first: usize,
    /// The number behind the piece, and the one that the forces on later parts would start at.
    end: usize,
    behind: usize,
    /// The numbers on which the part before has forces, from the one that they would start at.
    before: Range<usize>,
}

impl RunPlaces {
    #[inline(always)]
    fn ends<'a, R>(&self, forces: &'a mut [R], later: &'a mut [R]) -> Ends<'a, R> {
        let RunPlaces { first, end, behind, .. } = *self;
        Ends { forces, first, later, behind, end }
    }

    #[inline(always)]
    fn of<R>(Run { band, piece, is_alone, .. }: &Run<'_>, columns: &Swept<'_, R>) -> RunPlaces {
        let Swept { first, reached, .. } = *columns;
        let band = band.numbers.start;
        if *is_alone {
            return RunPlaces { first: first - band, end: usize::MAX, behind: 0, before: 0..0 };
        }
        // Where the column of forces between parts would start to have that on a number at its
        // place: the first that it has of a part is there.
        let start_for = |number: usize| {
            let seen = number.max(first);
            // Behind the last part there is none, nor such a start.
            (seen - band).saturating_sub(reached.place(seen) - reached.place(first))
        };
        let Range { start, end } = piece.numbers;
        let before = match piece.first {
            0 => 0..0,
            _ => start_for(start)..start + reached.numbers - band,
        };
        RunPlaces { first: first - band, before, end: end - band, behind: start_for(end) }
    }
}

impl<R: Real> Mover<'_, R> {
    /// Overwrites the forces on the farthest record that a step reaches with those of the fields
    /// on its masses, and the forces of its piece on it if that is in a later part.
    #[inline(always)]
    fn start<S: Simd, const PART: bool>(
        &self,
        simd: S,
        (masses, far): (&[R], usize),
        places: &RunPlaces,
        (forces, later): (&mut [R], &mut [R]),
    ) {
        let masses = &masses[far / 3..][..LANES];
        let forces = &mut forces[far - places.first..];
        for part in (0..LANES).step_by(Pack::<S, R>::LEN) {
            let masses = Pack::from_slice(simd, &masses[part..part + Pack::<S, R>::LEN]);
            store(self.fields.weights_of(simd, masses), forces, part);
        }
        if PART && places.end <= far {
            later[far - places.behind..][..RECORD].fill(R::ZERO);
        }
    }
}

/// How far ahead a sweep fetches records: by the bytes of its columns.
#[derive(Clone, Copy)]
struct Fetches {
    streams: bool,
    is_far: bool,
}

impl Fetches {
    fn of<R>(column: &[R]) -> Fetches {
        let streams = STREAMED_BYTES < size_of_val(column);
        Fetches { streams, is_far: is_far(column) }
    }

    /// Prefetches what a later step reads first, of columns that start at a number of the band.
    #[inline(always)]
    fn next<R, const N: usize>(self, (band, number): (&Band, usize), first: usize, of: [&[R]; N]) {
        if self.streams {
            for column in of {
                fetch(column, first, [(1 + number + AHEAD) * RECORD].into_iter());
            }
        }
        if self.is_far {
            for column in of {
                // The first is that.
                fetch(column, first, band.ahead(number).skip(1));
            }
        }
    }
}

/// Takes the rows of some steps that end at a record or behind it, and keeps their sums; returns
/// the row behind their last.
#[inline(always)]
pub(super) fn add_steps<S: Simd, R: Real, const DAMPED: bool, const PART: bool>(
    simd: S,
    mover: &Mover<'_, R>,
    (run, record): (Run<'_>, usize),
    [x, v]: [&[R]; 2],
    (columns, [ahead, burnt]): (&mut Swept<'_, R>, [&mut [R]; 2]),
) -> usize {
    let lanes = Pack::<S, R>::LEN;
    let Springs { layout, values, .. } = mover.springs;
    let places = RunPlaces::of(&run, columns);
    let Run { band, steps, mut row, .. } = run;
    let (f, later) = (&mut *columns.forces, &mut *columns.later);
    let v = &v[..x.len()];
    let masses = &mover.masses[band.numbers.start / 3..band.numbers.end / 3];
    let fetches = Fetches::of(x);
    for number in steps {
        let step = layout.steps[band.steps.start + number];
        let far = (1 + number) * RECORD;
        if far - places.first < f.len() {
            mover.start::<_, PART>(simd, (masses, far), &places, (&mut *f, &mut *later));
        }
        fetches.next((band, number), 0, [x, v]);
        fetches.next((band, number), places.first, [&*f]);
        let mut rows = &layout.rows[row..][..step.rows as usize];
        row += rows.len();
        // Those of the halo all do.
        if 0 < record {
            (rows, _) = split_rows(rows, (1 + record) * RECORD);
        }
        let (at, carry, to) = (step.at as usize, step.carry as usize, far - record * RECORD);
        for part in (0..LANES).step_by(lanes) {
            let mut sums = kept_sums(simd, [ahead, burnt], carry, part);
            let here = motion::<S, R, DAMPED>(simd, x, v, at, part);
            let motions = StepMotion { columns: [x, v], first: 0, here, part };
            let ends = places.ends(&mut *f, &mut *later);
            let rows = (rows, &**values);
            add_rows::<_, _, DAMPED, PART>(simd, rows, &motions, &mut sums, ends);
            store(sums.pull, &mut ahead[to..], part);
            sums.heat.store_slice(&mut burnt[to / 3 + part..][..lanes]);
        }
    }
    row
}

/// The sums that are kept at a number.
#[inline(always)]
fn kept_sums<S: Simd, R: Real>(
    simd: S,
    [ahead, burnt]: [&[R]; 2],
    at: usize,
    part: usize,
) -> StepSums<S, R> {
    let from = at / 3 + at % 3 + part;
    StepSums {
        pull: load(simd, &ahead[at..], part),
        heat: Pack::from_slice(simd, &burnt[from..][..Pack::<S, R>::LEN]),
    }
}

/// Takes some steps and moves their records; returns the row behind their last.
#[inline(always)]
pub(super) fn move_steps<S: Simd, R: Real, const DAMPED: bool, const PART: bool>(
    simd: S,
    mover: &Mover<'_, R>,
    run: Run<'_>,
    columns: &mut Swept<'_, R>,
    kept: [&[R]; 2],
) -> usize {
    let lanes = Pack::<S, R>::LEN;
    let Springs { layout, values, .. } = mover.springs;
    let places = RunPlaces::of(&run, columns);
    let Run { band, steps, mut row, .. } = run;
    let (first, end) = (places.first, places.first + columns.forces.len());
    let is_last = end == band.numbers.len();
    // Of one length: one check for all three.
    let count = columns.forces.len();
    let (x, v) = (&mut columns.positions[..count], &mut columns.velocities[..count]);
    let (f, later, power) =
        (&mut columns.forces[..count], &mut *columns.later, &mut *columns.power);
    let inverse_masses = &mover.inverse_masses[band.numbers.clone()];
    let (fetches, h) = (Fetches::of(x), Pack::new(simd, mover.h));
    let masses = &mover.masses[band.numbers.start / 3..band.numbers.end / 3];
    for number in steps {
        let step = layout.steps[band.steps.start + number];
        let (at, far) = (step.at as usize, (1 + number) * RECORD);
        let (mut rows, mut carry) = (&layout.rows[row..][..step.rows as usize], 0);
        row += rows.len();
        // The rows that end behind the share are done; those of the last share are of the halo,
        // and where a block is in parts their sums come last.
        let is_late = PART && is_last && end <= far;
        if far < end {
            mover.start::<_, PART>(simd, (masses, far), &places, (&mut *f, &mut *later));
        } else if !is_last {
            (rows, carry) = (split_rows(rows, end).1, far - end + RECORD);
        } else if !PART {
            carry = far - end + RECORD + 1;
        }
        fetches.next((band, number), first, [&*x, &*v, &*f]);
        if fetches.streams {
            // All that comes behind would wait for them.
            fetch(inverse_masses, 0, [at + AHEAD * RECORD].into_iter());
        }
        let here_at = at - first;
        for part in (0..LANES).step_by(lanes) {
            let mut sums = kept_sums(simd, kept, carry, part);
            let here = motion::<S, R, DAMPED>(simd, x, v, here_at, part);
            let motions = StepMotion { columns: [&*x, &*v], first, here, part };
            let (rows, ends) = ((rows, &**values), places.ends(&mut *f, &mut *later));
            add_rows::<_, _, DAMPED, PART>(simd, rows, &motions, &mut sums, ends);
            let StepSums { pull, mut heat } = sums;
            let mut force = zip(load(simd, &f[here_at..], part), pull, |f, s| f + s);
            if PART && at < places.before.end {
                let more = load(simd, &later[at - places.before.start..], part);
                force = zip(force, more, |f, more| f + more);
            }
            if is_late {
                let more = kept_sums(simd, kept, far - end + RECORD + 1, part);
                force = zip(force, more.pull, |f, more| f + more);
                heat = heat + more.heat;
            }
            store(force, &mut f[here_at..], part);
            if DAMPED {
                let to = (band.numbers.start + at - columns.power_first) / 3 + part;
                heat.store_slice(&mut power[to..][..lanes]);
            }
            let kick = Pack::from_slice(simd, &inverse_masses[at + part..][..lanes]) * h;
            let velocity = zip(load(simd, &v[here_at..], part), force, |v, f| v + f * kick);
            store(velocity, &mut v[here_at..], part);
            store(zip(here[0], velocity, |x, v| x + v * h), &mut x[here_at..], part);
        }
    }
    row
}
