//! Which particles rest on a plane, and how does it hold them?
//!
//! Contact in the limit of short substeps. A particle that hits a plane bounces, and one that a
//! hop would not lift noticeably is held: the plane keeps it and friction sticks it or slows its
//! slide. Within a substep the same particles are held in the same way, by laws that are smooth in
//! position and velocity, so that the integrator keeps its order. Where a law would end (no
//! pressure left, a pull stronger than friction, the end of a slide) is an event, see
//! [`crate::events`].

use crate::collision::bounce;
use crate::real::{Real, Vector};
use crate::scene::Friction;
use crate::support::{Law, MOST_PLANES, Support, support};
use crate::system::{Model, PlaneColumn, State};
use crate::tableau::STAGES;
use alloc::vec::Vec;

/// Rounds of one particle between planes; one in a narrow wedge then loses its speed into them.
const MOST_ROUNDS: usize = 8;
/// The height of a hop that is none, as a fraction of the error allowed, at most.
const HOP: f64 = 0.1;

/// How a held particle moves along its planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Along<V> {
    /// Without friction.
    Free,
    /// Not at all, as long as the pull is not stronger than friction.
    Sticks,
    /// Not at all: a plane that takes a fraction of the speed in every contact takes all.
    Glued,
    /// From a direction on; friction is against the velocity.
    Slides(V),
    /// So slowly that it goes where the pull goes, from a direction on; friction is against the
    /// pull. At a speed v a slide turns into the pull at a rate of about μ N / (m v), too fast to
    /// follow.
    Creeps(V),
}

/// A held particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hold<R: Real> {
    pub(crate) particle: usize,
    planes: [u32; MOST_PLANES],
    count: usize,
    pub(crate) along: Along<R::Vec3>,
    /// At each stage what is left until it is let go, metres per second squared: the least
    /// pressure per mass, or the friction that a pull leaves unused.
    pub(crate) margins: [R; STAGES],
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
    /// A slide that friction alone would end within this length has the direction of the pull,
    /// metres.
    blur: R,
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

impl<R: Real> Holds<R> {
    /// Forgets everything; `tolerance` is a fraction of `size`, metres.
    ///
    /// Where a particle is held instead of hopping, its speed changes. The height of a hop is like
    /// the square of a speed, so the hops left out are those below tolerance².
    pub(crate) fn reset(&mut self, tolerance: f64, size: f64) {
        self.rows.clear();
        self.hop = R::of(tolerance * Real::min(tolerance, HOP) * size);
        self.blur = R::of(tolerance * size);
    }

    /// The held particles, in order.
    pub(crate) fn rows(&self) -> &[Hold<R>] {
        &self.rows
    }

    /// The height of a hop that is none for a particle here, metres: never below rounding.
    pub(crate) fn hop_at(&self, position: R::Vec3) -> R {
        self.hop + rounding_at::<R>(position) * R::of(8.0)
    }

    /// The distance below which a particle is at a plane, metres.
    pub(crate) fn slack_at(&self, position: R::Vec3) -> R {
        self.hop / R::of(8.0) + rounding_at::<R>(position) * R::of(4.0)
    }

    /// Takes from the accelerations of a stage what the planes hold. Returns the power of friction,
    /// watts.
    ///
    /// No acceleration is left into or out of the planes. Along them friction takes μ N / m against
    /// a slide.
    pub(crate) fn act(
        &mut self,
        model: &Model<R>,
        stage: usize,
        velocities: &[R::Vec3],
        slopes: &mut [R::Vec3],
    ) -> f64 {
        let mut power = 0.0;
        for hold in &mut self.rows {
            let row = hold.particle;
            let Support { slope, least, grip, .. } =
                support(model, hold.planes(), slopes[row], Law::TwoSided);
            (slopes[row], hold.margins[stage]) = match hold.along {
                Along::Free => (slope, least),
                Along::Glued => (R::Vec3::ZERO, least),
                Along::Sticks => (R::Vec3::ZERO, grip - slope.dot(slope).sqrt()),
                Along::Creeps(_) => {
                    let friction = slope * (-grip / slope.dot(slope).sqrt());
                    power -= (friction.dot(velocities[row]) * model.masses[row]).to_f64();
                    (slope + friction, least)
                }
                Along::Slides(direction) => {
                    let friction = friction(direction, velocities[row]) * grip;
                    power -= (friction.dot(velocities[row]) * model.masses[row]).to_f64();
                    (slope + friction, least)
                }
            };
        }
        power
    }

