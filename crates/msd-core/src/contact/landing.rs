//! A particle that meets an obstacle of any form, and one that has no room between several.

use super::held::{Limit, Limits, MOST, Stopped};
use super::law::{Contacts, Span, Touch, bounce, hold, keeps, rounding};
use crate::number::{Real, Vector};
use crate::obstacles::{Obstacle, Obstacles, Placed};
use crate::pack::{dot, each};

/// A particle that has met an obstacle.
pub(crate) struct Landed<R> {
    pub(crate) position: [R; 3],
    pub(crate) velocity: [R; 3],
    pub(crate) contacts: Contacts,
}

/// Lets a particle of some mass inside an obstacle meet it; the obstacle may move.
#[inline(always)]
pub(crate) fn meet_surface<R: Real>(
    obstacle: &(impl Obstacle<R> + ?Sized),
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
    let keeps = keeps(&law, &touch, span);
    let outcome = if keeps { hold(&law, &touch, span) } else { bounce(&law, &touch, span) };
    let after = each(|axis| outcome.velocity[axis] + surface[axis]);
    let kick = each(|axis| after[axis] - before[axis]);
    let contacts = Contacts {
        driven: (dot(kick, surface) * mass).to_f64(),
        bounced: !keeps,
        turned: span.turn * span.turn < dot(way, way),
        ..Contacts::one((outcome.taken * mass).to_f64())
    };
    Landed { position: outcome.position, velocity: after, contacts }
}

/// A particle that has come into several obstacles in a substep.
pub(crate) struct Arrival<R: Real> {
    /// It, without a surface.
    touch: Touch<R>,
    rows: Limits<R>,
    /// Its depth in each, metres, and the depth that counts as none.
    depths: [(R, R); MOST],
}

impl<R: Real> Arrival<R> {
    pub(crate) fn new(touch: Touch<R>) -> Self {
        Arrival { touch, rows: Limits::default(), depths: [(R::ZERO, R::ZERO); MOST] }
    }

    /// The number of surfaces.
    pub(crate) fn count(&self) -> usize {
        self.rows.rows().len()
    }

    /// Adds a surface that it is so deep in, metres, or on within some noise.
    pub(crate) fn add(&mut self, row: Limit<R>, depth_and_noise: (R, R)) {
        self.depths[self.count()] = depth_and_noise;
        self.rows.push(row);
    }

    /// Its acceleration on the surfaces that it lay on. Where a method holds particles after each
    /// kick, these are the surfaces that it is on still, as one that it met within the substep is
    /// further off.
    fn slope(&self, span: &Span<R>) -> R::Vec3 {
        let mut lain = Limits::<R>::default();
        for (row, (depth, noise)) in self.rows.rows().iter().zip(self.depths) {
            if span.settles() && depth.abs() <= noise {
                lain.push(Limit { normal: row.normal, ..Limit::default() });
            }
        }
        let pull = R::Vec3::from_components(self.touch.pull);
        if lain.rows().is_empty() { pull } else { lain.push_out(pull).0 }
    }

    /// Sets the speeds at which it bounces off surfaces, and returns the part of its way since it
    /// met the last of them, and whether it bounces.
    fn meet(&mut self, span: &Span<R>) -> (R, bool) {
        let (mut since, mut bounces) = (R::ONE, false);
        for (row, &(depth, noise)) in self.rows.rows_mut().iter_mut().zip(&self.depths) {
            let mut touch = Touch { normal: row.normal.components(), depth, noise, ..self.touch };
            for (axis, carried) in row.surface.components().into_iter().enumerate() {
                touch.velocity[axis] -= carried;
                touch.start[axis] += carried * span.h;
            }
            if !keeps(&row.law, &touch, span) {
                let (_, squared) = touch.impact(span);
                row.least = row.law.restitution * squared.max(R::ZERO).sqrt();
                bounces = true;
            }
            let way = dot(touch.normal, touch.way());
            if noise < -(way + depth) && way < R::ZERO {
                since = since.min(depth.max(R::ZERO) / -way);
            }
        }
        (since, bounces)
    }

