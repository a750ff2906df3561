//! What does an implicit method do to a slice? It multiplies with its part of the matrix, and moves
//! its part of a solution on.
//!
//! The products have the bits of [`crate::tangent`]: each spring is met from both ends, in the
//! order of the model. A sum over all particles, as of the scalar product of
//! two columns, is one sum in `f64` for each lane of a part, whatever the instructions.

use super::columns::Start;
use super::links::{Link, damp, linearise, rows};
use super::pack::{Pack, Triple};
use super::sweep::{Job, reached};
use super::{LANES, RECORD};
use crate::real::Real;
use core::ops::Range;

/// Columns of a solve: mass, drag and grabs; momentum still missing; the change of velocity found;
/// where it goes next, and what the matrix makes of that; the residual times the blocks.
pub(super) const DIAGONAL: usize = 0;
pub(super) const RESIDUAL: usize = 1;
pub(super) const CHANGE: usize = 4;
pub(super) const DIRECTION: usize = 7;
pub(super) const PRODUCT: usize = 10;
const AIM: usize = 13;
/// Inverses of the blocks of particles, six numbers each, and what contact leaves of them.
pub(super) const INVERSE: usize = 16;
pub(super) const HELD: usize = 22;
/// How many columns that is.
pub(super) const COLUMNS: usize = 28;

/// Slices for each row of a plan: direction, weight along and weight across.
pub(super) const LINK: usize = 5;

/// What a task needs to know.
#[derive(Clone, Copy)]
pub(super) struct Matrix<'a, R: Real> {
    /// From is a motion for [`Task::Linearise`] and [`Task::Damp`], the direction for others; own
    /// are the columns of the solve.
    pub(super) job: Job<'a, R>,
    pub(super) links: Start<R>,
    /// The first column of the blocks that steer: [`INVERSE`] or [`HELD`].
    pub(super) blocks: usize,
}

/// What is done to all slices before anything else is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Task<R> {
    /// Makes the matrix about a motion for a stage of `tau` seconds.
    Linearise { tau: R },
    /// Starts in the direction of the residual times the blocks; sums its product with that.
    Aim,
    /// Multiplies the direction with the matrix; sums its product with the direction.
    Multiply,
    /// Goes so far; sums as [`Task::Aim`] does.
    Descend { distance: R },
    /// Turns to the residual times the blocks and keeps so much of the direction.
    Turn { keep: R },
    /// Sums the power that dampers take away, watts, each met from both ends.
    Damp,
}

/// Does a task to the slices of a range.
///
/// # Safety
/// See [`super::sweep::sweep`]; there are [`COLUMNS`] columns, and [`LINK`] slices for each row.
#[inline(always)]
pub(super) unsafe fn run<R: Real, P: Pack<R>, const GATHERS: bool>(
    matrix: &Matrix<'_, R>,
    task: Task<R>,
    slices: Range<usize>,
) -> f64 {
    let mut sums = [0.0; LANES];
    // SAFETY: the caller's promise.
    unsafe {
        match task {
            Task::Linearise { tau } => linearise::<R, P, GATHERS>(matrix, tau, slices),
            Task::Aim => aim::<R, P, GATHERS>(matrix, slices, &mut sums),
            Task::Multiply => multiply::<R, P, GATHERS>(matrix, slices, &mut sums),
            Task::Descend { distance } => descend::<R, P>(matrix, distance, slices, &mut sums),
            Task::Turn { keep } => turn::<R, P, GATHERS>(matrix, keep, slices),
            Task::Damp => damp::<R, P, GATHERS>(matrix, slices, &mut sums),
        }
    }
    sums.iter().sum()
}

/// # Safety
/// See [`run`].
#[inline(always)]
unsafe fn multiply<R: Real, P: Pack<R>, const GATHERS: bool>(
    matrix: &Matrix<'_, R>,
    slices: Range<usize>,
    sums: &mut [f64; LANES],
) {
    let job = &matrix.job;
    for slice in slices {
        let (first, rows) = rows(matrix, slice);
        let mut lane = 0;
        while lane < LANES {
            let slot = slice * LANES + lane;
            // SAFETY: the caller's promise; the rows of a plan name what is there.
            unsafe {
                let here = Triple::<P>::load(job.from, 0, slot);
                let mut product = here * P::load(job.own.at(DIAGONAL, slot));
                for (number, row) in rows.iter().enumerate() {
                    let (there, _) = reached::<R, P, false, GATHERS>(job, slot, row.reach);
                    let Link { direction, along, across } =
                        Link::<P>::load(matrix.links, first + number, lane);
                    let apart = there - here;
                    // Where there is no spring, its weights are zero.
                    let pull = apart * across + direction * (along * direction.dot(apart));
                    product = product - pull;
                }
                product.store::<R>(job.own, PRODUCT, slot);
                here.dot(product).add_to(&mut sums[lane..]);
            }
            lane += P::COUNT;
        }
    }
}

