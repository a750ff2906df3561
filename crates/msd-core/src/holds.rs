//! Which particles rest on a plane, and how does it hold them?
//!
//! Contact in the limit of short substeps. A particle that hits a plane bounces, and one that a
//! hop would not lift noticeably is held: the plane takes away the acceleration into it and, by
//! friction, some along it. All laws are functions of position and velocity that are continuous
//! while the same particles are held, so that the integrator keeps its order; in between are
//! events, see [`crate::events`].

use crate::collision::bounce;
use crate::real::{Real, Vector};
use crate::scene::Friction;
use crate::stages::ROUNDINGS;
use crate::system::{Model, Motion, PlaneColumn, State};
use alloc::vec::Vec;

/// Planes that hold one particle at a time; three independent ones leave it nowhere to go.
const MOST_PLANES: usize = 4;
/// Rounds of one particle between planes; one in a narrow wedge then loses its speed into them.
const MOST_ROUNDS: usize = 8;
/// The height of a hop that is none, as a fraction of the error allowed, at most.
const HOP: f64 = 0.1;
/// Sweeps over the planes of a corner. At right angles two are exact.
const MOST_SWEEPS: usize = 100;
/// The planes that hold a particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hold<R: Real> {
    pub(crate) particle: usize,
    planes: [u32; MOST_PLANES],
    count: usize,
    /// The direction in which friction finds it sliding, or zero: it sticks or there is none.
    pub(crate) direction: R::Vec3,
}

impl<R: Real> Hold<R> {
    pub(crate) fn planes(&self) -> &[u32] {
        &self.planes[..self.count]
    }
}

/// The held particles, in order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Holds<R: Real> {
    rows: Vec<Hold<R>>,
    /// A hop up to this height is none, metres.
    hop: R,
}

/// What meeting the planes did.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Met {
    /// Energy taken away, joules.
    pub(crate) energy: f64,
    /// Whether anything touched a plane.
    pub(crate) touched: bool,
    /// Whether the state changed by more than rounding, so that forces are stale.
    pub(crate) changed: bool,
}

/// What planes leave of an acceleration.
struct Support<R: Real> {
    slope: R::Vec3,
    /// What friction may take along the planes, metres per second squared.
    grip: R,
    /// Whether nothing slides.
    glued: bool,
}

impl<R: Real> Holds<R> {
    /// Forgets everything; `tolerance` is a fraction of `size`, metres.
    ///
    /// Where a particle is held instead of hopping, its speed changes. The height of a hop is like
    /// the square of a speed, so the hops left out are those below tolerance².
    pub(crate) fn reset(&mut self, tolerance: f64, size: f64) {
        self.rows.clear();
        self.hop = R::of(tolerance * Real::min(tolerance, HOP) * size);
    }

    /// The held particles, in order.
    pub(crate) fn rows(&self) -> &[Hold<R>] {
        &self.rows
    }

    /// The height of a hop that is none for a particle here, metres: never below rounding.
    pub(crate) fn hop_at(&self, position: R::Vec3) -> R {
        self.hop + rounding_at(position)
    }

    /// The distance below which a particle is at a plane, metres.
    pub(crate) fn slack_at(&self, position: R::Vec3) -> R {
        self.hop_at(position) / R::of(8.0)
    }

    /// Takes from accelerations what the planes hold. Returns the power of friction, watts.
    ///
    /// Into the planes no acceleration is left: of all that lead out of them the nearest is taken
    /// (Gauss's principle of least constraint), so that a particle is released where it is pulled
    /// off. Along them friction takes μ N / m against the slide or, of a particle that sticks, as
    /// much as there is. A plane holds up to the height of a hop.
    pub(crate) fn act(
        &self,
        model: &Model<R>,
        motion: Motion<'_, R>,
        slopes: &mut [R::Vec3],
    ) -> f64 {
        let mut power = 0.0;
        for hold in &self.rows {
            let row = hold.particle;
            let (position, velocity) = (motion.positions[row], motion.velocities[row]);
            let near = self.near(model, hold, position);
            let Support { slope, grip, glued } = support(model, near.planes(), slopes[row]);
            if glued {
                slopes[row] = R::Vec3::ZERO;
                continue;
            }
            slopes[row] = slope;
            if grip <= R::ZERO {
                continue;
            }
            let friction = friction(hold.direction, velocity, slope, grip);
            slopes[row] = slope + friction;
            power -= (friction.dot(velocity) * model.masses[row]).to_f64();
        }
        power
    }

