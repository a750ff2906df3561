//! Pairs of particles that may touch: a list that holds until particles have moved too far.
//!
//! It has all pairs closer than the sum of their radii and a skin, and serves until two particles
//! can have come closer by more than that (after Verlet, 1967). What they all share of a motion
//! wears it out by nothing: the box around all displacements is looked at first, and where that is
//! too long, those around the displacements in cells that touch. Where particles drift by their
//! velocities alone, the boxes around these are added up instead, as long as that leaves no doubt:
//! a third of the numbers are read.

use super::Touches;
use super::faces::{self, Facing};
use super::law::{Closed, PairLaw};
use crate::columns::extent::{Extent, Records};
use crate::columns::{load, vector};
use crate::error::Error;
use crate::grid::Grid;
use crate::number::{Real, Vector, at_level};
use crate::pack::zip;
use crate::scene::touch::check_pairs;
use alloc::vec::Vec;
use core::convert::Infallible;
use fearless_simd::{Level, Simd};

/// A pair that may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair<R: Real> {
    pub(crate) particles: [u32; 2],
    /// Where the numbers of both are in a column of vectors.
    pub(crate) at: [u32; 2],
    pub(super) law: PairLaw<R>,
}

impl<R: Real> Pair<R> {
    /// Its touch at a motion, in columns.
    #[inline(always)]
    pub(super) fn closed(&self, [x, v]: [&[R]; 2], inverse_masses: &[R]) -> Option<Closed<R>> {
        let at = self.at.map(|at| at as usize);
        let places = at.map(|at| vector::<R>(x, at));
        // Most pairs of the list do not touch: no more than this is read of them.
        let apart = places[1] - places[0];
        if self.law.reach * self.law.reach <= apart.dot(apart) {
            return None;
        }
        let masses = inverse_masses[at[0]] + inverse_masses[at[1]];
        let velocities = at.map(|at| vector::<R>(v, at));
        self.law.close([apart, velocities[1] - velocities[0]], masses)
    }
}

/// What may touch: pairs, and beads and triangles, each in order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Listed<'a, R: Real> {
    pub(super) pairs: &'a [Pair<R>],
    pub(super) facings: &'a [Facing<R>],
}

/// The list and what it is made with. Empty where nothing has a radius.
#[derive(Clone, Debug, Default)]
pub(crate) struct Near<R: Real> {
    pairs: Vec<Pair<R>>,
    facings: Vec<Facing<R>>,
    /// The positions at which it was made; empty where there is no list.
    from: Vec<R>,
    /// How much closer than when it was made pairs may be, metres.
    skin: f64,
    /// How much closer they were at most at these positions, metres.
    worn: f64,
    since: Vec<R>,
    /// The same between there and the last look, metres.
    used: f64,
    /// By how much a drift after the last look has brought two closer at most, metres; `None` where
    /// there was none.
    drift: Option<f64>,
    /// Whether particles may have been moved otherwise since the last look.
    is_disturbed: bool,
    /// Where the numbers of particles are, cell by cell, where each cell ends, and the cells that
    /// touch.
    cells: Vec<u32>,
    ends: Vec<u32>,
    neighbours: Vec<[u32; 2]>,
    /// The displacements in each cell.
    boxes: Vec<Extent<R>>,
    /// How much closer those in cells that do not touch may come before they are near, metres.
    spare: f64,
    /// Where the particles with a radius are.
    records: Records,
    /// How far two particles come closer in a substep at most, metres.
    stride: f64,
    /// Whether that is of the present velocities.
    is_of_present: bool,
    /// Rounding of a drift, metres.
    rounding: f64,
    grid: Grid,
    /// The beads of each pair of the list, as one number.
    keys: Vec<u64>,
}

/// The skin of a list, as a part of the largest sum of radii, and the largest skin that fast
/// particles get.
const SKIN: f64 = 1.0;
const LARGEST_SKIN: f64 = 2.0;
/// The part of its skin up to which a list serves on.
const WORN: f64 = 0.6;
/// The width of the cells in which displacements are looked at, in those of the grid.
const WIDTH: f64 = 4.0;

impl<R: Real> Near<R> {
    /// Discards the list: particles or laws are other ones.
    pub(crate) fn forget(&mut self) {
        self.from.clear();
        self.records = Records::default();
    }

