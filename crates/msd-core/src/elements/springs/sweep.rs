//! The pull of many springs at once, as many as a register holds, by [`super::law::pull`].

use super::gather::{NEAR_BYTES, prefetch, prefetch_all};
use super::law::{Law, pull};
use super::layout::{Band, Extra, Layout, Piece, Row};
use crate::columns::{LANES, RECORD, load, single, store};
use crate::number::{GATHERED, POINT, QUAD, Real};
use crate::pack::{Pack, PackMask, zip};
use core::ops::Range;
use fearless_simd::Simd;

/// Input of a sweep: a motion, and the numbers of rows in sixteens.
#[derive(Clone, Copy)]
pub(crate) struct Input<'a, R> {
    pub(crate) layout: &'a Layout,
    /// Rest lengths, stiffnesses and dampings.
    pub(crate) values: &'a [R],
    pub(crate) positions: &'a [R],
    pub(crate) velocities: &'a [R],
}

/// Output of a sweep of a piece.
pub(crate) struct Sums<'a, R> {
    /// The forces of the piece, newtons.
    pub(crate) forces: &'a mut [R],
    /// The power of the dampers of each of its particles' springs to higher numbers, watts.
    pub(crate) power: &'a mut [R],
    /// Forces and power at the ends of segments, kept until their turn in their own lane.
    pub(crate) ahead: &'a mut [R],
    pub(crate) burnt: &'a mut [R],
    /// Forces on the particles of later parts, record by record.
    pub(crate) later: &'a mut [R],
    /// Positions and velocities by particle, where a block has no segments.
    pub(crate) points: &'a mut [R],
}

/// The law of each spring of a row, and which of them are there.
#[inline(always)]
pub(super) fn laws<S: Simd, R: Real>(
    simd: S,
    table: &[R],
    row: &Row,
    part: usize,
) -> (Law<Pack<S, R>>, PackMask<S, R>) {
    let (sixteens, lanes) = (table.as_chunks::<LANES>().0, part..part + Pack::<S, R>::LEN);
    let at = |place: u32| Pack::from_slice(simd, &sixteens[place as usize][lanes.clone()]);
    let [rest, stiffness, damping] = row.values;
    let law = Law { rest: at(rest), stiffness: at(stiffness), damping: at(damping) };
    (law, Pack::<S, R>::mask(simd, u64::from(row.mask >> part)))
}

/// The motion that the springs of a step see: that of all of the band, and of a part of its record.
pub(super) struct StepMotion<'a, S: Simd, R: Real> {
    /// Positions and velocities from the number `first` of the band on.
    pub(super) columns: [&'a [R]; 2],
    pub(super) first: usize,
    pub(super) here: [[Pack<S, R>; 3]; 2],
    pub(super) part: usize,
}

/// The sums of a step: the pull on the particles whose springs it adds, and the power.
pub(super) struct StepSums<S: Simd, R: Real> {
    pub(super) pull: [Pack<S, R>; 3],
    pub(super) heat: Pack<S, R>,
}

/// The forces on the other ends of a step's springs, by their numbers in the band.
pub(super) struct Ends<'a, R> {
    /// The forces from the number `first` on.
    pub(super) forces: &'a mut [R],
    pub(super) first: usize,
    /// Those on later parts, which start at the number `end`; that of number `behind` comes first.
    pub(super) later: &'a mut [R],
    pub(super) behind: usize,
    pub(super) end: usize,
}

/// The rows of a step whose other ends are at a number of the band or behind it, and its others.
#[inline(always)]
pub(super) fn split_rows(rows: &[Row], at: usize) -> (&[Row], &[Row]) {
    // The farthest come first.
    rows.split_at(rows.iter().take_while(|row| at <= row.other as usize).count())
}

/// Adds the springs of the rows of a step to their other ends and to its sums.
#[inline(always)]
pub(super) fn add_rows<S: Simd, R: Real, const DAMPED: bool, const PART: bool>(
    simd: S,
    (rows, table): (&[Row], &[R]),
    motions: &StepMotion<'_, S, R>,
    sums: &mut StepSums<S, R>,
    ends: Ends<'_, R>,
) {
    let StepMotion { columns: [x, v], first, here, part } = *motions;
    for row in rows {
        let other = row.other as usize;
        let there = motion::<S, R, DAMPED>(simd, x, v, other - first, part);
        let (law, is_there) = laws(simd, table, row, part);
        let (pull, burns) = pull::<_, DAMPED>(here, there, law, is_there);
        let to = if PART && ends.end <= other {
            &mut ends.later[other - ends.behind..]
        } else {
            &mut ends.forces[other - ends.first..]
        };
        let far: [Pack<S, R>; 3] = load(simd, to, part);
        store(zip(pull, far, |p, f| p + f), to, part);
        sums.pull = zip(sums.pull, pull, |s, p| s - p);
        if DAMPED {
            sums.heat = sums.heat + burns;
        }
    }
}

