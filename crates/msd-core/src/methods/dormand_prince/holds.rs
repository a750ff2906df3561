//! Held particles: those that rest, slide or stick on obstacles within a substep.
//!
//! Contact in the limit of short substeps. A particle that hits an obstacle bounces, and one that a
//! hop would not lift noticeably is held. The obstacle keeps it and friction sticks it or slows its
//! slide. Within a substep the same particles are held in the same way, by laws that are smooth in
//! position and velocity, so that the integrator keeps its order. Where a law would end (no
//! pressure left, a pull stronger than friction, the end of a slide) is an event, see
//! [`super::events`].
//!
//! Sliding and sticking are of the velocity as seen from the surface. On a curved obstacle the
//! normal is that of each stage, and the acceleration along it is that of the curvature. The gap
//! that a substep leaves is removed at its end.

use super::meeting::Meeting;
use super::support::{Bearings, Constraint, MOST_OBSTACLES, Spot, Support};
use super::tableau::STAGES;
use crate::columns::slots::Slots;
use crate::columns::{Aligned, LANES, RECORD, set_vector, single, vector};
use crate::contact::Contacts;
use crate::elements::Motion;
use crate::number::{Real, Vector, at_level};
use crate::obstacles::PlaneColumn;
use crate::system::{Columns, Model};
use alloc::vec::Vec;
use fearless_simd::Level;

/// Steps along the normal that put a particle back on an obstacle; one is enough where its gap is
/// the distance to the nearest point.
const MOST_STEPS: usize = 8;
/// The largest height of a hop that is neglected, as a fraction of the error allowed.
const HOP: f64 = 0.1;

/// The motion of a held particle along its obstacles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Along<V> {
    /// Without friction.
    Free,
    /// Not at all, as long as the pull is not stronger than friction.
    Sticks,
    /// Not at all: an obstacle that takes a fraction of the speed in every contact takes all.
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
    /// Its place in the columns.
    pub(crate) at: usize,
    pub(super) obstacles: [u32; MOST_OBSTACLES],
    pub(super) count: usize,
    pub(crate) along: Along<R::Vec3>,
    /// The time in which friction can turn its slide, seconds.
    pub(super) turn: R,
    /// A speed that its acceleration gives it within the error allowed, metres per second.
    slow: R,
    /// The margin at each stage until it is let go, metres per second squared: the least pressure
    /// per mass, or the friction that a pull leaves unused.
    pub(crate) margins: [R; STAGES],
}

impl<R: Real> Hold<R> {
    pub(crate) fn obstacles(&self) -> &[u32] {
        &self.obstacles[..self.count]
    }

    /// Those of its obstacles that are not planes.
    fn curved(&self, model: &Model<R>) -> impl Iterator<Item = usize> + '_ {
        let planes = model.obstacles.planes.len();
        self.obstacles().iter().map(|&obstacle| obstacle as usize).filter(move |&o| planes <= o)
    }

    /// Whether only planes hold it.
    pub(crate) fn is_flat(&self, model: &Model<R>) -> bool {
        self.curved(model).next().is_none()
    }

    /// Whether it goes over an edge of an obstacle.
    pub(crate) fn leaves(&self, model: &Model<R>, spot: &Spot<R>) -> bool {
        let mut curved = self.curved(model);
        curved.any(|index| !spot.is_along(model.obstacles.get(index), self.slow))
    }

    pub(super) fn keep(&mut self, obstacle: u32) {
        self.obstacles[self.count] = obstacle;
        self.count += 1;
    }
}

/// The held particles, in the order of the scene.
#[derive(Clone, Debug)]
pub(crate) struct Holds<R: Real> {
    rows: Vec<Hold<R>>,
    /// The least gap of each slot to a plane, metres: most particles are far from all.
    gaps: Aligned<R>,
    /// A hop up to this height is neglected, metres.
    hop: R,
    /// A slide that friction alone would end within this length has the direction of the pull,
    /// metres.
    blur: R,
}