    /// What may touch at these positions.
    pub(crate) fn nearby(
        &mut self,
        level: Level,
        touches: &Touches,
        positions: &[R],
    ) -> Listed<'_, R> {
        if !self.follows() && !self.looks(level, positions) && !self.serves_on(positions) {
            self.list(level, touches, positions);
        }
        (self.drift, self.is_disturbed) = (None, false);
        self.listed()
    }

    fn listed(&self) -> Listed<'_, R> {
        Listed { pairs: &self.pairs, facings: &self.facings }
    }

    /// Takes note of a drift of all particles by these velocities for so many seconds, and whether
    /// it is the last change of either in the substep.
    pub(crate) fn drift(&mut self, level: Level, velocities: &[R], h: f64, is_last: bool) {
        self.stride = self.stride_of(level, velocities, h);
        self.is_of_present = is_last;
        self.drift = Some(self.stride + self.rounding);
    }

    /// How far two particles come closer in h seconds at most, metres.
    fn stride_of(&self, level: Level, velocities: &[R], h: f64) -> f64 {
        h * Real::sqrt(at_level!(level, simd => spread(simd, &self.records, velocities)).to_f64())
    }

    /// Takes note that particles may be moved otherwise.
    pub(crate) fn disturb(&mut self) {
        (self.is_disturbed, self.is_of_present) = (true, false);
    }

    /// Sees what may touch at these positions.
    pub(crate) fn see<T>(
        &self,
        level: Level,
        touches: &Touches,
        positions: &[R],
        see: impl FnOnce(Listed<'_, R>) -> T,
    ) -> T {
        match touches.is_empty() || self.holds(level, positions) {
            true => see(self.listed()),
            false => see(Near::default().nearby(level, touches, positions)),
        }
    }

    /// Refuses particles of which too many lie within reach of each other.
    ///
    /// # Errors
    /// [`Error::TooLarge`].
    pub(crate) fn check(touches: &Touches, positions: &[R]) -> Result<(), Error> {
        let mut near = Near::default();
        near.fill(touches, positions);
        let ([_, widest], mut count) = (touches.reaches(), 0);
        let reach = R::of(widest);
        near.grid.each_pair(Level::baseline(), widest, |a, b| {
            let apart = touches.point(positions, b) - touches.point(positions, a);
            count += usize::from(apart.dot(apart) < reach * reach);
            check_pairs(count, touches.beads.len())
        })?;
        count = 0;
        faces::each_near(touches, (&near.grid, positions), 0.0, |_, _| {
            count += 1;
            check_pairs(count, touches.beads.len())
        })
    }

    /// Whether the list is known to serve.
    fn holds(&self, level: Level, positions: &[R]) -> bool {
        !self.from.is_empty() && self.displacement(level, positions) <= self.left()
    }

    /// How much of the skin is left, less what rounding is worth, metres.
    fn left(&self) -> f64 {
        0.99 * (self.skin - self.worn)
    }

    /// The diagonal of the box around all displacements, metres.
    fn displacement(&self, level: Level, positions: &[R]) -> f64 {
        let square = at_level!(level, simd => wear(simd, &self.records, &self.since, positions));
        Real::sqrt(square.to_f64())
    }

    /// Whether the list is known to serve by the drifts since the last look.
    fn follows(&mut self) -> bool {
        let Some(drift) = self.drift.filter(|_| !self.is_disturbed) else { return false };
        self.used += drift;
        !self.from.is_empty() && self.used <= self.left()
    }

    /// Whether the list serves by a look at all displacements.
    fn looks(&mut self, level: Level, positions: &[R]) -> bool {
        if self.from.is_empty() {
            return false;
        }
        self.used = self.displacement(level, positions);
        self.used <= self.left()
    }

    /// Looks cell by cell by how much particles can have come closer; whether the list may serve
    /// on.
    fn serves_on(&mut self, positions: &[R]) -> bool {
        if self.from.is_empty() {
            return false;
        }
        let Near { from, boxes, cells, ends, .. } = self;
        boxes.clear();
        let mut start = 0;
        for &end in &*ends {
            let mut displacements = Extent::default();
            for &at in &cells[start..end as usize] {
                let at = at as usize;
                displacements.add(vector::<R>(positions, at) - vector::<R>(from, at));
            }
            boxes.push(displacements);
            start = end as usize;
        }
        let mut most = R::ZERO;
        for &[a, b] in &self.neighbours {
            most = R::max(most, self.boxes[a as usize].with(self.boxes[b as usize]).diagonal());
        }
        self.worn = Real::sqrt(most.to_f64());
        self.since.copy_from_slice(positions);
        self.used = 0.0;
        // Those in cells that do not touch are a cell apart, and may have come closer by any way.
        let all = self.boxes.iter().fold(Extent::default(), |all, own| all.with(*own));
        let are_apart = Real::sqrt(all.diagonal().to_f64()) <= self.spare;
        are_apart && self.worn <= WORN * self.skin
    }

    fn list(&mut self, level: Level, touches: &Touches, positions: &[R]) {
        let [_, reach] = touches.reaches();
        self.skin = (SKIN * reach).max(2.0 * self.stride).min(LARGEST_SKIN * reach);
        (self.worn, self.used) = (0.0, 0.0);
        let farthest = positions.iter().fold(R::ZERO, |most, x| most.max(x.abs()));
        self.rounding = 8.0 * (R::EPSILON * farthest).to_f64();
        for column in [&mut self.from, &mut self.since] {
            column.clear();
            column.extend_from_slice(positions);
        }
        if self.records.is_empty() {
            self.records = Records::new(touches.beads.iter().map(|bead| bead.at));
        }
        self.find_cells(touches, positions);
        self.fill(touches, positions);
        let Near { pairs, facings, keys, grid, skin, .. } = self;
        keys.clear();
        let never: Result<(), Infallible> = grid.each_pair(level, reach + *skin, |a, b| {
            if touches.do_touch(a, b) {
                keys.push((a as u64) << 32 | b as u64);
            }
            Ok(())
        });
        let Ok(()) = never;
        // Beads are in the order of their particles.
        keys.sort_unstable();
        pairs.clear();
        pairs.extend(keys.iter().filter_map(|key| {
            let both = [key >> 32, key & u64::from(u32::MAX)].map(|bead| bead as usize);
            let law = touches.law_of(both[0], both[1]);
            let apart = touches.point(positions, both[1]) - touches.point(positions, both[0]);
            let most = law.reach + R::of(*skin);
            let both = both.map(|bead| touches.beads[bead]);
            let (particles, at) = (both.map(|bead| bead.particle), both.map(|bead| bead.at));
            (apart.dot(apart) < most * most).then_some(Pair { particles, at, law })
        }));
        faces::list(touches, (grid, positions), *skin, keys, facings);
    }

    /// Puts all beads into cells as wide as pairs of the list are long.
    fn fill(&mut self, touches: &Touches, positions: &[R]) {
        let [_, reach] = touches.reaches();
        self.grid.fill(reach + self.skin, touches.points(positions));
    }

    /// Puts all beads into wider cells, whose displacements are looked at together.
    fn find_cells(&mut self, touches: &Touches, positions: &[R]) {
        let [_, reach] = touches.reaches();
        let Near { grid, cells, ends, neighbours, skin, spare, .. } = self;
        let near = reach + *skin;
        *spare = (WIDTH - 1.0) * near;
        // Where a corner is in no cell that touches that of a bead, they are so far apart that the
        // bead is a cell less an edge from the triangle.
        let edge = faces::longest_edge(touches, positions);
        grid.fill(WIDTH * near + edge, touches.points(positions));
        cells.clear();
        ends.clear();
        neighbours.clear();
        for row in 0..grid.row_count() {
            let places = grid.points_of(row).iter().map(|&bead| touches.beads[bead as usize].at);
            cells.extend(places);
            ends.push(cells.len() as u32);
            let with = core::iter::once(row).chain(grid.beside(row));
            neighbours.extend(with.map(|other| [row as u32, other as u32]));
        }
    }

    /// Takes note of the length of a substep, seconds, and counts the pairs that may pass through
    /// each other in the next one: that close by more than the sum of their radii. So do a bead and
    /// a triangle, or the bead goes from one side of it to the other. Where particles are so fast
    /// that the list would have to be far larger, one.
    pub(crate) fn count_passes(
        &mut self,
        level: Level,
        touches: &Touches,
        [positions, velocities]: [&[R]; 2],
        h: f64,
    ) -> u64 {
        if self.from.is_empty() {
            self.list(level, touches, positions);
        }
        let [least, most] = touches.reaches();
        if !core::mem::take(&mut self.is_of_present) {
            self.stride = self.stride_of(level, velocities, h);
        }
        let is_slow = self.stride <= least;
        if is_slow && touches.triangles.is_empty() {
            return 0;
        }
        if LARGEST_SKIN * most < self.stride {
            // Too many to look at each: something may have.
            return 1;
        }
        // Any that may pass are to be in the list, however worn.
        let needed = if is_slow { 0.0 } else { self.stride };
        if self.left() - self.displacement(level, positions) < needed {
            self.list(level, touches, positions);
        }
        let through = faces::count_passes(&self.facings, [positions, velocities], h) as u64;
        if is_slow {
            return through;
        }
        let passes = self.pairs.iter().filter(|pair| {
            let [a, b] = pair.at.map(|at| at as usize);
            let apart = (vector::<R>(positions, b) - vector::<R>(positions, a)).to_f64();
            let way = (vector::<R>(velocities, b) - vector::<R>(velocities, a)).to_f64() * h;
            passes(apart, way, pair.law.reach.to_f64())
        });
        through + passes.count() as u64
    }
}

/// Whether two particles may pass through each other: they close by more than the sum of their
/// radii, on a line that leads within it.
fn passes(apart: glam::DVec3, way: glam::DVec3, reach: f64) -> bool {
    let square = way.dot(way);
    let closing = -apart.dot(way);
    if square <= reach * reach || closing <= 0.0 {
        return false;
    }
    let nearest = apart + way * (closing / square).min(1.0);
    nearest.dot(nearest) < reach * reach
}

/// The square of the diagonal of the box around all displacements.
#[inline(always)]
fn wear<S: Simd, R: Real>(simd: S, records: &Records, from: &[R], to: &[R]) -> R {
    let way = |at: usize, part| {
        zip(load(simd, &to[at..], part), load(simd, &from[at..], part), |a, b| a - b)
    };
    Extent::of(simd, records, way).diagonal()
}

/// The square of the diagonal of the box around all vectors of a column.
#[inline(always)]
fn spread<S: Simd, R: Real>(simd: S, records: &Records, column: &[R]) -> R {
    Extent::of(simd, records, |at, part| load(simd, &column[at..], part)).diagonal()
}
