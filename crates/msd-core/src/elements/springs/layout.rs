//! Order of evaluation of the springs: rows of sixteen, compiled once from the topology.
//!
//! In a block of segments (see [`crate::columns::slots`]) a spring between particles i < j, d
//! apart, joins two records of the same lane, or, past the end of a segment, of neighbouring lanes.
//! A *row* is up to sixteen springs of one d that start at one record, each evaluated once. A
//! *step* is all rows that start at one record, the farthest first. The first steps of a block are
//! its *halo*: the ends of all segments, seen from the next lane. The step that comes upon the same
//! particles in their own lane carries their sums on.
//!
//! In other blocks a row is up to one spring for each particle of a record, whose other ends are
//! named one by one. A spring stands in the row of one end, such that all rows are about full.
//!
//! Every particle sums in one order, whatever the instructions and threads: see [`Sum`]. Threads
//! evaluate *parts* of a large block, runs of steps, at the same time. The forces of a part on
//! others, and on the ends of segments, are summed separately and added before the extras. The
//! parts depend on the springs alone, and so do the bits.

use super::unstructured::{Lists, near_order, slots_of};
use crate::columns::slots::{Block, Slots};
use crate::columns::{LANES, RECORD};
use crate::scene::check::MAX_SPRINGS;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// Up to sixteen springs, one for each lane in `mask`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Row {
    /// Where the other ends are: the first number of their record in the block, or, in a block
    /// without segments, the row of [`Layout::others`].
    pub(crate) other: u32,
    pub(crate) mask: u16,
    /// The sixteen rest lengths, stiffnesses and dampings, as places in a table of sixteens.
    pub(crate) values: [u32; 3],
}

/// The rows that start at one record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Step {
    /// The first number of the record in the block; of a step of the halo, that of the first lane's
    /// segment end, which lies one lane earlier for each segment spanned.
    pub(crate) at: u32,
    /// Where the sums of an earlier step are that go on here.
    pub(crate) carry: u32,
    pub(crate) rows: u32,
}

/// The steps and rows of a block.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Band {
    /// Its numbers in the columns of vectors, those in front of the first included.
    pub(crate) numbers: Range<usize>,
    pub(crate) steps: Range<usize>,
    pub(crate) rows: Range<usize>,
    /// Number of steps in the halo; `None` without segments.
    pub(crate) halo: Option<usize>,
    /// Largest distance to the other end of a spring, in records.
    pub(crate) reach: usize,
    /// With segments, the largest distance, and those so far below the next larger one that a
    /// record leaves the near caches in between: see [`Band::ahead`].
    edges: Vec<usize>,
}

impl Band {
    /// The first numbers of the records, counted in the band, that a step fetches for a later one.
    #[inline(always)]
    pub(crate) fn ahead(&self, number: usize) -> impl Iterator<Item = usize> + '_ {
        let (halo, len) = (self.halo.unwrap_or(0), self.numbers.len() / RECORD - 1);
        let records = self.edges.iter().map(move |edge| (number + AHEAD + edge).wrapping_sub(halo));
        records.filter(move |&record| record < len).map(|record| (1 + record) * RECORD)
    }
}

/// The share of a band that one thread evaluates: all of it, or a run of steps of a large one.
///
/// A part adds the forces of its springs on other parts to a column of its own, and those on the
/// ends of segments stay where they were summed. Both are added to the forces when all parts are
/// done, so that the parts can be evaluated at the same time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) band: usize,
    /// The numbers of its particles in the columns of vectors.
    pub(crate) numbers: Range<usize>,
    /// Its first step, counted in the band.
    pub(crate) first: usize,
    pub(crate) steps: Range<usize>,
    pub(crate) rows: Range<usize>,
    /// Whether it is not all of the band.
    pub(crate) is_part: bool,
}

/// Sums of a particle, in the order in which they are added to its forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sum {
    /// None: with segments, the springs to lower numbers are added at once, the lowest first.
    Forces,
    /// That of the springs of its rows; with segments, those to higher numbers, the highest first.
    Own,
    /// Without segments, that of the springs of its part that name it.
    Named,
    /// That of springs of another part.
    Later(usize),
    /// That of the springs of its rows in the halo of a block in parts.
    Carried,
}