/// The effect of meeting the obstacles.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Met {
    /// The energies of impacts; those of held particles are in the powers of [`Holds::act`].
    pub(crate) contacts: Contacts,
    /// Whether anything touched an obstacle.
    pub(crate) touched: bool,
    /// Whether the state changed by more than rounding, so that forces are stale.
    pub(crate) changed: bool,
}

impl Met {
    /// Adds contacts that moved particles and changed their velocities.
    pub(super) fn add(&mut self, contacts: Contacts) {
        let any = 0 < contacts.count;
        self.contacts += contacts;
        (self.touched, self.changed) = (self.touched | any, self.changed | any);
    }

    /// Notes that a particle of some mass was moved against a force, and the work by mass of the
    /// surfaces that moved it, joules per kilogram.
    fn note<R: Real>(
        &mut self,
        (mass, force): (R, R::Vec3),
        (from, to): (&Spot<R>, &Spot<R>),
        driven: R,
    ) {
        let moved = to.position - from.position;
        let kicked = to.velocity - from.velocity;
        let slower = from.velocity.dot(from.velocity) - to.velocity.dot(to.velocity);
        let driven = (driven * mass).to_f64();
        let taken = (slower * R::HALF * mass).to_f64() + force.dot(moved).to_f64() + driven;
        self.contacts += Contacts { count: 0, driven, ..Contacts::one(taken) };
        // Twice the rounding of a position; the speed that takes as long as a hop to move as far.
        let unfelt = R::of(2.0) * from.position.extent() * R::EPSILON;
        let pull = force * (R::ONE / mass);
        self.changed |= unfelt * unfelt < moved.dot(moved)
            || unfelt * pull.dot(pull).sqrt() < kicked.dot(kicked);
    }
}

impl<R: Real> Holds<R> {
    pub(crate) fn new(slots: &Slots) -> Self {
        let gaps = Aligned::new(slots.record_count() * LANES, 27);
        Holds { rows: Vec::new(), gaps, hop: R::ZERO, blur: R::ZERO }
    }

    /// Forgets everything; `tolerance` is a fraction of `size`, metres.
    ///
    /// Where a particle is held instead of hopping, its speed changes. The height of a hop is like
    /// the square of a speed, so the hops left out are those below tolerance².
    pub(crate) fn reset(&mut self, tolerance: f64, size: f64) {
        self.rows.clear();
        self.hop = R::of(tolerance * Real::min(tolerance, HOP) * size);
        self.blur = R::of(tolerance * size);
    }

    /// The held particles, in the order of the scene.
    pub(crate) fn rows(&self) -> &[Hold<R>] {
        &self.rows
    }

    /// The longest substep that follows every slide, seconds.
    ///
    /// Across a slide of speed v friction acts like a damper of rate μ N / (m v), which the method
    /// follows up to 3.3 per substep. Beyond that the slides of a body would jitter sideways as far
    /// as the tolerance lets them, and friction, which is against the velocity, would be too weak.
    pub(crate) fn longest(&self) -> f64 {
        let turns = self.rows.iter().map(|hold| hold.turn);
        2.0 * turns.fold(R::LARGEST, R::min).to_f64()
    }