/// Bytes of a column from which on it is worth to fetch records ahead: those of shorter ones arrive
/// in time by themselves.
const FAR_BYTES: usize = 1 << 21;

/// Whether records of a column are fetched ahead.
#[inline(always)]
pub(super) fn is_far<R>(column: &[R]) -> bool {
    FAR_BYTES < size_of_val(column)
}

/// Prefetches records of a column that starts at the number `first`.
#[inline(always)]
pub(super) fn fetch<R>(column: &[R], first: usize, records: impl Iterator<Item = usize>) {
    for at in records {
        let record = column.get(at.wrapping_sub(first)..).and_then(|column| column.get(..RECORD));
        record.into_iter().for_each(prefetch_all);
    }
}

/// Adds the springs between records, each evaluated once.
#[inline(always)]
pub(super) fn add_segments<S: Simd, R: Real, const DAMPED: bool, const PART: bool>(
    simd: S,
    (band, piece): (&Band, &Piece),
    halo: usize,
    input: Input<'_, R>,
    Sums { forces, power, ahead, burnt, later, .. }: Sums<'_, R>,
) {
    let lanes = Pack::<S, R>::LEN;
    let Input { layout, values: table, .. } = input;
    let (x, v) = (&input.positions[band.numbers.clone()], &input.velocities[band.numbers.clone()]);
    let f = forces;
    // The numbers of the piece, counted in the band.
    let first = if PART { piece.numbers.start - band.numbers.start } else { 0 };
    let end = first + f.len();
    if PART {
        later.fill(R::ZERO);
    }
    let is_far = is_far(x);
    let rows = &layout.rows[piece.rows.clone()];
    let mut next = 0;
    for (number, step) in layout.steps[piece.steps.clone()].iter().enumerate() {
        let number = if PART { piece.first + number } else { number };
        let (at, carry) = (step.at as usize, if PART { 0 } else { step.carry as usize });
        let start = next;
        next += step.rows as usize;
        if is_far {
            fetch(x, 0, band.ahead(number));
            fetch(v, 0, band.ahead(number));
            fetch(f, first, band.ahead(number));
        }
        for part in (0..LANES).step_by(lanes) {
            let here = motion::<S, R, DAMPED>(simd, x, v, at, part);
            let motions = StepMotion { columns: [x, v], first: 0, here, part };
            let from = carry / 3 + carry % 3 + part;
            let mut sums = StepSums {
                pull: load(simd, &ahead[carry..], part),
                heat: Pack::from_slice(simd, &burnt[from..from + lanes]),
            };
            let ends = Ends { forces: &mut *f, first, later: &mut *later, behind: end, end };
            let rows = (&rows[start..next], table);
            add_rows::<_, _, DAMPED, PART>(simd, rows, &motions, &mut sums, ends);
            let StepSums { pull: sum, heat } = sums;
            if number < halo {
                store(sum, &mut ahead[(1 + number) * RECORD..], part);
                let to = (1 + number) * LANES + part;
                heat.store_slice(&mut burnt[to..to + lanes]);
            } else {
                let at = at - first;
                let own: [Pack<S, R>; 3] = load(simd, &f[at..], part);
                store(zip(own, sum, |f, s| f + s), &mut f[at..], part);
                if DAMPED {
                    heat.store_slice(&mut power[at / 3 + part..at / 3 + part + lanes]);
                }
            }
        }
    }
}

/// Adds one column to another.
#[inline(always)]
pub(crate) fn add_column<R: Real>(column: &[R], to: &mut [R]) {
    for (to, &number) in to.iter_mut().zip(column) {
        *to += number;
    }
}

/// Rows whose pulls are computed before any is added to other ends, so that the processor may begin
/// one before the root and the quotient of another are done.
const TOGETHER: usize = 8;

