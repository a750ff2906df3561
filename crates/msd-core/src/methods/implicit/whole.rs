//! Coarse space of the implicit solve: translations of whole bodies, which no tolerance may lose.
//!
//! Springs, bends and volumes push no body as a whole. For particles held together by these, the
//! product of the matrix with a translation c is D c, with D the masses, drag and grabs. So the sum
//! that a solve has to reach is known beforehand, Σ r = Σ D δu, and c = Σ (r − D δu) / Σ D is the
//! translation that a δu lacks. Conjugate gradients find it last of all, and in single precision at
//! k τ²/m = 4e5 never: the weight of a particle is a rounding beside the stiffness. Here it is
//! added before the solve and corrected after it.
//!
//! A body that obstacles hold moves in the directions that are left to it, one that is pinned not
//! at all.

use super::conjugate::Solve;
use super::resting::Holds;
use crate::columns::{LANES, RECORD, single};
use crate::number::{Real, Vector, at_level};
use crate::system::Model;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use fearless_simd::Level;
use glam::DVec3;

/// Particles that springs, bends and volumes join to each other and to no others, two or
/// more: one alone is solved by its block.
#[derive(Clone, Debug, Default)]
struct Whole {
    /// Its range of the shares.
    shares: Range<usize>,
    /// Whether nothing of it is pinned.
    is_free: bool,
    /// Σ r, newton seconds.
    asked: DVec3,
    /// Σ D, kilograms.
    weight: f64,
    /// Friction on sliding particles, newton seconds.
    friction: DVec3,
    /// Directions in which obstacles hold it, of length one, and their number.
    axes: [DVec3; 3],
    held: usize,
}

/// The share of a body in a record: its lanes, a bit for each.
#[derive(Clone, Copy, Debug)]
struct RecordLanes {
    record: u32,
    lanes: u32,
}

/// The bodies of a model.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wholes {
    rows: Vec<Whole>,
    /// The shares of bodies in records, body by body.
    shares: Vec<RecordLanes>,
    /// The row of each particle, by the number of its slot.
    row_of: Vec<u32>,
    /// The rows of each kind that there were when bodies were sought.
    joints: Option<[usize; 3]>,
    /// Whether the changes are zero yet.
    is_fresh: bool,
}

/// All lanes of a record.
const ALL: u32 = (1 << LANES) - 1;
/// The row of a particle alone.
const NONE: u32 = u32::MAX;

impl Wholes {
    /// Updates the bodies for cuts and pins since the step before.
    pub(crate) fn find<R: Real>(&mut self, model: &Model<R>) {
        let joints = Some(model.inner().map(|kind| kind.count()));
        if self.joints != joints {
            self.joints = joints;
            self.seek(model);
        }
        // Others may push a body as a whole by any matrix.
        let may_be_free = model.other().into_iter().all(|kind| kind.count() == 0);
        let records = model.inverse_mass_column.as_chunks::<RECORD>().0;
        let moves = |share: &RecordLanes| {
            let w = &records[share.record as usize];
            (0..LANES).all(|lane| !share.has(lane) || w[lane] != R::ZERO)
        };
        for whole in &mut self.rows {
            whole.is_free = may_be_free && self.shares[whole.shares.clone()].iter().all(moves);
        }
    }

    /// Lists the bodies in the order of their first particles.
    fn seek<R: Real>(&mut self, model: &Model<R>) {
        let count = model.particle_count();
        // For each particle, a connected one of lower number, or itself.
        let mut lower: Vec<u32> = (0..count as u32).collect();
        let mut join = |ends: [u32; 2]| {
            let [a, b] = ends.map(|end| first_of(&mut lower, end));
            lower[a.max(b) as usize] = a.min(b);
        };
        model.inner().into_iter().for_each(|kind| kind.each_pair(&mut join));
        let mut is_joined = vec![false; count];
        for particle in 0..count as u32 {
            let first = first_of(&mut lower, particle);
            is_joined[first as usize] |= first != particle;
        }
        self.row_of.clear();
        self.row_of.resize(model.slots.record_count() * LANES, NONE);
        let mut rows = 0;
        for (particle, at) in model.slots.places().enumerate() {
            let first = lower[particle] as usize;
            self.row_of[single(at)] = self.row_of[single(model.slots.at(first))];
            if first == particle && is_joined[particle] {
                self.row_of[single(at)] = rows;
                rows += 1;
            }
        }
        self.list_shares(rows as usize);
    }

