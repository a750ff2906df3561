//! Contact at rest on several obstacles.

use super::super::held::{self, Limit, Limits, Stopped};
use super::super::law::{Contacts, rounding};
use super::{Drift, Kick, Kicked, lay};
use crate::columns::{LANES, RECORD, set_vector, vector};
use crate::number::{Real, Vector};
use crate::obstacles::Obstacles;

/// Iterations that find how particles bend with a surface, at most. Each leaves of a gap the angle
/// by which the surface turns in a substep, squared, and times the friction.
pub(super) const BENDS: usize = 8;

/// Holds a particle that lies on several obstacles, by all of them at once.
pub(super) fn settle_in_corner<R: Real>(
    obstacles: &Obstacles<R>,
    kicked: &mut Kicked<'_, R>,
    (record, lane): (usize, usize),
    contacts: &mut Contacts,
) {
    let (at, kick) = (record * RECORD + lane, kicked.kick);
    let (position, radius) = (vector::<R>(kicked.places.positions, at), kicked.places.radii.at(at));
    let v = vector::<R>(kicked.velocities, at);
    let a = vector::<R>(kicked.accelerations, at);
    let start = v - a * kick.length;
    let limit = (kick.substep + kick.substep) * a.dot(a).sqrt();
    let (mut rows, mut indices) = (Limits::default(), [0; held::MOST]);
    for index in 0..obstacles.count() {
        if kicked.found.on(record, index) >> lane & 1 == 0 {
            continue;
        }
        let obstacle = obstacles.get(index);
        let row = Limit {
            normal: obstacle.normal(position, kick.time),
            surface: obstacle.velocity(position, kick.time),
            least: R::ZERO,
            law: kick.law(obstacle.law()),
        };
        let seen = start - row.surface;
        let lay = lay(&row.law, row.normal.dot(seen), -limit, seen.components());
        if kick.drift == Drift::Behind || lay {
            if let Some(to) = indices.get_mut(rows.rows().len()) {
                *to = index;
            }
            rows.push(row);
        }
    }
    let mut held = rows.hold(v);
    if kick.drift == Drift::Ahead {
        for _ in 0..BENDS {
            if !bend_in_corner(obstacles, (&mut rows, &indices), ((position, radius), &held), &kick)
            {
                break;
            }
            held = rows.hold(v);
        }
    }
    if held.pushes.iter().all(|&push| push == R::ZERO) {
        return;
    }
    set_vector(kicked.velocities, at, held.velocity);
    let mass = kicked.masses[record * LANES + lane];
    let taken = if held.sticks {
        let seen = start - held.velocity;
        seen.dot(seen) * R::HALF
    } else {
        (v - held.velocity).dot(start + held.velocity) * R::HALF + held.driven
    };
    *contacts += Contacts {
        driven: (held.driven * mass).to_f64(),
        ..Contacts::one((taken * mass).to_f64())
    };
}

/// Turns the velocity that a particle may have on each surface of a corner, so that it lies on it
/// after the drift, as [`super::curved`] does on one. Returns whether any was off.
fn bend_in_corner<R: Real>(
    obstacles: &Obstacles<R>,
    (rows, indices): (&mut Limits<R>, &[usize; held::MOST]),
    ((position, radius), held): ((R::Vec3, R), &Stopped<R>),
    kick: &Kick<R>,
) -> bool {
    let end = position + held.velocity * kick.substep;
    let time = kick.time + kick.substep.to_f64();
    let mut is_any = false;
    for ((row, &index), push) in rows.rows_mut().iter_mut().zip(indices).zip(held.pushes) {
        if index < obstacles.planes.len() {
            continue;
        }
        let obstacle = obstacles.get(index);
        let gap = obstacle.gap(end, time) - radius;
        let noise = rounding(obstacle.terms(end, time), radius) * R::HALF;
        if noise < -gap || R::ZERO < push && noise < gap {
            row.least -= gap / kick.substep;
            is_any = true;
        }
    }
    is_any
}