/// Adds the springs whose other ends are named one by one, each evaluated once. The forces on those
/// ends are summed in quads, one for each slot, and added to the forces at the end.
#[inline(always)]
pub(super) fn add_named<S: Simd, R: Real, const DAMPED: bool>(
    simd: S,
    (band, piece): (&Band, &Piece),
    input: Input<'_, R>,
    Sums { forces, power, later, points, .. }: Sums<'_, R>,
) {
    let lanes = Pack::<S, R>::LEN;
    let Input { layout, values: table, positions, velocities } = input;
    let first = piece.numbers.start;
    let [front, behind] = layout.outside(piece);
    // The tables start as many records in front of the piece as springs reach.
    let (records, reach) = (forces.len() / RECORD, band.reach);
    let blank = reach - front.len() / RECORD;
    let numbers = front.start..behind.end;
    let seen = [&positions[numbers.clone()], &velocities[numbers]];
    set_points(simd, seen, &mut points[blank * LANES * POINT..]);
    let points = &points.as_chunks::<POINT>().0[..(records + 2 * reach) * LANES];
    let quads = &mut later.as_chunks_mut::<QUAD>().0[..(records + 2 * reach) * LANES];
    quads.as_flattened_mut().fill(R::ZERO);
    let is_far = NEAR_BYTES < size_of_val(points);
    let rows = &layout.rows[piece.rows.clone()];
    let mut next = 0;
    let mut pulls = [[R::ZERO; RECORD]; TOGETHER];
    for step in &layout.steps[piece.steps.clone()] {
        let at = band.numbers.start + step.at as usize;
        let start = next;
        next += step.rows as usize;
        let (mut own, mut heat) = ([R::ZERO; RECORD], [R::ZERO; LANES]);
        // Other ends are counted from as many records in front as springs reach.
        let window = (at - first) / RECORD * LANES;
        let window = window..window + (1 + 2 * reach) * LANES;
        let (points, quads) = (&points[window.clone()], &mut quads[window]);
        for rows in rows[start..next].chunks(TOGETHER) {
            for (row, pulls) in rows.iter().zip(&mut pulls) {
                let others = &layout.others[row.other as usize];
                prefetch(is_far, (points, quads), &layout.others, row.other as usize);
                for part in (0..LANES).step_by(lanes) {
                    let here = motion::<S, R, DAMPED>(simd, positions, velocities, at, part);
                    let mut there = [R::ZERO; GATHERED];
                    R::gather(simd, points, &others[part..part + lanes], &mut there);
                    let there = motion::<S, R, DAMPED>(simd, &there, &there[RECORD..], 0, 0);
                    let (law, is_there) = laws(simd, table, row, part);
                    let (pull, burns) = pull::<_, DAMPED>(here, there, law, is_there);
                    store(pull, pulls, part);
                    let sum: [Pack<S, R>; 3] = load(simd, &own, part);
                    store(zip(sum, pull, |s, p| s - p), &mut own, part);
                    if DAMPED {
                        let heat = &mut heat[part..part + lanes];
                        (Pack::from_slice(simd, heat) + burns).store_slice(heat);
                    }
                }
            }
            for (row, pulls) in rows.iter().zip(&pulls) {
                add_to_quads(simd, &layout.others[row.other as usize], pulls, quads);
            }
        }
        add_column(&own, &mut forces[at - first..][..RECORD]);
        if DAMPED {
            power[(at - first) / 3..][..LANES].copy_from_slice(&heat);
        }
    }
    let tail = reach + records..reach + records + behind.len() / RECORD;
    settle(simd, (blank..reach, tail), forces, later);
}

/// Adds the quads of a piece to its forces. Those of records in front of it and behind it make room
/// for these records, which are shorter.
#[inline(always)]
fn settle<S: Simd, R: Real>(
    simd: S,
    (front, behind): (Range<usize>, Range<usize>),
    forces: &mut [R],
    later: &mut [R],
) {
    for (record, forces) in (front.end..).zip(forces.as_chunks_mut::<RECORD>().0) {
        add_column(&columns_of(simd, later, record), forces);
    }
    for (to, record) in front.chain(behind).enumerate() {
        let columns = columns_of(simd, later, record);
        later[to * RECORD..][..RECORD].copy_from_slice(&columns);
    }
}

