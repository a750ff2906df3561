//! What happens to the particles of a slice that have entered a plane? As [`crate::collision`]
//! says, lane by lane, with the same bits.

use super::LANES;
use super::pack::{Pack, Spread, Triple};
use super::sweep::{Particles, Sums};
use crate::real::Real;
use crate::scene::Friction;
use crate::system::PlaneColumn;

/// A plane as a sweep reads it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planes<R: Real> {
    plane: PlaneColumn<R>,
    /// A slower approach does not bounce, metres per second.
    resting_speed: R,
}

impl<R: Real> Planes<R> {
    /// Makes a plane ready for substeps of `h` seconds.
    pub(super) fn new(plane: &PlaneColumn<R>, gravity: R::Vec3, h: R) -> Self {
        let resting_speed = crate::collision::resting_speed(plane, gravity, h);
        Planes { plane: *plane, resting_speed }
    }
}

/// A plane for each lane.
pub(super) trait Obstacle<R: Real> {
    /// The lanes that have a plane here.
    fn lanes(&self) -> u16;
    /// Directions out of the solid.
    ///
    /// # Safety
    /// See [`super::sweep::sweep`]; so for all functions here.
    unsafe fn normal<P: Pack<R>>(&self, lane: usize) -> Triple<P>;
    /// Signed distances from the origin.
    unsafe fn offset<P: Pack<R>>(&self, lane: usize) -> P;
    /// Speeds of a slower approach, which does not bounce, and fractions of a faster one returned.
    unsafe fn bounce<P: Pack<R>>(&self, lane: usize) -> [P; 2];
    /// Fractions kept of a velocity along the plane, while that towards it changes by `gained`.
    unsafe fn kept<P: Pack<R>>(&self, lane: usize, along: Triple<P>, gained: P) -> P;
}

impl<R: Real> Obstacle<R> for Planes<R> {
    #[inline(always)]
    fn lanes(&self) -> u16 {
        u16::MAX
    }
    #[inline(always)]
    unsafe fn normal<P: Pack<R>>(&self, _: usize) -> Triple<P> {
        // SAFETY: the caller's promise.
        unsafe { Triple::splat(self.plane.normal) }
    }
    #[inline(always)]
    unsafe fn offset<P: Pack<R>>(&self, _: usize) -> P {
        // SAFETY: the caller's promise.
        unsafe { P::splat(self.plane.offset) }
    }
    #[inline(always)]
    unsafe fn bounce<P: Pack<R>>(&self, _: usize) -> [P; 2] {
        // SAFETY: the caller's promise.
        unsafe { [P::splat(self.resting_speed), P::splat(self.plane.restitution)] }
    }
    #[inline(always)]
    unsafe fn kept<P: Pack<R>>(&self, lane: usize, along: Triple<P>, gained: P) -> P {
        // SAFETY: the caller's promise.
        unsafe {
            match self.plane.friction {
                Friction::TangentialLoss(loss) => P::splat(R::ONE - R::of(loss)),
                Friction::Coulomb(factor) => coulomb(R::of(factor).at(lane), along, gained),
            }
        }
    }
}

/// What Coulomb friction leaves of velocities along a plane.
///
/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
pub(super) unsafe fn coulomb<R: Real, P: Pack<R>>(factor: P, along: Triple<P>, gained: P) -> P {
    // SAFETY: the caller's promise.
    let (zero, one, all) = unsafe { (P::splat(R::ZERO), P::splat(R::ONE), P::mask(u16::MAX)) };
    let speed = along.dot(along).sqrt();
    let loss = factor * gained;
    (one - loss / speed).select(loss.less(speed, all), zero)
}

/// Moves the particles out of a plane, bounces them and slows them along it.
///
/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
pub(super) unsafe fn resolve<R: Real, P: Pack<R>>(
    plane: &impl Obstacle<R>,
    particles: &mut Particles<P>,
    sums: &mut Sums,
) {
    let lane = particles.slot % LANES;
    // SAFETY: the caller's promise.
    let (normal, offset, zero, all) = unsafe {
        let all = P::mask(plane.lanes() >> lane);
        (plane.normal::<P>(lane), plane.offset::<P>(lane), P::splat(R::ZERO), all)
    };
    let depth = offset - normal.dot(particles.position);
    let free = zero.less(particles.inverse_mass, all);
    let inside = zero.less(depth, free);
    let count = P::bits(inside).count_ones();
    if count == 0 {
        return;
    }
    // SAFETY: the caller's promise.
    let (bounced, half) =
        unsafe { (bounce(plane, (normal, lane), particles.velocity), P::splat(R::HALF)) };
    let moved = normal * depth;
    let velocity = particles.velocity;
    let slower = velocity.dot(velocity) - bounced.dot(bounced);
    let slowed = slower * half * particles.mass;
    slowed.select(inside, zero).add_to(&mut sums.energy[lane..]);
    particles.force.dot(moved).select(inside, zero).add_to(&mut sums.energy[lane..]);
    sums.contacts += count as usize;
    particles.position = particles.position.add_where::<R>(inside, moved);
    particles.velocity = bounced.select::<R>(inside, velocity);
}

/// The velocities after a bounce.
///
/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
unsafe fn bounce<R: Real, P: Pack<R>>(
    plane: &impl Obstacle<R>,
    (normal, lane): (Triple<P>, usize),
    velocity: Triple<P>,
) -> Triple<P> {
    // SAFETY: the caller's promise.
    let (zero, minus, all) = unsafe { (P::splat(R::ZERO), P::splat(-R::ONE), P::mask(u16::MAX)) };
    // SAFETY: as above.
    let [resting, restitution] = unsafe { plane.bounce::<P>(lane) };
    let normal_speed = velocity.dot(normal);
    let tangential = velocity - normal * normal_speed;
    let entering = normal_speed.less(zero, all);
    // To multiply by minus one is to change the sign, that of a zero too.
    let slow = (normal_speed * minus).less(resting, all);
    let restitution = zero.select(slow, restitution);
    let after = (restitution * normal_speed * minus).select(entering, normal_speed);
    // SAFETY: as above.
    let kept = unsafe { plane.kept(lane, tangential, after - normal_speed) };
    normal * after + tangential * kept
}
