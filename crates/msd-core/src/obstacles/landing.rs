//! A particle that meets an obstacle of any form, and one that has no room between several.

use super::contact::{Contacts, Span, Touch, dot, rounding};
use super::{Obstacle, Obstacles, Placed};
use crate::number::{Real, Vector};

/// A particle that has met an obstacle.
pub(super) struct Landed<R> {
    pub(super) position: [R; 3],
    pub(super) velocity: [R; 3],
    pub(super) contacts: Contacts,
}

/// Lets a particle of some mass inside an obstacle meet it; the obstacle may move.
pub(super) fn meet_surface<R: Real>(
    obstacle: &dyn Obstacle<R>,
    mut touch: Touch<R>,
    (span, time): (&Span<R>, f64),
    mass: R,
) -> Landed<R> {
    let (law, before) = (obstacle.law(), touch.velocity);
    let surface = obstacle.velocity(R::Vec3::from_components(touch.position), time).components();
    for (axis, &carried) in surface.iter().enumerate() {
        touch.velocity[axis] -= carried;
        touch.start[axis] += carried * span.h;
    }
    let way = touch.way();
    let keeps = law.keeps(&touch, span);
    let outcome = if keeps { law.hold(&touch, span) } else { law.bounce(&touch, span) };
    let after = core::array::from_fn(|axis| outcome.velocity[axis] + surface[axis]);
    let kick = core::array::from_fn(|axis| after[axis] - before[axis]);
    let contacts = Contacts {
        driven: (dot(kick, surface) * mass).to_f64(),
        bounced: !keeps,
        turned: span.turn * span.turn < dot(way, way),
        ..Contacts::one((outcome.taken * mass).to_f64())
    };
    Landed { position: outcome.position, velocity: after, contacts }
}

/// Corrections of a gap at most.
const CORRECTIONS: usize = 3;

/// Puts a particle back on the surface that it left along a tangent, as friction takes back some
/// of its way. What hovers over a surface is not held there by [`super::rest`].
pub(super) fn onto<R: Real>(
    obstacle: &dyn Obstacle<R>,
    touch: &Touch<R>,
    landed: &mut Landed<R>,
    time: f64,
) {
    let (normal, position) = (touch.normal, &mut landed.position);
    // Each time the square of the angle of the way along the surface is left.
    for _ in 0..CORRECTIONS {
        let gap = obstacle.gap(R::Vec3::from_components(*position), time) - touch.radius;
        if gap.abs() <= rounding(normal, *position, touch.radius) {
            break;
        }
        for (number, normal) in position.iter_mut().zip(normal) {
            *number -= normal * gap;
        }
    }
}

/// Rounds over all obstacles, each of which puts a particle out of them one after the other: of a
/// depth in a groove they leave the cosine of its angle, squared and to that power.
const ROUNDS: usize = 8;

/// Whether a particle of some radius that was put out of several obstacles has no room outside of
/// all: it stays inside one however often it is put out of each.
#[cold]
pub(super) fn is_squeezed<R: Real>(
    obstacles: &Obstacles<R>,
    (mut place, radius): (R::Vec3, R),
    time: f64,
) -> bool {
    let noise = rounding([R::ONE; 3], place.components(), radius) * R::of(16.0);
    let mut round = || {
        let mut deepest = R::ZERO;
        let mut put_out = |obstacle: &dyn Obstacle<R>| {
            let depth = radius - obstacle.gap(place, time);
            if R::ZERO < depth {
                place = place + obstacle.normal(place, time) * depth;
                deepest = deepest.max(depth);
            }
        };
        obstacles.planes.iter().for_each(|plane| put_out(plane));
        obstacles.solids.iter().for_each(|solid| put_out(&Placed::new(solid, time)));
        deepest
    };
    let first = round();
    noise < first && (1..ROUNDS).all(|_| first * R::HALF < round())
}
