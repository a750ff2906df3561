//! What happens to one slice? The springs of its rows pull, and its particles move on.
//!
//! A sweep reads one set of columns and writes another, so that its slices may be done in any order
//! and by any number of threads.

use super::columns::Start;
use super::contact::Planes;
use super::pack::{Pack, Triple};
use super::plan::{Plan, Reach, Row};
use super::update::Apply;
use super::{LANES, RECORD};
use crate::real::{Real, Vector};
use core::ops::Range;

/// Columns of a motion: positions, then velocities.
pub(super) const POSITION: usize = 0;
pub(super) const VELOCITY: usize = 3;
/// Columns of what particles are: masses and their reciprocals.
pub(super) const MASS: usize = 0;
pub(super) const INVERSE_MASS: usize = 1;

/// A force on a single particle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push<R: Real> {
    pub(super) slot: u32,
    /// Which one it is of those on a particle.
    pub(super) number: u32,
    pub(super) force: R::Vec3,
}

/// What a sweep needs to know. All columns have at least as many slots as the plan.
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
    /// Records of `from` and of `to`, which are there if there are gather rows.
    pub(super) records: [*mut R; 2],
    /// Whether there are more records than the nearer caches hold.
    pub(super) far: bool,
    /// Gravitational acceleration and uniform force.
    pub(super) fields: [R::Vec3; 2],
    pub(super) drag: R,
    /// Forces on single particles by slot, in the order in which they are added.
    pub(super) pushes: &'a [Push<R>],
    pub(super) planes: &'a [Planes<R>],
}

// SAFETY: what a job points to is written only to the slices that a sweep is told to do, which the
// callers of `sweep` keep apart.
unsafe impl<R: Real> Sync for Job<'_, R> {}

