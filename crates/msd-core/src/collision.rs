//! What happens to a particle that has entered a plane?

use crate::real::{Real, Vector};
use crate::scene::Friction;
use crate::system::{Model, PlaneColumn, State};

/// What the planes did in one substep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Particles moved out of a plane; one in a corner counts once per plane.
    pub count: usize,
    /// Energy taken away, joules: kinetic energy lost less the potential energy gained by moving
    /// the particle against the force on it.
    ///
    /// The force is taken as constant over the move, so what a fast impact does to stiff springs is
    /// counted to first order in the depth.
    pub energy: f64,
}

/// Moves every particle out of every plane, bounces it and slows it along the plane.
///
/// The position is projected on the plane. A normal velocity v_n < 0 becomes −e v_n; where it is
/// slower than what gravity adds in two substeps (2 h |g·n|) it becomes 0, so that a resting
/// contact does not buzz. Coulomb friction takes at most μ (1 + e) |v_n| from the tangential speed.
/// `forces` are those of the last evaluation, newtons, for the energy alone.
///
/// Source: algorithm 1 of the source report (2014), with Coulomb's law beside its factor.
pub fn resolve<R: Real>(
    model: &Model<R>,
    h: R,
    forces: &[R::Vec3],
    state: &mut State<R>,
) -> Contacts {
    let mut contacts = Contacts::default();
    for plane in &model.planes {
        let resting_speed = resting_speed(plane, model.gravity, h);
        for (particle, &force) in forces.iter().enumerate() {
            let depth = plane.offset - plane.normal.dot(state.positions[particle]);
            if depth <= R::ZERO || model.inverse_masses[particle] == R::ZERO {
                continue;
            }
            let moved = plane.normal * depth;
            let velocity = state.velocities[particle];
            let bounced = bounce(plane, velocity, resting_speed);
            state.positions[particle] += moved;
            state.velocities[particle] = bounced;
            let slower = velocity.dot(velocity) - bounced.dot(bounced);
            let slowed = slower * R::HALF * model.masses[particle];
            contacts.count += 1;
            contacts.energy += slowed.to_f64() + force.dot(moved).to_f64();
        }
    }
    contacts
}

/// The speed towards a plane below which a contact rests, metres per second: what gravity adds in
/// two substeps.
pub(crate) fn resting_speed<R: Real>(plane: &PlaneColumn<R>, gravity: R::Vec3, h: R) -> R {
    (h + h) * gravity.dot(plane.normal).abs()
}

/// The velocity after a bounce; a normal speed below `resting_speed` is not returned.
pub(crate) fn bounce<R: Real>(
    plane: &PlaneColumn<R>,
    velocity: R::Vec3,
    resting_speed: R,
) -> R::Vec3 {
    let normal_speed = velocity.dot(plane.normal);
    let tangential = velocity - plane.normal * normal_speed;
    let leaving = R::ZERO <= normal_speed;
    let restitution = if -normal_speed < resting_speed { R::ZERO } else { plane.restitution };
    let after = if leaving { normal_speed } else { -(restitution * normal_speed) };
    let kept = match plane.friction {
        Friction::TangentialLoss(loss) => R::ONE - R::of(loss),
        Friction::Coulomb(factor) => {
            let speed = tangential.dot(tangential).sqrt();
            let loss = R::of(factor) * (after - normal_speed);
            if speed <= loss { R::ZERO } else { R::ONE - loss / speed }
        }
    };
    plane.normal * after + tangential * kept
}