/// Adds the vectors of a record to the quads of the slots that are named.
#[inline(always)]
pub(super) fn add_to_quads<S: Simd, R: Real>(
    simd: S,
    others: &[u32; LANES],
    vectors: &[R; RECORD],
    quads: &mut [[R; QUAD]],
) {
    for (&other, vector) in others.iter().zip(R::to_quads(simd, vectors)) {
        let sum = &mut quads[other as usize];
        *sum = core::array::from_fn(|axis| sum[axis] + vector[axis]);
    }
}

/// A record of quads as columns.
#[inline(always)]
pub(super) fn columns_of<S: Simd, R: Real>(simd: S, quads: &[R], record: usize) -> [R; RECORD] {
    R::to_columns(simd, &quads.as_chunks::<QUAD>().0.as_chunks::<LANES>().0[record])
}

/// Copies a motion to points, particle by particle.
#[inline(always)]
pub(super) fn set_points<S: Simd, R: Real>(
    simd: S,
    [positions, velocities]: [&[R]; 2],
    points: &mut [R],
) {
    let records = positions.as_chunks::<RECORD>().0.iter().zip(velocities.as_chunks::<RECORD>().0);
    let points = points.as_chunks_mut::<POINT>().0.as_chunks_mut::<LANES>().0;
    for ((x, v), points) in records.zip(points) {
        let (x, v) = (R::to_quads(simd, x), R::to_quads(simd, v));
        for lane in 0..LANES {
            points[lane][..QUAD].copy_from_slice(&x[lane]);
            points[lane][QUAD..].copy_from_slice(&v[lane]);
        }
    }
}

/// Adds the pull of springs that fit no row, sixteen at a time.
#[inline(always)]
pub(crate) fn add_extras<S: Simd, R: Real, const DAMPED: bool>(
    simd: S,
    (extras, law_of): (&[Extra], impl Fn(usize) -> Law<R>),
    input: Input<'_, R>,
    (forces, power): (&mut [R], &mut [R]),
) {
    let lanes = Pack::<S, R>::LEN;
    for extras in extras.chunks(LANES) {
        // Positions and velocities here and there, and the law of each spring.
        let mut ends = [[R::ZERO; RECORD]; 4];
        let mut laws = [[R::ZERO; LANES]; 3];
        for (lane, extra) in extras.iter().enumerate() {
            let [here, there] = extra.at.map(|at| at as usize);
            for axis in 0..3 {
                let (to, of) = (axis * LANES + lane, axis * LANES);
                ends[0][to] = input.positions[here + of];
                ends[2][to] = input.positions[there + of];
                if DAMPED {
                    ends[1][to] = input.velocities[here + of];
                    ends[3][to] = input.velocities[there + of];
                }
            }
            let law = law_of(extra.spring as usize);
            (laws[0][lane], laws[1][lane], laws[2][lane]) = (law.rest, law.stiffness, law.damping);
        }
        let (mut pulls, mut burns) = ([R::ZERO; RECORD], [R::ZERO; LANES]);
        for part in (0..LANES).step_by(lanes) {
            let here = motion::<S, R, DAMPED>(simd, &ends[0], &ends[1], 0, part);
            let there = motion::<S, R, DAMPED>(simd, &ends[2], &ends[3], 0, part);
            let [rest, stiffness, damping] =
                laws.each_ref().map(|law| Pack::from_slice(simd, &law[part..part + lanes]));
            let law = Law { rest, stiffness, damping };
            let all = Pack::<S, R>::mask(simd, u64::MAX);
            let (pull, burn) = pull::<_, DAMPED>(here, there, law, all);
            store(pull, &mut pulls, part);
            burn.store_slice(&mut burns[part..part + lanes]);
        }
        for (lane, extra) in extras.iter().enumerate() {
            let [here, there] = extra.at.map(|at| at as usize);
            for axis in (0..RECORD).step_by(LANES) {
                forces[here + axis] -= pulls[axis + lane];
            }
            for axis in (0..RECORD).step_by(LANES) {
                forces[there + axis] += pulls[axis + lane];
            }
            if DAMPED {
                power[single(here)] += burns[lane];
            }
        }
    }
}

/// Positions and velocities of some particles of a record.
#[inline(always)]
pub(super) fn motion<S: Simd, R: Real, const DAMPED: bool>(
    simd: S,
    x: &[R],
    v: &[R],
    at: usize,
    part: usize,
) -> [[Pack<S, R>; 3]; 2] {
    let positions = load(simd, &x[at..], part);
    [positions, if DAMPED { load(simd, &v[at..], part) } else { positions }]
}
