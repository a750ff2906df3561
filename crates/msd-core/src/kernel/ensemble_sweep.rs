//! What happens to sixteen copies at once? The plain loops of [`crate::forces`] and
//! [`crate::explicit`] with a copy in each lane.

use super::LANES;
use super::columns::{Slice, Start};
use super::contact::{self, Obstacle};
use super::ensemble_plan::Pull;
use super::pack::{Pack, Triple};
use super::sweep::{POSITION, Particles, Sums, VELOCITY};
use super::update::{self, Apply, Phase, Place, Update};
use crate::real::Real;
use alloc::vec::Vec;

/// What copies differ in, but for particles and springs.
#[derive(Clone, Debug)]
pub(super) struct Lanes<R> {
    pub(super) gravity: [Slice<R>; 3],
    pub(super) force: [Slice<R>; 3],
    pub(super) drag: Slice<R>,
    /// The lanes with drag, and those with dampers.
    pub(super) dragged: u16,
    pub(super) damped: u16,
    /// Lengths of a substep, and of its half.
    pub(super) h: Slice<R>,
    pub(super) half: Slice<R>,
    pub(super) extent: Slice<R>,
    pub(super) planes: Vec<PlaneRow<R>>,
}

/// A plane of each copy.
#[derive(Clone, Debug)]
pub(super) struct PlaneRow<R> {
    /// The lanes that have it.
    pub(super) lanes: u16,
    pub(super) normal: [Slice<R>; 3],
    pub(super) offset: Slice<R>,
    pub(super) resting_speed: Slice<R>,
    pub(super) restitution: Slice<R>,
    /// Fractions kept along the plane, or factors of Coulomb friction where that is.
    pub(super) kept: Slice<R>,
    pub(super) factor: Slice<R>,
    pub(super) coulomb: u16,
}

/// What a turn needs to know. A particle is some rows of numbers, and its slot is where they begin.
pub(super) struct Turn<'a, R> {
    pub(super) pulls: &'a [Pull],
    /// Rows of numbers that pulls name.
    pub(super) values: Start<R>,
    pub(super) particles: usize,
    /// Rows from one particle to the next.
    pub(super) width: usize,
    pub(super) from: Start<R>,
    pub(super) to: Start<R>,
    /// The forces on particles: those of no spring when a turn begins and when it ends.
    pub(super) forces: Start<R>,
    pub(super) fixed: Start<R>,
    pub(super) own: Start<R>,
    /// Constant forces that are added last, if there are any.
    pub(super) loads: Option<Start<R>>,
    pub(super) lanes: &'a Lanes<R>,
}

/// Columns of what a particle is: mass and its reciprocal.
pub(super) const MASS: usize = 0;
pub(super) const INVERSE_MASS: usize = 1;

/// Loads a vector of each lane.
///
/// # Safety
/// The processor has the instructions of the pack; the lane is within a slice.
#[inline(always)]
unsafe fn triple<R: Real, P: Pack<R>>(rows: &[Slice<R>; 3], lane: usize) -> Triple<P> {
    // SAFETY: the caller's promise.
    unsafe { Triple { x: row(&rows[0], lane), y: row(&rows[1], lane), z: row(&rows[2], lane) } }
}

/// Loads a number of each lane.
///
/// # Safety
/// See [`triple`].
#[inline(always)]
unsafe fn row<R: Real, P: Pack<R>>(row: &Slice<R>, lane: usize) -> P {
    // SAFETY: the caller's promise.
    unsafe { P::load(row.0.as_ptr().add(lane)) }
}

impl<R: Real> Obstacle<R> for PlaneRow<R> {
    #[inline(always)]
    fn lanes(&self) -> u16 {
        self.lanes
    }
    #[inline(always)]
    unsafe fn normal<P: Pack<R>>(&self, lane: usize) -> Triple<P> {
        // SAFETY: the caller's promise.
        unsafe { triple(&self.normal, lane) }
    }
    #[inline(always)]
    unsafe fn offset<P: Pack<R>>(&self, lane: usize) -> P {
        // SAFETY: the caller's promise.
        unsafe { row(&self.offset, lane) }
    }
    #[inline(always)]
    unsafe fn bounce<P: Pack<R>>(&self, lane: usize) -> [P; 2] {
        // SAFETY: the caller's promise.
        unsafe { [row(&self.resting_speed, lane), row(&self.restitution, lane)] }
    }
    #[inline(always)]
    unsafe fn kept<P: Pack<R>>(&self, lane: usize, along: Triple<P>, gained: P) -> P {
        // SAFETY: the caller's promise.
        unsafe {
            let (kept, factor) = (row(&self.kept, lane), row(&self.factor, lane));
            contact::coulomb(factor, along, gained).select(P::mask(self.coulomb >> lane), kept)
        }
    }
}

