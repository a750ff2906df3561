//! Solids of a shape where they are at a time.

use super::motion::{Route, SolidMotion, longest_way, middle};
use super::{ContactLaw, Obstacle};
use crate::columns::{LANES, RECORD, set_vector};
use crate::number::{Real, Vector};
use crate::pack::{dot, each};
use crate::scene::{Shape, Solid};
use glam::{DMat3, DVec3};

/// A solid at a time, seconds.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'s> {
    pub(crate) solid: &'s Solid,
    /// Its middle, metres.
    pub middle: DVec3,
    /// Its own axes, as columns.
    pub axes: DMat3,
    /// Velocity of its middle, metres per second.
    pub velocity: DVec3,
    /// Angular velocity about its middle, radians per second.
    pub spin: DVec3,
}

impl<'s> Placed<'s> {
    /// A solid where it is at a time, seconds.
    pub fn new(solid: &'s Solid, time: f64) -> Self {
        let SolidMotion { middle, axes, velocity, spin } = SolidMotion::at(Route::of(solid), time);
        Placed { solid, middle, axes, velocity, spin }
    }

    /// A point as seen from the solid.
    #[inline(always)]
    pub(crate) fn own<R: Real>(&self, position: R::Vec3) -> DVec3 {
        self.axes.transpose() * (position.to_f64() - self.middle)
    }

    /// The point in a lane of a record as seen from the solid.
    #[inline(always)]
    fn own_of<R: Real>(&self, x: &[R; RECORD], lane: usize) -> DVec3 {
        self.own::<R>(R::Vec3::from_components(lane_of(x, lane)))
    }
}

/// The vector of a lane.
#[inline(always)]
pub(crate) fn lane_of<R: Real>(record: &[R; RECORD], lane: usize) -> [R; 3] {
    [record[lane], record[LANES + lane], record[2 * LANES + lane]]
}

/// The lanes of bits.
pub(crate) fn lanes(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

/// An obstacle that is not a plane, at the points of a record that some bits select.
pub(crate) trait Sampled<R: Real>: Obstacle<R> {
    /// The gaps, metres.
    fn gaps(&self, points: (&[R; RECORD], u32), time: f64) -> [R; LANES];

    /// The normals, as a record.
    fn normals(&self, points: (&[R; RECORD], u32), time: f64) -> [R; RECORD];

    /// The velocities of the surface, metres per second, as a record.
    fn velocities(&self, points: (&[R; RECORD], u32), time: f64) -> [R; RECORD];
}

impl<R: Real> Sampled<R> for Placed<'_> {
    #[inline(always)]
    fn gaps(&self, (x, which): (&[R; RECORD], u32), _: f64) -> [R; LANES] {
        let mut gaps = [R::ZERO; LANES];
        let own = |lane| self.own_of(x, lane);
        self.solid.shape.each_gap::<LANES>(which, own, |lane, gap| gaps[lane] = R::of(gap));
        gaps
    }

    #[inline(always)]
    fn normals(&self, (x, which): (&[R; RECORD], u32), _: f64) -> [R; RECORD] {
        let mut normals = [R::ZERO; RECORD];
        let own = |lane| self.own_of(x, lane);
        self.solid.shape.each_normal::<LANES>(which, own, |lane, normal| {
            set_vector(&mut normals, lane, R::Vec3::of(self.axes * normal));
        });
        normals
    }

    #[inline(always)]
    fn velocities(&self, (x, _): (&[R; RECORD], u32), time: f64) -> [R; RECORD] {
        let mut all = [R::ZERO; RECORD];
        for lane in 0..LANES {
            let point = R::Vec3::from_components(lane_of(x, lane));
            set_vector(&mut all, lane, Obstacle::<R>::velocity(self, point, time));
        }
        all
    }
}

impl<R: Real> Sampled<R> for dyn Obstacle<R> + '_ {
    fn gaps(&self, (x, which): (&[R; RECORD], u32), time: f64) -> [R; LANES] {
        let mut gaps = [R::ZERO; LANES];
        for lane in lanes(which) {
            gaps[lane] = self.gap(R::Vec3::from_components(lane_of(x, lane)), time);
        }
        gaps
    }

    fn normals(&self, points: (&[R; RECORD], u32), time: f64) -> [R; RECORD] {
        vectors(points, |point| self.normal(point, time))
    }

    fn velocities(&self, points: (&[R; RECORD], u32), time: f64) -> [R; RECORD] {
        vectors(points, |point| self.velocity(point, time))
    }
}

