//! A row: a contact of up to four particles, and the impulse that it gives.

use crate::columns::{add_vector, vector};
use crate::contact::law::coulomb;
use crate::number::{Real, Vector};
use glam::DVec3;

/// A contact: up to four particles, and what keeps two sides of them apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactRow<R: Real> {
    /// Which features: their kind, and the number of each.
    pub(super) key: u64,
    /// Where the numbers of each particle are in a column of vectors, and their weights: positive
    /// on one side, negative on the other.
    pub(super) at: [u32; 4],
    pub(super) weights: [R; 4],
    pub(super) count: usize,
    /// Direction from the second side to the first, length one.
    pub(super) normal: R::Vec3,
    /// A face that takes the couple of friction: whether there is one, where the numbers of its
    /// corners are, and the distance of both sides times the gradient of their weights.
    pub(super) turns: bool,
    pub(super) turning: [u32; 3],
    pub(super) turns_by: [R::Vec3; 3],
    /// The distance at which it stops them, and by how much they are farther apart, metres.
    pub(super) stop: R,
    pub(super) gap: R,
    /// Velocity of the second side where that is an obstacle, metres per second.
    pub(super) carried: R::Vec3,
    /// The mass that both sides have along the normal, kilograms.
    pub(super) mass: R,
    pub(super) friction: R,
    /// The impulse given along the normal and across it, newton seconds.
    pub(super) push: R,
    pub(super) rub: R::Vec3,
    /// The velocity of one side as seen from the other before the last kick, metres per second, and
    /// the impulse that has been booked already.
    pub(super) before: R::Vec3,
    pub(super) booked: R::Vec3,
}

/// The impulse of a row, from which the next substep starts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RowImpulse {
    /// Which features it is between: their kind, and the number of each.
    pub key: u64,
    /// Along the normal, newton seconds.
    pub push: f64,
    /// Across the normal, newton seconds.
    pub rub: DVec3,
}

/// Kinds of rows, in the highest bits of their keys.
pub(super) const FACE: u64 = 0;
pub(super) const EDGE: u64 = 1;
pub(super) const VERTEX: u64 = 2;
pub(super) const EDGES: u64 = 3;
/// What marks a row of a vertex and an obstacle among those of edges.
pub(super) const OBSTACLE: u64 = 1 << 61;

/// The bits of the number of a feature in a key.
const MOST_FEATURES: u64 = (1 << 30) - 1;

pub(super) fn key(kind: u64, a: u32, b: u32) -> u64 {
    kind << 62 | u64::from(a) << 30 | u64::from(b)
}

/// The two features of a key.
pub(super) fn features(key: u64) -> [u32; 2] {
    [key >> 30 & MOST_FEATURES, key & MOST_FEATURES].map(|number| number as u32)
}

impl<R: Real> Default for ContactRow<R> {
    fn default() -> Self {
        ContactRow {
            key: 0,
            at: [0; 4],
            weights: [R::ZERO; 4],
            count: 0,
            normal: R::Vec3::ZERO,
            turns: false,
            turning: [0; 3],
            turns_by: [R::Vec3::ZERO; 3],
            stop: R::ZERO,
            gap: R::ZERO,
            carried: R::Vec3::ZERO,
            mass: R::ZERO,
            friction: R::ZERO,
            push: R::ZERO,
            rub: R::Vec3::ZERO,
            before: R::Vec3::ZERO,
            booked: R::Vec3::ZERO,
        }
    }
}

impl<R: Real> ContactRow<R> {
    /// A vector of one side as seen from the other.
    #[inline(always)]
    pub(super) fn relative(&self, column: &[R]) -> R::Vec3 {
        self.sum(|at| vector::<R>(column, at))
    }

    /// The sum of a vector of each particle, by the weights, and of what the turning face adds
    /// across the normal.
    #[inline(always)]
    pub(super) fn sum(&self, of: impl Fn(usize) -> R::Vec3) -> R::Vec3 {
        let each = self.at.iter().zip(self.weights).take(self.count);
        let sum = each.fold(R::Vec3::ZERO, |sum, (&at, weight)| sum + of(at as usize) * weight);
        if !self.turns {
            return sum;
        }
        let each = self.turning.iter().zip(self.turns_by);
        each.fold(sum, |sum, (&at, by)| sum + by * self.normal.dot(of(at as usize)))
    }

    /// The velocity of one side as seen from the other, metres per second.
    #[inline(always)]
    pub(super) fn velocity(&self, velocities: &[R]) -> R::Vec3 {
        self.relative(velocities) - self.carried
    }

    /// Gives both sides an impulse, newton seconds; or, of a column of positions, a way of theirs
    /// times the mass.
    ///
    /// Friction acts on both sides at the same place, half way between them or not: a face takes
    /// the couple of the two forces, which are some distance apart.
    #[inline(always)]
    pub(super) fn give(&self, column: &mut [R], inverse_masses: &[R], impulse: R::Vec3) {
        self.share(column, impulse, |at| inverse_masses[at]);
    }

    /// Adds a vector to both sides, by the weights and a number of each particle.
    #[inline(always)]
    pub(super) fn share(&self, column: &mut [R], vector: R::Vec3, by: impl Fn(usize) -> R) {
        for (&at, weight) in self.at.iter().zip(self.weights).take(self.count) {
            let at = at as usize;
            add_vector::<R>(column, at, vector * (weight * by(at)));
        }
        if self.turns {
            for (&at, turn) in self.turning.iter().zip(self.turns_by) {
                let at = at as usize;
                let part = vector.dot(turn) * by(at);
                add_vector::<R>(column, at, self.normal * part);
            }
        }
    }

    /// The impulse that it has given, newton seconds.
    pub(super) fn impulse(&self) -> R::Vec3 {
        self.normal * self.push + self.rub
    }

    /// Corrects its impulse so that the sides do not come closer than they may at a speed, metres
    /// per second, and Coulomb's law holds.
    #[inline(always)]
    pub(super) fn correct(&mut self, velocities: &mut [R], inverse_masses: &[R], may_close: R) {
        let velocity = self.velocity(velocities);
        let speed = velocity.dot(self.normal);
        let push = (self.push - (speed + may_close) * self.mass).max(R::ZERO);
        if push == R::ZERO && self.push == R::ZERO {
            return;
        }
        let slip = velocity - self.normal * speed;
        let wanted = self.rub - slip * self.mass;
        let (_, per_size) = coulomb(wanted.dot(wanted).sqrt(), self.friction * push);
        let kept = if per_size == R::ZERO { R::ONE } else { self.friction * push * per_size };
        let rub = wanted * kept;
        let change = self.normal * (push - self.push) + (rub - self.rub);
        (self.push, self.rub) = (push, rub);
        self.give(velocities, inverse_masses, change);
    }
}
