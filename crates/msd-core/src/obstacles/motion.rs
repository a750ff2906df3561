//! The motion of solids and of guides of pins: steady, or through key frames.
//!
//! Between two key frames it moves by a cubic of time (Hermite). Its velocity is zero at the first
//! key frame and at the last. At others it is, along each axis, a mean of those on both sides, zero
//! where they have different signs (Fritsch and Butland, 1984). So position and velocity are
//! continuous, and no coordinate leaves the range of its two key frames. Key frames that a steady
//! motion passes through give that motion. A turn is the same cubic of a rotation vector that
//! starts at the key frame before.

use crate::number::Real;
use crate::scene::solid::rotation;
use crate::scene::{KeyFrame, Solid};
use glam::{DMat3, DQuat, DVec3};

/// Where something starts, and how it moves from there; the fields are those of a [`Solid`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Route<'a> {
    pub(crate) position: DVec3,
    pub(crate) axes: DMat3,
    pub(crate) velocity: DVec3,
    pub(crate) spin: DVec3,
    pub(crate) since: f64,
    pub(crate) keys: &'a [KeyFrame],
}

impl<'a> Route<'a> {
    /// That of a solid.
    pub(crate) fn of(solid: &'a Solid) -> Self {
        let Solid { position, axes, velocity, spin, since, ref keys, .. } = *solid;
        Route { position, axes, velocity, spin, since, keys }
    }

    /// Its middle at a time, seconds, without key frames.
    fn steady_middle(&self, time: f64) -> DVec3 {
        self.position + self.velocity * (time - self.since)
    }

    /// Whether it moves from one key frame to another in less than so many seconds, at any of the
    /// times between two, seconds.
    pub(crate) fn jumps(&self, [from, to]: [f64; 2], shortest: f64) -> bool {
        (0..self.keys.len()).any(|index| {
            let [start, end] = [index, index + 1].map(|index| Frame::of(self, index));
            let is_now = from < end.time && start.time < to;
            let moves = start.position != end.position || start.axes != end.axes;
            is_now && moves && end.time - start.time < shortest
        })
    }
}

/// Where a solid is and how it moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolidMotion {
    /// Its middle, metres.
    pub(crate) middle: DVec3,
    /// Its own axes, as columns.
    pub(crate) axes: DMat3,
    /// Velocity of its middle, metres per second.
    pub(crate) velocity: DVec3,
    /// Angular velocity, radians per second.
    pub(crate) spin: DVec3,
}

impl SolidMotion {
    /// The motion along a route at a time, seconds.
    pub(crate) fn at(route: Route<'_>, time: f64) -> Self {
        let solid = &route;
        if !solid.keys.is_empty() {
            return SolidMotion::through_keys(solid, time);
        }
        let since = time - solid.since;
        let speed = Real::sqrt(solid.spin.dot(solid.spin));
        let axes = if speed == 0.0 {
            solid.axes
        } else {
            rotation(solid.spin / speed, speed * since) * solid.axes
        };
        let middle = solid.steady_middle(time);
        SolidMotion { middle, axes, velocity: solid.velocity, spin: solid.spin }
    }

    fn through_keys(solid: &Route<'_>, time: f64) -> Self {
        let still = |frame: Frame| SolidMotion {
            middle: frame.position,
            axes: frame.axes,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
        };
        let before = solid.keys.partition_point(|key| key.time <= time);
        if before == solid.keys.len() || time <= solid.since {
            return still(Frame::of(solid, before));
        }
        let [start, end] = [before, before + 1].map(|index| Frame::of(solid, index));
        let length = end.time - start.time;
        let way = end.position - start.position;
        let speeds = [before, before + 1].map(|index| passing(solid, index, travel));
        let (moved, velocity) = hermite(way, speeds, length, time - start.time);
        let middle = start.position + moved;
        if solid.keys.iter().all(|key| key.axes == solid.axes) {
            return SolidMotion { middle, axes: solid.axes, velocity, spin: DVec3::ZERO };
        }
        let turn = turn(&start, &end);
        let [first, last] = [before, before + 1].map(|index| passing(solid, index, self::turn));
        let rates = [first, vector_rate(turn, last)];
        let (turned, rate) = hermite(turn, rates, length, time - start.time);
        let angle = Real::sqrt(turned.dot(turned));
        let axes =
            if angle == 0.0 { start.axes } else { rotation(turned / angle, angle) * start.axes };
        SolidMotion { middle, axes, velocity, spin: spin(turned, rate) }
    }
}

/// The middle of a solid at a time, seconds, in metres.
pub(crate) fn middle(solid: &Solid, time: f64) -> DVec3 {
    let route = Route::of(solid);
    if route.keys.is_empty() {
        route.steady_middle(time)
    } else {
        SolidMotion::at(route, time).middle
    }
}