/// The vectors of a law at the points of a record that some bits say, one by one.
fn vectors<R: Real>(
    (x, which): (&[R; RECORD], u32),
    law: impl Fn(R::Vec3) -> R::Vec3,
) -> [R; RECORD] {
    let mut all = [R::ZERO; RECORD];
    for lane in lanes(which) {
        set_vector(&mut all, lane, law(R::Vec3::from_components(lane_of(x, lane))));
    }
    all
}

/// Rounding of coordinates in single precision, a few times.
const ROUNDING: f64 = 1e-6;

/// A ball outside of which nothing touches a solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball<R> {
    middle: [R; 3],
    squared: R,
}

impl<R: Real> Ball<R> {
    /// The ball around a solid at a time, seconds, however it has turned, for particles of up to a
    /// radius, metres: those that it may have run into in the h seconds before.
    pub(crate) fn behind(solid: &Solid, (time, h): (f64, R), radius: R) -> Self {
        Ball::new(solid, time, radius + R::of(longest_way(solid, (time, h.to_f64()))))
    }

    /// The ball around a solid at a time, seconds, however it has turned, for particles of up to a
    /// radius, metres. That of a solid without end is infinite, and holds any place.
    pub(crate) fn new(solid: &Solid, time: f64, radius: R) -> Self {
        let middle = middle(solid, time);
        // A part in a thousand is more than all rounding of a point at the solid.
        let reach =
            1.001 * (solid.shape.reach() + radius.to_f64()) + middle.abs().max_element() * ROUNDING;
        Ball { middle: R::Vec3::of(middle).components(), squared: R::of(reach * reach) }
    }

    /// Returns whether a place of some records is between the two planes that hold the ball along
    /// an axis. It is false only where none is inside, as the square of one component, rounded, is
    /// at most the rounded sum. A third of the numbers are read.
    #[inline(always)]
    pub(crate) fn may_hold_any(&self, records: &[[R; RECORD]]) -> bool {
        let Some(some) = records.last() else { return false };
        // Most often the axis along which one place is farthest off decides.
        let off: [R; 3] = each(|axis| (some[axis * LANES] - self.middle[axis]).abs());
        let axis = usize::from(off[0] < off[1]);
        let axis = if off[axis] < off[2] { 2 } else { axis };
        let middle = self.middle[axis];
        for record in records {
            let row: &[R; LANES] = record[axis * LANES..].first_chunk().expect("a row");
            let mut any = [0; LANES];
            for (lane, any) in any.iter_mut().enumerate() {
                let way = row[lane] - middle;
                *any = u32::from(way * way <= self.squared);
            }
            if any.iter().fold(0, |all, any| all | any) != 0 {
                return true;
            }
        }
        false
    }

    /// Whether a place is inside.
    #[inline(always)]
    pub(crate) fn holds(&self, position: R::Vec3) -> bool {
        let way = position - R::Vec3::from_components(self.middle);
        way.dot(way) <= self.squared
    }

    /// The places of a record that are inside, a bit for each.
    #[inline(always)]
    pub(crate) fn inside(&self, record: &[R; RECORD]) -> u32 {
        let mut bits = [0; LANES];
        for (lane, bit) in bits.iter_mut().enumerate() {
            let x = lane_of(record, lane);
            let way: [R; 3] = each(|axis| x[axis] - self.middle[axis]);
            *bit = u32::from(dot(way, way) <= self.squared) << lane;
        }
        bits.iter().fold(0, |all, bit| all | bit)
    }
}

impl<R: Real> Obstacle<R> for Placed<'_> {
    fn gap(&self, position: R::Vec3, _: f64) -> R {
        R::of(self.solid.shape.gap(self.own::<R>(position)))
    }

    fn normal(&self, position: R::Vec3, _: f64) -> R::Vec3 {
        R::Vec3::of(self.axes * self.solid.shape.normal(self.own::<R>(position)))
    }

    #[inline(always)]
    fn velocity(&self, position: R::Vec3, _: f64) -> R::Vec3 {
        R::Vec3::of(self.velocity + self.spin.cross(position.to_f64() - self.middle))
    }

    /// Its own coordinates, which it turns by numbers of one, and its place; of a half space, which
    /// has no end, as of a plane.
    #[inline(always)]
    fn terms(&self, position: R::Vec3, _: f64) -> R {
        let [x, y, z] = (position - R::Vec3::of(self.middle)).components();
        let (weights, middle) = match self.solid.shape {
            Shape::HalfSpace => {
                let normal = (self.axes * self.solid.shape.normal(DVec3::ZERO)).abs();
                (normal, self.middle.abs() * normal)
            }
            _ => (DVec3::ONE, self.middle.abs()),
        };
        let [a, b, c] = weights.to_array().map(R::of);
        x.abs() * a + y.abs() * b + z.abs() * c + R::of(middle.x + middle.y + middle.z)
    }

    fn law(&self) -> ContactLaw<R> {
        ContactLaw::new(self.solid.restitution, self.solid.friction)
    }
}