    /// Lets every particle meet the planes it is at, and finds out which of them hold it.
    ///
    /// A particle at a plane is put on it and bounces if it moves into it. It is held if it is
    /// pushed into it with an acceleration a, and d + v_n²/(2 a), the top of its hop from a
    /// distance d, is no higher than a hop. A slide that would end within a hop has ended.
    /// `forces` are those at the state or near it, newtons.
    pub(crate) fn meet(
        &mut self,
        model: &Model<R>,
        forces: &[R::Vec3],
        state: &mut State<R>,
    ) -> Met {
        self.rows.clear();
        // Allocates in the first step alone.
        self.rows.reserve(forces.len());
        let mut met = Met::default();
        for (particle, &force) in forces.iter().enumerate() {
            let (position, w) = (state.positions[particle], model.inverse_masses[particle]);
            let (hop, slack) = (self.hop_at(position), self.slack_at(position));
            let is_near = |plane| distance(plane, position) <= hop;
            if w == R::ZERO || !model.planes.iter().any(is_near) {
                continue;
            }
            let velocity = state.velocities[particle];
            let hold = Hold {
                particle,
                planes: [0; MOST_PLANES],
                count: 0,
                along: Along::Free,
                margins: [R::ZERO; STAGES],
            };
            let mut guest = Guest {
                position,
                velocity,
                pull: force * w,
                hop,
                slack,
                blur: self.blur,
                hold,
                met: false,
            };
            guest.meet_planes(model);
            guest.slide(model);
            let moved = guest.position - position;
            let kicked = guest.velocity - velocity;
            let slower = velocity.dot(velocity) - guest.velocity.dot(guest.velocity);
            let slowed = slower * R::HALF * model.masses[particle];
            met.energy += slowed.to_f64() + force.dot(moved).to_f64();
            met.touched |= guest.met;
            // Twice the rounding of a position; what takes as long as a hop to move as far.
            let unfelt = R::of(2.0) * rounding_at::<R>(position);
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
    blur: R,
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
        let push =
            -support(model, self.hold.planes(), self.pull, Law::OneSided).slope.dot(plane.normal);
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
        let Support { slope, pressures, grip, glued, .. } =
            support(model, self.hold.planes(), self.pull, Law::OneSided);
        self.keep_pressed(pressures);
        let speed = self.velocity.dot(self.velocity).sqrt();
        let pull = slope.dot(slope).sqrt();
        self.hold.along = if glued {
            self.velocity = R::Vec3::ZERO;
            Along::Glued
        } else if grip <= R::ZERO {
            Along::Free
        } else if speed * speed <= grip * self.blur && grip <= pull + pull {
            self.creep(slope * (R::ONE / pull), pull, grip)
        } else if R::ZERO < speed && !self.ends(speed, grip, slope) {
            Along::Slides(self.velocity * (R::ONE / speed))
        } else {
            self.velocity = R::Vec3::ZERO;
            Along::Sticks
        }
    }

    /// Gives a slow slide the direction of the pull, if it does not end.
    fn creep(&mut self, direction: R::Vec3, pull: R, grip: R) -> Along<R::Vec3> {
        let speed = self.velocity.dot(direction).max(R::ZERO);
        let brake = grip - pull;
        let ends = R::ZERO <= brake && speed * speed <= (brake + brake) * self.hop;
        self.velocity = if ends { R::Vec3::ZERO } else { direction * speed };
        if ends { Along::Sticks } else { Along::Creeps(direction) }
    }

    /// Whether friction would end the slide within a hop.
    fn ends(&self, speed: R, grip: R, slope: R::Vec3) -> bool {
        let brake = grip - slope.dot(self.velocity) / speed;
        R::ZERO < brake && speed * speed <= (brake + brake) * self.hop
    }

    /// Leaves out the planes on which another one leaves no pressure.
    fn keep_pressed(&mut self, pressures: [R; MOST_PLANES]) {
        let (planes, count) = (self.hold.planes, self.hold.count);
        self.hold.count = 0;
        for (&plane, pressure) in planes[..count].iter().zip(pressures) {
            if R::ZERO < pressure {
                self.hold.planes[self.hold.count] = plane;
                self.hold.count += 1;
            }
        }
    }
}

/// The rounding of a coordinate at a position, metres.
fn rounding_at<R: Real>(position: R::Vec3) -> R {
    position.extent() * R::EPSILON
}

/// The signed distance of a point from a plane, metres; negative inside.
pub(crate) fn distance<R: Real>(plane: &PlaneColumn<R>, position: R::Vec3) -> R {
    plane.normal.dot(position) - plane.offset
}

/// The direction of friction, against the velocity; zero for none.
///
/// Past the end of a slide, where the substep is cut, it goes on as before: against the velocity
/// reflected to the side of the direction at the start.
fn friction<V: Vector<Scalar = R>, R: Real>(direction: V, velocity: V) -> V {
    let squared = velocity.dot(velocity);
    if squared == R::ZERO {
        return -direction;
    }
    let back = velocity.dot(direction).min(R::ZERO);
    (direction * (back + back) - velocity) * (R::ONE / squared.sqrt())
}
