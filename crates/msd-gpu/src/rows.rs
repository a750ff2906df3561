//! Springs as rows: of a slice of 64 particles, the springs that come at one turn of their sums.
//!
//! A particle gathers the pulls of its springs itself, so that no two threads add to one sum. It
//! adds them in the order of the core: those of each sum in turn, and the sums in their order. A
//! row holds one spring of each particle of a slice. If all its springs lead to the particle the
//! same number further on and have one law, the row is an offset, a law and a bit for each
//! particle. Otherwise it names the other end and the law of each.

use crate::bends::{BendLists, STARTS};
use crate::shader::THREADS;
use msd_core::Model;
use msd_core::elements::springs::Sum;
use msd_core::laws::Law;
use std::collections::HashMap;

/// Flag of a row that names its springs.
const NAMED: u32 = 1 << 31;
/// Flag of a group whose pulls are added to the force one by one, not summed on their own first.
const DIRECT: u32 = 1 << 31;

/// The springs and bends of a model as a device reads them; see `step.wgsl`.
pub struct Rows {
    /// How springs and bends join particles.
    pub structure: Structure,
    /// The bits of rest length, stiffness and damping of each different spring, and three rows for
    /// each bend.
    pub numbers: Vec<[u32; 4]>,
    /// The first row of bends; 0 if there are none.
    pub bends_at: u32,
}

/// Rows, which name particles by how much further on they are, and laws by number.
#[derive(Default, PartialEq)]
pub struct Structure {
    /// The first and last group of each slice.
    slices: Vec<[u32; 2]>,
    /// The first and last row of each group.
    groups: Vec<[u32; 2]>,
    rows: Vec<[u32; 4]>,
    /// Ways and laws of rows that name their springs.
    named: Vec<u32>,
    bends: BendLists,
}

/// A spring as one of its ends sees it.
#[derive(Clone, Copy, PartialEq)]
struct Entry {
    /// The place of its sum among those of the particle.
    rank: u32,
    other: u32,
    law: u32,
}

/// The rank of springs that are added to the whole force last, one by one.
const LAST: u32 = u32::MAX;

fn rank(sum: Sum) -> u32 {
    match sum {
        Sum::Forces => 0,
        Sum::Own => 1,
        Sum::Named => 2,
        Sum::Later(part) => 3 + part as u32,
        Sum::Carried => LAST - 1,
    }
}

/// The different laws of springs.
#[derive(Default)]
struct Laws {
    laws: Vec<[f32; 4]>,
    known: HashMap<[u32; 3], u32>,
}

impl Laws {
    fn number(&mut self, Law { rest, stiffness, damping }: Law<f32>) -> u32 {
        let key = [rest, stiffness, damping].map(f32::to_bits);
        *self.known.entry(key).or_insert_with(|| {
            self.laws.push([rest, stiffness, damping, 0.0]);
            self.laws.len() as u32 - 1
        })
    }
}

/// The springs of each particle in the order in which it adds them.
struct Lists {
    starts: Vec<usize>,
    entries: Vec<Entry>,
}

impl Lists {
    fn new(model: &Model<f32>, laws: &mut Laws) -> Self {
        let springs = model.springs();
        let extra = |spring: u32| {
            let [a, b] = springs.ends()[spring as usize];
            (spring, [a.min(b), a.max(b)], [LAST; 2])
        };
        let turn = |(spring, ends, sums): (u32, [u32; 2], [Sum; 2])| (spring, ends, sums.map(rank));
        let all = springs.turns(model.slots()).map(turn).chain(springs.extras().map(extra));
        let all: Vec<_> = all.filter(|row| !springs.is_cut(row.0 as usize)).collect();
        let mut starts = vec![0; model.particle_count() + 1];
        all.iter().flat_map(|row| row.1).for_each(|end| starts[end as usize + 1] += 1);
        for particle in 1..starts.len() {
            starts[particle] += starts[particle - 1];
        }
        let mut ends = starts.clone();
        let mut entries = vec![Entry { rank: 0, other: 0, law: 0 }; 2 * all.len()];
        for (spring, [here, there], ranks) in all {
            let law = laws.number(springs.law(spring as usize));
            for ((end, other), rank) in [(here, there), (there, here)].into_iter().zip(ranks) {
                entries[ends[end as usize]] = Entry { rank, other, law };
                ends[end as usize] += 1;
            }
        }
        for window in starts.windows(2) {
            // Springs of one sum keep their order.
            entries[window[0]..window[1]].sort_by_key(|entry| entry.rank);
        }
        Lists { starts, entries }
    }

    fn of(&self, particle: usize) -> &[Entry] {
        &self.entries[self.starts[particle]..self.starts[particle + 1]]
    }
}

impl Rows {
    /// The springs of a model that are not cut.
    pub fn new(model: &Model<f32>) -> Self {
        let mut laws = Laws::default();
        let lists = Lists::new(model, &mut laws);
        let mut structure = Structure::default();
        let particles: Vec<usize> = (0..model.particle_count()).collect();
        for slice in particles.chunks(THREADS) {
            let first = structure.groups.len() as u32;
            let lists: Vec<&[Entry]> = slice.iter().map(|&particle| lists.of(particle)).collect();
            structure.add_slice(slice[0], &lists);
            structure.slices.push([first, structure.groups.len() as u32]);
        }
        laws.laws.push([0.0; 4]);
        let mut numbers: Vec<_> = laws.laws.iter().map(|law| law.map(f32::to_bits)).collect();
        let (bends, mut rows) = BendLists::new(model);
        let bends_at = if rows.is_empty() { 0 } else { numbers.len() as u32 };
        numbers.append(&mut rows);
        Rows { structure: Structure { bends, ..structure }, numbers, bends_at }
    }
}