    /// Finds the least distance of each particle from a plane in some motions, each after a
    /// straight way of so many seconds.
    pub(crate) fn set_gaps(
        &mut self,
        level: Level,
        model: &Model<R>,
        motions: &[(Motion<'_, R>, R)],
    ) {
        self.gaps.fill(R::LARGEST);
        for plane in &model.obstacles.planes {
            for &(motion, way) in motions {
                at_level!(level, _simd => lower_gaps(plane, motion, way, &mut self.gaps));
            }
        }
        for (gap, radius) in self.gaps.iter_mut().zip(model.radii().column) {
            *gap -= *radius;
        }
    }

    /// The distance found by [`Holds::set_gaps`], metres.
    pub(crate) fn gap(&self, at: usize) -> R {
        self.gaps[single(at)]
    }

    /// The height of a neglected hop for coordinates up to an extent, metres: never below rounding.
    fn hop_within(&self, extent: R) -> R {
        self.hop + extent * R::EPSILON * R::of(8.0)
    }

    /// The distance below which a particle is at an obstacle, for coordinates and a radius up to an
    /// extent, metres.
    pub(crate) fn slack_within(&self, extent: R) -> R {
        self.hop / R::of(8.0) + extent * R::EPSILON * R::of(4.0)
    }

    /// Removes from the accelerations of a stage the part that obstacles hold. Returns the power
    /// dissipated and that of moving surfaces, watts.
    ///
    /// No acceleration is left into or out of the obstacles. Along them friction takes μ N / m
    /// against a slide.
    pub(crate) fn act(
        &mut self,
        model: &Model<R>,
        stage: usize,
        motion: &Motion<'_, R>,
        slopes: &mut [R],
    ) -> [f64; 2] {
        let mut powers = [0.0; 2];
        for hold in &mut self.rows {
            let at = hold.at;
            let (position, velocity) =
                (vector(motion.positions, at), vector(motion.velocities, at));
            let (time, radius) = (motion.time, model.radii().at(at));
            let spot = Spot { position, velocity, time, radius };
            let touches = Bearings::new(model, hold.obstacles(), &spot);
            let pull: R::Vec3 = vector(slopes, at);
            let Support { slope, least, grip, .. } = touches.support(pull, Constraint::Bilateral);
            let (held, margin) = match hold.along {
                Along::Free => (slope, least),
                Along::Glued => (touches.acceleration(), least),
                Along::Sticks => {
                    let (carried, left) = (touches.acceleration(), slope - touches.acceleration());
                    (carried, grip - left.dot(left).sqrt())
                }
                Along::Creeps(_) => {
                    let along = slope - touches.acceleration();
                    (slope - along * (grip / along.dot(along).sqrt()), least)
                }
                Along::Slides(direction) => {
                    let sliding = velocity - touches.velocity();
                    (slope + friction(direction, sliding) * grip, least)
                }
            };
            hold.margins[stage] = margin;
            let (mass, carried) = (model.mass_column[single(at)], touches.velocity());
            powers[0] += ((pull - held).dot(velocity - carried) * mass).to_f64();
            powers[1] += ((held - pull).dot(carried) * mass).to_f64();
            set_vector(slopes, at, held);
        }
        powers
    }

    /// Lets every particle meet the obstacles it is at, and finds out which of them hold it.
    ///
    /// A particle at an obstacle is put on it and bounces if it moves into it. It is held if it is
    /// pushed into it with an acceleration a, and d + v_n²/(2 a), the top of its hop from a
    /// distance d, is at most a hop high. A slide that would end within a hop has ended. `forces`
    /// are those at the state or near it, newtons.
    pub(crate) fn meet(
        &mut self,
        (level, model): (Level, &Model<R>),
        forces: &[R],
        time: f64,
        state: &mut Columns<R>,
    ) -> Met {
        let mut met = self.pull_back(model, forces, time, state);
        let own = model.obstacles.planes.len()..model.obstacles.count();
        self.set_gaps(level, model, &[(state.motion(&model.slots, time), R::ZERO)]);
        self.rows.clear();
        // Allocates in the first step alone.
        self.rows.reserve(model.particle_count());
        // Most particles are further away than a hop is high anywhere in the world.
        let far = self.hop_within(model.extent + model.radii().largest);
        for (particle, at) in model.slots.places().enumerate() {
            let is_far = own.is_empty() && far < self.gap(at);
            if is_far || model.inverse_mass_column[at] == R::ZERO {
                continue;
            }
            let (position, velocity) = state.get(at);
            let before = Spot { position, velocity, time, radius: model.radii().at(at) };
            let hop = self.hop_within(before.extent());
            let is_at = |index| before.gap(model.obstacles.get(index)) <= hop;
            let is_near = self.gap(at) <= hop || own.clone().any(is_at);
            if !is_near {
                continue;
            }
            let force = vector::<R>(forces, at);
            let pull = force * model.inverse_mass_column[at];
            let hold = Hold {
                particle,
                at,
                obstacles: [0; MOST_OBSTACLES],
                count: 0,
                along: Along::Free,
                turn: R::LARGEST,
                slow: (self.blur * pull.dot(pull).sqrt()).sqrt(),
                margins: [R::ZERO; STAGES],
            };
            let mut meeting = Meeting {
                model,
                spot: before,
                pull,
                hop,
                slack: self.slack_within(before.extent()),
                blur: self.blur,
                hold,
                met: false,
                driven: R::ZERO,
            };
            meeting.meet_obstacles();
            meeting.slide();
            let Meeting { spot, hold, met: touched, driven, .. } = meeting;
            met.note((model.mass_column[single(at)], force), (&before, &spot), driven);
            met.touched |= touched;
            met.contacts.count += u64::from(touched);
            state.put(at, (spot.position, spot.velocity));
            if 0 < hold.count {
                self.rows.push(hold);
            }
        }
        met
    }

    /// Puts particles back on the curved obstacles that held them, but for those behind an edge. A
    /// substep leaves them off by its error, which is more than a hop.
    fn pull_back(&self, model: &Model<R>, forces: &[R], time: f64, state: &mut Columns<R>) -> Met {
        let mut met = Met::default();
        for hold in self.rows.iter().filter(|hold| !hold.is_flat(model)) {
            let (position, velocity) = state.get(hold.at);
            let before = Spot { position, velocity, time, radius: model.radii().at(hold.at) };
            if hold.leaves(model, &before) {
                continue;
            }
            let (mut spot, mut driven) = (before, R::ZERO);
            for obstacle in hold.curved(model).map(|index| model.obstacles.get(index)) {
                for _ in 0..MOST_STEPS {
                    let gap = spot.gap(obstacle);
                    spot.position -= obstacle.normal(spot.position, time) * gap;
                    if gap.abs() <= spot.extent() * R::EPSILON {
                        break;
                    }
                }
                let kick = obstacle.normal(spot.position, time) * -spot.speed_off(obstacle);
                driven += kick.dot(obstacle.velocity(spot.position, time));
                spot.velocity += kick;
            }
            let mass = model.mass_column[single(hold.at)];
            met.note((mass, vector(forces, hold.at)), (&before, &spot), driven);
            state.put(hold.at, (spot.position, spot.velocity));
        }
        met
    }
}

#[inline(always)]
fn lower_gaps<R: Real>(plane: &PlaneColumn<R>, motion: Motion<'_, R>, way: R, gaps: &mut [R]) {
    let (n, x) = (plane.normal.components(), motion.positions.as_chunks::<RECORD>().0);
    let rows = x.iter().zip(motion.velocities.as_chunks::<RECORD>().0);
    for (gaps, (x, v)) in gaps.as_chunks_mut::<LANES>().0.iter_mut().zip(rows) {
        for lane in 0..LANES {
            let along =
                |axis: usize| n[axis] * (x[axis * LANES + lane] + v[axis * LANES + lane] * way);
            let gap = along(0) + along(1) + along(2) - plane.offset;
            gaps[lane] = if gap < gaps[lane] { gap } else { gaps[lane] };
        }
    }
}

/// The direction of friction, against the velocity; zero for none.
///
/// Past the end of a slide, where the substep is cut, friction goes on as before: against the
/// velocity reflected to the side of the direction at the start.
fn friction<V: Vector<Scalar = R>, R: Real>(direction: V, velocity: V) -> V {
    let squared = velocity.dot(velocity);
    if squared == R::ZERO {
        return -direction;
    }
    let back = velocity.dot(direction).min(R::ZERO);
    (direction * (back + back) - velocity) * (R::ONE / squared.sqrt())
}
