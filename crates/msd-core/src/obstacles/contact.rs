//! The law of contact: where a particle inside an obstacle goes, and with which velocity.

use super::{Obstacle, PlaneColumn};
use crate::columns::threads::{Split, merge_shares};
use crate::columns::{self, LANES, RECORD};
use crate::number::{Real, Vector, at_level};
use crate::scene::Friction;
use fearless_simd::Level;

/// How a surface gives back and slows what touches it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactLaw<R> {
    /// Fraction of the normal speed that a bounce returns, 0 to 1.
    pub(crate) restitution: R,
    /// Coulomb's factor.
    pub(crate) friction: R,
    /// The fraction of the tangential velocity that each contact takes, 0 to 1.
    pub(crate) loss: R,
}

impl<R: Real> ContactLaw<R> {
    /// The law of a surface that returns a fraction of the normal speed, with some friction.
    pub fn new(restitution: f64, friction: Friction) -> Self {
        let (friction, loss) = match friction {
            Friction::Coulomb(factor) => (factor, 0.0),
            Friction::TangentialLoss(loss) => (0.0, loss),
        };
        ContactLaw { restitution: R::of(restitution), friction: R::of(friction), loss: R::of(loss) }
    }

    /// The velocity after a bounce, as seen from the surface, metres per second.
    ///
    /// A normal velocity v_n < 0 becomes −e v_n, or 0 where it is slower than `resting`, so that a
    /// resting contact does not buzz. Coulomb friction takes at most μ (1 + e) |v_n| from the
    /// tangential speed. Without a branch, so that sixteen are computed at once.
    ///
    /// Source: algorithm 1 of the source report (2014), with Coulomb's law beside its factor.
    #[inline(always)]
    pub(crate) fn bounce(&self, n: [R; 3], v: [R; 3], resting: R) -> [R; 3] {
        let speed = v[0] * n[0] + v[1] * n[1] + v[2] * n[2];
        let t = [v[0] - n[0] * speed, v[1] - n[1] * speed, v[2] - n[2] * speed];
        let restitution = if -speed < resting { R::ZERO } else { self.restitution };
        let after = if R::ZERO <= speed { speed } else { -(restitution * speed) };
        let slip = (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
        let loss = self.friction * (after - speed);
        let left = R::ONE - loss / slip;
        let kept = if slip <= loss { R::ZERO } else { left } * (R::ONE - self.loss);
        [n[0] * after + t[0] * kept, n[1] * after + t[1] * kept, n[2] * after + t[2] * kept]
    }

    /// [`ContactLaw::bounce`] of vectors.
    pub(crate) fn bounced(&self, normal: R::Vec3, velocity: R::Vec3, resting: R) -> R::Vec3 {
        let bounced = self.bounce(normal.components(), velocity.components(), resting);
        R::Vec3::from_components(bounced)
    }
}

/// The speed towards a surface below which a contact rests, metres per second: what gravity adds in
/// two substeps.
pub(crate) fn resting_speed<R: Real>(normal: R::Vec3, gravity: R::Vec3, h: R) -> R {
    (h + h) * gravity.dot(normal).abs()
}

/// What obstacles did in one substep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Particles moved out of an obstacle; one in a corner counts once for each.
    pub count: usize,
    /// Energy taken away, joules: kinetic energy lost less the potential energy gained by moving
    /// the particle against the force on it, which is taken as constant over the move.
    pub energy: f64,
}

impl core::ops::AddAssign for Contacts {
    fn add_assign(&mut self, other: Self) {
        self.count += other.count;
        self.energy += other.energy;
    }
}

/// What a substep ends with, as contact needs it.
#[derive(Debug)]
pub(crate) struct Bodies<'a, R: Real> {
    /// Masses, a number for each slot, and their reciprocals, three for each.
    pub(crate) masses: &'a [R],
    pub(crate) inverse_masses: &'a [R],
    /// Forces of the last evaluation, newtons, for the energy alone.
    pub(crate) forces: &'a [R],
    pub(crate) positions: &'a mut [R],
    pub(crate) velocities: &'a mut [R],
    pub(crate) gravity: R::Vec3,
    /// Length of the substep, seconds, and the time at its end.
    pub(crate) h: R,
    pub(crate) time: f64,
}

impl<R: Real> Bodies<'_, R> {
    /// The same, lent for a shorter time.
    fn reborrow(&mut self) -> Bodies<'_, R> {
        Bodies { positions: &mut *self.positions, velocities: &mut *self.velocities, ..*self }
    }
}

impl<R: Real> Split for Bodies<'_, R> {
    fn numbers(&self) -> usize {
        self.positions.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let (low_masses, masses) = self.masses.split_at(numbers / 3);
        let (low_inverse_masses, inverse_masses) = self.inverse_masses.split_at(numbers);
        let (low_forces, forces) = self.forces.split_at(numbers);
        let (low_positions, positions) = self.positions.split_at_mut(numbers);
        let (low_velocities, velocities) = self.velocities.split_at_mut(numbers);
        let low = Bodies {
            masses: low_masses,
            inverse_masses: low_inverse_masses,
            forces: low_forces,
            positions: low_positions,
            velocities: low_velocities,
            ..self
        };
        (low, Bodies { masses, inverse_masses, forces, positions, velocities, ..self })
    }
}