/// A spring of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turn {
    pub(crate) spring: u32,
    /// The place of the end whose row it is; `None` for the end with the lower number.
    pub(crate) here: Option<usize>,
    /// The sums to which the pull on the end whose row it is, and on the other, is added.
    pub(crate) sums: [Sum; 2],
}

/// A spring that fits no row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extra {
    pub(crate) spring: u32,
    /// Where its ends are in the columns of vectors, that of the lower number first.
    pub(crate) at: [u32; 2],
}

/// The springs of a scene, ordered.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Layout {
    pub(crate) bands: Vec<Band>,
    pub(crate) pieces: Vec<Piece>,
    /// Pieces in turn that one thread evaluates.
    pub(crate) groups: Vec<Range<usize>>,
    pub(crate) steps: Vec<Step>,
    pub(crate) rows: Vec<Row>,
    /// The other ends of rows without segments, as slots counted from as many records in front as
    /// the springs of the band reach. It is the particle itself where there is none.
    pub(crate) others: Vec<[u32; LANES]>,
    pub(crate) extras: Vec<Extra>,
    /// Row and lane of each spring, row · 16 + lane; [`NOWHERE`] for an extra.
    pub(crate) places: Vec<u32>,
}

/// The place of a spring that is in no row.
pub(crate) const NOWHERE: u32 = u32::MAX;

/// The bits of the number of a spring: see [`MAX_SPRINGS`].
const LANE: u32 = MAX_SPRINGS.ilog2();

/// Springs of one distance that make a family: one for every so many particles, at least. Rows of
/// fewer would be emptier than rows that name each end are slow.
const FAMILY: usize = 8;

/// Springs of a particle that fill the window of the processor, records that leave its near caches,
/// and the distance of the prefetch, records.
const MANY: usize = 8;
const WIDE: usize = 512;
pub(crate) const AHEAD: usize = 4;

/// Extras of a block of segments: at most one in so many springs, as they are evaluated one by one.
const MOST_EXTRAS: usize = 20;

/// Bodies of fewer particles share a block with their neighbours.
const FEW: usize = 256;

/// Rows of a piece of a large block and of a group of pieces, at least: 50 000 springs, worth a
/// thread of their own.
const GROUP: usize = 50_000 / LANES;

/// Parts of a block, at most.
const MOST_PARTS: usize = 16;

/// Rows for each step of the halo and each part but the first, at least. The forces of a part on
/// later ones are added record by record, which takes a few percent of the time of as many rows.
const ROWS_PER_STEP: usize = 24;