impl<R: Real> Place<R> for Turn<'_, R> {
    #[inline(always)]
    fn own(&self) -> Start<R> {
        self.own
    }
    #[inline(always)]
    fn to(&self) -> Start<R> {
        self.to
    }
    #[inline(always)]
    unsafe fn collide<P: Pack<R>>(&self, particles: &mut Particles<P>, sums: &mut Sums) {
        for plane in &self.lanes.planes {
            // SAFETY: the caller's promise.
            unsafe { contact::resolve(plane, particles, sums) };
        }
    }
}

/// Adds the pull of every spring to the forces.
///
/// # Safety
/// The processor has the instructions of the pack; pulls name what is there; nobody else reads or
/// writes what the turn does.
#[inline(always)]
unsafe fn pull<R: Real, P: Pack<R>, const DAMPED: bool>(turn: &Turn<'_, R>) {
    for pull in turn.pulls {
        let mut lane = 0;
        while lane < LANES {
            // SAFETY: the caller's promise.
            unsafe { pull_once::<R, P, DAMPED>(turn, pull, lane) };
            lane += P::COUNT;
        }
    }
}

/// Adds the pull of a spring to the forces at its ends.
///
/// # Safety
/// See [`pull`].
#[inline(always)]
unsafe fn pull_once<R: Real, P: Pack<R>, const DAMPED: bool>(
    turn: &Turn<'_, R>,
    pull: &Pull,
    lane: usize,
) {
    let [a, b] = pull.ends.map(|end| end as usize * turn.width * LANES + lane);
    // SAFETY: the caller's promise.
    unsafe {
        let value = |place: u32| P::load(turn.values.at(place as usize, lane));
        let vector = |column, slot| Triple::<P>::load(turn.from, column, slot);
        let across = vector(POSITION, b) - vector(POSITION, a);
        let squared = across.dot(across);
        let acts = squared.not_less(P::splat(R::SHORTEST_SQUARED), P::mask(u16::MAX));
        let length = squared.sqrt();
        let per_length = P::splat(R::ONE) / length;
        let mut pulls = value(pull.stiffness) * (length - value(pull.rest_length));
        if DAMPED {
            let parting = across.dot(vector(VELOCITY, b) - vector(VELOCITY, a));
            let drag = value(pull.damping) * (parting * per_length);
            pulls = pulls.add_where(P::mask(turn.lanes.damped >> lane), drag);
        }
        let force = across * (pulls * per_length);
        let (at_a, at_b) =
            (Triple::<P>::load(turn.forces, 0, a), Triple::<P>::load(turn.forces, 0, b));
        // Lanes without a force add minus zero and subtract zero, which changes nothing: a store of
        // some lanes would be slow to read back.
        let (plus_zero, minus_zero) = (P::splat(R::ZERO), P::splat(-R::ZERO));
        let at_a = at_a + force.select::<R>(acts, Triple::of([minus_zero; 3]));
        let at_b = at_b - force.select::<R>(acts, Triple::of([plus_zero; 3]));
        at_a.store::<R>(turn.forces, 0, a);
        at_b.store::<R>(turn.forces, 0, b);
    }
}

/// Moves all particles on, and leaves the forces of no spring where they are then. Returns whether
/// any has touched a plane.
///
/// # Safety
/// See [`pull`].
#[inline(always)]
unsafe fn move_on<R: Real, P: Pack<R>>(turn: &Turn<'_, R>, update: impl Apply<R>) -> bool {
    let mut sums = Sums::default();
    for particle in 0..turn.particles {
        let mut lane = 0;
        while lane < LANES {
            let slot = particle * turn.width * LANES + lane;
            // SAFETY: the caller's promise.
            unsafe {
                let mut force = Triple::<P>::load(turn.forces, 0, slot);
                if let Some(loads) = turn.loads {
                    force = force + Triple::load(loads, 0, slot);
                }
                let particles = Particles {
                    slot,
                    position: Triple::<P>::load(turn.from, POSITION, slot),
                    velocity: Triple::load(turn.from, VELOCITY, slot),
                    force,
                    mass: P::load(turn.fixed.at(MASS, slot)),
                    inverse_mass: P::load(turn.fixed.at(INVERSE_MASS, slot)),
                };
                update.apply(turn, particles, &mut sums);
                set_external_force::<R, P>(turn, slot, particles.mass);
            }
            lane += P::COUNT;
        }
    }
    0 < sums.contacts
}

