//! What obstacles leave of the acceleration of a particle that they hold.

use crate::number::{Real, Vector};
use crate::obstacles::{ContactLaw, Obstacle};
use crate::system::Model;

/// Obstacles that hold one particle at a time; three independent ones leave it nowhere to go.
pub(crate) const MOST_OBSTACLES: usize = 4;
/// Sweeps over the obstacles of a corner. At right angles two are exact.
const MOST_SWEEPS: usize = 100;
/// The longest time over which the motion of an obstacle is taken as smooth, seconds.
const SMOOTH: f64 = 0.1;

/// Where a particle is, how fast, and when.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot<R: Real> {
    pub(crate) position: R::Vec3,
    pub(crate) velocity: R::Vec3,
    /// Simulated time, seconds.
    pub(crate) time: f64,
}

impl<R: Real> Spot<R> {
    /// Where it is in `way` seconds if nothing acts on it.
    fn ahead(&self, way: f64) -> Self {
        let position = self.position + self.velocity * R::of(way);
        Spot { position, velocity: self.velocity, time: self.time + way }
    }

    /// The speed away from the surface of an obstacle, metres per second.
    pub(crate) fn speed_off<O: Obstacle<R> + ?Sized>(&self, obstacle: &O) -> R {
        let &Spot { position, velocity, time } = self;
        (velocity - obstacle.velocity(position, time)).dot(obstacle.normal(position, time))
    }
}

/// An obstacle at a spot.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Touch<R: Real> {
    pub(crate) normal: R::Vec3,
    /// Velocity of the surface, metres per second.
    pub(crate) velocity: R::Vec3,
    /// Acceleration of the surface as the particle sees it, metres per second squared.
    acceleration: R::Vec3,
    /// How fast a particle that goes straight on speeds up away from the surface, metres per second
    /// squared: v²/r on a ball at rest.
    pub(crate) lift: R,
    pub(crate) law: ContactLaw<R>,
}

impl<R: Real> Touch<R> {
    /// An obstacle at a spot; only a plane is flat and at rest.
    ///
    /// The speed away from the surface is n·(v − u), u being the surface's. Its derivative along the
    /// straight path is a central difference, whose error, ε/δ + δ², is least about the cube root
    /// of ε.
    pub(crate) fn new(model: &Model<R>, index: usize, spot: &Spot<R>) -> Self {
        if let Some(plane) = model.obstacles.planes.get(index) {
            return Touch { normal: plane.normal, law: plane.law, ..Touch::default() };
        }
        let obstacle = model.obstacles.get(index);
        let &Spot { position, velocity, time } = spot;
        let epsilon = if R::EPSILON.to_f64() < 1e-10 { 1e-5 } else { 4e-3 };
        let speed = velocity.dot(velocity).sqrt().to_f64();
        let reach = epsilon * Real::min(SMOOTH, model.size / speed);
        let [before, after] = [-reach, reach].map(|way| spot.ahead(way));
        let surface = |spot: &Spot<R>| obstacle.velocity(spot.position, spot.time);
        let rate = R::of(0.5 / reach);
        Touch {
            normal: obstacle.normal(position, time),
            velocity: surface(spot),
            acceleration: (surface(&after) - surface(&before)) * rate,
            lift: (after.speed_off(obstacle) - before.speed_off(obstacle)) * rate,
            law: obstacle.law(),
        }
    }
}

/// The obstacles that hold a particle, at a spot.
pub(crate) struct Touches<R: Real> {
    rows: [Touch<R>; MOST_OBSTACLES],
    count: usize,
}

/// What obstacles leave of an acceleration.
pub(crate) struct Support<R: Real> {
    pub(crate) slope: R::Vec3,
    /// Normal force on each obstacle per mass, metres per second squared.
    pub(crate) pressures: [R; MOST_OBSTACLES],
    /// The least of them.
    pub(crate) least: R,
    /// What friction may take along the obstacles, metres per second squared.
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

impl<R: Real> Touches<R> {
    pub(crate) fn new(model: &Model<R>, obstacles: &[u32], spot: &Spot<R>) -> Self {
        let mut rows = [Touch::default(); MOST_OBSTACLES];
        for (row, &obstacle) in rows.iter_mut().zip(obstacles) {
            *row = Touch::new(model, obstacle as usize, spot);
        }
        Touches { rows, count: obstacles.len() }
    }

    /// Projects an acceleration out of the obstacles (Gauss's principle of least constraint): its
    /// part along each normal becomes what keeps the particle on a curved or moving surface.
    pub(crate) fn support(&self, pull: R::Vec3, constraint: Constraint) -> Support<R> {
        let (slope, pressures) = self.fit(pull, constraint, |touch| -touch.lift);
        let (mut grip, mut glued, mut least) = (R::ZERO, false, pressures[0]);
        for (&pressure, Touch { law, .. }) in pressures.iter().zip(&self.rows[..self.count]) {
            least = least.min(pressure);
            grip += law.friction * pressure;
            glued |= R::ZERO < law.loss && R::ZERO < pressure;
        }
        Support { slope, pressures, least, grip, glued }
    }

    /// The velocity of a particle that does not slide, metres per second: that of the first surface,
    /// as far as the others let it.
    pub(crate) fn velocity(&self) -> R::Vec3 {
        let wanted = |touch: &Touch<R>| touch.velocity.dot(touch.normal);
        self.fit(self.rows[0].velocity, Constraint::Bilateral, wanted).0
    }

    /// The acceleration of a particle that does not slide, metres per second squared.
    pub(crate) fn acceleration(&self) -> R::Vec3 {
        let wanted = |touch: &Touch<R>| -touch.lift;
        self.fit(self.rows[0].acceleration, Constraint::Bilateral, wanted).0
    }

    /// Changes a vector along the normals until its part along each is what is wanted, by the method
    /// of Gauss and Seidel; returns the changes as well.
    fn fit(
        &self,
        mut vector: R::Vec3,
        constraint: Constraint,
        wanted: impl Fn(&Touch<R>) -> R,
    ) -> (R::Vec3, [R; MOST_OBSTACLES]) {
        let mut pressures = [R::ZERO; MOST_OBSTACLES];
        let close = vector.extent() * R::EPSILON;
        for _ in 0..MOST_SWEEPS {
            let mut largest = R::ZERO;
            for (pressure, touch) in pressures.iter_mut().zip(&self.rows[..self.count]) {
                let lacks = wanted(touch) - vector.dot(touch.normal);
                let change = match constraint {
                    Constraint::Unilateral => lacks.max(-*pressure),
                    Constraint::Bilateral => lacks,
                };
                *pressure += change;
                vector += touch.normal * change;
                largest = largest.max(change.abs());
            }
            if self.count < 2 || largest <= close {
                break;
            }
        }
        (vector, pressures)
    }
}
