//! A row: a contact of up to four particles, and the impulse that it gives.

use super::features::Shells;
use crate::columns::add_vector;
use crate::contact::law::coulomb;
use crate::number::{Real, Vector};
use glam::DVec3;

/// A contact: up to four particles, and the impulse that keeps two sides of them apart.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ContactRow<R: Real> {
    /// The features: their kind, and the number of each.
    pub(super) key: u64,
    /// The vertices, and their weights: positive on one side, negative on the other, and 0 for an
    /// entry that is not a particle of the row.
    pub(super) vertices: [u32; 4],
    pub(super) weights: [R; 4],
    /// Direction from the second side to the first, length one.
    pub(super) normal: R::Vec3,
    /// A face that takes the couple of friction: whether there is one, its corners, and the
    /// distance of both sides times the gradient of their weights.
    pub(super) turns: bool,
    pub(super) turning: [u32; 3],
    pub(super) turns_by: [R::Vec3; 3],
    /// The distance at which it stops them, and their distance beyond that, metres.
    pub(super) stop: R,
    pub(super) gap: R,
    /// Velocity of the second side where that is an obstacle, or at which both sides of an overlap
    /// part, metres per second.
    pub(super) carried: R::Vec3,
    /// The mass that both sides have along the normal, kilograms.
    pub(super) mass: R,
    pub(super) friction: R,
    pub(super) restitution: R,
    /// The speed at which both sides part once they met in this substep, metres per second.
    pub(super) parting: R,
    /// The impulse given along the normal and across it, newton seconds.
    pub(super) push: R,
    pub(super) rub: R::Vec3,
    /// The impulse that has been booked already, newton seconds.
    pub(super) booked: R::Vec3,
}

/// The impulse of a row, from which the next substep starts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RowImpulse {
    /// The features that it is between: their kind, and the number of each.
    pub key: u64,
    /// Along the normal, newton seconds.
    pub push: f64,
    /// Across the normal, newton seconds.
    pub rub: DVec3,
    /// The normal, from its second side to the first, length one: once that has turned about, both
    /// have gone through each other.
    pub normal: DVec3,
}

/// Kinds of rows, in the highest bits of their keys.
pub(super) const FACE: u64 = 0;
pub(super) const EDGE: u64 = 1;
pub(super) const VERTEX: u64 = 2;
pub(super) const EDGES: u64 = 3;
/// The bit that marks a row of a vertex and an obstacle among those of edges.
pub(super) const OBSTACLE: u64 = 1 << 61;

/// The bit that marks a row of a vertex inside another shell among those of edges.
pub(super) const OVERLAP: u64 = 1 << 60;

/// The bits of the number of a feature in a key.
const MOST_FEATURES: u64 = (1 << 30) - 1;

pub(super) fn key(kind: u64, a: u32, b: u32) -> u64 {
    kind << 62 | u64::from(a) << 30 | u64::from(b)
}

/// The two features of a key.
pub(super) fn features(key: u64) -> [u32; 2] {
    [key >> 30 & MOST_FEATURES, key & MOST_FEATURES].map(|number| number as u32)
}

impl<R: Real> ContactRow<R> {
    pub(super) fn is_of_obstacle(&self) -> bool {
        EDGES << 62 | OBSTACLE <= self.key
    }

    /// Whether it is of a vertex that is inside another shell.
    pub(super) fn is_of_overlap(&self) -> bool {
        !self.is_of_features() && !self.is_of_obstacle()
    }

    /// The shells of such a row: that of the vertex, and the other.
    pub(super) fn overlapping(&self, shells: &Shells) -> [usize; 2] {
        let [vertex, solid] = features(self.key);
        [shells.shell_of(vertex), solid as usize]
    }

    /// Whether it is between two features that are nearest to each other.
    pub(super) fn is_of_features(&self) -> bool {
        self.key < EDGES << 62 | OVERLAP
    }

    /// A vector of one side as seen from the other.
    #[inline(always)]
    pub(super) fn relative(&self, column: &[R::Vec3]) -> R::Vec3 {
        let sum = self.apart(column);
        if !self.turns {
            return sum;
        }
        let each = self.turning.iter().zip(self.turns_by);
        each.fold(sum, |sum, (&at, by)| sum + by * self.normal.dot(column[at as usize]))
    }

    /// The same, but for the part across the normal that the turning face adds.
    #[inline(always)]
    fn apart(&self, column: &[R::Vec3]) -> R::Vec3 {
        let each = self.vertices.iter().zip(self.weights);
        each.fold(R::Vec3::ZERO, |sum, (&at, weight)| sum + column[at as usize] * weight)
    }