/// Overwrites the force on a particle with gravity, the uniform force and drag.
///
/// # Safety
/// See [`pull`].
#[inline(always)]
unsafe fn set_external_force<R: Real, P: Pack<R>>(turn: &Turn<'_, R>, slot: usize, mass: P) {
    let (lane, lanes) = (slot % LANES, turn.lanes);
    // SAFETY: the caller's promise.
    unsafe {
        let mut force = triple::<R, P>(&lanes.gravity, lane) * mass + triple(&lanes.force, lane);
        if lanes.dragged != 0 {
            let velocity = Triple::<P>::load(turn.to, VELOCITY, slot);
            let slowed = force - velocity * row(&lanes.drag, lane);
            force = slowed.select::<R>(P::mask(lanes.dragged >> lane), force);
        }
        force.store::<R>(turn.forces, 0, slot);
    }
}

/// The lanes of which a particle is outside the world, or a velocity not finite.
///
/// # Safety
/// See [`pull`].
#[inline(always)]
unsafe fn outside<R: Real, P: Pack<R>>(turn: &Turn<'_, R>) -> u16 {
    let (mut lane, mut outside) = (0, 0);
    while lane < LANES {
        // SAFETY: the caller's promise.
        outside |= unsafe { outside_of::<R, P>(turn, lane) } << lane;
        lane += P::COUNT;
    }
    outside
}

/// # Safety
/// See [`pull`].
#[inline(always)]
unsafe fn outside_of<R: Real, P: Pack<R>>(turn: &Turn<'_, R>, lane: usize) -> u16 {
    // SAFETY: the caller's promise.
    unsafe {
        let (zero, infinite) = (P::splat(R::ZERO), P::splat(R::ONE / R::ZERO));
        let extent: P = row(&turn.lanes.extent, lane);
        let all = P::mask(u16::MAX);
        let mut inside = [all; 3];
        for particle in 0..turn.particles {
            let slot = particle * turn.width * LANES + lane;
            for (axis, inside) in inside.iter_mut().enumerate() {
                let position = P::load(turn.to.at(POSITION + axis, slot));
                let position = position.select(zero.less(position, all), zero - position);
                let velocity = P::load(turn.to.at(VELOCITY + axis, slot));
                let velocity = velocity.select(zero.less(velocity, all), zero - velocity);
                // What is no number is not less than infinite.
                let finite = velocity.less(infinite, position.less(infinite, *inside));
                *inside = extent.not_less(position, finite);
            }
        }
        let [x, y, z] = inside;
        P::bits(all) & !(P::bits(x) & P::bits(y) & P::bits(z))
    }
}

/// What is done to a group.
#[derive(Clone, Copy, Debug)]
pub(super) enum Task<'a, R> {
    /// Pulls if forces are needed, and moves all particles on. Answers 1 if any touched a plane.
    Advance(Update<R, &'a [R; LANES]>),
    /// Leaves the forces of no spring at the motion that comes out.
    SetExternal,
    /// Answers with the lanes that are outside the world.
    Guard,
}

/// Does a task.
///
/// # Safety
/// See [`pull`].
#[inline(always)]
pub(super) unsafe fn perform<R: Real, P: Pack<R>>(turn: &Turn<'_, R>, task: Task<'_, R>) -> u16 {
    // SAFETY: the caller's promise.
    unsafe {
        match task {
            Task::Advance(update) => u16::from(advance::<R, P>(turn, update)),
            Task::Guard => outside::<R, P>(turn),
            Task::SetExternal => {
                for particle in 0..turn.particles {
                    for lane in (0..LANES).step_by(P::COUNT) {
                        let slot = particle * turn.width * LANES + lane;
                        let mass = P::load(turn.fixed.at(MASS, slot));
                        set_external_force::<R, P>(turn, slot, mass);
                    }
                }
                0
            }
        }
    }
}

/// # Safety
/// See [`pull`].
#[inline(always)]
unsafe fn advance<R: Real, P: Pack<R>>(turn: &Turn<'_, R>, update: Update<R, &[R; LANES]>) -> bool {
    let warm = matches!(update, Update::VelocityVerlet { phase: Phase::Warm, .. });
    // SAFETY: the caller's promise.
    unsafe {
        match (warm, turn.lanes.damped != 0) {
            (true, _) => {}
            (false, true) => pull::<R, P, true>(turn),
            (false, false) => pull::<R, P, false>(turn),
        }
        match update {
            Update::Forces => false,
            Update::ExplicitEuler { h } => move_on::<R, P>(turn, update::ExplicitEuler(h)),
            Update::SymplecticEuler { h } => move_on::<R, P>(turn, update::SymplecticEuler(h)),
            Update::VelocityVerlet { h, phase, damped } => {
                move_on::<R, P>(turn, update::VelocityVerlet { h, phase, damped })
            }
            Update::Rk4Stage { first, weight, reach } => {
                move_on::<R, P>(turn, update::Rk4Stage { first, weight, reach })
            }
            Update::Rk4Last { h } => move_on::<R, P>(turn, update::Rk4Last(h)),
        }
    }
}