impl Layout {
    /// Orders springs by their ends alone: the same springs give the same layout, cut or not.
    pub(crate) fn new(count: usize, ends: &[[u32; 2]], bodies: &[Range<usize>]) -> (Slots, Self) {
        let ranges = ranges(count, bodies);
        let block_of = |particle: u32| ranges.partition_point(|r| r.end <= particle as usize);
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); ranges.len()];
        let mut extras = Vec::new();
        for (spring, &[a, b]) in ends.iter().enumerate() {
            let block = if ranges.len() == 1 { 0 } else { block_of(a) };
            if ranges.len() == 1 || block == block_of(b) {
                members[block].push(spring as u32);
            } else {
                extras.push(spring as u32);
            }
        }
        let mut layout = Layout { places: vec![NOWHERE; ends.len()], ..Layout::default() };
        let (mut blocks, mut blank) = (Vec::new(), 0);
        for (range, members) in ranges.into_iter().zip(members) {
            let springs = BlockSprings { ends, members, first: range.start, count: range.len() };
            let order = layout.add_block(&springs, blank, &mut extras);
            let len = range.len().div_ceil(LANES);
            blocks.push(Block { particles: range, blank, len, order });
            blank += 1 + len;
        }
        layout.rows.shrink_to_fit();
        let slots = Slots::new(blocks);
        extras.sort_unstable_by_key(|&spring| (sorted(ends[spring as usize]), spring));
        let extra = |&spring: &u32| {
            let at = sorted(ends[spring as usize]).map(|end| slots.at(end as usize) as u32);
            Extra { spring, at }
        };
        layout.extras = extras.iter().map(extra).collect();
        layout.group();
        (slots, layout)
    }

    /// The most steps of a halo.
    pub(crate) fn halo(&self) -> usize {
        self.bands.iter().filter_map(|band| band.halo).max().unwrap_or(0)
    }

    /// Largest distance to a named end, in records.
    pub(crate) fn reach(&self) -> usize {
        let named = self.bands.iter().filter(|band| band.halo.is_none());
        named.map(|band| band.reach).max().unwrap_or(0)
    }

    /// The numbers in front of a piece and behind it that its springs reach. With segments they
    /// reach none in front.
    pub(crate) fn outside(&self, piece: &Piece) -> [Range<usize>; 2] {
        let Band { numbers, halo, reach, .. } = &self.bands[piece.band];
        let Range { start, end } = piece.numbers;
        let front = if halo.is_some() { 0 } else { reach * RECORD };
        let behind = (reach * RECORD).min(numbers.end - end);
        [start - front.min(start - numbers.start)..start, end..end + behind]
    }

    /// The numbers that a group keeps for records outside its pieces.
    pub(crate) fn kept(&self, group: &Range<usize>) -> usize {
        let pieces = self.pieces[group.clone()].iter();
        let kept = pieces.map(|piece| self.outside(piece).iter().map(Range::len).sum());
        kept.max().unwrap_or(0)
    }

    /// The most slots that the tables of a piece of a group have.
    pub(crate) fn named(&self, group: &Range<usize>) -> usize {
        let pieces = self.pieces[group.clone()].iter();
        let slots = |piece: &Piece| match &self.bands[piece.band] {
            Band { halo: None, reach, .. } => (piece.numbers.len() / RECORD + 2 * reach) * LANES,
            _ => 0,
        };
        pieces.map(slots).max().unwrap_or(0)
    }

    /// Takes a spring out of its rows.
    pub(crate) fn cut(&mut self, spring: usize) {
        let place = self.places[spring] as usize;
        if place != NOWHERE as usize {
            self.rows[place / LANES].mask &= !(1 << (place % LANES));
        }
        // Extras are few; a spring that is cut twice is gone already.
        self.extras.retain(|extra| extra.spring as usize != spring);
    }

    /// Cuts the bands into pieces, and groups these. Both depend on the rows alone, so that the
    /// bits do not depend on threads.
    fn group(&mut self) {
        for band in 0..self.bands.len() {
            self.add_pieces(band);
        }
        let (mut start, mut rows) = (0, 0);
        let mut left: usize = self.pieces.iter().map(|piece| piece.rows.len()).sum();
        for (number, piece) in self.pieces.iter().enumerate() {
            (rows, left) = (rows + piece.rows.len(), left - piece.rows.len());
            let next = self.pieces.get(number + 1);
            // A part needs work columns of its own.
            let is_cut = piece.is_part || next.is_none_or(|next| next.is_part);
            if is_cut || (GROUP <= rows && GROUP <= left) {
                self.groups.push(start..number + 1);
                (start, rows) = (number + 1, 0);
            }
        }
    }

    /// Adds the pieces of a band, with about as many rows each.
    fn add_pieces(&mut self, band: usize) {
        let Band { numbers, steps, rows, halo, reach, .. } = self.bands[band].clone();
        let (halo, len) = (halo.unwrap_or(0), numbers.len() / RECORD - 1);
        // Tables go on as far in front of a part and behind it, and a record of them takes longer.
        let reached = if halo == 0 { 4 * reach } else { reach };
        let most = (1 + rows.len() / (reached.max(1) * ROWS_PER_STEP)).min(rows.len() / GROUP);
        // A power of two, as threads mostly are. Sums are carried on once at most.
        let is_large = 0 < reach && reach < len && 1 < most;
        let parts = if is_large { 1 << most.min(MOST_PARTS).ilog2() } else { 1 };
        let mut piece = Piece {
            band,
            numbers: numbers.start..numbers.end,
            first: 0,
            steps: steps.start..steps.start,
            rows: rows.start..rows.start,
            is_part: 1 < parts,
        };
        for part in 1..=parts {
            let last_row = rows.start + rows.len() * part / parts;
            while piece.steps.end < steps.end && (part == parts || piece.rows.end < last_row) {
                piece.rows.end += self.steps[piece.steps.end].rows as usize;
                piece.steps.end += 1;
            }
            let next = piece.steps.end - steps.start;
            let start = numbers.start + (1 + next.saturating_sub(halo)) * RECORD;
            piece.numbers.end = if part == parts { numbers.end } else { start };
            self.pieces.push(piece.clone());
            piece.numbers.start = piece.numbers.end;
            piece.first = next;
            piece.steps.start = piece.steps.end;
            piece.rows.start = piece.rows.end;
        }
    }

    /// The springs of rows in the order in which they are evaluated.
    pub(crate) fn turns(&self) -> Vec<Turn> {
        let mut springs = vec![NOWHERE; self.rows.len() * LANES];
        for (spring, &place) in self.places.iter().enumerate().filter(|row| *row.1 != NOWHERE) {
            springs[place as usize] = spring as u32;
        }
        let mut turns = Vec::new();
        for (number, piece) in self.pieces.iter().enumerate() {
            let band = &self.bands[piece.band];
            let mut rows = piece.rows.clone();
            for (step, first) in self.steps[piece.steps.clone()].iter().zip(piece.first..) {
                let is_carried = piece.is_part && Some(first) < band.halo;
                let here = if is_carried { Sum::Carried } else { Sum::Own };
                for place in rows.by_ref().take(step.rows as usize).flat_map(|row| {
                    (row * LANES..(row + 1) * LANES).filter(|&place| springs[place] != NOWHERE)
                }) {
                    let row = self.rows[place / LANES].other as usize;
                    let at = band.numbers.start + step.at as usize;
                    let (own, other, there) = match band.halo {
                        Some(_) => (None, band.numbers.start + row, Sum::Forces),
                        None => {
                            let record = self.others[row][place % LANES] as usize / LANES;
                            let other = at + record * RECORD - band.reach * RECORD;
                            (Some(at + place % LANES), other, Sum::Named)
                        }
                    };
                    let is_outside = piece.is_part && !piece.numbers.contains(&other);
                    let there = if is_outside { Sum::Later(number) } else { there };
                    turns.push(Turn { spring: springs[place], here: own, sums: [here, there] });
                }
            }
        }
        turns
    }

    /// Adds the rows of a block, and returns the slots of its particles if it has no segments.
    fn add_block(
        &mut self,
        springs: &BlockSprings<'_>,
        blank: usize,
        extras: &mut Vec<u32>,
    ) -> Option<Vec<u32>> {
        let len = springs.count.div_ceil(LANES);
        let numbers = blank * RECORD..(blank + 1 + len) * RECORD;
        let (first_step, first_row) = (self.steps.len(), self.rows.len());
        let (near, far) = springs.near_and_far();
        if !springs.has_segments(&far) {
            let (order, reach) = self.add_named(springs);
            let (steps, rows) = (first_step..self.steps.len(), first_row..self.rows.len());
            self.bands.push(Band { numbers, steps, rows, halo: None, reach, edges: Vec::new() });
            return Some(order);
        }
        extras.extend(far);
        let edges = springs.edges(&near);
        let reach = self.add_segments(springs, near, len);
        let (steps, rows) = (first_step..self.steps.len(), first_row..self.rows.len());
        self.bands.push(Band { numbers, steps, rows, halo: Some(reach), reach, edges });
        None
    }

    /// Adds steps and rows of segments of `len` particles; returns the length of the halo.
    fn add_segments(&mut self, springs: &BlockSprings<'_>, near: Vec<u32>, len: usize) -> usize {
        let halo = near.iter().map(|&spring| springs.apart(spring)).max().unwrap_or(0);
        let step_of = |spring: u32| {
            let [i, j] = springs.ends(spring);
            halo + j % len - (j - i)
        };
        let (starts, ordered) = by_place(near, halo + len, step_of);
        let turn = |spring| springs.turn(spring, len);
        let mut ordered: Vec<u64> = ordered.into_iter().map(turn).collect();
        for step in 0..halo + len {
            let ordered = &mut ordered[starts[step] as usize..starts[step + 1] as usize];
            ordered.sort_unstable();
            let first_row = self.rows.len();
            self.add_rows(springs, ordered, len);
            let rows = (self.rows.len() - first_row) as u32;
            self.steps.push(Step { rows, ..segment_step(step, halo, len) });
        }
        halo
    }

    /// Adds the rows of a step from its springs, the farthest first and by lane.
    fn add_rows(&mut self, springs: &BlockSprings<'_>, ordered: &[u64], len: usize) {
        let mut last = (u64::MAX, usize::MAX);
        let (mut first_row, mut row) = (self.rows.len(), 0);
        for turn in ordered {
            let (apart, lane) = (turn >> 32, (turn >> LANE) as usize % LANES);
            let spring = (turn & ((1 << LANE) - 1)) as u32;
            if apart != last.0 {
                first_row = self.rows.len();
            }
            // Two springs between the same ends are in two rows.
            row = if (apart, lane) == last { row + 1 } else { first_row };
            if row == self.rows.len() {
                let far = springs.ends(spring)[1];
                let other = ((1 + far % len) * RECORD) as u32;
                self.rows.push(Row { other, ..Row::default() });
            }
            self.rows[row].mask |= 1 << lane;
            self.places[spring as usize] = (row * LANES + lane) as u32;
            last = (apart, lane);
        }
    }

    /// Adds rows that name each other end; returns the slot of each particle, and the number of
    /// records springs reach.
    fn add_named(&mut self, springs: &BlockSprings<'_>) -> (Vec<u32>, usize) {
        let owned = springs.owned();
        let order = near_order(&springs.lists(), &owned);
        let slots = slots_of(&order);
        let record = |particle: u32| slots[particle as usize] as usize / LANES;
        let ends = springs.members.iter().map(|&spring| springs.ends(spring));
        let reach = ends.map(|[i, j]| record(i as u32).abs_diff(record(j as u32))).max();
        let reach = reach.unwrap_or(0);
        for (record, particles) in order.chunks(LANES).enumerate() {
            let first_row = self.rows.len();
            for (lane, &particle) in particles.iter().enumerate() {
                for (row, &[end, spring]) in (first_row..).zip(owned.of(particle)) {
                    if row == self.rows.len() {
                        let other = self.others.len() as u32;
                        let own = (reach * LANES) as u32;
                        self.others.push(core::array::from_fn(|lane| own + lane as u32));
                        self.rows.push(Row { other, ..Row::default() });
                    }
                    let seen = slots[end as usize] as usize + reach * LANES - record * LANES;
                    self.rows[row].mask |= 1 << lane;
                    self.others[self.rows[row].other as usize][lane] = seen as u32;
                    self.places[spring as usize] = (row * LANES + lane) as u32;
                }
            }
            let at = ((1 + record) * RECORD) as u32;
            self.steps.push(Step { at, carry: 0, rows: (self.rows.len() - first_row) as u32 });
        }
        (slots, reach)
    }
}

