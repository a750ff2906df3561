//! Pairs of particles that may touch: a list that holds until particles have moved too far.
//!
//! It has all pairs closer than the sum of their radii and a skin, and serves until the box around
//! all displacements since it was made is as long as the skin (after Verlet, 1967): no two particles
//! have then come closer by more than that. A motion that all share wears it out by nothing.

use super::Touches;
use crate::error::Error;
use crate::columns::{LANES, RECORD, vector};
use crate::grid::Grid;
use crate::number::{Real, Vector, at_level};
use crate::scene::touch::check_pairs;
use alloc::vec::Vec;
use fearless_simd::Level;

/// A pair that may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub(crate) particles: [u32; 2],
    /// Where the numbers of both are in a column of vectors.
    pub(crate) at: [u32; 2],
    /// The place of its law.
    pub(crate) law: u32,
}

/// The list and what it is made with. Empty where nothing has a radius.
#[derive(Clone, Debug, Default)]
pub(crate) struct Near<R: Real> {
    pairs: Vec<Pair>,
    /// The positions at which it was made; empty where there is no list.
    from: Vec<R>,
    /// How much closer than when it was made pairs may be, metres.
    skin: f64,
    /// Records with particles that have a radius, and which lanes have one.
    records: Vec<(u32, [bool; LANES])>,
    /// How far two particles come closer in a substep at most, metres.
    stride: f64,
    grid: Grid,
    found: Vec<u32>,
}

/// The skin of a list, as a part of the largest sum of radii, and the largest skin that fast
/// particles get.
const SKIN: f64 = 0.5;
const LARGEST_SKIN: f64 = 2.0;

impl<R: Real> Near<R> {
    /// Discards the list: particles or laws are other ones.
    pub(crate) fn forget(&mut self) {
        self.from.clear();
        self.records.clear();
    }

    /// The pairs that may touch at these positions.
    pub(crate) fn pairs(&mut self, level: Level, touches: &Touches<R>, positions: &[R]) -> &[Pair] {
        if !self.holds(level, positions) {
            self.list(touches, positions);
        }
        &self.pairs
    }

    /// Sees the pairs that may touch at these positions.
    pub(crate) fn see<T>(
        &self,
        level: Level,
        touches: &Touches<R>,
        positions: &[R],
        see: impl FnOnce(&[Pair]) -> T,
    ) -> T {
        match touches.is_empty() || self.holds(level, positions) {
            true => see(&self.pairs),
            false => see(Near::default().pairs(level, touches, positions)),
        }
    }

    /// Refuses particles of which too many lie within reach of each other.
    ///
    /// # Errors
    /// [`Error::TooLarge`].
    pub(crate) fn check(touches: &Touches<R>, positions: &[R]) -> Result<(), Error> {
        let (mut near, mut pairs) = (Near::default(), 0);
        near.fill(touches, positions);
        for ball in 0..touches.balls.len() {
            near.find(touches, positions, ball);
            pairs += near.found.len();
            check_pairs(pairs, touches.balls.len())?;
        }
        Ok(())
    }

    fn holds(&self, level: Level, positions: &[R]) -> bool {
        // Less than all of the skin: what rounding is worth.
        let most = R::of(0.99 * self.skin);
        !self.from.is_empty()
            && at_level!(level, _simd => wear(&self.records, &self.from, positions)) <= most * most
    }

    fn list(&mut self, touches: &Touches<R>, positions: &[R]) {
        let reach = touches.largest_reach();
        self.skin = (SKIN * reach).max(2.0 * self.stride).min(LARGEST_SKIN * reach);
        self.from.clear();
        self.from.extend_from_slice(positions);
        if self.records.is_empty() {
            self.records = records(touches);
        }
        self.pairs.clear();
        self.fill(touches, positions);
        for a in 0..touches.balls.len() {
            self.find(touches, positions, a);
            let Near { pairs, found, .. } = self;
            pairs.extend(found.iter().map(|&b| {
                let both = [a, b as usize].map(|ball| touches.balls[ball]);
                Pair {
                    particles: both.map(|ball| ball.particle),
                    at: both.map(|ball| ball.at),
                    law: touches.law_place(a, b as usize) as u32,
                }
            }));
        }
    }

