//! The order in which springs are evaluated: rows of sixteen, compiled once from who is joined to
//! whom.
//!
//! In a block of segments (see [`crate::columns::slots`]) a spring between particles i < j, d
//! apart, joins two records of the same lane, or, past the end of a segment, of neighbouring lanes.
//! A *row* is up to sixteen springs of one d that start at one record, each evaluated once. A
//! *step* is all rows that start at one record, the farthest first. The first steps of a block are
//! its *halo*: the ends of all segments, seen from the next lane; the sums of their particles are
//! carried on by the step that comes upon the same particles in their own lane.
//!
//! In other blocks a row is up to one spring for each particle of a record, whose other ends are
//! named one by one; each such spring is evaluated from both ends.
//!
//! Every particle sums in one order, whatever the layout: the springs to lower numbers, the lowest
//! first, on what the fields have left there; then, on their own, those to higher numbers, the
//! highest first; then what fits no row, the *extras*, in the order of their ends. The one
//! exception is a large block of segments: threads evaluate *parts* of it, steps in turn, at the
//! same time, and what a part does to later ones, and to the ends of segments, is summed on its own
//! and added before the extras. The parts depend on the springs alone, and so do the bits.

use crate::columns::slots::{Block, Slots};
use crate::columns::{LANES, RECORD};
use alloc::vec;
use alloc::vec::Vec;
use core::cmp::Reverse;
use core::ops::Range;

/// Numbers of a particle that other ends are read from: position, nothing, velocity, nothing.
pub(crate) const POINT: usize = 8;

/// Up to sixteen springs, one for each lane in `mask`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Row {
    /// Where the other ends are: the first number of their record in the block, or, in a block
    /// without segments, the row of [`Layout::others`].
    pub(crate) other: u32,
    pub(crate) mask: u16,
    /// The lanes whose other end has the higher number; without segments alone.
    pub(crate) higher: u16,
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

/// The steps and rows of a block, or of some records of a block without segments.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Band {
    /// Its numbers in the columns of vectors, those in front of the first included.
    pub(crate) numbers: Range<usize>,
    pub(crate) steps: Range<usize>,
    pub(crate) rows: Range<usize>,
    /// How many of the steps are the halo; `None` without segments.
    pub(crate) halo: Option<usize>,
}

/// What one thread evaluates of a band: all, or of a large block with segments some steps in turn.
///
/// A part adds what its springs do to later parts to a column of its own, and what the ends of
/// segments feel stays where it was summed. Both are added to the forces when all parts are done,
/// so that these can be evaluated at once.
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
    /// The other ends of rows without segments, as places in the table of points.
    pub(crate) others: Vec<[u32; LANES]>,
    pub(crate) extras: Vec<Extra>,
    /// Row and lane of each spring, row · 16 + lane; [`NOWHERE`] for an extra.
    pub(crate) places: Vec<u32>,
    /// The same, seen from the other end; empty where every block has segments.
    pub(crate) second_places: Vec<u32>,
}

/// The place of a spring that is in no row.
pub(crate) const NOWHERE: u32 = u32::MAX;

/// Springs of one distance that make a family: one for every so many particles, at least. Rows of
/// fewer would be emptier than rows that name each end are slow.
const FAMILY: usize = 8;

/// Extras of a block of segments: one of so many springs, at most, as they are evaluated one by
/// one.
const MOST_EXTRAS: usize = 20;

/// Bodies of fewer particles share a block with their neighbours.
const FEW: usize = 256;

/// Rows of a piece of a large block and of a group of pieces, at least: 50 000 springs, worth a
/// thread of their own.
const GROUP: usize = 50_000 / LANES;

/// Parts of a block, at most.
const MOST_PARTS: usize = 16;

