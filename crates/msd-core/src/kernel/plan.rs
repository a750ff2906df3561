//! How is this topology evaluated fastest? As slices of [`LANES`] particles, and rows of springs.
//!
//! A row is at most one spring for each particle of a slice. Where most of the particles reach the
//! same number of places ahead or back, as in a lattice, they do so together (a *run*); elsewhere
//! each names the particle it reaches (a *gather*: SELLPACK of Kreutzer and others, 2014). Each
//! particle meets its springs in the order of the model, so that its sum has the bits of the plain
//! loop in [`crate::forces`].

use super::columns::Slice;
use super::{LANES, RECORD};
use crate::forces::Incidence;
use crate::real::Real;
use crate::system::{Column, Model};
use alloc::vec;
use alloc::vec::Vec;
use core::cmp::Reverse;

/// Where the other ends of a row are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reach {
    /// As many slots ahead, or back, of each particle.
    Run(i32),
    /// Where a row of [`Plan::others`] says.
    Gather(u32),
}

/// At most one spring for each particle of a slice. What is said per lane is a place in
/// [`Plan::values`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Row {
    pub(super) reach: Reach,
    /// The lanes that have a spring, the first lowest.
    pub(super) mask: u16,
    pub(super) rest_length: u32,
    pub(super) stiffness: u32,
    pub(super) damping: u32,
}

/// A topology made ready. A slot is a place in the order of evaluation.
///
/// Every row has at least one lane set in its mask, and reaches only slots of particles where it is
/// set; every place in a row is one of the tables; there are as many starts as slices and one.
#[derive(Clone, Debug)]
pub(super) struct Plan<R> {
    /// The slot of each particle; `None` where each is in that of its number.
    slots: Option<Vec<u32>>,
    /// The first row of each slice, and the number of rows.
    pub(super) starts: Vec<u32>,
    pub(super) rows: Vec<Row>,
    /// Rest lengths, stiffnesses and dampings of rows, one number per lane; what is the same for
    /// many rows is there once. Aligned: a load across two lines of the cache is two loads.
    pub(super) values: Vec<Slice<R>>,
    /// For each lane of a gather row, the record of the other end, counted in numbers.
    pub(super) others: Vec<Slice<u32>>,
    pub(super) damped: bool,
}

impl<R: Real> Plan<R> {
    /// Compiles the springs of a model. The same springs give the same plan.
    pub(super) fn new(model: &Model<R>) -> Self {
        let incidence = Incidence::new(model);
        let count = model.particle_count();
        let plan = Plan::in_order(model, &incidence, None);
        // A lattice, or something as small, stays in the order of its scene.
        if plan.gathered() <= model.spring_count() || count <= LANES {
            return plan;
        }
        drop(plan);
        Plan::in_order(model, &incidence, Some(near_order(&incidence, count)))
    }

    /// Compiles with a given particle in each slot, or with each in that of its number.
    fn in_order(model: &Model<R>, incidence: &Incidence, order: Option<Vec<u32>>) -> Self {
        let count = model.particle_count();
        let slots = order.as_ref().map(|order| {
            let mut slots = vec![0; count];
            for (slot, &particle) in order.iter().enumerate() {
                slots[particle as usize] = slot as u32;
            }
            slots
        });
        let mut plan = Plan {
            slots,
            starts: vec![0],
            rows: Vec::new(),
            values: Vec::new(),
            others: Vec::new(),
            damped: !model.dampings.is_zero(),
        };
        let mut compiler = Compiler { model, runs: order.is_none(), uniform: Vec::new() };
        for begin in (0..count).step_by(LANES) {
            let mut lists = [&[][..]; LANES];
            for (list, slot) in lists.iter_mut().zip(begin..count) {
                *list = incidence.of(order.as_ref().map_or(slot, |order| order[slot] as usize));
            }
            compiler.add_slice(&mut plan, begin as i32, lists);
            plan.starts.push(plan.rows.len() as u32);
        }
        plan.rows.shrink_to_fit();
        plan.values.shrink_to_fit();
        plan.others.shrink_to_fit();
        plan.starts.shrink_to_fit();
        plan
    }