    /// The velocity of one side as seen from the other, metres per second.
    #[inline(always)]
    pub(super) fn velocity(&self, velocities: &[R::Vec3]) -> R::Vec3 {
        self.relative(velocities) - self.carried
    }

    /// Whether its sides part, or come closer at less than a speed, metres per second.
    #[inline(always)]
    pub(super) fn is_open(&self, velocities: &[R::Vec3], may_close: R) -> bool {
        let velocity = self.apart(velocities) - self.carried;
        R::ZERO <= velocity.dot(self.normal) + may_close
    }

    /// Gives both sides an impulse, newton seconds; or, of a column of positions, a way of theirs
    /// times the mass.
    ///
    /// Friction acts on both sides at the same place, half way between them or not. A face takes
    /// the couple of the two forces, which are some distance apart.
    #[inline(always)]
    pub(super) fn give(&self, column: &mut [R::Vec3], inverse_masses: &[R], impulse: R::Vec3) {
        let mass = |vertex: u32| inverse_masses[vertex as usize];
        self.share(impulse, mass, |vertex, part| column[vertex as usize] += part);
    }

    /// Shares a vector among both sides, by the weights and a number of each vertex.
    #[inline(always)]
    pub(super) fn share(
        &self,
        vector: R::Vec3,
        by: impl Fn(u32) -> R,
        mut add: impl FnMut(u32, R::Vec3),
    ) {
        for (&vertex, weight) in self.vertices.iter().zip(self.weights) {
            add(vertex, vector * (weight * by(vertex)));
        }
        if self.turns {
            for (&vertex, turn) in self.turning.iter().zip(self.turns_by) {
                add(vertex, self.normal * (vector.dot(turn) * by(vertex)));
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
    pub(super) fn correct(
        &mut self,
        velocities: &mut [R::Vec3],
        inverse_masses: &[R],
        may_close: R,
    ) {
        let velocity = self.velocity(velocities);
        let (push, rub, _) = self.answer(velocity, may_close, self.mass);
        if push == R::ZERO && self.push == R::ZERO {
            return;
        }
        let change = self.normal * (push - self.push) + (rub - self.rub);
        (self.push, self.rub) = (push, rub);
        self.give(velocities, inverse_masses, change);
    }

    /// The impulse, along the normal and across it, by which a mass, kilograms, answers the
    /// velocity of one side, and the fraction of the holding impulse that the second is: Coulomb's
    /// law.
    #[inline(always)]
    pub(super) fn answer(&self, velocity: R::Vec3, may_close: R, mass: R) -> (R, R::Vec3, R) {
        let speed = velocity.dot(self.normal);
        let push = (self.push - (speed + may_close) * mass).max(R::ZERO);
        let most = self.friction * push;
        let wanted = self.rub - (velocity - self.normal * speed) * mass;
        let (_, per_size) = coulomb(wanted.dot(wanted).sqrt(), most);
        let kept = if per_size == R::ZERO { R::ONE } else { most * per_size };
        let grip = if most == R::ZERO { R::ZERO } else { kept };
        (push, wanted * kept, grip)
    }
}

/// A row in a solve.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InSolve<R: Real> {
    /// The stiffness, kilograms, and the part of it that acts across the normal.
    pub(super) stiffness: R,
    pub(super) grip: R,
    pub(super) is_stiff: bool,
    /// Number of times that it began or ceased to act.
    pub(super) changes: u32,
    /// The impulse along the normal and across it as last corrected, newton seconds.
    pub(super) push: R,
    pub(super) rub: R::Vec3,
    /// The velocity for which the impulse of the row was computed, metres per second.
    pub(super) velocity: R::Vec3,
    /// The impulse that the last solve found, newton seconds.
    pub(super) found: R::Vec3,
}

impl<R: Real> InSolve<R> {
    /// The stiffness times a change of velocity, newton seconds.
    #[inline(always)]
    pub(super) fn resist(&self, normal: R::Vec3, change: R::Vec3) -> R::Vec3 {
        let along = normal * change.dot(normal);
        (along + (change - along) * self.grip) * self.stiffness
    }
}

/// Adds the shares of a vector to the particles of a row in a column.
#[inline(always)]
pub(super) fn add_shares<R: Real>(
    row: &ContactRow<R>,
    shells: &Shells,
    vector: R::Vec3,
    column: &mut [R],
) {
    let at = |vertex: u32| shells.vertices[vertex as usize].at as usize;
    row.share(vector, |_| R::ONE, |vertex, part| add_vector::<R>(column, at(vertex), part));
}

/// The part of a distance up to which an overlap is left: all that a run makes by itself.
pub(super) const SLOP: f64 = 0.1;