impl Structure {
    /// The numbers of [`Structure::placed`].
    pub fn len(&self) -> u32 {
        self.first_list() + (self.bends.starts.len() + self.bends.parts.len()) as u32
    }

    /// The place of the first list of bends, counted from that of the structure.
    fn first_list(&self) -> u32 {
        (2 * self.groups.len() + 4 * self.rows.len() + self.named.len()) as u32
    }

    /// The places of the first and last group of each slice and of its lists of bends, counted from
    /// that of the structure. Where there are no bends, nobody reads the last.
    pub fn slices(&self) -> impl Iterator<Item = [u32; 3]> {
        let lists = (self.first_list()..).step_by(STARTS);
        self.slices.iter().zip(lists).map(|([first, last], lists)| [2 * first, 2 * last, lists])
    }

    /// Groups, rows, named springs and bends one after the other, from a place on: each with the
    /// places of those that it leads to.
    pub fn placed(&self, place: u32) -> Vec<u32> {
        let first_row = place + 2 * self.groups.len() as u32;
        let first_named = first_row + 4 * self.rows.len() as u32;
        let row = |row: u32| first_row + 4 * row;
        let groups = self.groups.iter().flat_map(|&[first, last]| {
            let flag = first & DIRECT;
            [row(first & !DIRECT) | flag, row(last)]
        });
        let rows = self.rows.iter().flat_map(|&[at, law, low, high]| {
            let start = if law & NAMED == 0 { 0 } else { first_named };
            [at.wrapping_add(start), law, low, high]
        });
        let BendLists { starts, parts } = &self.bends;
        let first_part = place + self.first_list() + starts.len() as u32;
        let starts = starts.iter().map(|start| first_part + start);
        let springs = groups.chain(rows).chain(self.named.iter().copied());
        springs.chain(starts).chain(parts.iter().copied()).collect()
    }

    fn add_slice(&mut self, base: usize, lists: &[&[Entry]]) {
        let mut ranks: Vec<u32> =
            lists.iter().flat_map(|list| list.iter()).map(|entry| entry.rank).collect();
        ranks.sort_unstable();
        ranks.dedup();
        for rank in ranks {
            let flag = if rank == 0 || rank == LAST { DIRECT } else { 0 };
            let first = self.rows.len() as u32;
            let of_rank = |list: &&[Entry]| -> Vec<Entry> {
                list.iter().copied().filter(|entry| entry.rank == rank).collect()
            };
            self.add_group(base, &lists.iter().map(of_rank).collect::<Vec<_>>());
            self.groups.push([first | flag, self.rows.len() as u32]);
        }
    }

    /// Adds the rows of the springs of one sum: by offset where every particle adds its springs in
    /// the order of their offsets, up or down, and most rows are full.
    fn add_group(&mut self, base: usize, lists: &[Vec<Entry>]) {
        let offset = |lane: usize, entry: &Entry| i64::from(entry.other) - (base + lane) as i64;
        let of_lane = |(lane, list): (usize, &Vec<Entry>)| -> Vec<i64> {
            list.iter().map(|entry| offset(lane, entry)).collect()
        };
        let offsets: Vec<Vec<i64>> = lists.iter().enumerate().map(of_lane).collect();
        let ascends = offsets.iter().all(|list| list.is_sorted_by(|a, b| a < b));
        let descends = offsets.iter().all(|list| list.is_sorted_by(|a, b| b < a));
        let most = lists.iter().map(Vec::len).max().unwrap_or(0);
        let mut all: Vec<i64> = offsets.iter().flatten().copied().collect();
        all.sort_unstable();
        all.dedup();
        if (ascends || descends) && all.len() <= 2 * most {
            if !ascends {
                all.reverse();
            }
            for wanted in all {
                let find = |(list, offsets): (&Vec<Entry>, &Vec<i64>)| {
                    let at = offsets.iter().position(|&offset| offset == wanted)?;
                    Some(list[at])
                };
                let springs: Vec<_> = lists.iter().zip(&offsets).map(find).collect();
                self.add_row(base, &springs, Some(wanted));
            }
            return;
        }
        for at in 0..most {
            let springs: Vec<_> = lists.iter().map(|list| list.get(at).copied()).collect();
            self.add_row(base, &springs, None);
        }
    }

    fn add_row(&mut self, base: usize, springs: &[Option<Entry>], offset: Option<i64>) {
        let mut present = springs.iter().flatten();
        let law = present.next().map_or(0, |entry| entry.law);
        let is_alike = present.all(|entry| entry.law == law);
        let bit = |(lane, spring): (usize, &Option<Entry>)| u64::from(spring.is_some()) << lane;
        let mask = springs.iter().enumerate().map(bit).fold(0, |mask, bit| mask | bit);
        if let (Some(offset), true) = (offset, is_alike) {
            self.rows.push([offset as i32 as u32, law, mask as u32, (mask >> 32) as u32]);
            return;
        }
        let at = self.named.len() as u32;
        let of = |lane: usize| springs.get(lane).copied().flatten();
        let way = |lane| of(lane).map_or(0, |entry| entry.other.wrapping_sub((base + lane) as u32));
        self.named.extend((0..THREADS).map(way));
        self.named.extend((0..THREADS).map(|lane| of(lane).map_or(0, |entry| entry.law)));
        self.rows.push([at, NAMED, mask as u32, (mask >> 32) as u32]);
    }
}
