//! How do the particles of a slice move on, once the forces on them are known? As [`crate::explicit`]
//! says, lane by lane, with the same bits.

use super::pack::{Pack, Triple};
use super::sweep::{Job, POSITION, Particles, Sums, VELOCITY, collide};
use crate::real::Real;

/// What a sweep does with forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Update<R> {
    /// Writes them instead of positions.
    Forces,
    /// A substep of explicit Euler, `h` long.
    ExplicitEuler { h: R },
    /// A substep of symplectic Euler.
    SymplecticEuler { h: R },
    /// The end of a substep of velocity Verlet, and the start of the next.
    VelocityVerlet { h: R, phase: Phase, damped: bool },
    /// A stage of RK4: the sum of slopes takes this one so many times, and the next stage is that
    /// long after the start.
    Rk4Stage { first: bool, weight: R, reach: R },
    /// The last stage of RK4.
    Rk4Last { h: R },
}

/// Where velocity Verlet stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// Accelerations are not known: they are found, and the first substep starts.
    Cold,
    /// Accelerations are known from the last step: the first substep starts.
    Warm,
    /// A substep ends, the next one starts.
    Next,
    /// The last substep ends.
    Last,
}

impl<R> Update<R> {
    /// Whether forces are needed.
    pub(super) fn evaluates(&self) -> bool {
        !matches!(self, Update::VelocityVerlet { phase: Phase::Warm, .. })
    }
}

/// Columns of what velocity Verlet remembers: velocities and accelerations.
const OWN_VELOCITY: usize = 0;
const ACCELERATION: usize = 3;
/// Columns of what RK4 remembers: the start of the substep and the sum of slopes.
const START: usize = 0;
const SLOPE: usize = 6;

/// Columns that a method remembers.
pub(super) const VERLET_COLUMNS: usize = 6;
pub(super) const RK4_COLUMNS: usize = 12;

/// Moves some particles on.
///
/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
pub(super) unsafe fn apply<R: Real, P: Pack<R>>(
    job: &Job<'_, R>,
    mut particles: Particles<P>,
    sums: &mut Sums,
) {
    let Particles { slot, position, velocity, force, inverse_mass, .. } = particles;
    // SAFETY: the caller's promise, for all that follows.
    unsafe {
        match job.update {
            Update::Forces => force.store::<R>(job.to, POSITION, slot),
            Update::ExplicitEuler { h } => {
                let h = P::splat(h);
                particles.position = position + velocity * h;
                particles.velocity = velocity + force * (inverse_mass * h);
                finish(job, &mut particles, sums);
            }
            Update::SymplecticEuler { h } => {
                let h = P::splat(h);
                particles.velocity = velocity + force * (inverse_mass * h);
                particles.position = position + particles.velocity * h;
                finish(job, &mut particles, sums);
            }
            Update::VelocityVerlet { h, phase, damped } => {
                velocity_verlet(job, particles, sums, (h, phase, damped));
            }
            Update::Rk4Stage { first, weight, reach } => {
                rk4_stage(job, particles, first, (P::splat(weight), P::splat(reach)));
            }
            Update::Rk4Last { h } => {
                let sixth = P::splat(h / R::of(6.0));
                let last = force * inverse_mass;
                let (start, start_velocity, drifts, kicks) = remembered(job, slot);
                particles.position = start + (drifts + velocity) * sixth;
                particles.velocity = start_velocity + (kicks + last) * sixth;
                finish(job, &mut particles, sums);
            }
        }
    }
}

/// Keeps particles out of planes and writes them.
///
/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
unsafe fn finish<R: Real, P: Pack<R>>(
    job: &Job<'_, R>,
    particles: &mut Particles<P>,
    sums: &mut Sums,
) {
    // SAFETY: the caller's promise.
    unsafe {
        collide(job, particles, sums);
        particles.position.store::<R>(job.to, POSITION, particles.slot);
        particles.velocity.store::<R>(job.to, VELOCITY, particles.slot);
    }
}

/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
unsafe fn velocity_verlet<R: Real, P: Pack<R>>(
    job: &Job<'_, R>,
    mut particles: Particles<P>,
    sums: &mut Sums,
    (h, phase, damped): (R, Phase, bool),
) {
    let slot = particles.slot;
    // SAFETY: the caller's promise.
    let (half, quarter, h) =
        unsafe { (P::splat(h * R::HALF), P::splat(h * R::HALF * R::HALF), P::splat(h)) };
    // SAFETY: as above.
    let (own, remembered) = unsafe {
        (Triple::<P>::load(job.own, OWN_VELOCITY, slot), Triple::load(job.own, ACCELERATION, slot))
    };
    let found = particles.force * particles.inverse_mass;
    let (before, now) = match phase {
        Phase::Cold => (found, found),
        Phase::Warm => (remembered, remembered),
        Phase::Next | Phase::Last => (remembered, found),
    };
    particles.velocity = own;
    // SAFETY: as above, for all that follows.
    unsafe {
        if matches!(phase, Phase::Next | Phase::Last) {
            particles.velocity = own + now * half;
            collide(job, &mut particles, sums);
        }
        now.store::<R>(job.own, ACCELERATION, slot);
        if phase == Phase::Last {
            particles.position.store::<R>(job.to, POSITION, slot);
            particles.velocity.store::<R>(job.to, VELOCITY, slot);
            return;
        }
        let velocity = particles.velocity + now * half;
        let position = particles.position + velocity * h;
        velocity.store::<R>(job.own, OWN_VELOCITY, slot);
        position.store::<R>(job.to, POSITION, slot);
        let predicted = if damped { velocity + (now + before) * quarter } else { velocity };
        predicted.store::<R>(job.to, VELOCITY, slot);
    }
}

/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
unsafe fn rk4_stage<R: Real, P: Pack<R>>(
    job: &Job<'_, R>,
    particles: Particles<P>,
    first: bool,
    (weight, reach): (P, P),
) {
    let Particles { slot, position, velocity, force, inverse_mass, .. } = particles;
    let acceleration = force * inverse_mass;
    // SAFETY: the caller's promise.
    unsafe {
        let zero = Triple::<P>::splat(R::Vec3::default());
        let (start, start_velocity, drifts, kicks) = if first {
            position.store::<R>(job.own, START, slot);
            velocity.store::<R>(job.own, START + 3, slot);
            (position, velocity, zero, zero)
        } else {
            remembered(job, slot)
        };
        (drifts + velocity * weight).store::<R>(job.own, SLOPE, slot);
        (kicks + acceleration * weight).store::<R>(job.own, SLOPE + 3, slot);
        (start + velocity * reach).store::<R>(job.to, POSITION, slot);
        (start_velocity + acceleration * reach).store::<R>(job.to, VELOCITY, slot);
    }
}

/// Positions and velocities at the start of a substep of RK4, and the sums of their slopes.
///
/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
unsafe fn remembered<R: Real, P: Pack<R>>(
    job: &Job<'_, R>,
    slot: usize,
) -> (Triple<P>, Triple<P>, Triple<P>, Triple<P>) {
    // SAFETY: the caller's promise.
    unsafe {
        (
            Triple::load(job.own, START, slot),
            Triple::load(job.own, START + 3, slot),
            Triple::load(job.own, SLOPE, slot),
            Triple::load(job.own, SLOPE + 3, slot),
        )
    }
}