    /// The hold without the planes that the particle has left.
    fn near(&self, model: &Model<R>, hold: &Hold<R>, position: R::Vec3) -> Hold<R> {
        let (mut near, hop) = (*hold, self.hop_at(position));
        near.count = 0;
        for &index in hold.planes() {
            let plane = &model.planes[index as usize];
            if plane.normal.dot(position) - plane.offset <= hop {
                near.planes[near.count] = index;
                near.count += 1;
            }
        }
        near
    }

    /// Lets every particle meet the planes it is at, and finds out which of them hold it.
    ///
    /// A particle at a plane is put on it and bounces if it moves into it. It is held if it is pushed into it with an acceleration a, and d + v_n²/(2 a), the top of its hop
    /// from a distance d, is no higher than a hop. A slide that would end within a hop has ended.
    /// `forces` are those at the state or near it, newtons.
    pub(crate) fn meet(
        &mut self,
        model: &Model<R>,
        forces: &[R::Vec3],
        state: &mut State<R>,
    ) -> Met {
        self.rows.clear();
        let mut met = Met::default();
        for (particle, &force) in forces.iter().enumerate() {
            let (position, w) = (state.positions[particle], model.inverse_masses[particle]);
            let (hop, slack) = (self.hop_at(position), self.slack_at(position));
            let is_near = |plane| distance(plane, position) <= hop;
            if w == R::ZERO || !model.planes.iter().any(is_near) {
                continue;
            }
            let velocity = state.velocities[particle];
            let planes = [0; MOST_PLANES];
            let hold = Hold { particle, planes, count: 0, direction: R::Vec3::ZERO };
            let mut guest =
                Guest { position, velocity, pull: force * w, hop, slack, hold, met: false };
            guest.meet_planes(model);
            guest.slide(model);
            let moved = guest.position - position;
            let kicked = guest.velocity - velocity;
            let slower = velocity.dot(velocity) - guest.velocity.dot(guest.velocity);
            let slowed = slower * R::HALF * model.masses[particle];
            met.energy += slowed.to_f64() + force.dot(moved).to_f64();
            met.touched |= guest.met;
            // Twice the rounding of a position; what takes as long as a hop to move as far.
            let unfelt = R::of(1.0 / 32.0) * rounding_at(position);
            met.changed |= unfelt * unfelt < moved.dot(moved)
                || unfelt * guest.pull.dot(guest.pull).sqrt() < kicked.dot(kicked);
            state.positions[particle] = guest.position;
            state.velocities[particle] = guest.velocity;
            if 0 < guest.hold.count {
                self.rows.push(guest.hold);
            }
        }
        met
    }
}

/// A particle that meets planes.
struct Guest<R: Real> {
    position: R::Vec3,
    velocity: R::Vec3,
    /// Its acceleration without planes, metres per second squared.
    pull: R::Vec3,
    hop: R,
    slack: R,
    hold: Hold<R>,
    met: bool,
}

impl<R: Real> Guest<R> {
    fn meet_planes(&mut self, model: &Model<R>) {
        for _ in 0..MOST_ROUNDS {
            let mut news = false;
            for index in 0..model.planes.len() {
                news |= self.meet_plane(model, index as u32);
            }
            if !news {
                return;
            }
        }
        for plane in &model.planes {
            let speed = self.velocity.dot(plane.normal);
            if distance(plane, self.position) <= self.slack && speed < R::ZERO {
                self.velocity -= plane.normal * speed;
            }
        }
    }

