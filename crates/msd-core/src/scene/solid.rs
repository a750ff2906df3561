//! Solids of a shape: their rows in a scene, and the distance from their surface.

use super::{DistanceGrid, Friction};
use crate::number::Real;
use alloc::sync::Arc;
use alloc::vec::Vec;
use glam::{DMat3, DVec3};

/// The shape of a solid about its own middle; y is the axis of shapes that have one.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Shape {
    /// All points within a radius.
    Sphere {
        /// Metres.
        radius: f64,
    },
    /// All points within a radius of a piece of the axis.
    Capsule {
        /// Metres.
        radius: f64,
        /// Length of that piece, metres.
        length: f64,
    },
    /// A cuboid with these sides.
    Box {
        /// Metres.
        size: DVec3,
    },
    /// A round rod with flat ends.
    Cylinder {
        /// Metres.
        radius: f64,
        /// From end to end, metres.
        length: f64,
    },
    /// All points within some distance of a circle about the axis.
    Torus {
        /// Radius of that circle, metres.
        radius: f64,
        /// That distance, metres; smaller than the radius.
        tube: f64,
    },
    /// The inside of a closed surface, by distances on a grid.
    Mesh(
        #[cfg_attr(feature = "serde", serde(with = "super::distances::shared"))] Arc<DistanceGrid>,
    ),
    /// All points that are not above its middle, without end. A [`Plane`](super::Plane) costs less
    /// than a half space that stands still.
    HalfSpace,
}

/// Where a solid is at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct KeyFrame {
    /// Seconds; later than the start of the motion and the key frame before.
    pub time: f64,
    /// Its middle, metres.
    pub position: DVec3,
    /// Its own axes, as columns; a rotation.
    pub axes: DMat3,
}

/// A solid that particles cannot enter, still, moving steadily or through key frames.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Solid {
    /// Its shape.
    pub shape: Shape,
    /// Its middle at the start of its motion, metres.
    pub position: DVec3,
    /// Its own axes there, as columns; a rotation.
    pub axes: DMat3,
    /// Velocity of its middle, metres per second; zero with key frames.
    pub velocity: DVec3,
    /// Angular velocity about its middle, radians per second; zero with key frames.
    pub spin: DVec3,
    /// The start of its motion, seconds: 0 unless an interaction has moved it since, or a run
    /// starts later on its way.
    pub since: f64,
    /// Key frames that it moves through, smoothly, in order of time; it stays at the last. None: it
    /// moves steadily.
    pub keys: Vec<KeyFrame>,
    /// Fraction of the normal speed that a bounce returns, 0 to 1.
    pub restitution: f64,
    /// Friction along its surface.
    pub friction: Friction,
    /// Whether it meets, besides particles, points on springs that are longer than its thickness.
    pub springs: bool,
}

impl Solid {
    /// A solid of this shape that stands still about the origin, without bounce and friction.
    pub fn new(shape: Shape) -> Self {
        Solid {
            shape,
            position: DVec3::ZERO,
            axes: DMat3::IDENTITY,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            since: 0.0,
            keys: Vec::new(),
            restitution: 0.0,
            friction: Friction::Coulomb(0.0),
            springs: false,
        }
    }
}

impl Shape {
    /// The distance of a point from the surface, metres; negative inside.
    pub fn gap(&self, point: DVec3) -> f64 {
        let mut only = 0.0;
        self.each_gap::<1>(1, |_| point, |_, gap| only = gap);
        only
    }