    fn list_shares(&mut self, rows: usize) {
        let mut shares: Vec<(u32, RecordLanes)> = Vec::new();
        for (record, lanes) in self.row_of.as_chunks::<LANES>().0.iter().enumerate() {
            let start = shares.len();
            for (lane, &row) in lanes.iter().enumerate().filter(|&(_, &row)| row != NONE) {
                match shares[start..].iter_mut().find(|share| share.0 == row) {
                    Some((_, share)) => share.lanes |= 1 << lane,
                    None => {
                        shares.push((row, RecordLanes { record: record as u32, lanes: 1 << lane }))
                    }
                }
            }
        }
        shares.sort_by_key(|&(row, _)| row);
        let mut end = 0;
        self.rows.clear();
        self.rows.extend((0..rows as u32).map(|row| {
            let start = end;
            end += shares[start..].partition_point(|share| share.0 == row);
            Whole { shares: start..end, ..Whole::default() }
        }));
        self.shares = shares.into_iter().map(|(_, share)| share).collect();
    }

    /// Whether every body is pinned.
    pub(crate) fn is_empty(&self) -> bool {
        !self.rows.iter().any(|whole| whole.is_free)
    }

    /// Sums the residuals of all forces but those of springs, bends and volumes, before anything is
    /// changed, and the diagonal of the matrix.
    pub(crate) fn begin<R: Real>(&mut self, level: Level, residuals: &[R], diagonals: &[R]) {
        self.is_fresh = true;
        for whole in self.rows.iter_mut().filter(|whole| whole.is_free) {
            let shares = &self.shares[whole.shares.clone()];
            whole.asked = at_level!(level, _simd => sum(shares, residuals));
            whole.weight = at_level!(level, _simd => sum(shares, diagonals)).x;
        }
    }

    /// Adds impulses, newton seconds, to the right-hand side of the changes that were made.
    pub(crate) fn give<R: Real>(&mut self, level: Level, impulses: &[R]) {
        self.is_fresh = false;
        for whole in self.rows.iter_mut().filter(|whole| whole.is_free) {
            let shares = &self.shares[whole.shares.clone()];
            whole.asked += at_level!(level, _simd => sum(shares, impulses));
        }
    }

    /// Adds to the changes of velocity the translation of each whole body that they lack.
    pub(crate) fn shift<R: Real>(
        &mut self,
        level: Level,
        holds: &Holds<R>,
        diagonals: &[R],
        solve: &mut Solve<R>,
    ) {
        if self.is_empty() {
            return;
        }
        self.rows.iter_mut().for_each(|whole| (whole.held, whole.friction) = (0, DVec3::ZERO));
        for (at, axes, friction) in holds.directions() {
            if let Some(whole) = self.rows.get_mut(self.row_of[single(at)] as usize) {
                axes.into_iter().for_each(|axis| whole.hold(axis));
                whole.friction += friction;
            }
        }
        let Solve { changes, residuals, .. } = solve;
        for whole in self.rows.iter().filter(|whole| whole.is_free && whole.held < 3) {
            let shares = &self.shares[whole.shares.clone()];
            let mut lacking = whole.asked + whole.friction;
            if !self.is_fresh {
                lacking -= at_level!(level, _simd => sum_products(shares, changes, diagonals));
            }
            let lacking = whole.free(lacking);
            let shift = R::Vec3::of(lacking / whole.weight).components();
            at_level!(level, _simd => add_shift(shares, shift, diagonals, changes, residuals));
        }
        self.is_fresh = false;
    }
}