impl<R: Real> Obstacle<R> for Solid {
    fn gap(&self, position: R::Vec3, time: f64) -> R {
        Obstacle::<R>::gap(&Placed::new(self, time), position, time)
    }

    fn normal(&self, position: R::Vec3, time: f64) -> R::Vec3 {
        Obstacle::<R>::normal(&Placed::new(self, time), position, time)
    }

    fn velocity(&self, position: R::Vec3, time: f64) -> R::Vec3 {
        Obstacle::<R>::velocity(&Placed::new(self, time), position, time)
    }

    fn terms(&self, position: R::Vec3, time: f64) -> R {
        Obstacle::<R>::terms(&Placed::new(self, time), position, time)
    }

    fn law(&self) -> ContactLaw<R> {
        ContactLaw::new(self.restitution, self.friction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::{Instructions, at_level};
    use crate::scene::solid::rotation;
    use alloc::vec::Vec;

    /// Points inside and outside, on faces, edges, corners and axes, and a rounding beside them.
    fn points(sides: DVec3) -> Vec<DVec3> {
        let mut state = 7u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as usize
        };
        let mut number = |side: f64| {
            let apart = [0.0, -0.0, side, side * (1.0 + f64::EPSILON), side * 0.5, side * 1.5];
            let anywhere = next() as f64 / f64::from(1u32 << 31) * 4.0 - 2.0;
            let sign = if next() % 2 == 0 { 1.0 } else { -1.0 };
            apart.get(next() % 9).map_or(anywhere, |x| x * sign)
        };
        (0..2000).map(|_| DVec3::new(number(sides.x), number(sides.y), number(sides.z))).collect()
    }

    fn sixteen_are_as_one<R: Real>(shape: &Shape, sides: DVec3) {
        let mut solid = Solid::new(shape.clone());
        for axes in [DMat3::IDENTITY, rotation(DVec3::new(2.0, -1.0, 2.0) / 3.0, 0.8)] {
            solid.axes = axes;
            let placed = Placed::new(&solid, 0.0);
            for points in points(sides).chunks_exact(LANES) {
                let mut x = [R::ZERO; RECORD];
                for (lane, &point) in points.iter().enumerate() {
                    set_vector(&mut x, lane, R::Vec3::of(axes * point));
                }
                for level in Instructions::ALL.map(Instructions::level) {
                    let at = (&x, u32::MAX);
                    let (gaps, normals) =
                        at_level!(level, _simd => (placed.gaps(at, 0.0), placed.normals(at, 0.0)));
                    for (lane, sixteenth) in gaps.into_iter().enumerate() {
                        let point = R::Vec3::from_components(lane_of(&x, lane));
                        let gap: R = placed.gap(point, 0.0);
                        let normal = Obstacle::<R>::normal(&placed, point, 0.0);
                        let bits = |number: R| number.to_f64().to_bits();
                        assert_eq!(bits(sixteenth), bits(gap), "{shape:?} {point:?}");
                        let normals = lane_of(&normals, lane).map(bits);
                        assert_eq!(normals, normal.components().map(bits), "{shape:?} {point:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn sixteen_gaps_and_normals_have_the_bits_of_single_ones() {
        let (radius, length, tube) = (0.6, 0.9, 0.25);
        let size = DVec3::new(0.8, 1.2, 0.5);
        let round = DVec3::new(radius, 0.5 * length, radius);
        for (shape, sides) in [
            (Shape::Sphere { radius }, DVec3::splat(radius)),
            (Shape::Capsule { radius, length }, round),
            (Shape::Box { size }, size * 0.5),
            (Shape::Cylinder { radius, length }, round),
            (Shape::Torus { radius, tube }, DVec3::new(radius + tube, tube, radius)),
            (Shape::HalfSpace, DVec3::ONE),
        ] {
            sixteen_are_as_one::<f32>(&shape, sides);
            sixteen_are_as_one::<f64>(&shape, sides);
        }
    }
}
