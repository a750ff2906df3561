//! How do the particles of a slice move on, once the forces on them are known? As
//! [`crate::explicit`] says, lane by lane, with the same bits.

use super::LANES;
use super::columns::Start;
use super::contact;
use super::pack::{Pack, Spread, Triple};
use super::sweep::{Job, POSITION, Particles, Sums, VELOCITY};
use crate::integrator::Explicit;
use crate::real::Real;

/// What a sweep does with forces; lengths of time are of type `S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Update<R, S = R> {
    /// Writes them instead of positions.
    Forces,
    /// A substep of explicit Euler, `h` long.
    ExplicitEuler { h: S },
    /// A substep of symplectic Euler.
    SymplecticEuler { h: S },
    /// The end of a substep of velocity Verlet, and the start of the next.
    VelocityVerlet { h: S, phase: Phase, damped: bool },
    /// A stage of RK4: the sum of slopes takes this one so many times, and the next stage is that
    /// long after the start.
    Rk4Stage { first: bool, weight: R, reach: S },
    /// The last stage of RK4.
    Rk4Last { h: S },
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

/// Where an update finds and leaves what belongs to particles.
pub(super) trait Place<R: Real> {
    /// What the method remembers about each particle.
    fn own(&self) -> Start<R>;
    /// What comes out: a motion, or forces.
    fn to(&self) -> Start<R>;
    /// Keeps particles out of planes.
    ///
    /// # Safety
    /// See [`super::sweep::sweep`].
    unsafe fn collide<P: Pack<R>>(&self, particles: &mut Particles<P>, sums: &mut Sums);
}

impl<R: Real> Place<R> for Job<'_, R> {
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
        for plane in self.planes {
            // SAFETY: the caller's promise.
            unsafe { contact::resolve(plane, particles, sums) };
        }
    }
}

/// An update that a sweep is compiled for, one of [`Update`].
pub(super) trait Apply<R: Real>: Copy {
    /// Whether what comes out is a motion.
    fn moves(self) -> bool {
        true
    }

    /// Whether forces are needed.
    fn evaluates(self) -> bool {
        true
    }

    /// Moves some particles on.
    ///
    /// # Safety
    /// See [`super::sweep::sweep`].
    unsafe fn apply<P: Pack<R>>(
        self,
        job: &impl Place<R>,
        particles: Particles<P>,
        sums: &mut Sums,
    );
}

/// Columns of what velocity Verlet remembers: velocities and accelerations.
const OWN_VELOCITY: usize = 0;
const ACCELERATION: usize = 3;
/// Columns of what RK4 remembers: the start of the substep and the sum of slopes.
const START: usize = 0;
const SLOPE: usize = 6;

/// The number of columns that a method remembers.
pub(super) fn own_columns(method: Explicit) -> usize {
    match method {
        Explicit::Euler | Explicit::SymplecticEuler => 0,
        Explicit::VelocityVerlet => ACCELERATION + 3,
        Explicit::Rk4 => SLOPE + 6,
    }
}

/// The stages of RK4 before the last one, and the weights of their powers.
pub(super) fn rk4_stages<R: Real, S>(half: S, h: S) -> [(R, Update<R, S>); 3]
where
    S: Copy,
{
    let two = R::ONE + R::ONE;
    [(true, R::ONE, half), (false, two, half), (false, two, h)]
        .map(|(first, weight, reach)| (weight, Update::Rk4Stage { first, weight, reach }))
}

/// See [`Update::Forces`].
#[derive(Clone, Copy)]
pub(super) struct Forces;

impl<R: Real> Apply<R> for Forces {
    fn moves(self) -> bool {
        false
    }

    #[inline(always)]
    unsafe fn apply<P: Pack<R>>(self, job: &impl Place<R>, particles: Particles<P>, _: &mut Sums) {
        // SAFETY: the caller's promise.
        unsafe { particles.force.store::<R>(job.to(), POSITION, particles.slot) };
    }
}

/// See [`Update::ExplicitEuler`].
#[derive(Clone, Copy)]
pub(super) struct ExplicitEuler<S>(pub(super) S);

impl<R: Real, S: Spread<R>> Apply<R> for ExplicitEuler<S> {
    #[inline(always)]
    unsafe fn apply<P: Pack<R>>(self, job: &impl Place<R>, mut at: Particles<P>, sums: &mut Sums) {
        // SAFETY: the caller's promise.
        unsafe {
            let h: P = self.0.at(at.slot % LANES);
            at.position = at.position + at.velocity * h;
            at.velocity = at.velocity + at.force * (at.inverse_mass * h);
            finish(job, at, sums);
        }
    }
}

/// See [`Update::SymplecticEuler`].
#[derive(Clone, Copy)]
pub(super) struct SymplecticEuler<S>(pub(super) S);

impl<R: Real, S: Spread<R>> Apply<R> for SymplecticEuler<S> {
    #[inline(always)]
    unsafe fn apply<P: Pack<R>>(self, job: &impl Place<R>, mut at: Particles<P>, sums: &mut Sums) {
        // SAFETY: the caller's promise.
        unsafe {
            let h: P = self.0.at(at.slot % LANES);
            at.velocity = at.velocity + at.force * (at.inverse_mass * h);
            at.position = at.position + at.velocity * h;
            finish(job, at, sums);
        }
    }
}