/// What a part of a sweep came to: power taken away by dampers and drag, watts; particles moved out
/// of a plane, and the energy that took away, joules.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub(super) power: f64,
    pub(super) contacts: usize,
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
#[derive(Default)]
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
pub(super) unsafe fn sweep<R: Real, P: Pack<R>, const DAMPED: bool, const GATHERS: bool>(
    job: &Job<'_, R>,
    update: impl Apply<R>,
    slices: Range<usize>,
) -> Tally {
    let mut sums = Sums::default();
    for slice in slices {
        let starts = &job.plan.starts[slice..slice + 2];
        let rows = if update.evaluates() { starts[0] as usize..starts[1] as usize } else { 0..0 };
        let rows = &job.plan.rows[rows];
        let mut lane = 0;
        while lane < LANES {
            let slot = slice * LANES + lane;
            // SAFETY: the caller's promise; the slot is one of the plan.
            unsafe {
                let particles = pulled::<R, P, DAMPED, GATHERS>(job, slot, rows, &mut sums);
                update.apply(job, particles, &mut sums);
                if GATHERS && update.moves() {
                    write_records::<R, P>(job, slot);
                }
            }
            lane += P::COUNT;
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
unsafe fn pulled<R: Real, P: Pack<R>, const DAMPED: bool, const GATHERS: bool>(
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
    let pushes = pushes_on(job.pushes, slot..slot + P::COUNT);
    if !pushes.is_empty() {
        // SAFETY: as above.
        force = unsafe { pushed(pushes, slot, force) };
    }
    if job.drag != R::ZERO {
        // SAFETY: as above.
        let drag = unsafe { P::splat(job.drag) };
        force = force - velocity * drag;
        (drag * velocity.dot(velocity)).add_to(&mut sums.drag[slot % LANES..]);
    }
    let mut particles = Particles { slot, position, velocity, force, mass, inverse_mass };
    let mut dampers = zero;
    // Two rows at a time, since a root and a quotient take long, and two of them as long as one.
    let (pairs, rest) = rows.as_chunks::<2>();
    for pair in pairs {
        // SAFETY: the caller's promise.
        unsafe {
            let first = Stretched::of::<R, DAMPED, GATHERS>(job, &particles, &pair[0]);
            let second = Stretched::of::<R, DAMPED, GATHERS>(job, &particles, &pair[1]);
            first.pull::<R, DAMPED, GATHERS>(job, &pair[0], &mut particles, &mut dampers);
            second.pull::<R, DAMPED, GATHERS>(job, &pair[1], &mut particles, &mut dampers);
        }
    }
    for row in rest {
        // SAFETY: the caller's promise.
        unsafe {
            let stretched = Stretched::of::<R, DAMPED, GATHERS>(job, &particles, row);
            stretched.pull::<R, DAMPED, GATHERS>(job, row, &mut particles, &mut dampers);
        }
    }
    if DAMPED {
        dampers.add_to(&mut sums.dampers[slot % LANES..]);
    }
    particles
}

/// How the other ends of a row lie from some particles.
pub(super) struct Apart<P, M> {
    pub(super) across: Triple<P>,
    /// The velocities of the other ends, seen from the particles; `across` without dampers.
    pub(super) parting: Triple<P>,
    /// The square of the length.
    pub(super) squared: P,
    /// Which springs there are, and have a direction.
    pub(super) acts: M,
}

impl<P: Copy> Apart<P, ()> {
    /// # Safety
    /// See [`sweep`].
    #[inline(always)]
    pub(super) unsafe fn of<R: Real, const DAMPED: bool, const GATHERS: bool>(
        job: &Job<'_, R>,
        (slot, (position, velocity)): (usize, (Triple<P>, Triple<P>)),
        row: &Row,
    ) -> Apart<P, P::Mask>
    where
        P: Pack<R>,
    {
        // SAFETY: the caller's promise; the rows of a plan name what is there.
        unsafe {
            let (there, there_velocity) = reached::<R, P, DAMPED, GATHERS>(job, slot, row.reach);
            let across = there - position;
            let squared = across.dot(across);
            let mask = P::mask(row.mask >> (slot % LANES));
            let acts = squared.not_less(P::splat(R::SHORTEST_SQUARED), mask);
            let parting = if DAMPED { there_velocity - velocity } else { across };
            Apart { across, parting, squared, acts }
        }
    }
}

/// The springs of a row as they are, before it is known how they pull.
struct Stretched<P, M> {
    /// From the particles to the other ends.
    across: Triple<P>,
    /// Which of them there are, and have a direction.
    acts: M,
    length: P,
    per_length: P,
    /// Length times the speed of parting.
    parting: P,
}

impl<P: Copy> Stretched<P, ()> {
    /// # Safety
    /// See [`sweep`].
    #[inline(always)]
    unsafe fn of<R: Real, const DAMPED: bool, const GATHERS: bool>(
        job: &Job<'_, R>,
        particles: &Particles<P>,
        row: &Row,
    ) -> Stretched<P, P::Mask>
    where
        P: Pack<R>,
    {
        let slot = particles.slot;
        // SAFETY: the caller's promise; the rows of a plan name what is there.
        unsafe {
            let at = (slot, (particles.position, particles.velocity));
            let Apart { across, parting, squared, acts } =
                Apart::of::<R, DAMPED, GATHERS>(job, at, row);
            let length = squared.sqrt();
            let per_length = P::splat(R::ONE) / length;
            let parting = if DAMPED { across.dot(parting) } else { length };
            Stretched { across, acts, length, per_length, parting }
        }
    }
}

impl<P: Copy, M: Copy> Stretched<P, M> {
    /// Adds the pull of the springs to the forces on the particles.
    ///
    /// # Safety
    /// See [`sweep`].
    #[inline(always)]
    unsafe fn pull<R: Real, const DAMPED: bool, const GATHERS: bool>(
        self,
        job: &Job<'_, R>,
        row: &Row,
        particles: &mut Particles<P>,
        dampers: &mut P,
    ) where
        P: Pack<R, Mask = M>,
    {
        let Stretched { across, acts, length, per_length, parting } = self;
        let lane = particles.slot % LANES;
        // SAFETY: the caller's promise; the rows of a plan name what is there.
        unsafe {
            let value = |place: u32| job.plan.value(place, lane);
            if GATHERS && job.far {
                // All three: where springs have numbers of their own, each is another line.
                for place in [row.rest_length, row.stiffness, row.damping] {
                    P::prefetch(value(place).wrapping_add(2 * AHEAD * LANES));
                }
            }
            let stiffness = P::load(value(row.stiffness));
            let tension = stiffness * (length - P::load(value(row.rest_length)));
            let pull = if DAMPED {
                let rate = parting * per_length;
                let drag = P::load(value(row.damping)) * rate;
                *dampers = dampers.add_where(acts, drag * rate);
                tension + drag
            } else {
                tension
            };
            particles.force = particles.force.add_where::<R>(acts, across * (pull * per_length));
        }
    }
}

/// Positions and velocities at the other ends of a row.
///
/// # Safety
/// See [`sweep`].
#[inline(always)]
pub(super) unsafe fn reached<R: Real, P: Pack<R>, const DAMPED: bool, const GATHERS: bool>(
    job: &Job<'_, R>,
    slot: usize,
    reach: Reach,
) -> (Triple<P>, Triple<P>) {
    // SAFETY: a run ends less than a slice beyond the slots, where columns go on; a gather has
    // records, and names those of slots.
    unsafe {
        match reach {
            Reach::Gather(row) if GATHERS => {
                let others = job.plan.others.as_ptr().add(row as usize);
                ask_for::<R, P>(job, row as usize, slot % LANES);
                let at = others.cast::<u32>().add(slot % LANES);
                let [there, velocity] = P::gather(job.records[0], at, DAMPED);
                (Triple::of(there), Triple::of(velocity))
            }
            Reach::Run(offset) => {
                let slot = slot.wrapping_add_signed(offset as isize);
                let there = Triple::load(job.from, POSITION, slot);
                (there, if DAMPED { Triple::load(job.from, VELOCITY, slot) } else { there })
            }
            Reach::Gather(_) => core::hint::unreachable_unchecked(),
        }
    }
}

/// Asks for the records of a later gather row, if there are more than the near caches hold, and for
/// the places in a row beyond that. A sweep is not in memory's order there, and memory is slow.
#[inline(always)]
fn ask_for<R: Real, P: Pack<R>>(job: &Job<'_, R>, row: usize, lane: usize) {
    let others = &job.plan.others;
    P::prefetch(others.as_ptr().wrapping_add(row + 2 * AHEAD));
    if let (true, Some(others)) = (job.far, others.get(row + AHEAD)) {
        for &other in &others.0[lane..lane + P::COUNT] {
            P::prefetch(job.records[0].wrapping_add(other as usize));
        }
    }
}

/// Gather rows between what is asked for and what is read: as long as memory takes to answer.
const AHEAD: usize = 16;

/// Those on the particles of some slots.
#[inline(always)]
fn pushes_on<R: Real>(pushes: &[Push<R>], slots: Range<usize>) -> &[Push<R>] {
    let before = |slot: usize| pushes.partition_point(|push| (push.slot as usize) < slot);
    if pushes.is_empty() { pushes } else { &pushes[before(slots.start)..before(slots.end)] }
}

/// # Safety
/// See [`sweep`].
#[cold]
unsafe fn pushed<R: Real, P: Pack<R>>(
    pushes: &[Push<R>],
    slot: usize,
    mut force: Triple<P>,
) -> Triple<P> {
    for &Push { slot: at, force: push, .. } in pushes {
        let lane = at as usize - slot;
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

/// Copies what some particles have become into their records.
///
/// # Safety
/// See [`sweep`].
#[inline(always)]
unsafe fn write_records<R: Real, P: Pack<R>>(job: &Job<'_, R>, slot: usize) {
    // SAFETY: the caller's promise; there is a record for each slot.
    unsafe {
        let position = Triple::<P>::load(job.to, POSITION, slot);
        let velocity = Triple::<P>::load(job.to, VELOCITY, slot);
        let halves = [position, velocity].map(|Triple { x, y, z }| [x, y, z]);
        P::scatter(job.records[1].add(slot * RECORD), halves);
    }
}