/// Moves every particle out of a plane, and lets it bounce.
pub(crate) fn resolve_plane<R: Real>(
    level: Level,
    plane: &PlaneColumn<R>,
    bodies: &mut Bodies<'_, R>,
) -> Contacts {
    let resolve =
        |mut bodies: Bodies<'_, R>| at_level!(level, _simd => resolve_lanes(plane, &mut bodies));
    let add = |mut low: Contacts, high| {
        low += high;
        low
    };
    merge_shares(bodies.reborrow(), &resolve, &add)
}

#[inline(always)]
fn resolve_lanes<R: Real>(plane: &PlaneColumn<R>, bodies: &mut Bodies<'_, R>) -> Contacts {
    let Bodies { masses, inverse_masses, forces, positions, velocities, gravity, h, .. } = bodies;
    let resting = resting_speed::<R>(plane.normal, *gravity, *h);
    let (n, offset, law) = (plane.normal.components(), plane.offset, plane.law);
    let mut contacts = Contacts::default();
    let rows = positions.as_chunks_mut::<RECORD>().0.iter_mut();
    let rows = rows.zip(velocities.as_chunks_mut::<RECORD>().0).enumerate();
    for (record, (x, v)) in rows {
        let depth = |x: &[R; RECORD], l: usize| {
            offset - (n[0] * x[l] + n[1] * x[LANES + l] + n[2] * x[2 * LANES + l])
        };
        let mut below = 0u32;
        for l in 0..LANES {
            below |= u32::from(R::ZERO < depth(x, l));
        }
        if below == 0 {
            continue;
        }
        let numbers = record * RECORD..(record + 1) * RECORD;
        let w: &[R; RECORD] = inverse_masses[numbers.clone()].first_chunk().expect("a record");
        let f: &[R; RECORD] = forces[numbers].first_chunk().expect("a record");
        let mass: &[R; LANES] = masses[record * LANES..].first_chunk().expect("a record");
        let (mut energies, mut hits) = ([0.0; LANES], [0u32; LANES]);
        for l in 0..LANES {
            let [ix, iy, iz] = [l, LANES + l, 2 * LANES + l];
            let depth = depth(x, l);
            let on = (R::ZERO < depth) & (w[l] != R::ZERO);
            let before = [v[ix], v[iy], v[iz]];
            let after = law.bounce(n, before, resting);
            let moved = [n[0] * depth, n[1] * depth, n[2] * depth];
            let square = |v: [R; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
            let slower = square(before) - square(after);
            let work = f[ix] * moved[0] + f[iy] * moved[1] + f[iz] * moved[2];
            let energy = (slower * R::HALF * mass[l]).to_f64() + work.to_f64();
            energies[l] = if on { energy } else { 0.0 };
            hits[l] = u32::from(on);
            for (axis, at) in [ix, iy, iz].into_iter().enumerate() {
                x[at] = if on { x[at] + moved[axis] } else { x[at] };
                v[at] = if on { after[axis] } else { v[at] };
            }
        }
        contacts.count += hits.iter().sum::<u32>() as usize;
        contacts.energy += energies.iter().sum::<f64>();
    }
    contacts
}

/// Moves particles out of any obstacle, one by one, and lets them bounce; `places` are those of all
/// particles.
pub(crate) fn resolve_one_by_one<R: Real>(
    obstacle: &dyn Obstacle<R>,
    places: impl Iterator<Item = usize>,
    bodies: &mut Bodies<'_, R>,
) -> Contacts {
    let mut contacts = Contacts::default();
    let (law, time) = (obstacle.law(), bodies.time);
    for at in places {
        let position = columns::vector::<R>(bodies.positions, at);
        let depth = -obstacle.gap(position, time);
        let is_inside = R::ZERO < depth;
        if !is_inside || bodies.inverse_masses[at] == R::ZERO {
            continue;
        }
        let normal = obstacle.normal(position, time);
        let surface = obstacle.velocity(position, time);
        let resting = resting_speed::<R>(normal, bodies.gravity, bodies.h);
        let before = columns::vector::<R>(bodies.velocities, at);
        let after = law.bounced(normal, before - surface, resting) + surface;
        let moved = normal * depth;
        let slower = before.dot(before) - after.dot(after);
        let slowed = slower * R::HALF * bodies.masses[columns::single(at)];
        let work = columns::vector::<R>(bodies.forces, at).dot(moved);
        columns::set_vector(bodies.positions, at, position + moved);
        columns::set_vector(bodies.velocities, at, after);
        contacts += Contacts { count: 1, energy: slowed.to_f64() + work.to_f64() };
    }
    contacts
}