    /// The number of slices.
    pub(super) fn slices(&self) -> usize {
        self.starts.len() - 1
    }

    /// The slot of each particle; `None` where each is in that of its number.
    pub(super) fn slots(&self) -> Option<&[u32]> {
        self.slots.as_deref()
    }

    /// The slot of a particle.
    pub(super) fn slot(&self, particle: u32) -> usize {
        self.slots.as_ref().map_or(particle, |slots| slots[particle as usize]) as usize
    }

    /// Where a row of values is, from a lane on; it is there if the place is in a row of the plan.
    #[inline(always)]
    pub(super) fn value(&self, place: u32, lane: usize) -> *const R {
        self.values.as_ptr().wrapping_add(place as usize).cast::<R>().wrapping_add(lane)
    }

    /// The number of springs' ends that are in gather rows.
    fn gathered(&self) -> usize {
        let gathers = self.rows.iter().filter(|row| matches!(row.reach, Reach::Gather(_)));
        gathers.map(|row| row.mask.count_ones() as usize).sum()
    }

    /// The place of a row of values, the same for rows that are alike in one number.
    fn place(&mut self, uniform: &mut Vec<(R, u32)>, lanes: [Option<R>; LANES]) -> u32 {
        let first = lanes.iter().flatten().next().copied().unwrap_or(R::ZERO);
        // By their bits: minus zero is not zero.
        let same = |value: R| value.to_le_bytes().into_iter().eq(first.to_le_bytes());
        let alike = lanes.iter().flatten().all(|&value| same(value));
        let known = uniform.iter().find(|&&(value, _)| same(value));
        if let (true, Some(&(_, place))) = (alike, known) {
            return place;
        }
        let place = self.values.len() as u32;
        self.values.push(Slice(lanes.map(|value| value.unwrap_or(first))));
        if alike && uniform.len() < MOST_UNIFORM {
            uniform.push((first, place));
        }
        place
    }
}

/// Rows of one number that are looked up before another is made.
const MOST_UNIFORM: usize = 16;

/// Springs that a particle has still to meet: spring and other end.
type List<'a> = &'a [[u32; 2]];

struct Compiler<'a, R: Real> {
    model: &'a Model<R>,
    /// Whether to look for runs.
    runs: bool,
    /// Rows of values that hold one number, and where.
    uniform: Vec<(R, u32)>,
}