/// # Safety
/// See [`run`].
#[inline(always)]
unsafe fn aim<R: Real, P: Pack<R>, const GATHERS: bool>(
    matrix: &Matrix<'_, R>,
    slices: Range<usize>,
    sums: &mut [f64; LANES],
) {
    let mut slot = slices.start * LANES;
    while slot < slices.end * LANES {
        // SAFETY: the caller's promise.
        unsafe {
            let residual = Triple::<P>::load(matrix.job.own, RESIDUAL, slot);
            let aim = steered::<R, P>(matrix, slot, residual);
            set_direction::<R, P, GATHERS>(&matrix.job, slot, aim);
            residual.dot(aim).add_to(&mut sums[slot % LANES..]);
        }
        slot += P::COUNT;
    }
}

/// # Safety
/// See [`run`].
#[inline(always)]
unsafe fn descend<R: Real, P: Pack<R>>(
    matrix: &Matrix<'_, R>,
    distance: R,
    slices: Range<usize>,
    sums: &mut [f64; LANES],
) {
    let own = matrix.job.own;
    let mut slot = slices.start * LANES;
    while slot < slices.end * LANES {
        // SAFETY: the caller's promise.
        unsafe {
            let distance = P::splat(distance);
            let direction = Triple::<P>::load(own, DIRECTION, slot);
            let change = Triple::load(own, CHANGE, slot) + direction * distance;
            change.store::<R>(own, CHANGE, slot);
            let product = Triple::<P>::load(own, PRODUCT, slot);
            let residual = Triple::load(own, RESIDUAL, slot) - product * distance;
            residual.store::<R>(own, RESIDUAL, slot);
            let aim = steered::<R, P>(matrix, slot, residual);
            aim.store::<R>(own, AIM, slot);
            residual.dot(aim).add_to(&mut sums[slot % LANES..]);
        }
        slot += P::COUNT;
    }
}

/// # Safety
/// See [`run`].
#[inline(always)]
unsafe fn turn<R: Real, P: Pack<R>, const GATHERS: bool>(
    matrix: &Matrix<'_, R>,
    keep: R,
    slices: Range<usize>,
) {
    let own = matrix.job.own;
    let mut slot = slices.start * LANES;
    while slot < slices.end * LANES {
        // SAFETY: the caller's promise.
        unsafe {
            let before = Triple::<P>::load(own, DIRECTION, slot);
            let direction = Triple::load(own, AIM, slot) + before * P::splat(keep);
            set_direction::<R, P, GATHERS>(&matrix.job, slot, direction);
        }
        slot += P::COUNT;
    }
}

/// The product of blocks and vectors.
///
/// # Safety
/// See [`run`].
#[inline(always)]
unsafe fn steered<R: Real, P: Pack<R>>(
    matrix: &Matrix<'_, R>,
    slot: usize,
    vector: Triple<P>,
) -> Triple<P> {
    let blocks = matrix.job.own.from(matrix.blocks);
    // SAFETY: the caller's promise.
    unsafe {
        let Triple { x: xx, y: xy, z: xz } = Triple::<P>::load(blocks, 0, slot);
        let Triple { x: yy, y: yz, z: zz } = Triple::<P>::load(blocks, 3, slot);
        let column = |x, y, z| Triple { x, y, z };
        column(xx, xy, xz) * vector.x
            + column(xy, yy, yz) * vector.y
            + column(xz, yz, zz) * vector.z
    }
}

/// Writes where the solve goes next.
///
/// # Safety
/// See [`run`].
#[inline(always)]
unsafe fn set_direction<R: Real, P: Pack<R>, const GATHERS: bool>(
    job: &Job<'_, R>,
    slot: usize,
    direction: Triple<P>,
) {
    // SAFETY: the caller's promise; if there are gather rows, there is a record for each slot.
    unsafe {
        direction.store::<R>(job.own, DIRECTION, slot);
        if GATHERS {
            let Triple { x, y, z } = direction;
            P::scatter(job.records[1].add(slot * RECORD), [[x, y, z]; 2]);
        }
    }
}