    /// The direction out of the solid at a point, length one.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        let mut only = DVec3::ZERO;
        self.each_normal::<1>(1, |_| point, |_, normal| only = normal);
        only
    }

    /// Computes the gaps of N points, as of [`Shape::gap`]; of a mesh only where a bit says so.
    #[inline(always)]
    pub(crate) fn each_gap<const N: usize>(
        &self,
        which: u32,
        point: impl Fn(usize) -> DVec3,
        set: impl FnMut(usize, f64),
    ) {
        match *self {
            Shape::Sphere { radius } => {
                let rod = Rod { radius, length: 0.0 };
                each::<N, f64>(ALL, |lane| rod.gap(point(lane)), set);
            }
            Shape::Capsule { radius, length } => {
                let rod = Rod { radius, length };
                each::<N, f64>(ALL, |lane| rod.gap(point(lane)), set);
            }
            Shape::Box { size } => {
                each::<N, f64>(ALL, |lane| beyond(point(lane).abs() - size * 0.5), set);
            }
            Shape::Cylinder { radius, length } => {
                let sides = |lane| sides_of_rod(point(lane), radius, length);
                each::<N, f64>(ALL, |lane| beyond(sides(lane)), set);
            }
            Shape::Torus { radius, tube } => {
                let away = |lane| from_circle(point(lane), radius);
                each::<N, f64>(ALL, |lane| length(away(lane)) - tube, set);
            }
            Shape::Mesh(ref grid) => each::<N, f64>(which, |lane| grid.gap(point(lane)), set),
            Shape::HalfSpace => each::<N, f64>(ALL, |lane| point(lane).y, set),
        }
    }

    /// Computes the normals at N points, as of [`Shape::normal`]; of a mesh only where a bit says
    /// so.
    #[inline(always)]
    pub(crate) fn each_normal<const N: usize>(
        &self,
        which: u32,
        point: impl Fn(usize) -> DVec3,
        set: impl FnMut(usize, DVec3),
    ) {
        match *self {
            Shape::Sphere { radius } => {
                let rod = Rod { radius, length: 0.0 };
                each::<N, DVec3>(ALL, |lane| rod.normal(point(lane)), set);
            }
            Shape::Capsule { radius, length } => {
                let rod = Rod { radius, length };
                each::<N, DVec3>(ALL, |lane| rod.normal(point(lane)), set);
            }
            Shape::Box { size } => {
                let law = |point: DVec3| out(point.abs() - size * 0.5, point, DMat3::IDENTITY);
                each::<N, DVec3>(ALL, |lane| law(point(lane)), set);
            }
            Shape::Cylinder { radius, length } => {
                let law = |point: DVec3| {
                    let across = direction(around(point), DVec3::X);
                    let axes = DMat3::from_cols(across, DVec3::Y, DVec3::ZERO);
                    let sides = sides_of_rod(point, radius, length);
                    out(sides, DVec3::new(1.0, point.y, 1.0), axes)
                };
                each::<N, DVec3>(ALL, |lane| law(point(lane)), set);
            }
            Shape::Torus { radius, .. } => {
                let away = |lane| from_circle(point(lane), radius);
                each::<N, DVec3>(ALL, |lane| direction(away(lane), DVec3::Y), set);
            }
            Shape::Mesh(ref grid) => each::<N, DVec3>(which, |lane| grid.normal(point(lane)), set),
            Shape::HalfSpace => each::<N, DVec3>(ALL, |_| DVec3::Y, set),
        }
    }

    /// The least distance from one side to the other, metres; of a mesh, where it is unknown, the
    /// edge of a cell; of a half space infinite.
    pub fn thickness(&self) -> f64 {
        match *self {
            Shape::Sphere { radius } | Shape::Capsule { radius, .. } => 2.0 * radius,
            Shape::Box { size } => size.min_element(),
            Shape::Cylinder { radius, length } => f64::min(2.0 * radius, length),
            Shape::Torus { tube, .. } => 2.0 * tube,
            Shape::Mesh(ref grid) => grid.cell,
            Shape::HalfSpace => f64::INFINITY,
        }
    }

    /// The least radius by which its surface bends outwards, metres: infinite where it is flat
    /// between edges; of a mesh unknown, and infinite too. Edges and corners do not count:
    /// automatic substeps follow this radius, and would never be short enough.
    pub fn bend(&self) -> f64 {
        match *self {
            Shape::Sphere { radius }
            | Shape::Capsule { radius, .. }
            | Shape::Cylinder { radius, .. } => radius,
            Shape::Torus { tube, .. } => tube,
            Shape::Box { .. } | Shape::Mesh(_) | Shape::HalfSpace => f64::INFINITY,
        }
    }

    /// The radius of a ball about its middle that holds it, metres; of a half space infinite.
    pub fn reach(&self) -> f64 {
        match *self {
            Shape::Sphere { radius } => radius,
            Shape::Capsule { radius, length } => radius + 0.5 * length,
            Shape::Box { size } => 0.5 * length(size),
            Shape::Cylinder { radius, length: long } => length(DVec3::new(radius, 0.5 * long, 0.0)),
            Shape::Torus { radius, tube } => radius + tube,
            // The interpolated surface may be outside the other by its error.
            Shape::Mesh(ref grid) => grid.reach + grid.error,
            Shape::HalfSpace => f64::INFINITY,
        }
    }
}