impl<R: Real> Compiler<'_, R> {
    /// Adds the rows of one slice, which begins at a slot.
    fn add_slice(&mut self, plan: &mut Plan<R>, slot: i32, mut lists: [List<'_>; LANES]) {
        loop {
            let reach = |lane: usize, other: u32| plan.slot(other) as i32 - (slot + lane as i32);
            let heads: [Option<i32>; LANES] = core::array::from_fn(|lane| {
                lists[lane].first().map(|&[_, other]| reach(lane, other))
            });
            let active = lanes_where(|lane| heads[lane].is_some());
            if active == 0 {
                return;
            }
            let run = self.runs.then(|| best_run(&heads, active, &lists, reach)).flatten();
            let mask = run.map_or(active, |(_, mask)| mask);
            let reach = match run {
                Some((offset, _)) => Reach::Run(offset),
                None => {
                    let record = |lane: usize| match lists[lane].first() {
                        Some(&[_, other]) => (plan.slot(other) * RECORD) as u32,
                        None => 0,
                    };
                    plan.others.push(Slice(core::array::from_fn(record)));
                    Reach::Gather(plan.others.len() as u32 - 1)
                }
            };
            self.add_row(plan, reach, mask, &mut lists);
        }
    }

    /// Adds a row and takes its springs from the lists.
    fn add_row(
        &mut self,
        plan: &mut Plan<R>,
        reach: Reach,
        mask: u16,
        lists: &mut [List<'_>; LANES],
    ) {
        debug_assert!(mask != 0, "a run without lanes might reach anywhere");
        let mut springs = [None; LANES];
        for (lane, list) in lists.iter_mut().enumerate() {
            if mask >> lane & 1 == 1 {
                springs[lane] = Some(list[0][0] as usize);
                *list = &list[1..];
            }
        }
        let model = self.model;
        let each = |column: &Column<R>| springs.map(|spring| spring.map(|row| column.get(row)));
        let rests = springs.map(|spring| spring.map(|row| model.rest_lengths[row]));
        let rest_length = plan.place(&mut self.uniform, rests);
        let stiffness = plan.place(&mut self.uniform, each(&model.stiffnesses));
        let damping = plan.place(&mut self.uniform, each(&model.dampings));
        plan.rows.push(Row { reach, mask, rest_length, stiffness, damping });
    }
}

fn lanes_where(wanted: impl Fn(usize) -> bool) -> u16 {
    (0..LANES).fold(0, |mask, lane| mask | u16::from(wanted(lane)) << lane)
}

/// The offset, and the lanes, of the run that comes next, if it serves at least a third of them.
///
/// Of several, one that no other lane still has before it: those meet it later, all at once. That
/// is what brings the rows of a lattice together again after its borders.
fn best_run(
    heads: &[Option<i32>; LANES],
    active: u16,
    lists: &[List<'_>; LANES],
    reach: impl Fn(usize, u32) -> i32,
) -> Option<(i32, u16)> {
    let mut best = None;
    let mut seen = 0;
    for lane in 0..LANES {
        let Some(offset) = heads[lane].filter(|_| seen >> lane & 1 == 0) else { continue };
        let mask = lanes_where(|other| heads[other] == Some(offset));
        seen |= mask;
        if mask == active {
            return Some((offset, mask));
        }
        let served = mask.count_ones();
        if served * MOST_RUNS < active.count_ones() {
            continue;
        }
        let waits = |lane: usize| {
            mask >> lane & 1 == 0
                && lists[lane].iter().take(AHEAD).any(|&[_, to]| reach(lane, to) == offset)
        };
        let rank = (!(0..LANES).any(waits), served);
        if best.is_none_or(|(before, _)| before < rank) {
            best = Some((rank, (offset, mask)));
        }
    }
    best.map(|(_, run)| run)
}

/// Springs that are looked through for one that waits: more than a particle of a lattice has.
const AHEAD: usize = 64;

/// Lanes served by a run at least: one in this many, since a gather costs about so many runs.
const MOST_RUNS: u32 = 3;

/// Particles in the order in which a walk along springs finds them, nearest first, backwards
/// (Cuthill and McKee, 1969; George, 1971), so that what is joined is near; in windows of which
/// those with the most springs come first, so that the rows of a slice are full.
fn near_order(incidence: &Incidence, count: usize) -> Vec<u32> {
    let springs = |&particle: &u32| incidence.of(particle as usize).len();
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
            for &[_, other] in incidence.of(particle as usize) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::Material;
    use crate::scene::Scene;
    use crate::shape;

    fn rows(sides: [usize; 3]) -> Vec<Row> {
        let material = Material { mass: 1.0, stiffness: 1.0, damping: 1.0 };
        let scene = Scene::of("block", shape::block(sides, 1.0, material).expect("small"));
        let (model, _) = Model::<f32>::new(&scene).expect("a valid scene");
        Plan::new(&model).rows
    }

    #[test]
    fn a_lattice_is_runs_alone_and_about_as_many_as_a_particle_has_springs() {
        for (sides, springs) in [([31usize, 31, 1], 8), ([10, 10, 10], 26), ([1, 1, 100], 2)] {
            let slices = (sides[0] * sides[1] * sides[2]).div_ceil(LANES);
            let rows = rows(sides);
            let runs = rows.iter().filter(|row| matches!(row.reach, Reach::Run(_))).count();
            assert_eq!(runs, rows.len(), "{sides:?}");
            assert!(rows.len() <= slices * springs, "{sides:?}: {} rows", rows.len());
        }
    }
}
