//! What happens to one slice? The springs of its rows pull, and its particles move on.
//!
//! A sweep reads one set of columns and writes another, so that the slices of a sweep may be done in
//! any order, and by any number of threads.

use super::columns::Start;
use super::contact::{self, Planes};
use super::pack::{Pack, Triple};
use super::plan::{Plan, Reach, Row};
use super::update::{self, Update};
use super::{LANES, RECORD};
use crate::real::{Real, Vector};
use core::ops::Range;

/// Columns of a motion: positions, then velocities.
pub(super) const POSITION: usize = 0;
pub(super) const VELOCITY: usize = 3;
/// Columns of what particles are: masses and their reciprocals.
pub(super) const MASS: usize = 0;
pub(super) const INVERSE_MASS: usize = 1;

/// What a sweep needs to know. All columns have as many slots as the plan.
#[derive(Clone, Copy)]
pub(super) struct Job<'a, R: Real> {
    pub(super) plan: &'a Plan<R>,
    /// What particles are.
    pub(super) fixed: Start<R>,
    /// The motion at which forces are evaluated.
    pub(super) from: Start<R>,
    /// What comes out: a motion, or forces.
    pub(super) to: Start<R>,
    /// What the method remembers about each particle.
    pub(super) own: Start<R>,
    /// Records of `from` and of `to`, if there are gather rows.
    pub(super) records: Option<[*mut R; 2]>,
    /// Gravitational acceleration and uniform force.
    pub(super) fields: [R::Vec3; 2],
    pub(super) drag: R,
    /// Forces on single particles by slot, in the order in which they are added.
    pub(super) pushes: &'a [(u32, R::Vec3)],
    pub(super) planes: &'a [Planes<R>],
    pub(super) update: Update<R>,
}

/// What a part of a sweep came to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    /// Power taken away by dampers and drag, watts.
    pub(super) power: f64,
    /// Particles moved out of a plane.
    pub(super) contacts: usize,
    /// Energy taken away by contact, joules.
    pub(super) energy: f64,
}

impl core::ops::AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.power += other.power;
        self.contacts += other.contacts;
        self.energy += other.energy;
    }
}

/// Sums of a part of a sweep, one per lane.
pub(super) struct Sums {
    /// Of dampers: each of them is met from both ends.
    dampers: [f64; LANES],
    drag: [f64; LANES],
    pub(super) energy: [f64; LANES],
    pub(super) contacts: usize,
}

/// Some particles of a slice, one per lane.
#[derive(Clone, Copy)]
pub(super) struct Particles<P> {
    /// The first slot.
    pub(super) slot: usize,
    pub(super) position: Triple<P>,
    pub(super) velocity: Triple<P>,
    pub(super) force: Triple<P>,
    pub(super) mass: P,
    pub(super) inverse_mass: P,
}

/// Does the slices of a range.
///
/// # Safety
/// The processor has the instructions of the pack. Nobody else writes what the job reads, nor reads
/// or writes what it writes to these slices.
#[inline(always)]
pub(super) unsafe fn sweep<R: Real, P: Pack<R>, const DAMPED: bool>(
    job: &Job<'_, R>,
    slices: Range<usize>,
) -> Tally {
    let mut sums =
        Sums { dampers: [0.0; LANES], drag: [0.0; LANES], energy: [0.0; LANES], contacts: 0 };
    for slice in slices {
        let starts = &job.plan.starts[slice..slice + 2];
        let rows = if job.update.evaluates() { starts[0] as usize..starts[1] as usize } else { 0..0 };
        let rows = &job.plan.rows[rows];
        let mut lane = 0;
        while lane < LANES {
            let slot = slice * LANES + lane;
            // SAFETY: the caller's promise; the slot is one of the plan.
            unsafe {
                let particles = pulled::<R, P, DAMPED>(job, slot, rows, &mut sums);
                update::apply(job, particles, &mut sums);
            }
            lane += P::COUNT;
        }
        if let (Some([_, records]), true) = (job.records, job.update != Update::Forces) {
            // SAFETY: as above.
            unsafe { write_records(job.to, records, slice) };
        }
    }
    let sum = |lanes: [f64; LANES]| lanes.iter().sum::<f64>();
    let power = 0.5 * sum(sums.dampers) + sum(sums.drag);
    Tally { power, contacts: sums.contacts, energy: sum(sums.energy) }
}