    /// Returns whether other planes may see something new.
    fn meet_plane(&mut self, model: &Model<R>, index: u32) -> bool {
        let plane = &model.planes[index as usize];
        let depth = -distance(plane, self.position);
        if depth < -self.hop || self.hold.planes().contains(&index) {
            return false;
        }
        if R::ZERO < depth {
            self.position += plane.normal * depth;
        }
        let height = R::max(-depth, R::ZERO);
        let speed = self.velocity.dot(plane.normal);
        let push = -support(model, self.hold.planes(), self.pull).slope.dot(plane.normal);
        let two = R::ONE + R::ONE;
        let low = R::ZERO < push && speed * speed <= two * push * (self.hop - height);
        if low && self.hold.count < MOST_PLANES {
            self.position -= plane.normal * height;
            self.rest(plane.normal, speed, plane.friction);
            self.hold.planes[self.hold.count] = index;
            self.hold.count += 1;
            self.met = true;
            return true;
        }
        if speed < R::ZERO && height <= self.slack {
            self.position -= plane.normal * height;
            self.velocity = bounce(plane, self.velocity, R::ZERO);
            self.met = true;
            return true;
        }
        false
    }

    /// Takes away the normal speed left. The hops that are not made would have pressed the less on
    /// the plane for it (the more if the particle came down), which friction feels.
    fn rest(&mut self, normal: R::Vec3, speed: R, friction: Friction) {
        self.velocity -= normal * speed;
        let Friction::Coulomb(factor) = friction else { return };
        let along = self.velocity.dot(self.velocity).sqrt();
        if R::ZERO < along {
            let kept = R::max(R::ZERO, R::ONE + R::of(factor) * speed / along);
            self.velocity = self.velocity * kept;
        }
    }

    /// Finds out whether it slides or sticks.
    fn slide(&mut self, model: &Model<R>) {
        if self.hold.count == 0 {
            return;
        }
        let Support { slope, grip, glued } = support(model, self.hold.planes(), self.pull);
        let speed = self.velocity.dot(self.velocity).sqrt();
        if glued {
            self.velocity = R::Vec3::ZERO;
        } else if R::ZERO < grip && R::ZERO < speed {
            let direction = self.velocity * (R::ONE / speed);
            let brake = grip - slope.dot(direction);
            let ends = R::ZERO < brake && speed * speed <= (brake + brake) * self.hop;
            if ends {
                self.velocity = R::Vec3::ZERO;
            } else {
                self.hold.direction = direction;
            }
        }
    }
}

/// Distances that are not told from none at a position, metres.
fn rounding_at<R: Real>(position: R::Vec3) -> R {
    position.extent() * (R::EPSILON * R::of(ROUNDINGS))
}

/// The signed distance of a point from a plane, metres; negative inside.
pub(crate) fn distance<R: Real>(plane: &PlaneColumn<R>, position: R::Vec3) -> R {
    plane.normal.dot(position) - plane.offset
}

/// The acceleration of friction, metres per second squared.
fn friction<R: Real>(direction: R::Vec3, velocity: R::Vec3, slope: R::Vec3, grip: R) -> R::Vec3 {
    if direction == R::Vec3::ZERO {
        let pull = slope.dot(slope).sqrt();
        return if pull <= grip { -slope } else { slope * (-grip / pull) };
    }
    // Past the end of a slide friction goes on smoothly: the substep is cut at the end.
    if R::ZERO < velocity.dot(direction) {
        velocity * (-grip / velocity.dot(velocity).sqrt())
    } else {
        direction * -grip
    }
}

/// Projects an acceleration out of planes, by the method of Gauss and Seidel on the pressures.
fn support<R: Real>(model: &Model<R>, planes: &[u32], pull: R::Vec3) -> Support<R> {
    let mut slope = pull;
    let mut pressures = [R::ZERO; MOST_PLANES];
    let close = pull.extent() * R::EPSILON;
    for _ in 0..MOST_SWEEPS {
        let mut largest = R::ZERO;
        for (pressure, &plane) in pressures.iter_mut().zip(planes) {
            let normal = model.planes[plane as usize].normal;
            let change = R::max(-slope.dot(normal), -*pressure);
            *pressure += change;
            slope += normal * change;
            largest = R::max(largest, change.abs());
        }
        if planes.len() < 2 || largest <= close {
            break;
        }
    }
    let (mut grip, mut glued) = (R::ZERO, false);
    for (&pressure, &plane) in pressures.iter().zip(planes) {
        match model.planes[plane as usize].friction {
            Friction::Coulomb(factor) => grip += R::of(factor) * pressure,
            Friction::TangentialLoss(loss) => glued |= 0.0 < loss && R::ZERO < pressure,
        }
    }
    Support { slope, grip, glued }
}