/// See [`Update::VelocityVerlet`].
#[derive(Clone, Copy)]
pub(super) struct VelocityVerlet<S> {
    pub(super) h: S,
    pub(super) phase: Phase,
    pub(super) damped: bool,
}

impl<R: Real, S: Spread<R>> Apply<R> for VelocityVerlet<S> {
    #[inline(always)]
    fn evaluates(self) -> bool {
        self.phase != Phase::Warm
    }

    #[inline(always)]
    unsafe fn apply<P: Pack<R>>(self, job: &impl Place<R>, mut at: Particles<P>, sums: &mut Sums) {
        let VelocityVerlet { h, phase, damped } = self;
        let slot = at.slot;
        // SAFETY: the caller's promise.
        unsafe {
            let (h, halved): (P, P) = (h.at(slot % LANES), P::splat(R::HALF));
            let (half, quarter) = (h * halved, h * halved * halved);
            let own = match phase {
                Phase::Cold | Phase::Warm => at.velocity,
                Phase::Next | Phase::Last => Triple::load(job.own(), OWN_VELOCITY, slot),
            };
            let remembered = Triple::load(job.own(), ACCELERATION, slot);
            let found = at.force * at.inverse_mass;
            let (before, now) = match phase {
                Phase::Cold => (found, found),
                Phase::Warm => (remembered, remembered),
                Phase::Next | Phase::Last => (remembered, found),
            };
            at.velocity = own;
            if matches!(phase, Phase::Next | Phase::Last) {
                at.velocity = own + now * half;
                job.collide(&mut at, sums);
            }
            now.store::<R>(job.own(), ACCELERATION, slot);
            let mut velocity = at.velocity;
            if phase != Phase::Last {
                velocity = at.velocity + now * half;
                velocity.store::<R>(job.own(), OWN_VELOCITY, slot);
                at.position = at.position + velocity * h;
                velocity = if damped { velocity + (now + before) * quarter } else { velocity };
            }
            at.position.store::<R>(job.to(), POSITION, slot);
            velocity.store::<R>(job.to(), VELOCITY, slot);
        }
    }
}

/// See [`Update::Rk4Stage`].
#[derive(Clone, Copy)]
pub(super) struct Rk4Stage<R, S> {
    pub(super) first: bool,
    pub(super) weight: R,
    pub(super) reach: S,
}

impl<R: Real, S: Spread<R>> Apply<R> for Rk4Stage<R, S> {
    #[inline(always)]
    unsafe fn apply<P: Pack<R>>(self, job: &impl Place<R>, at: Particles<P>, _: &mut Sums) {
        let Particles { slot, position, velocity, force, inverse_mass, .. } = at;
        let acceleration = force * inverse_mass;
        // SAFETY: the caller's promise.
        unsafe {
            let (weight, reach): (P, P) = (P::splat(self.weight), self.reach.at(slot % LANES));
            let zero = Triple::<P>::splat(R::Vec3::default());
            let (start, start_velocity, drifts, kicks) = if self.first {
                position.store::<R>(job.own(), START, slot);
                velocity.store::<R>(job.own(), START + 3, slot);
                (position, velocity, zero, zero)
            } else {
                remembered(job, slot)
            };
            (drifts + velocity * weight).store::<R>(job.own(), SLOPE, slot);
            (kicks + acceleration * weight).store::<R>(job.own(), SLOPE + 3, slot);
            (start + velocity * reach).store::<R>(job.to(), POSITION, slot);
            (start_velocity + acceleration * reach).store::<R>(job.to(), VELOCITY, slot);
        }
    }
}

/// See [`Update::Rk4Last`].
#[derive(Clone, Copy)]
pub(super) struct Rk4Last<S>(pub(super) S);

impl<R: Real, S: Spread<R>> Apply<R> for Rk4Last<S> {
    #[inline(always)]
    unsafe fn apply<P: Pack<R>>(self, job: &impl Place<R>, mut at: Particles<P>, sums: &mut Sums) {
        let last = at.force * at.inverse_mass;
        // SAFETY: the caller's promise.
        unsafe {
            let sixth = self.0.at::<P>(at.slot % LANES) / P::splat(R::of(6.0));
            let (start, start_velocity, drifts, kicks) = remembered(job, at.slot);
            at.position = start + (drifts + at.velocity) * sixth;
            at.velocity = start_velocity + (kicks + last) * sixth;
            finish(job, at, sums);
        }
    }
}

/// Keeps particles out of planes and writes them.
///
/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
unsafe fn finish<R: Real, P: Pack<R>>(
    job: &impl Place<R>,
    mut particles: Particles<P>,
    sums: &mut Sums,
) {
    // SAFETY: the caller's promise.
    unsafe {
        job.collide(&mut particles, sums);
        particles.position.store::<R>(job.to(), POSITION, particles.slot);
        particles.velocity.store::<R>(job.to(), VELOCITY, particles.slot);
    }
}

/// Positions and velocities at the start of a substep of RK4, and the sums of their slopes.
///
/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
unsafe fn remembered<R: Real, P: Pack<R>>(
    job: &impl Place<R>,
    slot: usize,
) -> (Triple<P>, Triple<P>, Triple<P>, Triple<P>) {
    // SAFETY: the caller's promise.
    unsafe {
        (
            Triple::load(job.own(), START, slot),
            Triple::load(job.own(), START + 3, slot),
            Triple::load(job.own(), SLOPE, slot),
            Triple::load(job.own(), SLOPE + 3, slot),
        )
    }
}
