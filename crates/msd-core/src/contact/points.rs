//! Contact points on springs, for solids thinner than springs are long.
//!
//! Particles pass on both sides of a thin solid, and the springs between them through it. Where a
//! solid asks for it ([`Solid::springs`]) it meets points on springs too. A point at a part s of
//! the way from a to b moves as (1 − s) a + s b, and a push on it is shared out to the ends by the
//! same weights. So it meets a solid as a particle does, of the reciprocal mass (1 − s)²/m_a +
//! s²/m_b: momentum and energy are those of any other contact.

use super::ending::{Bodies, Substep};
use super::landing::meet_surface;
use super::law::{Contacts, Evaluated, Span, TURN, Touch, rounding};
use super::passage::{Entrance, Passage};
use crate::columns::slots::Slots;
use crate::columns::{RECORD, add_vector, single_of, vector};
use crate::elements::springs::Springs;
use crate::number::{Real, Vector};
use crate::obstacles::solid::Ball;
use crate::obstacles::{Obstacle, Placed};
use crate::scene::Solid;
use alloc::vec::Vec;

/// The most points on a spring.
const MOST_POINTS: usize = 15;

/// The springs with contact points, solid by solid.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    rows: Vec<Strings>,
}

/// The springs that have points for a solid.
#[derive(Clone, Debug)]
struct Strings {
    solid: usize,
    /// The longest of them, metres.
    longest: f64,
    springs: Vec<Pointed>,
}

/// A spring with contact points.
#[derive(Clone, Copy, Debug)]
struct Pointed {
    spring: u32,
    /// Where its ends are in a column of vectors.
    at: [u32; 2],
    count: u32,
}

/// The number of points on a spring of some length for a solid of some thickness, metres. It is 0
/// on a spring that is not longer, else large enough that they are half of the thickness apart.
fn count(length: f64, thickness: f64) -> u32 {
    if length <= thickness {
        return 0;
    }
    let parts = libm::ceil(2.0 * length / thickness);
    parts.min(MOST_POINTS as f64 + 1.0) as u32 - 1
}

