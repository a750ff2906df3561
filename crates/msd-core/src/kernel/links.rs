//! What do the springs of a slice add to the matrix of an implicit method? What [`crate::tangent`]
//! says, lane by lane, with the same numbers.

use super::LANES;
use super::columns::Start;
use super::pack::{Pack, Triple};
use super::plan::Row;
use super::solve::{DIAGONAL, INVERSE, LINK, Matrix};
use super::sweep::{Apart, INVERSE_MASS, Job, POSITION, VELOCITY};
use crate::real::Real;
use crate::tangent::{inverse, steady_inverse};
use core::ops::Range;

/// What the springs of a row add to the matrix; see [`crate::tangent`].
pub(super) struct Link<P> {
    pub(super) direction: Triple<P>,
    pub(super) along: P,
    pub(super) across: P,
}

impl<P: Copy> Link<P> {
    /// # Safety
    /// See [`super::solve::run`].
    #[inline(always)]
    pub(super) unsafe fn load<R: Real>(links: Start<R>, row: usize, lane: usize) -> Self
    where
        P: Pack<R>,
    {
        let at = |number: usize| links.at(0, (row * LINK + number) * LANES + lane).cast_const();
        // SAFETY: the caller's promise.
        unsafe {
            let direction = Triple { x: P::load(at(0)), y: P::load(at(1)), z: P::load(at(2)) };
            Link { direction, along: P::load(at(3)), across: P::load(at(4)) }
        }
    }

    /// # Safety
    /// See [`super::solve::run`].
    #[inline(always)]
    unsafe fn store<R: Real>(self, links: Start<R>, row: usize, lane: usize)
    where
        P: Pack<R>,
    {
        let Link { direction: Triple { x, y, z }, along, across } = self;
        for (number, value) in [x, y, z, along, across].into_iter().enumerate() {
            // SAFETY: the caller's promise.
            unsafe { value.store(links.at(0, (row * LINK + number) * LANES + lane)) };
        }
    }
}

/// The rows of a slice, and the number of the first.
#[inline(always)]
pub(super) fn rows<'a, R: Real>(matrix: &Matrix<'a, R>, slice: usize) -> (usize, &'a [Row]) {
    let plan = matrix.job.plan;
    let range = plan.starts[slice] as usize..plan.starts[slice + 1] as usize;
    (range.start, &plan.rows[range])
}

/// Makes the matrix of some slices.
///
/// # Safety
/// See [`super::solve::run`].
#[inline(always)]
pub(super) unsafe fn linearise<R: Real, P: Pack<R>, const GATHERS: bool>(
    matrix: &Matrix<'_, R>,
    tau: R,
    slices: Range<usize>,
) {
    let job = &matrix.job;
    for slice in slices {
        let (first, rows) = rows(matrix, slice);
        let mut blocks = [[R::ZERO; LANES]; 6];
        let mut lane = 0;
        while lane < LANES {
            let slot = slice * LANES + lane;
            // SAFETY: the caller's promise.
            unsafe {
                let here = (
                    Triple::<P>::load(job.from, POSITION, slot),
                    Triple::<P>::load(job.from, VELOCITY, slot),
                );
                let (diagonal, zero) = (P::load(job.own.at(DIAGONAL, slot)), P::splat(R::ZERO));
                let mut block = [diagonal, zero, zero, diagonal, zero, diagonal];
                for (number, row) in rows.iter().enumerate() {
                    let link = link::<R, P, GATHERS>(job, tau, (slot, here), row);
                    let Link { direction: u, along, across } = link;
                    let w = u * along;
                    let [xx, xy, xz, yy, yz, zz] = block;
                    block = [
                        xx + (w.x * u.x + across),
                        xy + w.x * u.y,
                        xz + w.x * u.z,
                        yy + (w.y * u.y + across),
                        yz + w.y * u.z,
                        zz + (w.z * u.z + across),
                    ];
                    link.store(matrix.links, first + number, lane);
                }
                for (column, numbers) in blocks.iter_mut().zip(block) {
                    numbers.store(column.as_mut_ptr().add(lane));
                }
            }
            lane += P::COUNT;
        }
        // SAFETY: the caller's promise.
        unsafe { invert(job, &blocks, slice * LANES) };
    }
}

