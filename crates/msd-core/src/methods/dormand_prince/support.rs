//! Constrained accelerations: the part that obstacles leave to a particle that they hold.

use crate::contact::held::{Limit, Limits, MOST};
use crate::number::{Real, Vector};
use crate::obstacles::{ContactLaw, Obstacle};
use crate::system::Model;

/// Obstacles that hold one particle at a time.
pub(crate) const MOST_OBSTACLES: usize = MOST;
/// Sweeps over the obstacles of a corner. At right angles two are exact.
const MOST_SWEEPS: usize = 100;
/// The longest time over which the motion of an obstacle is taken as smooth, seconds.
const SMOOTH: f64 = 0.1;

/// Position and velocity of a particle at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot<R: Real> {
    pub(crate) position: R::Vec3,
    pub(crate) velocity: R::Vec3,
    /// Simulated time, seconds.
    pub(crate) time: f64,
    /// Radius of the particle against obstacles, metres.
    pub(crate) radius: R,
}

impl<R: Real> Spot<R> {
    /// Where it is in `way` seconds if nothing acts on it.
    fn ahead(&self, way: f64) -> Self {
        let position = self.position + self.velocity * R::of(way);
        Spot { position, time: self.time + way, ..*self }
    }

    /// The largest length that gaps are the difference of, about, metres.
    pub(crate) fn extent(&self) -> R {
        self.position.extent() + self.radius
    }

    /// The gap between the particle and an obstacle, metres.
    pub(crate) fn gap<O: Obstacle<R> + ?Sized>(&self, obstacle: &O) -> R {
        obstacle.gap(self.position, self.time) - self.radius
    }

    /// Whether it moves along the surface of an obstacle rather than into or off it, as it does
    /// behind an edge. Any speed up to `slow` counts as along, metres per second.
    pub(crate) fn is_along(&self, obstacle: &dyn Obstacle<R>, slow: R) -> bool {
        let &Spot { position, velocity, time, .. } = self;
        let sliding = velocity - obstacle.velocity(position, time);
        let quarter = R::of(0.25) * sliding.dot(sliding).sqrt();
        self.speed_off(obstacle).abs() <= quarter + slow
    }

    /// The speed away from the surface of an obstacle, metres per second.
    pub(crate) fn speed_off<O: Obstacle<R> + ?Sized>(&self, obstacle: &O) -> R {
        let &Spot { position, velocity, time, .. } = self;
        (velocity - obstacle.velocity(position, time)).dot(obstacle.normal(position, time))
    }
}

/// An obstacle at a spot.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bearing<R: Real> {
    pub(crate) normal: R::Vec3,
    /// Velocity of the surface, metres per second.
    pub(crate) velocity: R::Vec3,
    /// Acceleration of the surface as the particle sees it, metres per second squared.
    acceleration: R::Vec3,
    /// Acceleration away from the surface of a particle that goes straight on, metres per second
    /// squared: v²/r on a ball at rest.
    pub(crate) lift: R,
    pub(crate) law: ContactLaw<R>,
    /// Acceleration for each unit of pressure: the normal and, where the surface passes by a
    /// particle that another one carries, the friction against that.
    reaction: R::Vec3,
    passes: bool,
}

impl<R: Real> Bearing<R> {
    /// An obstacle at a spot; only a plane is flat and at rest.
    ///
    /// The speed away from the surface is n·(v − u), u being the surface's. Its derivative along
    /// the straight path is a central difference, whose error, ε/δ + δ², is least about the cube
    /// root of ε.
    pub(crate) fn new(model: &Model<R>, index: usize, spot: &Spot<R>) -> Self {
        if let Some(plane) = model.obstacles.planes.get(index) {
            let (normal, law) = (plane.normal, plane.law);
            return Bearing { normal, law, reaction: normal, ..Bearing::default() };
        }
        let obstacle = model.obstacles.get(index);
        let &Spot { position, velocity, time, .. } = spot;
        let epsilon = if R::EPSILON.to_f64() < 1e-10 { 1e-5 } else { 4e-3 };
        let speed = velocity.dot(velocity).sqrt().to_f64();
        let reach = epsilon * Real::min(SMOOTH, model.size / speed);
        let [before, after] = [-reach, reach].map(|way| spot.ahead(way));
        let surface = |spot: &Spot<R>| obstacle.velocity(spot.position, spot.time);
        let rate = R::of(0.5 / reach);
        let normal = obstacle.normal(position, time);
        Bearing {
            normal,
            velocity: surface(spot),
            acceleration: (surface(&after) - surface(&before)) * rate,
            lift: (after.speed_off(obstacle) - before.speed_off(obstacle)) * rate,
            law: obstacle.law(),
            reaction: normal,
            passes: false,
        }
    }
}

/// The obstacles that hold a particle, at a spot.
pub(crate) struct Bearings<R: Real> {
    rows: [Bearing<R>; MOST_OBSTACLES],
    count: usize,
}