impl Points {
    /// The points on the springs that are longer than a solid which meets them is thick.
    pub(crate) fn new<R: Real>(solids: &[Solid], springs: &Springs<R>, slots: &Slots) -> Self {
        let wanted = solids.iter().enumerate().filter(|(_, solid)| solid.springs);
        let row = |(number, solid): (usize, &Solid)| {
            let thickness = solid.shape.thickness();
            let mut row = Strings { solid: number, longest: 0.0, springs: Vec::new() };
            for (spring, ends) in springs.present() {
                let length = springs.rest_lengths()[spring].to_f64();
                let count = count(length, thickness);
                if 0 < count {
                    row.longest = f64::max(row.longest, length);
                    let at = ends.map(|particle| slots.at(particle) as u32);
                    row.springs.push(Pointed { spring: spring as u32, at, count });
                }
            }
            row
        };
        Points { rows: wanted.map(row).filter(|row| !row.springs.is_empty()).collect() }
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Lets the points that have come into their solid meet it.
    pub(crate) fn meet<R: Real>(
        &self,
        solids: &[Solid],
        springs: &Springs<R>,
        bodies: &mut Bodies<'_, R>,
    ) -> Contacts {
        let mut contacts = Contacts::default();
        for row in &self.rows {
            let (solid, time) = (&solids[row.solid], bodies.substep.time);
            // The middle of a spring is at most half its length from an end, stretched to four
            // times that at rest.
            let Substep { h, reach, .. } = bodies.substep;
            let margin = bodies.radii.largest + R::of(2.0 * row.longest) + reach;
            let wide = Ball::<R>::behind(solid, (time, h), margin);
            if !wide.may_hold_any(bodies.positions.as_chunks::<RECORD>().0) {
                continue;
            }
            let placed = Placed::new(solid, time);
            let passage = Passage::new(&placed, (time, h.to_f64()));
            for pointed in row.springs.iter().filter(|row| !springs.is_cut(row.spring as usize)) {
                let at = pointed.at.map(|at| at as usize);
                let [a, b] = at.map(|at| vector::<R>(bodies.positions, at));
                if wide.holds(a) || wide.holds(b) {
                    for number in 1..=pointed.count {
                        let part = f64::from(number) / f64::from(pointed.count + 1);
                        let point = Point { at, parts: [R::of(1.0 - part), R::of(part)] };
                        contacts += point.meet((&placed, &passage), bodies);
                    }
                }
            }
        }
        contacts
    }
}

/// Where a point of some radius is in a solid: below its entrance if it moved far, else below the
/// surface next to it.
fn inside<R: Real>(
    (placed, passage): (&Placed<'_>, &Passage<'_, '_>),
    (from, to): (R::Vec3, R::Vec3),
    radius: R,
    time: f64,
) -> Option<Entrance<R>> {
    let is_long = passage.is_long((to - from).components());
    let way = (from.components(), to.components());
    let swept = if is_long { passage.entrance(way, radius) } else { None };
    swept.or_else(|| {
        let gap = Obstacle::<R>::gap(placed, to, time);
        let normal = || Obstacle::<R>::normal(placed, to, time).components();
        (gap < radius).then(|| Entrance { normal: normal(), depth: radius - gap })
    })
}

/// A point on a spring.
struct Point<R> {
    at: [usize; 2],
    /// The weights of its ends.
    parts: [R; 2],
}

impl<R: Real> Point<R> {
    /// The mean of the vectors of its ends.
    fn of(&self, column: &[R]) -> R::Vec3 {
        let [a, b] = self.at.map(|at| vector::<R>(column, at));
        a * self.parts[0] + b * self.parts[1]
    }

    /// The mean of the numbers of its ends.
    fn mean(&self, [a, b]: [R; 2]) -> R {
        a * self.parts[0] + b * self.parts[1]
    }

    /// Lets it meet a solid, and moves the ends of its spring for it.
    fn meet(
        &self,
        (placed, passage): (&Placed<'_>, &Passage<'_, '_>),
        bodies: &mut Bodies<'_, R>,
    ) -> Contacts {
        let [first, last] = self.parts;
        let [w, u] = self.at.map(|at| bodies.inverse_masses[at]);
        let inverse_mass = first * first * w + last * last * u;
        let position = self.of(bodies.positions);
        let radius = self.mean(self.at.map(|at| bodies.radii.at(at)));
        if inverse_mass == R::ZERO {
            return Contacts::default();
        }
        let substep = bodies.substep;
        let pull = {
            let [a, b] = self.at.map(|at| vector::<R>(bodies.forces, at));
            a * (first * w) + b * (last * u)
        };
        let before = substep.before.map_or(pull, |column| self.of(column));
        let velocity = self.of(bodies.velocities);
        let start = match substep.starts {
            Some(column) => self.of(column),
            None => position - (velocity - pull * substep.lag) * substep.h,
        };
        let inside = inside((placed, passage), (start, position), radius, substep.time);
        let Some(Entrance { normal, depth }) = inside else { return Contacts::default() };
        let stiffness = self.mean(self.at.map(|at| single_of(bodies.stiffnesses, at)));
        let touch = Touch {
            normal,
            depth,
            position: position.components(),
            radius,
            noise: rounding(Obstacle::<R>::terms(placed, position, substep.time), radius),
            velocity: velocity.components(),
            start: start.components(),
            pull: pull.components(),
            before: before.components(),
            stiffness: stiffness * inverse_mass,
        };
        // Nothing else holds a point that lies.
        let evaluated = Evaluated::Nowhere;
        let (h, lag) = (substep.h, substep.lag);
        let turn = R::of(TURN * placed.solid.shape.bend());
        let span = Span { h, shift: lag - h * R::HALF, evaluated, turn };
        let met = meet_surface(placed, touch, (&span, substep.time), R::ONE / inverse_mass);
        let moved = R::Vec3::from_components(met.position) - position;
        let kick = R::Vec3::from_components(met.velocity) - velocity;
        for (at, share) in self.at.into_iter().zip([first * w, last * u]) {
            let share = share / inverse_mass;
            add_vector::<R>(bodies.positions, at, moved * share);
            add_vector::<R>(bodies.velocities, at, kick * share);
        }
        let turned = met.contacts.turned | passage.is_fast();
        let contacts = Contacts { turned, ..met.contacts };
        let Evaluated::AtEnd = substep.evaluated else { return contacts };
        // The ends may have met something in this substep already, and no longer have the energy of
        // its start. So the change counts, by the forces that are known at its end.
        let surface = Obstacle::<R>::velocity(placed, position, substep.time);
        let mean = velocity + kick * R::HALF - surface;
        let taken = pull.dot(moved) - mean.dot(kick) + touch.eased();
        let taken = Contacts::one((taken / inverse_mass).to_f64());
        Contacts { taken: taken.taken, added: taken.added, ..contacts }
    }
}