/// Computes a law at each of N points that a bit is set for. The laws of shapes have no branches:
/// all of their points are computed at once.
#[inline(always)]
fn each<const N: usize, T>(which: u32, law: impl Fn(usize) -> T, mut set: impl FnMut(usize, T)) {
    for lane in 0..N {
        if which >> lane & 1 != 0 {
            set(lane, law(lane));
        }
    }
}

/// Every point.
const ALL: u32 = u32::MAX;

/// All points within a radius of a piece of the axis, which may be a point: a ball or a capsule.
#[derive(Clone, Copy, Debug)]
struct Rod {
    radius: f64,
    length: f64,
}

impl Rod {
    #[inline(always)]
    fn gap(self, point: DVec3) -> f64 {
        length(self.away(point)) - self.radius
    }

    #[inline(always)]
    fn normal(self, point: DVec3) -> DVec3 {
        // On the axis of a capsule its ends are farther than its round side.
        direction(self.away(point), if 0.0 < self.length { DVec3::X } else { DVec3::Y })
    }

    /// The way from the nearest point of the axis.
    #[inline(always)]
    fn away(self, point: DVec3) -> DVec3 {
        point - DVec3::Y * point.y.clamp(-0.5 * self.length, 0.5 * self.length)
    }
}

#[inline(always)]
fn length(vector: DVec3) -> f64 {
    Real::sqrt(vector.dot(vector))
}

/// One of two vectors.
#[inline(always)]
fn select(first: bool, a: DVec3, b: DVec3) -> DVec3 {
    let one = |a, b| if first { a } else { b };
    DVec3::new(one(a.x, b.x), one(a.y, b.y), one(a.z, b.z))
}

/// A vector at length one, or another where it has no direction.
#[inline(always)]
fn direction(vector: DVec3, other: DVec3) -> DVec3 {
    let length = length(vector);
    select(0.0 < length, vector / length, other)
}

/// The way from the axis.
#[inline(always)]
fn around(point: DVec3) -> DVec3 {
    DVec3::new(point.x, 0.0, point.z)
}

/// The way from the nearest point of a circle about the axis.
#[inline(always)]
fn from_circle(point: DVec3, radius: f64) -> DVec3 {
    let away = around(point);
    let length = length(away);
    point - select(0.0 < length, away * (radius / length), DVec3::X * radius)
}

/// Distances of a point beyond the round side of a rod and beyond its end; it has no third side.
#[inline(always)]
fn sides_of_rod(point: DVec3, radius: f64, long: f64) -> DVec3 {
    DVec3::new(length(around(point)) - radius, point.y.abs() - 0.5 * long, f64::MIN)
}

/// The distance from a shape with flat sides, by the distances of a point beyond each.
#[inline(always)]
fn beyond(sides: DVec3) -> f64 {
    length(sides.max(DVec3::ZERO)) + Real::min(sides.max_element(), 0.0)
}

/// The direction out of a shape with flat sides: from the nearest point outside, through the
/// nearest side inside; `point` gives the signs of the axes.
#[inline(always)]
fn out(sides: DVec3, point: DVec3, axes: DMat3) -> DVec3 {
    let outside = sides.max(DVec3::ZERO);
    let most = sides.max_element();
    let side = select(sides.y == most, DVec3::Y, DVec3::Z);
    let side = select(sides.x == most, DVec3::X, side);
    let nearest = select(0.0 < most, outside / length(outside), side);
    let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
    axes * (nearest * DVec3::new(sign(point.x), sign(point.y), sign(point.z)))
}

/// The matrix of a turn about an axis of length one, by the right-hand rule (Rodrigues, 1840).
///
/// Sine and cosine come from libm: those of the platform differ in the last bit.
pub fn rotation(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    let DVec3 { x, y, z } = axis;
    let rest = 1.0 - cos;
    DMat3::from_cols(
        DVec3::new(cos + x * x * rest, y * x * rest + z * sin, z * x * rest - y * sin),
        DVec3::new(x * y * rest - z * sin, cos + y * y * rest, z * y * rest + x * sin),
        DVec3::new(x * z * rest + y * sin, y * z * rest - x * sin, cos + z * z * rest),
    )
}