    /// Where it is and how fast, once all of them have held it; `depth` is how deep a place is in
    /// the surface of a number, metres.
    ///
    /// As with a single one ([`hold`]), a particle that sticks goes back to where it met them. One
    /// that slides goes back by the way that friction would have saved. Energy is that of the
    /// motion at the start of the substep, by a constant force.
    pub(crate) fn land(
        mut self,
        (span, lag): (&Span<R>, R),
        mass: R,
        depth: impl Fn(usize, R::Vec3) -> R,
    ) -> Landed<R> {
        let [position, velocity, pull] =
            [self.touch.position, self.touch.velocity, self.touch.pull]
                .map(R::Vec3::from_components);
        let slope = self.slope(span);
        // Its displacement was that of the motion along the surfaces that it lay on.
        let start = R::Vec3::from_components(self.touch.start) + (slope - pull) * (lag * span.h);
        self.touch.start = start.components();
        let (since, bounces) = self.meet(span);
        let held = self.hold(velocity, (slope - pull) * (since * span.h));
        let mut to = if held.sticks {
            let way = position - (start + self.rows.rows()[0].surface * span.h);
            position - way * since
        } else {
            let pushes = self.rows.rows().iter().zip(held.pushes);
            let normal = pushes.fold(R::Vec3::ZERO, |sum, (row, push)| sum + row.normal * push);
            let pushed = held.pushes.into_iter().fold(R::ZERO, R::add);
            let deep =
                self.depths.iter().fold(R::ZERO, |sum, &(depth, _)| sum + depth.max(R::ZERO));
            let time = if R::ZERO < pushed { (deep / pushed).min(span.h) } else { R::ZERO };
            let rubbed = held.velocity - velocity - normal;
            let is_rough = self.rows.rows().iter().any(|row| row.law.friction != R::ZERO);
            if is_rough { position + rubbed * time } else { position }
        };
        // Surfaces that bend take the square of the way each time.
        for _ in 0..CORRECTIONS {
            let mut lifts = Limits::default();
            for (number, (row, &(_, noise))) in
                self.rows.rows().iter().zip(&self.depths).enumerate()
            {
                let deep = depth(number, to);
                let least = if deep <= noise { R::ZERO } else { deep };
                lifts.push(Limit { normal: row.normal, least, ..Limit::default() });
            }
            let lift = lifts.push_out(R::Vec3::ZERO).0;
            if lift == R::Vec3::ZERO {
                break;
            }
            to += lift;
        }
        let before = velocity - slope * span.h;
        let slower = (before.dot(before) - held.velocity.dot(held.velocity)) * R::HALF;
        let taken = slower + pull.dot(to - start) + held.driven;
        let contacts = Contacts {
            count: self.count() as u64,
            driven: (held.driven * mass).to_f64(),
            bounced: bounces,
            ..Contacts::one((taken * mass).to_f64())
        };
        let [position, velocity] = [to, held.velocity].map(Vector::components);
        Landed { position, velocity, contacts }
    }

    /// The velocity that the surfaces leave it, which have borne it by an impulse by mass since it
    /// met the last of them.
    ///
    /// A surface that the last one pushes it off has borne it in vain since then. Without this a
    /// particle that slides through the foot of a groove gains speed there.
    fn hold(&self, velocity: R::Vec3, borne: R::Vec3) -> Stopped<R> {
        let held = self.rows.hold(velocity);
        let pushes = held.pushes.iter().zip(self.depths);
        let leaves =
            |(&push, (depth, noise)): (&R, (R, R))| push == R::ZERO && depth.abs() <= noise;
        if pushes.take(self.count()).any(leaves) { self.rows.hold(velocity - borne) } else { held }
    }
}

/// Corrections of a gap at most.
const CORRECTIONS: usize = 3;

/// Puts a particle back on the surface that it left along a tangent, as friction takes back some of
/// its way. [`super::after_kick`] does not hold a particle that hovers over a surface.
pub(crate) fn onto<R: Real>(
    obstacle: &(impl Obstacle<R> + ?Sized),
    touch: &Touch<R>,
    landed: &mut Landed<R>,
    time: f64,
) {
    let (normal, position) = (touch.normal, &mut landed.position);
    // Each time the square of the angle of the way along the surface is left.
    for _ in 0..CORRECTIONS {
        let gap = obstacle.gap(R::Vec3::from_components(*position), time) - touch.radius;
        if gap.abs() <= touch.noise {
            break;
        }
        for (number, normal) in position.iter_mut().zip(normal) {
            *number -= normal * gap;
        }
    }
}

/// Rounds over all obstacles, each of which puts a particle out of them one after the other. Of a
/// depth in a groove they leave the cosine of its angle, squared and to that power.
const ROUNDS: usize = 8;

/// Returns whether a particle of some radius that was put out of several obstacles has no room
/// outside of all. It stays inside one however often it is put out of each.
#[cold]
pub(crate) fn is_squeezed<R: Real>(
    obstacles: &Obstacles<R>,
    (mut place, radius): (R::Vec3, R),
    time: f64,
) -> bool {
    let noise = {
        let [x, y, z] = place.components().map(R::abs);
        rounding(x + y + z, radius) * R::of(16.0)
    };
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