/// Where a step of segments starts, and where the sums are that it carries on.
///
/// Steps of the halo see the record that is `lanes` segments earlier: as far back, in the flat
/// column, as that. Their sums lie in records of their own; the first of these stays zero.
fn segment_step(step: usize, halo: usize, len: usize) -> Step {
    let lanes = if step < halo { (halo - step).div_ceil(len) } else { 0 };
    let at = (1 + step + lanes * len - halo) * RECORD - lanes;
    let carries = len <= step && step - len < halo;
    let carry = if carries { (1 + step - len) * RECORD + 1 } else { 0 };
    Step { at: at as u32, carry: carry as u32, rows: 0 }
}

/// The springs of a block; its particles count from `first`.
struct BlockSprings<'a> {
    ends: &'a [[u32; 2]],
    members: Vec<u32>,
    first: usize,
    count: usize,
}

impl BlockSprings<'_> {
    /// The particles of a spring, counted in the block, the lower number first.
    fn ends(&self, spring: u32) -> [usize; 2] {
        sorted(self.ends[spring as usize]).map(|end| end as usize - self.first)
    }

    fn apart(&self, spring: u32) -> usize {
        let [i, j] = self.ends(spring);
        j - i
    }

    /// A spring as a number, by which those of a step are sorted: the farthest first, then by the
    /// lane of the other end, which is one of segments of `len` particles.
    fn turn(&self, spring: u32, len: usize) -> u64 {
        let [i, j] = self.ends(spring);
        let nearness = u32::MAX - (j - i) as u32;
        u64::from(nearness) << 32 | ((j / len) << LANE) as u64 | u64::from(spring)
    }

    /// Whether the springs of each distance are a family.
    fn families(&self) -> Vec<bool> {
        let mut counts = vec![0usize; self.count];
        self.members.iter().for_each(|&spring| counts[self.apart(spring)] += 1);
        counts.iter().map(|&count| 0 < count && self.count <= count * FAMILY).collect()
    }

    /// The springs of families, and the others.
    fn near_and_far(&self) -> (Vec<u32>, Vec<u32>) {
        let families = self.families();
        self.members.iter().partition(|&&spring| families[self.apart(spring)])
    }

    /// The distances of springs behind which there is none for long, the largest included; none
    /// where a step is so short that the processor fetches the next ones in time.
    fn edges(&self, near: &[u32]) -> Vec<usize> {
        if near.len() < MANY * self.count {
            return Vec::new();
        }
        let mut is_distance = vec![false; self.count];
        near.iter().for_each(|&spring| is_distance[self.apart(spring)] = true);
        let (mut edges, mut last) = (Vec::new(), usize::MAX);
        for distance in (0..self.count).rev().filter(|&distance| is_distance[distance]) {
            if WIDE < last - distance {
                edges.push(distance);
            }
            last = distance;
        }
        edges
    }

    /// Whether the block is cut into segments, if these springs are of no family.
    fn has_segments(&self, far: &[u32]) -> bool {
        far.len() * MOST_EXTRAS <= self.members.len()
    }

    /// The springs of each particle.
    fn lists(&self) -> Lists {
        let rows = self.members.iter().flat_map(|&spring| {
            let [i, j] = self.ends(spring);
            [(i, [j as u32, spring]), (j, [i as u32, spring])]
        });
        Lists::new(self.count, rows)
    }

    /// Each spring with one of its ends, so that all particles have about as many.
    fn owned(&self) -> Lists {
        let mut counts = vec![0u32; self.count];
        let mut owners: Vec<bool> = vec![false; self.members.len()];
        for pass in 0..2 {
            for (&spring, is_higher) in self.members.iter().zip(&mut owners) {
                let [i, j] = self.ends(spring);
                if 0 < pass {
                    counts[if *is_higher { j } else { i }] -= 1;
                }
                *is_higher = counts[j] < counts[i];
                counts[if *is_higher { j } else { i }] += 1;
            }
        }
        let rows = self.members.iter().zip(owners).map(|(&spring, is_higher)| {
            let [i, j] = self.ends(spring);
            if is_higher { (j, [i as u32, spring]) } else { (i, [j as u32, spring]) }
        });
        Lists::new(self.count, rows)
    }
}