    /// Puts all balls into cells.
    fn fill(&mut self, touches: &Touches<R>, positions: &[R]) {
        let points = touches.balls.iter().map(|ball| vector::<R>(positions, ball.at as usize));
        let width = touches.largest_reach() + self.skin;
        self.grid.fill(width, points.map(R::Vec3::to_f64));
    }

    /// Finds the balls of a higher number that may touch a ball.
    fn find(&mut self, touches: &Touches<R>, positions: &[R], a: usize) {
        let point = |ball: usize| vector::<R>(positions, touches.balls[ball].at as usize);
        let (here, skin) = (point(a), R::of(self.skin));
        self.grid.list_near(a, &mut self.found, |b| {
            let apart = point(b) - here;
            touches.laws[touches.law_place(a, b)].is_some_and(|law| {
                let most = law.reach + skin;
                apart.dot(apart) < most * most
            })
        });
        self.found.retain(|&b| !touches.spared_of(a).contains(&b));
    }

    /// Takes note of the length of a substep, seconds, and counts the pairs that may pass through
    /// each other in the next one: that close by more than the sum of their radii. Where particles
    /// are so fast that the list would have to be far larger, one.
    pub(crate) fn count_passes(
        &mut self,
        level: Level,
        touches: &Touches<R>,
        [positions, velocities]: [&[R]; 2],
        h: f64,
    ) -> u64 {
        if self.from.is_empty() {
            self.list(touches, positions);
        }
        let fast = at_level!(level, _simd => spread(&self.records, velocities)).to_f64();
        self.stride = h * Real::sqrt(fast);
        let least = touches.laws.iter().flatten().map(|law| law.reach.to_f64());
        if self.stride <= least.fold(f64::INFINITY, f64::min) {
            return 0;
        }
        if LARGEST_SKIN * touches.largest_reach() < self.stride {
            // Too many to look at each: something may have.
            return 1;
        }
        if self.skin < self.stride {
            self.list(touches, positions);
        }
        let passes = self.pairs.iter().filter(|pair| {
            let [a, b] = pair.at.map(|at| at as usize);
            let apart = (vector::<R>(positions, b) - vector::<R>(positions, a)).to_f64();
            let way = (vector::<R>(velocities, b) - vector::<R>(velocities, a)).to_f64() * h;
            let law = touches.laws[pair.law as usize].as_ref();
            let reach = law.map_or(f64::INFINITY, |law| law.reach.to_f64());
            passes(apart, way, reach)
        });
        passes.count() as u64
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

/// The records with balls in them.
fn records<R: Real>(touches: &Touches<R>) -> Vec<(u32, [bool; LANES])> {
    let mut at: Vec<u32> = touches.balls.iter().map(|ball| ball.at).collect();
    at.sort_unstable();
    let mut records: Vec<(u32, [bool; LANES])> = Vec::new();
    for at in at {
        let record = at / RECORD as u32;
        if records.last().is_none_or(|last| last.0 != record) {
            records.push((record, [false; LANES]));
        }
        let last = records.last_mut().expect("one was pushed");
        last.1[at as usize % RECORD] = true;
    }
    records
}

/// The square of the diagonal of the box around all displacements.
#[inline(always)]
fn wear<R: Real>(records: &[(u32, [bool; LANES])], from: &[R], to: &[R]) -> R {
    diagonal(records, |at| to[at] - from[at])
}

/// The square of the diagonal of the box around all vectors of a column.
#[inline(always)]
fn spread<R: Real>(records: &[(u32, [bool; LANES])], column: &[R]) -> R {
    diagonal(records, |at| column[at])
}

/// The square of the diagonal of the box around vectors.
#[inline(always)]
fn diagonal<R: Real>(records: &[(u32, [bool; LANES])], number: impl Fn(usize) -> R) -> R {
    let mut square = R::ZERO;
    for axis in 0..3 {
        let mut low = [R::LARGEST; LANES];
        let mut high = [-R::LARGEST; LANES];
        for (record, is_ball) in records {
            let at = *record as usize * RECORD + axis * LANES;
            for lane in 0..LANES {
                let x = number(at + lane);
                low[lane] = if is_ball[lane] & (x < low[lane]) { x } else { low[lane] };
                high[lane] = if is_ball[lane] & (high[lane] < x) { x } else { high[lane] };
            }
        }
        let low = low.into_iter().fold(R::LARGEST, R::min);
        let high = high.into_iter().fold(-R::LARGEST, R::max);
        let side = high - low;
        square += side * side;
    }
    square
}