/// The sum of a column over a body.
#[inline(always)]
fn sum<R: Real>(shares: &[RecordLanes], column: &[R]) -> DVec3 {
    let records = column.as_chunks::<RECORD>().0;
    sum_of(shares, |record| {
        let numbers = &records[record];
        move |i| numbers[i].to_f64()
    })
}

/// The sum of the products of two columns over a body.
#[inline(always)]
fn sum_products<R: Real>(shares: &[RecordLanes], a: &[R], b: &[R]) -> DVec3 {
    let (a, b) = (a.as_chunks::<RECORD>().0, b.as_chunks::<RECORD>().0);
    sum_of(shares, |record| {
        let (a, b) = (&a[record], &b[record]);
        move |i| a[i].to_f64() * b[i].to_f64()
    })
}

/// Sums numbers, given by record and place in it, in an order that depends on the layout alone.
#[inline(always)]
fn sum_of<F: Fn(usize) -> f64>(shares: &[RecordLanes], numbers: impl Fn(usize) -> F) -> DVec3 {
    let mut sums = [0.0; RECORD];
    for share in shares {
        let number = numbers(share.record as usize);
        if share.lanes == ALL {
            for (i, sum) in sums.iter_mut().enumerate() {
                *sum += number(i);
            }
        } else {
            for i in (0..RECORD).filter(|i| share.has(i % LANES)) {
                sums[i] += number(i);
            }
        }
    }
    let [x, y, z] = [0, 1, 2].map(|axis| sums[axis * LANES..][..LANES].iter().sum());
    DVec3::new(x, y, z)
}

/// Adds a translation to the changes of a body, and subtracts its product with the matrix from the
/// residuals.
#[inline(always)]
fn add_shift<R: Real>(
    shares: &[RecordLanes],
    shift: [R; 3],
    diagonals: &[R],
    changes: &mut [R],
    residuals: &mut [R],
) {
    for share in shares {
        let record = share.record as usize;
        let diagonals = &diagonals.as_chunks::<RECORD>().0[record];
        let changes = &mut changes.as_chunks_mut::<RECORD>().0[record];
        let residuals = &mut residuals.as_chunks_mut::<RECORD>().0[record];
        for (axis, &shift) in shift.iter().enumerate() {
            for lane in 0..LANES {
                let i = axis * LANES + lane;
                let shift = if share.has(lane) { shift } else { R::ZERO };
                changes[i] += shift;
                residuals[i] -= shift * diagonals[i];
            }
        }
    }
}

impl RecordLanes {
    #[inline(always)]
    fn has(self, lane: usize) -> bool {
        self.lanes >> lane & 1 == 1
    }
}

impl Whole {
    /// The part of a vector in the directions that are left.
    fn free(&self, vector: DVec3) -> DVec3 {
        self.axes[..self.held].iter().fold(vector, |rest, axis| rest - *axis * axis.dot(rest))
    }

    /// Holds a direction, unless it is a combination of those held.
    fn hold(&mut self, direction: DVec3) {
        let rest = self.free(direction);
        let length = Real::sqrt(rest.dot(rest));
        if self.held < 3 && SAME < length {
            self.axes[self.held] = rest * (1.0 / length);
            self.held += 1;
        }
    }
}

/// Length below which a direction is a combination of those before, up to rounding.
const SAME: f64 = 1e-6;

/// The first particle connected to one; shortens the path to it.
fn first_of(lower: &mut [u32], particle: u32) -> u32 {
    let mut at = particle;
    while lower[at as usize] != at {
        let next = lower[at as usize];
        lower[at as usize] = lower[next as usize];
        at = lower[at as usize];
    }
    at
}
