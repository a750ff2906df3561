//! The law of a pair of particles that touch.

use super::tangent::Touching;
use crate::number::{Real, Vector};
use crate::scene::{Between, Touch};
use glam::DVec3;

/// The law of a pair: the sum of its radii, metres, and the numbers of [`Touch`].
#[derive(Clone, Copy, Debug)]
pub(super) struct PairLaw<R> {
    pub(super) reach: R,
    pub(super) stiffness: R,
    pub(super) damping: R,
    pub(super) friction: R,
}

/// The touch of a pair at a motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closed<R: Real> {
    /// From the first particle to the second, of length one.
    normal: R::Vec3,
    distance: R,
    /// How much closer they are than the sum of their radii, metres.
    overlap: R,
    /// The speed at which they part, metres per second.
    rate: R,
    /// Velocity of the second across the normal, as seen from the first.
    slip: R::Vec3,
    /// The push, newtons.
    push: R,
    /// The factor of friction, newton seconds per metre.
    grip: R,
}

impl<R: Real> PairLaw<R> {
    /// The law of two rows, and what stands between them.
    pub(super) fn new(a: &Touch, b: &Touch, between: Option<&Between>) -> Self {
        let between = between.copied().unwrap_or_default();
        let friction = || Real::sqrt(a.friction) * Real::sqrt(b.friction);
        PairLaw {
            reach: R::of(a.radius + b.radius),
            stiffness: R::of(between.stiffness_of([a, b])),
            damping: R::of(between.damping_of([a, b])),
            friction: R::of(between.friction.unwrap_or_else(friction)),
        }
    }

    /// The touch of two particles, by the position and the velocity of the second as seen from the
    /// first and the sum of their reciprocal masses; `None` where they do not touch, or have no
    /// direction.
    #[inline(always)]
    pub(super) fn close(
        &self,
        [apart, relative]: [R::Vec3; 2],
        inverse_masses: R,
    ) -> Option<Closed<R>> {
        let square = apart.dot(apart);
        let touches = R::SHORTEST_SQUARED <= square && square < self.reach * self.reach;
        if !touches || inverse_masses == R::ZERO {
            return None;
        }
        let distance = square.sqrt();
        let normal = apart * (R::ONE / distance);
        let (overlap, rate) = (self.reach - distance, normal.dot(relative));
        let push = R::max(overlap * self.stiffness - rate * self.damping, R::ZERO);
        let slip = relative - normal * rate;
        let mut grip = R::ZERO;
        if self.friction != R::ZERO {
            grip = (self.stiffness / inverse_masses).sqrt();
            let (speed, most) = (slip.dot(slip).sqrt(), push * self.friction);
            if most < grip * speed {
                grip = most / speed;
            }
        }
        Some(Closed { normal, distance, overlap, rate, slip, push, grip })
    }

    /// The impulse on the second of two particles in a substep, in kilogram metres, by where XPBD
    /// has moved it to as seen from the first, by how much it has, and the sum of their reciprocal
    /// masses; `None` where they do not touch.
    #[inline(always)]
    pub(super) fn project(&self, [apart, moved]: [R::Vec3; 2], w: R, h: R) -> Option<R::Vec3> {
        let square = apart.dot(apart);
        let touches = R::SHORTEST_SQUARED <= square && square < self.reach * self.reach;
        if !touches || w == R::ZERO {
            return None;
        }
        let distance = square.sqrt();
        let normal = apart * (R::ONE / distance);
        let [stiff, damp] = [self.stiffness * h * h, self.damping * h];
        let along = normal.dot(moved);
        let yielding = R::ONE + (stiff + damp) * w;
        let asked = stiff * (self.reach - distance) - damp * along;
        let push = R::max(asked / yielding, R::ZERO);
        let slip = moved - normal * along;
        let mut drag = R::ZERO;
        if self.friction != R::ZERO {
            let grip = (self.stiffness / w).sqrt() * h;
            drag = grip / (R::ONE + grip * w);
            let (length, most) = (slip.dot(slip).sqrt(), push * self.friction);
            if most < drag * length {
                drag = most / length;
            }
        }
        Some(normal * push - slip * drag)
    }
}

impl<R: Real> Closed<R> {
    /// The force on the second particle, newtons, and the power that is dissipated, watts.
    #[inline(always)]
    pub(super) fn pull(&self, law: &PairLaw<R>) -> (R::Vec3, R) {
        let force = self.normal * self.push - self.slip * self.grip;
        let lost = (self.overlap * law.stiffness - self.push) * self.rate;
        (force, lost + self.slip.dot(self.slip) * self.grip)
    }

    /// Its derivative, with the part of each particle in the motion of the second side as seen from
    /// the first.
    pub(super) fn tangent<const N: usize>(
        &self,
        law: &PairLaw<R>,
        particles: [u32; N],
        at: [u32; N],
        weights: [R; N],
    ) -> Touching<N> {
        let pushes = R::ZERO < self.push;
        let number = |value: R| if pushes { value.to_f64() } else { 0.0 };
        Touching {
            particles: particles.map(|particle| particle as usize),
            at: at.map(|at| at as usize),
            weights: weights.map(R::to_f64),
            normal: self.normal.to_f64(),
            slide: DVec3::ZERO,
            along: number(law.stiffness),
            across: -number(law.stiffness * self.overlap / self.distance),
            damping: number(law.damping),
            grip: number(self.grip),
        }
    }
}