/// Some particles with the forces on them.
///
/// # Safety
/// See [`sweep`].
#[inline(always)]
unsafe fn pulled<R: Real, P: Pack<R>, const DAMPED: bool>(
    job: &Job<'_, R>,
    slot: usize,
    rows: &[Row],
    sums: &mut Sums,
) -> Particles<P> {
    // SAFETY: the caller's promise, for all loads.
    let (position, velocity, mass, inverse_mass, zero) = unsafe {
        (
            Triple::<P>::load(job.from, POSITION, slot),
            Triple::<P>::load(job.from, VELOCITY, slot),
            P::load(job.fixed.at(MASS, slot)),
            P::load(job.fixed.at(INVERSE_MASS, slot)),
            P::splat(R::ZERO),
        )
    };
    let [gravity, uniform] = job.fields;
    // SAFETY: as above.
    let (gravity, uniform) = unsafe { (Triple::<P>::splat(gravity), Triple::splat(uniform)) };
    let mut force = gravity * mass + uniform;
    if !job.pushes.is_empty() {
        // SAFETY: as above.
        force = unsafe { pushed(job, slot, force) };
    }
    if job.drag != R::ZERO {
        // SAFETY: as above.
        let drag = unsafe { P::splat(job.drag) };
        force = force - velocity * drag;
        (drag * velocity.dot(velocity)).add_to(&mut sums.drag[slot % LANES..]);
    }
    let mut dampers = zero;
    // SAFETY: as above.
    let shortest = unsafe { P::splat(R::SHORTEST_SQUARED) };
    // SAFETY: as above.
    let one = unsafe { P::splat(R::ONE) };
    for row in rows {
        // SAFETY: as above; the rows of a plan name what is there.
        unsafe {
            let lane = slot % LANES;
            let value = |place: u32| {
                job.plan.values.as_ptr().add(place as usize).cast::<R>().add(lane)
            };
            let (there, there_velocity) = reached::<R, P, DAMPED>(job, slot, row.reach);
            let across = there - position;
            let squared = across.dot(across);
            let acts = squared.not_less(shortest, P::mask(row.mask >> lane));
            let length = squared.sqrt();
            let per_length = one / length;
            let tension =
                P::load(value(row.stiffness)) * (length - P::load(value(row.rest_length)));
            if DAMPED {
                let rate = across.dot(there_velocity - velocity) * per_length;
                let drag = P::load(value(row.damping)) * rate;
                let pull = across * ((tension + drag) * per_length);
                force = force.add_where::<R>(acts, pull);
                dampers = dampers.add_where(acts, drag * rate);
            } else {
                force = force.add_where::<R>(acts, across * (tension * per_length));
            }
        }
    }
    if DAMPED {
        dampers.add_to(&mut sums.dampers[slot % LANES..]);
    }
    Particles { slot, position, velocity, force, mass, inverse_mass }
}

/// Positions and velocities at the other ends of a row.
///
/// # Safety
/// See [`sweep`].
#[inline(always)]
unsafe fn reached<R: Real, P: Pack<R>, const DAMPED: bool>(
    job: &Job<'_, R>,
    slot: usize,
    reach: Reach,
) -> (Triple<P>, Triple<P>) {
    // SAFETY: a run ends less than a slice beyond the slots, where columns go on; a gather has
    // records, and names those of slots.
    unsafe {
        match (reach, job.records) {
            (Reach::Gather(row), Some([records, _])) => {
                let at = job.plan.others.as_ptr().add(row as usize).cast::<u32>();
                let at = at.add(slot % LANES);
                let there = Triple::of(P::gather(records, at));
                let velocity =
                    if DAMPED { Triple::of(P::gather(records.add(RECORD / 2), at)) } else { there };
                (there, velocity)
            }
            (Reach::Run(offset), _) => {
                let slot = slot.wrapping_add_signed(offset as isize);
                let there = Triple::load(job.from, POSITION, slot);
                (there, if DAMPED { Triple::load(job.from, VELOCITY, slot) } else { there })
            }
            (Reach::Gather(_), None) => core::hint::unreachable_unchecked(),
        }
    }
}

/// Adds what pushes single particles.
///
/// # Safety
/// See [`sweep`].
#[cold]
unsafe fn pushed<R: Real, P: Pack<R>>(
    job: &Job<'_, R>,
    slot: usize,
    mut force: Triple<P>,
) -> Triple<P> {
    let begin = job.pushes.partition_point(|&(at, _)| (at as usize) < slot);
    for &(at, push) in &job.pushes[begin..] {
        let lane = at as usize - slot;
        if P::COUNT <= lane {
            break;
        }
        // Minus zero changes nothing, not even the sign of a zero.
        let mut lanes = [[-R::ZERO; LANES]; 3];
        for (column, component) in lanes.iter_mut().zip(push.components()) {
            column[lane] = component;
        }
        // SAFETY: no pack is longer than the columns.
        let push = unsafe { lanes.map(|column| P::load(column.as_ptr())) };
        force = force + Triple::of(push);
    }
    force
}

/// Copies what a slice has become into its records.
///
/// # Safety
/// See [`sweep`].
#[inline(always)]
unsafe fn write_records<R: Real>(columns: Start<R>, records: *mut R, slice: usize) {
    for lane in 0..LANES {
        let slot = slice * LANES + lane;
        for component in 0..3 {
            // SAFETY: there is a record for each slot.
            unsafe {
                let record = records.add(slot * RECORD + component);
                *record = *columns.at(POSITION + component, slot);
                *record.add(RECORD / 2) = *columns.at(VELOCITY + component, slot);
            }
        }
    }
}

/// Keeps particles out of the planes and says what that took.
///
/// # Safety
/// See [`sweep`].
#[inline(always)]
pub(super) unsafe fn collide<R: Real, P: Pack<R>>(
    job: &Job<'_, R>,
    particles: &mut Particles<P>,
    sums: &mut Sums,
) {
    for plane in job.planes {
        // SAFETY: the caller's promise.
        unsafe { contact::resolve(plane, particles, sums) };
    }
}