/// Rows for each step of the halo and each part but the first, at least: what a part does to later
/// ones is added record by record, which takes a few percent of the time of as many rows.
const ROWS_PER_STEP: usize = 16;

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
            let springs = Springs { ends, members, first: range.start, count: range.len() };
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

    /// The records that a group keeps for later parts.
    pub(crate) fn kept_for_later(&self, group: &Range<usize>) -> usize {
        let piece = &self.pieces[group.start];
        let band = &self.bands[piece.band];
        if piece.is_part && piece.numbers.end < band.numbers.end {
            band.halo.unwrap_or(0)
        } else {
            0
        }
    }

    /// The most rows of a step that name each other end.
    pub(crate) fn most_gathered(&self) -> usize {
        let gathers = self.bands.iter().filter(|band| band.halo.is_none());
        let steps = gathers.flat_map(|band| &self.steps[band.steps.clone()]);
        steps.map(|step| step.rows as usize).max().unwrap_or(0)
    }

    /// Takes a spring out of its rows.
    pub(crate) fn cut(&mut self, spring: usize) {
        for places in [&self.places, &self.second_places] {
            if let Some(&place) = places.get(spring).filter(|&&place| place != NOWHERE) {
                self.rows[place as usize / LANES].mask &= !(1 << (place as usize % LANES));
            }
        }
        // One by one they are few; a spring that is cut twice is not there any more.
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
        let Band { numbers, steps, rows, halo } = self.bands[band].clone();
        let (halo, len) = (halo.unwrap_or(0), numbers.len() / RECORD - 1);
        let most = (1 + rows.len() / (halo.max(1) * ROWS_PER_STEP)).min(rows.len() / GROUP);
        // A power of two, as threads mostly are. Sums are carried on once at most.
        let is_large = 0 < halo && halo < len && 1 < most;
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

    /// The later of the sums of its ends that each row of a part is added to: whether that of the
    /// end with the lower number is carried on, and, for the other, the piece that keeps it.
    pub(crate) fn late_sums(&self) -> Vec<(bool, Option<usize>)> {
        let mut late = vec![(false, None); self.rows.len()];
        for (number, piece) in self.pieces.iter().enumerate().filter(|piece| piece.1.is_part) {
            let band = &self.bands[piece.band];
            let end = piece.numbers.end - band.numbers.start;
            let mut rows = piece.rows.clone();
            for (step, first) in self.steps[piece.steps.clone()].iter().zip(piece.first..) {
                for row in rows.by_ref().take(step.rows as usize) {
                    let is_later = end <= self.rows[row].other as usize;
                    late[row] = (Some(first) < band.halo, is_later.then_some(number));
                }
            }
        }
        late
    }

    /// Adds the rows of a block, and returns the slots of its particles if it has no segments.
    fn add_block(
        &mut self,
        springs: &Springs<'_>,
        blank: usize,
        extras: &mut Vec<u32>,
    ) -> Option<Vec<u32>> {
        let len = springs.count.div_ceil(LANES);
        let numbers = blank * RECORD..(blank + 1 + len) * RECORD;
        let (first_step, first_row) = (self.steps.len(), self.rows.len());
        let (near, far) = springs.near_and_far();
        if !springs.has_segments(&far) {
            let order = self.add_gathers(springs, blank);
            self.add_bands(blank, first_step, first_row);
            return Some(order);
        }
        extras.extend(far);
        let halo = Some(self.add_segments(springs, near, len));
        let (steps, rows) = (first_step..self.steps.len(), first_row..self.rows.len());
        self.bands.push(Band { numbers, steps, rows, halo });
        None
    }

    /// Adds the bands of a block without segments, the steps and rows of which are there: each step
    /// writes one record, so that its records can be evaluated in any order.
    fn add_bands(&mut self, blank: usize, step: usize, row: usize) {
        let (records, parts) = (self.steps.len() - step, (self.rows.len() - row) / GROUP);
        let len = records.div_ceil(parts.clamp(1, MOST_PARTS)).max(1);
        let mut start = (blank * RECORD, step, row);
        for last in (step + len..).step_by(len) {
            let (first_number, first_step, first_row) = start;
            let steps = first_step..last.min(self.steps.len());
            let mut end = ((blank + 1 + steps.end - step) * RECORD, steps.end, first_row);
            for step in &mut self.steps[steps.clone()] {
                step.at -= (first_number - blank * RECORD) as u32;
                end.2 += step.rows as usize;
            }
            let (numbers, rows) = (first_number..end.0, first_row..end.2);
            self.bands.push(Band { numbers, steps, rows, halo: None });
            if end.1 == self.steps.len() {
                return;
            }
            start = end;
        }
    }

    /// Adds steps and rows of segments of `len` particles; returns the length of the halo.
    fn add_segments(&mut self, springs: &Springs<'_>, near: Vec<u32>, len: usize) -> usize {
        let halo = near.iter().map(|&spring| springs.apart(spring)).max().unwrap_or(0);
        let step_of = |spring: u32| {
            let [i, j] = springs.ends(spring);
            halo + j % len - (j - i)
        };
        let mut starts = vec![0u32; halo + len + 1];
        near.iter().for_each(|&spring| starts[step_of(spring) + 1] += 1);
        (0..halo + len).for_each(|step| starts[step + 1] += starts[step]);
        let (mut next, mut ordered) = (starts.clone(), vec![0u32; near.len()]);
        for spring in near {
            let place = &mut next[step_of(spring)];
            ordered[*place as usize] = spring;
            *place += 1;
        }
        for step in 0..halo + len {
            let ordered = &mut ordered[starts[step] as usize..starts[step + 1] as usize];
            let key = |&spring: &u32| {
                (Reverse(springs.apart(spring)), springs.ends(spring)[1] / len, spring)
            };
            ordered.sort_unstable_by_key(key);
            let first_row = self.rows.len();
            self.add_rows(springs, ordered, len);
            let rows = (self.rows.len() - first_row) as u32;
            self.steps.push(Step { rows, ..segment_step(step, halo, len) });
        }
        halo
    }

    /// Adds the rows of a step from its springs, the farthest first and by lane.
    fn add_rows(&mut self, springs: &Springs<'_>, ordered: &[u32], len: usize) {
        let mut last = (usize::MAX, usize::MAX);
        let (mut first_row, mut row) = (self.rows.len(), 0);
        for &spring in ordered {
            let (apart, far) = (springs.apart(spring), springs.ends(spring)[1]);
            let lane = far / len;
            if apart != last.0 {
                first_row = self.rows.len();
            }
            // Two springs between the same ends are in two rows.
            row = if (apart, lane) == last { row + 1 } else { first_row };
            if row == self.rows.len() {
                let other = ((1 + far % len) * RECORD) as u32;
                self.rows.push(Row { other, ..Row::default() });
            }
            self.rows[row].mask |= 1 << lane;
            self.places[spring as usize] = (row * LANES + lane) as u32;
            last = (apart, lane);
        }
    }

    /// Adds rows that name each other end; returns the slot of each particle.
    fn add_gathers(&mut self, springs: &Springs<'_>, blank: usize) -> Vec<u32> {
        let lists = springs.lists();
        let order = near_order(&lists);
        let mut slots = vec![0; springs.count];
        for (slot, &particle) in order.iter().enumerate() {
            slots[particle as usize] = slot as u32;
        }
        self.second_places.resize(self.places.len(), NOWHERE);
        let first_slot = (blank + 1) * LANES;
        for (record, particles) in order.chunks(LANES).enumerate() {
            let most = particles.iter().map(|&p| lists.of(p).len()).max().unwrap_or(0);
            for number in 0..most {
                let row = self.rows.len();
                let mut others = [((first_slot + record * LANES) * POINT) as u32; LANES];
                let (mut mask, mut higher) = (0, 0);
                for (lane, &particle) in particles.iter().enumerate() {
                    let Some(&[other, spring]) = lists.of(particle).get(number) else { continue };
                    others[lane] = ((first_slot + slots[other as usize] as usize) * POINT) as u32;
                    mask |= 1 << lane;
                    higher |= u16::from(particle < other) << lane;
                    let places = [&mut self.second_places, &mut self.places];
                    let [second, first] = places.map(|places| &mut places[spring as usize]);
                    *(if particle < other { first } else { second }) = (row * LANES + lane) as u32;
                }
                self.rows.push(Row {
                    other: self.others.len() as u32,
                    mask,
                    higher,
                    values: [0; 3],
                });
                self.others.push(others);
            }
            let at = ((1 + record) * RECORD) as u32;
            self.steps.push(Step { at, carry: 0, rows: most as u32 });
        }
        slots
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
struct Springs<'a> {
    ends: &'a [[u32; 2]],
    members: Vec<u32>,
    first: usize,
    count: usize,
}

impl Springs<'_> {
    /// The particles of a spring, counted in the block, the lower number first.
    fn ends(&self, spring: u32) -> [usize; 2] {
        sorted(self.ends[spring as usize]).map(|end| end as usize - self.first)
    }

    fn apart(&self, spring: u32) -> usize {
        let [i, j] = self.ends(spring);
        j - i
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

    /// Whether the block is cut into segments, if these springs are of no family.
    fn has_segments(&self, far: &[u32]) -> bool {
        far.len() * MOST_EXTRAS <= self.members.len()
    }

    /// The springs of each particle, in the order in which it sums them.
    fn lists(&self) -> Lists {
        let mut starts = vec![0u32; self.count + 1];
        for end in self.members.iter().flat_map(|&spring| self.ends(spring)) {
            starts[end + 1] += 1;
        }
        (0..self.count).for_each(|particle| starts[particle + 1] += starts[particle]);
        let (mut next, mut rows) = (starts.clone(), vec![[0; 2]; 2 * self.members.len()]);
        for &spring in &self.members {
            let [i, j] = self.ends(spring);
            for (here, there) in [(i, j), (j, i)] {
                rows[next[here] as usize] = [there as u32, spring];
                next[here] += 1;
            }
        }
        for particle in 0..self.count {
            let list = &mut rows[starts[particle] as usize..starts[particle + 1] as usize];
            list.sort_unstable_by_key(|&[other, spring]| {
                let is_higher = particle < other as usize;
                (is_higher, if is_higher { u32::MAX - other } else { other }, spring)
            });
        }
        Lists { starts, rows }
    }
}

/// Other end and spring of each row of a particle.
struct Lists {
    starts: Vec<u32>,
    rows: Vec<[u32; 2]>,
}

impl Lists {
    fn of(&self, particle: u32) -> &[[u32; 2]] {
        let particle = particle as usize;
        &self.rows[self.starts[particle] as usize..self.starts[particle + 1] as usize]
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The particles of the blocks: bodies, and what is between them. Bodies that overlap are one.
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

/// Particles in the order in which a walk along springs finds them, nearest first, backwards
/// (Cuthill and McKee, 1969; George, 1971), so that what is joined is near; in windows of which
/// those with the most springs come first, so that the rows of a record are full.
fn near_order(lists: &Lists) -> Vec<u32> {
    let count = lists.starts.len() - 1;
    let springs = |&particle: &u32| lists.of(particle).len();
    let mut starts: Vec<u32> = (0..count as u32).collect();
    starts.sort_by_key(springs);
    let mut order = Vec::with_capacity(count);
    let mut found = vec![false; count];
    for start in starts {
        let mut next = order.len();
        if !core::mem::replace(&mut found[start as usize], true) {
            order.push(start);
        }
        while let Some(&particle) = order.get(next) {
            next += 1;
            let first = order.len();
            for &[other, _] in lists.of(particle) {
                if !core::mem::replace(&mut found[other as usize], true) {
                    order.push(other);
                }
            }
            order[first..].sort_by_key(springs);
        }
    }
    order.reverse();
    for window in order.chunks_mut(WINDOW) {
        window.sort_by_key(|particle| Reverse(springs(particle)));
    }
    order
}

/// Particles that are sorted by their number of springs: few enough to stay near each other.
const WINDOW: usize = 128;
