//! What happens to the particles of a slice that have entered a plane? As [`crate::collision`] says,
//! lane by lane, with the same bits.

use super::LANES;
use super::pack::{Pack, Triple};
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

/// Moves the particles out of a plane, bounces them and slows them along it.
///
/// # Safety
/// See [`super::sweep::sweep`].
#[inline(always)]
pub(super) unsafe fn resolve<R: Real, P: Pack<R>>(
    plane: &Planes<R>,
    particles: &mut Particles<P>,
    sums: &mut Sums,
) {
    // SAFETY: the caller's promise.
    let (normal, offset, zero, all) = unsafe {
        let normal = Triple::<P>::splat(plane.plane.normal);
        (normal, P::splat(plane.plane.offset), P::splat(R::ZERO), P::mask(u16::MAX))
    };
    let depth = offset - normal.dot(particles.position);
    let free = zero.less(particles.inverse_mass, all);
    let inside = zero.less(depth, free);
    let count = P::bits(inside).count_ones();
    if count == 0 {
        return;
    }
    // SAFETY: the caller's promise.
    let (bounced, half) = unsafe { (bounce(plane, normal, particles.velocity), P::splat(R::HALF)) };
    let moved = normal * depth;
    let velocity = particles.velocity;
    let slower = velocity.dot(velocity) - bounced.dot(bounced);
    let slowed = slower * half * particles.mass;
    let lane = particles.slot % LANES;
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
    plane: &Planes<R>,
    normal: Triple<P>,
    velocity: Triple<P>,
) -> Triple<P> {
    // SAFETY: the caller's promise.
    let (zero, one, minus, all) =
        unsafe { (P::splat(R::ZERO), P::splat(R::ONE), P::splat(-R::ONE), P::mask(u16::MAX)) };
    // SAFETY: as above.
    let (resting, restitution) =
        unsafe { (P::splat(plane.resting_speed), P::splat(plane.plane.restitution)) };
    let normal_speed = velocity.dot(normal);
    let tangential = velocity - normal * normal_speed;
    let entering = normal_speed.less(zero, all);
    // To multiply by minus one is to change the sign, that of a zero too.
    let slow = (normal_speed * minus).less(resting, all);
    let restitution = zero.select(slow, restitution);
    let after = (restitution * normal_speed * minus).select(entering, normal_speed);
    let kept = match plane.plane.friction {
        // SAFETY: as above.
        Friction::TangentialLoss(loss) => unsafe { P::splat(R::ONE - R::of(loss)) },
        Friction::Coulomb(factor) => {
            let speed = tangential.dot(tangential).sqrt();
            // SAFETY: as above.
            let loss = unsafe { P::splat(R::of(factor)) } * (after - normal_speed);
            (one - loss / speed).select(loss.less(speed, all), zero)
        }
    };
    normal * after + tangential * kept
}