/// What the springs of a row add to the matrix.
///
/// # Safety
/// See [`super::solve::run`].
#[inline(always)]
unsafe fn link<R: Real, P: Pack<R>, const GATHERS: bool>(
    job: &Job<'_, R>,
    tau: R,
    (slot, motion): (usize, (Triple<P>, Triple<P>)),
    row: &Row,
) -> Link<P> {
    let lane = slot % LANES;
    // SAFETY: the caller's promise; the rows of a plan name what is there.
    unsafe {
        let Apart { across: apart, parting, squared, acts } =
            Apart::of::<R, true, GATHERS>(job, (slot, motion), row);
        let (zero, tau) = (P::splat(R::ZERO), P::splat(tau));
        let length = squared.sqrt();
        let per_length = P::splat(R::ONE) / length;
        let direction = apart * per_length;
        let rate = direction.dot(parting);
        let rest_length = P::load(job.plan.value(row.rest_length, lane));
        let stiffness = P::load(job.plan.value(row.stiffness, lane));
        let damping = P::load(job.plan.value(row.damping, lane));
        let tension = stiffness * (length - rest_length) + damping * rate;
        let stretched = tension * per_length;
        let pulls = zero.select(stretched.less(zero, P::mask(u16::MAX)), stretched);
        let across = tau * tau * pulls;
        let along = tau * (tau * stiffness + damping) - across;
        let none = Triple { x: zero, y: zero, z: zero };
        Link {
            direction: direction.select::<R>(acts, none),
            along: along.select(acts, zero),
            across: across.select(acts, zero),
        }
    }
}

/// Writes the inverses of the blocks of a slice: plain loops over lanes, since they are in double
/// precision whatever the pack.
///
/// # Safety
/// See [`super::solve::run`].
#[inline(always)]
unsafe fn invert<R: Real>(job: &Job<'_, R>, blocks: &[[R; LANES]; 6], slot: usize) {
    // SAFETY: the caller's promise: there are so many slots.
    let inverse_masses = unsafe { &*job.fixed.at(INVERSE_MASS, slot).cast::<[R; LANES]>() };
    let mut inverses = [[R::ZERO; LANES]; 6];
    let mut sound = [true; LANES];
    for lane in 0..LANES {
        let block: [f64; 6] = core::array::from_fn(|number| blocks[number][lane].to_f64());
        let (found, is_sound) = inverse::<R>(block);
        let pinned = inverse_masses[lane] == R::ZERO;
        for (column, found) in inverses.iter_mut().zip(found) {
            column[lane] = if pinned { R::ZERO } else { R::of(found) };
        }
        sound[lane] = is_sound | pinned;
    }
    if sound != [true; LANES] {
        steady(blocks, sound, &mut inverses);
    }
    for (number, column) in inverses.iter().enumerate() {
        // SAFETY: as above.
        unsafe { *job.own.at(INVERSE + number, slot).cast::<[R; LANES]>() = *column };
    }
}

/// Inverts the blocks that rounding left without an inverse.
#[cold]
fn steady<R: Real>(blocks: &[[R; LANES]; 6], sound: [bool; LANES], inverses: &mut [[R; LANES]; 6]) {
    for lane in (0..LANES).filter(|&lane| !sound[lane]) {
        let found = steady_inverse::<R>(blocks.map(|column| column[lane].to_f64()));
        for (column, found) in inverses.iter_mut().zip(found) {
            column[lane] = R::of(found);
        }
    }
}

/// Sums the power that dampers take away.
///
/// # Safety
/// See [`super::solve::run`].
#[inline(always)]
pub(super) unsafe fn damp<R: Real, P: Pack<R>, const GATHERS: bool>(
    matrix: &Matrix<'_, R>,
    slices: Range<usize>,
    sums: &mut [f64; LANES],
) {
    let job = &matrix.job;
    for slice in slices {
        let (_, rows) = rows(matrix, slice);
        let mut lane = 0;
        while lane < LANES {
            let slot = slice * LANES + lane;
            // SAFETY: the caller's promise; the rows of a plan name what is there.
            unsafe {
                let position = Triple::<P>::load(job.from, POSITION, slot);
                let velocity = Triple::<P>::load(job.from, VELOCITY, slot);
                let mut power = P::splat(R::ZERO);
                for row in rows {
                    let at = (slot, (position, velocity));
                    let Apart { across: apart, parting, squared, acts } =
                        Apart::of::<R, true, GATHERS>(job, at, row);
                    let parting = apart.dot(parting);
                    let damping = P::load(job.plan.value(row.damping, lane));
                    power = power.add_where(acts, damping * (parting * parting / squared));
                }
                power.add_to(&mut sums[lane..]);
            }
            lane += P::COUNT;
        }
    }
}