/// The longest way of a point of a solid in the h seconds up to a time, metres.
pub(crate) fn longest_way(solid: &Solid, (time, h): (f64, f64)) -> f64 {
    let length = |vector: DVec3| Real::sqrt(vector.dot(vector));
    let moved = |way: f64, spin: DVec3| {
        // The reach may be infinite.
        if spin == DVec3::ZERO { way } else { way + length(spin) * h * solid.shape.reach() }
    };
    if solid.keys.is_empty() {
        return moved(length(solid.velocity) * h, solid.spin);
    }
    let [start, end] = [time - h, time].map(|time| SolidMotion::at(Route::of(solid), time));
    moved(length(end.middle - start.middle), end.spin)
}

/// A key frame, the start of the motion included.
struct Frame {
    time: f64,
    position: DVec3,
    axes: DMat3,
}

impl Frame {
    /// That of a number: 0 is the start.
    fn of(solid: &Route<'_>, index: usize) -> Self {
        match index.checked_sub(1) {
            None => Frame { time: solid.since, position: solid.position, axes: solid.axes },
            Some(index) => {
                let key = &solid.keys[index];
                Frame { time: key.time, position: key.position, axes: key.axes }
            }
        }
    }
}

/// The way from one key frame to another, metres.
fn travel(start: &Frame, end: &Frame) -> DVec3 {
    end.position - start.position
}

/// The rotation vector of the turn from one key frame to another, radians: the shorter way round.
fn turn(start: &Frame, end: &Frame) -> DVec3 {
    let turn = DQuat::from_mat3(&(end.axes * start.axes.transpose()));
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let axis = DVec3::new(turn.x, turn.y, turn.z);
    let sine = Real::sqrt(axis.dot(axis));
    if sine == 0.0 { DVec3::ZERO } else { axis * (2.0 * libm::atan2(sine, turn.w) / sine) }
}

/// The rate of change at a key frame, by the changes from the one before and to the next.
fn passing(solid: &Route<'_>, index: usize, change: fn(&Frame, &Frame) -> DVec3) -> DVec3 {
    if index == 0 || index == solid.keys.len() {
        return DVec3::ZERO;
    }
    let [before, here, after] = [index - 1, index, index + 1].map(|index| Frame::of(solid, index));
    let (early, late) = (here.time - before.time, after.time - here.time);
    let (a, b) = (change(&before, &here) / early, change(&here, &after) / late);
    let mean = |axis: usize| {
        let (a, b) = (a[axis], b[axis]);
        // The harmonic mean, with more weight for the shorter time.
        let (of_a, of_b) = (early + 2.0 * late, 2.0 * early + late);
        if 0.0 < a * b { (of_a + of_b) / (of_a / a + of_b / b) } else { 0.0 }
    };
    DVec3::new(mean(0), mean(1), mean(2))
}

/// The cubic from zero to `way` in `length` seconds with these rates at its ends, `time` seconds
/// after its start, and its rate.
fn hermite(way: DVec3, [first, last]: [DVec3; 2], length: f64, time: f64) -> (DVec3, DVec3) {
    let part = time / length;
    let (squared, rest) = (part * part, 1.0 - part);
    let value = way * (squared * (3.0 - 2.0 * part))
        + (first * rest - last * part) * (length * part * rest);
    let rate = way * (6.0 * part * rest / length)
        + first * (rest * (1.0 - 3.0 * part))
        + last * (part * (3.0 * part - 2.0));
    (value, rate)
}

/// The angular velocity at a rotation vector r that changes at a rate r', radians per second:
/// r' + (1 − cos θ)/θ² r×r' + (θ − sin θ)/θ³ r×(r×r').
fn spin(turn: DVec3, rate: DVec3) -> DVec3 {
    let squared = turn.dot(turn);
    let angle = Real::sqrt(squared);
    let (sine, cosine) = libm::sincos(angle);
    let (once, twice) = if angle < SMALL {
        (0.5, 1.0 / 6.0)
    } else {
        ((1.0 - cosine) / squared, (angle - sine) / (squared * angle))
    };
    let across = turn.cross(rate);
    rate + across * once + turn.cross(across) * twice
}

/// The rate at which a rotation vector changes at an angular velocity: the inverse of [`spin`],
/// w − r×w/2 + (1/θ² − cot(θ/2)/(2θ)) r×(r×w), for θ up to π.
fn vector_rate(turn: DVec3, spin: DVec3) -> DVec3 {
    let squared = turn.dot(turn);
    let angle = Real::sqrt(squared);
    let (sine, cosine) = libm::sincos(0.5 * angle);
    let twice =
        if angle < SMALL { 1.0 / 12.0 } else { 1.0 / squared - cosine / (2.0 * angle * sine) };
    let across = turn.cross(spin);
    spin - across * 0.5 + turn.cross(across) * twice
}

/// An angle below which the next terms of series are less than rounding, radians. Above it the
/// differences in the formulas keep half of the digits, of terms that are as small as the angle.
const SMALL: f64 = 1e-4;