/// Springs by their place among `count`, those of one place in turn, and where each place starts.
fn by_place(springs: Vec<u32>, count: usize, place: impl Fn(u32) -> usize) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; count + 1];
    springs.iter().for_each(|&spring| starts[place(spring) + 1] += 1);
    (0..count).for_each(|place| starts[place + 1] += starts[place]);
    let (mut next, mut ordered) = (starts.clone(), vec![0u32; springs.len()]);
    for spring in springs {
        let next = &mut next[place(spring)];
        ordered[*next as usize] = spring;
        *next += 1;
    }
    (starts, ordered)
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The particles of the blocks: bodies, and the particles between them. Bodies that overlap are
/// one.
fn ranges(count: usize, bodies: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut bodies: Vec<Range<usize>> =
        bodies.iter().filter(|body| !body.is_empty()).cloned().collect();
    bodies.sort_by_key(|body| body.start);
    let apart = bodies.windows(2).all(|pair| pair[0].end <= pair[1].start);
    let inside = bodies.last().is_none_or(|last| last.end <= count);
    if !(apart && inside) {
        bodies.clear();
    }
    let mut cuts: Vec<usize> = bodies.iter().flat_map(|body| [body.start, body.end]).collect();
    cuts.push(count);
    let (mut ranges, mut start) = (Vec::<Range<usize>>::new(), 0);
    for cut in cuts {
        if start == cut {
            continue;
        }
        match ranges.last_mut() {
            Some(last) if last.len() < FEW && cut - start < FEW => last.end = cut,
            _ => ranges.push(start..cut),
        }
        start = cut;
    }
    ranges
}