/// An acceleration constrained by obstacles.
pub(crate) struct Support<R: Real> {
    pub(crate) slope: R::Vec3,
    /// Normal force on each obstacle per mass, metres per second squared.
    pub(crate) pressures: [R; MOST_OBSTACLES],
    /// The least of them.
    pub(crate) least: R,
    /// Largest deceleration by friction along the obstacles, metres per second squared.
    pub(crate) grip: R,
    /// Whether nothing slides.
    pub(crate) glued: bool,
}

/// Whether an obstacle only pushes, or pulls as well.
#[derive(Clone, Copy)]
pub(crate) enum Constraint {
    Unilateral,
    Bilateral,
}

impl<R: Real> Bearings<R> {
    pub(crate) fn new(model: &Model<R>, obstacles: &[u32], spot: &Spot<R>) -> Self {
        let mut rows = [Bearing::default(); MOST_OBSTACLES];
        for (row, &obstacle) in rows.iter_mut().zip(obstacles) {
            *row = Bearing::new(model, obstacle as usize, spot);
        }
        let mut touches = Bearings { rows, count: obstacles.len() };
        touches.set_reactions(spot.velocity);
        touches
    }

    /// Finds the surfaces that pass by: a piston that pushes a particle along a floor carries it.
    fn set_reactions(&mut self, velocity: R::Vec3) {
        let (carried, first) = (self.velocity(), self.rows[0].velocity);
        let rows = &mut self.rows[..self.count];
        if rows.iter().all(|touch| touch.velocity == first) {
            return;
        }
        for touch in rows {
            let (passing, sliding) = (carried - touch.velocity, velocity - touch.velocity);
            let rounding = R::of(8.0) * R::EPSILON * (carried.extent() + touch.velocity.extent());
            let speed = sliding.dot(sliding).sqrt();
            touch.passes = rounding < passing.extent() && R::ZERO < speed;
            if touch.passes {
                touch.reaction -= sliding * (touch.law.friction / speed);
            }
        }
    }

    /// Projects an acceleration out of the obstacles (Gauss's principle of least constraint). Its
    /// part along each normal becomes the one that keeps the particle on a curved or moving
    /// surface.
    pub(crate) fn support(&self, pull: R::Vec3, constraint: Constraint) -> Support<R> {
        let (slope, pressures) = self.fit(pull, constraint, |touch| (-touch.lift, touch.reaction));
        let (mut grip, mut glued, mut least) = (R::ZERO, false, pressures[0]);
        for (&pressure, touch) in pressures.iter().zip(&self.rows[..self.count]) {
            least = least.min(pressure);
            if !touch.passes {
                grip += touch.law.friction * pressure;
                glued |= R::ZERO < touch.law.loss && R::ZERO < pressure;
            }
        }
        Support { slope, pressures, least, grip, glued }
    }

    /// The velocity of a particle that does not slide, metres per second: that of the first
    /// surface, as far as the others let it.
    pub(crate) fn velocity(&self) -> R::Vec3 {
        let wanted = |touch: &Bearing<R>| (touch.velocity.dot(touch.normal), touch.normal);
        self.fit(self.rows[0].velocity, Constraint::Bilateral, wanted).0
    }

    /// The acceleration of a particle that does not slide, metres per second squared.
    pub(crate) fn acceleration(&self) -> R::Vec3 {
        let wanted = |touch: &Bearing<R>| (-touch.lift, touch.normal);
        self.fit(self.rows[0].acceleration, Constraint::Bilateral, wanted).0
    }

    /// Changes a vector until its part along each normal has the wanted value, in a direction for
    /// each, and returns the changes as well. Those along the normals come first, the others from
    /// there by the method of Gauss and Seidel.
    fn fit(
        &self,
        vector: R::Vec3,
        constraint: Constraint,
        wanted: impl Fn(&Bearing<R>) -> (R, R::Vec3),
    ) -> (R::Vec3, [R; MOST_OBSTACLES]) {
        let rows = &self.rows[..self.count];
        let mut pressures = [R::ZERO; MOST_OBSTACLES];
        if 1 < self.count {
            let mut held = Limits::default();
            for touch in rows {
                let least = wanted(touch).0;
                held.push(Limit { normal: touch.normal, least, ..Limit::default() });
            }
            pressures = match constraint {
                Constraint::Unilateral => held.push_out(vector).1,
                Constraint::Bilateral => held.pull_to(vector),
            };
        }
        let pulled = rows.iter().zip(pressures);
        let mut vector = pulled.fold(vector, |sum, (row, push)| sum + wanted(row).1 * push);
        let close = vector.extent() * R::EPSILON;
        for _ in 0..MOST_SWEEPS {
            let mut largest = R::ZERO;
            for (pressure, touch) in pressures.iter_mut().zip(rows) {
                let (part, direction) = wanted(touch);
                let lacks = part - vector.dot(touch.normal);
                let change = match constraint {
                    Constraint::Unilateral => lacks.max(-*pressure),
                    Constraint::Bilateral => lacks,
                };
                *pressure += change;
                vector += direction * change;
                largest = largest.max(change.abs());
            }
            if self.count < 2 || largest <= close {
                break;
            }
        }
        (vector, pressures)
    }
}
