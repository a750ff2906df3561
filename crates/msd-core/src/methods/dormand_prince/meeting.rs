//! Contact of one particle with several obstacles: its new motion, and which of them hold it.

use super::holds::{Along, Hold};
use super::support::{Bearing, Bearings, Constraint, MOST_OBSTACLES, Spot, Support};
use crate::contact::law::bounced;
use crate::number::{Real, Vector};
use crate::system::Model;

/// Rounds of one particle between obstacles; one in a narrow wedge then loses its speed into them.
const MOST_ROUNDS: usize = 8;

/// A particle in contact with obstacles.
pub(super) struct Meeting<'a, R: Real> {
    pub(super) model: &'a Model<R>,
    pub(super) spot: Spot<R>,
    /// Its acceleration without obstacles, metres per second squared.
    pub(super) pull: R::Vec3,
    pub(super) hop: R,
    pub(super) slack: R,
    pub(super) blur: R,
    pub(super) hold: Hold<R>,
    pub(super) met: bool,
    /// Work by mass of the surfaces that gave it its velocity, joules per kilogram.
    pub(super) driven: R,
}

impl<R: Real> Meeting<'_, R> {
    /// Lets it meet every obstacle until nothing is new.
    pub(super) fn meet_obstacles(&mut self) {
        let count = self.model.obstacles.count();
        for _ in 0..MOST_ROUNDS {
            let mut news = false;
            for index in 0..count {
                news |= self.meet_obstacle(index);
            }
            if !news {
                return;
            }
        }
        for index in 0..count {
            let obstacle = self.model.obstacles.get(index);
            let speed = self.spot.speed_off(obstacle);
            if self.gap(index) <= self.slack && speed < R::ZERO {
                let normal = obstacle.normal(self.spot.position, self.spot.time);
                let surface = obstacle.velocity(self.spot.position, self.spot.time);
                self.kick(self.spot.velocity - normal * speed, surface);
            }
        }
    }

    /// Gives it a velocity, by a surface that has another.
    fn kick(&mut self, velocity: R::Vec3, surface: R::Vec3) {
        self.driven += (velocity - self.spot.velocity).dot(surface);
        self.spot.velocity = velocity;
    }

    fn gap(&self, index: usize) -> R {
        self.spot.gap(self.model.obstacles.get(index))
    }

    fn touches(&self) -> Bearings<R> {
        Bearings::new(self.model, self.hold.obstacles(), &self.spot)
    }

    /// Returns whether other obstacles may see something new.
    fn meet_obstacle(&mut self, index: usize) -> bool {
        let depth = -self.gap(index);
        if depth < -self.hop || self.hold.obstacles().contains(&(index as u32)) {
            return false;
        }
        let mut touch = Bearing::new(self.model, index, &self.spot);
        if R::ZERO < depth {
            self.spot.position += touch.normal * depth;
            touch = Bearing::new(self.model, index, &self.spot);
        }
        let Bearing { normal, velocity, lift, law, .. } = touch;
        let height = R::max(-depth, R::ZERO);
        let speed = (self.spot.velocity - velocity).dot(normal);
        let push = -(self.slope_beside(velocity).dot(normal) + lift);
        let two = R::ONE + R::ONE;
        let low = R::ZERO < push && speed * speed <= two * push * (self.hop - height);
        if low && self.hold.count < MOST_OBSTACLES {
            self.spot.position -= normal * height;
            self.rest(&touch, speed);
            self.hold.keep(index as u32);
            self.met = true;
            return true;
        }
        if speed < R::ZERO && height <= self.slack {
            self.spot.position -= normal * height;
            let bounced = bounced(&law, normal, self.spot.velocity - velocity);
            self.kick(velocity + bounced, velocity);
            self.leave();
            self.met = true;
            return true;
        }
        false
    }

    /// Lets go of obstacles that an impact on another one throws it off.
    fn leave(&mut self) {
        let (obstacles, count) = (self.hold.obstacles, self.hold.count);
        self.hold.count = 0;
        let still = self.hop * self.pull.dot(self.pull).sqrt();
        for &obstacle in &obstacles[..count] {
            let speed = self.spot.speed_off(self.model.obstacles.get(obstacle as usize));
            if speed <= R::ZERO || speed * speed <= still + still {
                self.hold.keep(obstacle);
            }
        }
    }

    /// The acceleration left by the obstacles that hold it already, as seen by another one that
    /// moves at its own velocity. Their friction presses the particle against one that moves
    /// relative to them.
    fn slope_beside(&self, velocity: R::Vec3) -> R::Vec3 {
        let touches = self.touches();
        let Support { slope, grip, .. } = touches.support(self.pull, Constraint::Unilateral);
        let carried = touches.velocity();
        let sliding = self.spot.velocity - carried;
        let speed = sliding.dot(sliding).sqrt();
        if velocity == carried || speed == R::ZERO {
            return slope;
        }
        slope - sliding * (grip / speed)
    }

    /// Removes the remaining normal speed. The hops not made would have pressed less on the
    /// obstacle because of it (more if the particle came down), which changes friction.
    fn rest(&mut self, touch: &Bearing<R>, speed: R) {
        let sliding = self.spot.velocity - touch.velocity - touch.normal * speed;
        let along = sliding.dot(sliding).sqrt();
        let kept = if R::ZERO < along {
            R::max(R::ZERO, R::ONE + touch.law.friction * speed / along)
        } else {
            R::ONE
        };
        self.kick(touch.velocity + sliding * kept, touch.velocity);
    }

    /// Finds out whether it slides or sticks.
    pub(super) fn slide(&mut self) {
        if self.hold.count == 0 {
            return;
        }
        let Support { slope, pressures, grip, glued, .. } =
            self.touches().support(self.pull, Constraint::Unilateral);
        self.keep_pressed(pressures);
        let touches = self.touches();
        let carried = touches.velocity();
        let (sliding, slope) = (self.spot.velocity - carried, slope - touches.acceleration());
        let speed = sliding.dot(sliding).sqrt();
        let pull = slope.dot(slope).sqrt();
        self.hold.along = if glued {
            Along::Glued
        } else if grip <= R::ZERO {
            Along::Free
        } else if speed * speed <= grip * self.blur && grip <= pull + pull {
            // A slow slide takes the direction of the pull.
            let direction = slope * (R::ONE / pull);
            let speed = sliding.dot(direction).max(R::ZERO);
            self.kick(carried + direction * speed, carried);
            let ends = self.ends(speed, grip - pull);
            if ends { Along::Sticks } else { Along::Creeps(direction) }
        } else if R::ZERO < speed && !self.ends(speed, grip - slope.dot(sliding) / speed) {
            self.hold.turn = speed / grip;
            Along::Slides(sliding * (R::ONE / speed))
        } else {
            Along::Sticks
        };
        if matches!(self.hold.along, Along::Glued | Along::Sticks) {
            self.kick(carried, carried);
        }
    }

    /// Whether a deceleration would end the slide within a hop.
    fn ends(&self, speed: R, brake: R) -> bool {
        R::ZERO <= brake && speed * speed <= (brake + brake) * self.hop
    }

    /// Leaves out the obstacles on which another one leaves no pressure.
    fn keep_pressed(&mut self, pressures: [R; MOST_OBSTACLES]) {
        let (obstacles, count) = (self.hold.obstacles, self.hold.count);
        self.hold.count = 0;
        for (&obstacle, pressure) in obstacles[..count].iter().zip(pressures) {
            if R::ZERO < pressure {
                self.hold.keep(obstacle);
            }
        }
    }
}
