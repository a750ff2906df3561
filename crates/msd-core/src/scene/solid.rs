//! Solids of a shape: what a scene says of them, and the distance from their surface.

use super::{DistanceGrid, Friction};
use crate::number::Real;
use alloc::sync::Arc;
use alloc::vec::Vec;
use glam::{DMat3, DVec3};

/// The shape of a solid about its own middle; y is the axis of what has one.
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
    /// All points that are not above its middle, without end. One that stands still is better a
    /// [`Plane`](super::Plane), which costs less.
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
    /// The start of its motion, seconds: 0 unless an interaction has moved it since.
    pub since: f64,
    /// Key frames that it moves through, smoothly, in order of time; it stays at the last. None: it
    /// moves steadily.
    pub keys: Vec<KeyFrame>,
    /// Fraction of the normal speed that a bounce returns, 0 to 1.
    pub restitution: f64,
    /// Friction along its surface.
    pub friction: Friction,
    /// Whether it meets points on springs that are longer than it is thick, not particles alone.
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
    /// A ball or a capsule as a rod.
    #[inline(always)]
    pub(crate) fn rod(&self) -> Option<Rod> {
        match *self {
            Shape::Sphere { radius } => Some(Rod { radius, length: 0.0 }),
            Shape::Capsule { radius, length } => Some(Rod { radius, length }),
            _ => None,
        }
    }

    /// The distance of a point from the surface, metres; negative inside.
    pub fn gap(&self, point: DVec3) -> f64 {
        match *self {
            Shape::Sphere { radius } => Rod { radius, length: 0.0 }.gap(point),
            Shape::Capsule { radius, length } => Rod { radius, length }.gap(point),
            Shape::Box { size } => beyond(point.abs() - size * 0.5),
            Shape::Cylinder { radius, length } => beyond(sides_of_rod(point, radius, length)),
            Shape::Torus { radius, tube } => length(point - on_circle(point, radius)) - tube,
            Shape::Mesh(ref grid) => grid.gap(point),
            Shape::HalfSpace => point.y,
        }
    }

    /// The direction out of the solid at a point, length one.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        match *self {
            Shape::Sphere { radius } => Rod { radius, length: 0.0 }.normal(point),
            Shape::Capsule { radius, length } => Rod { radius, length }.normal(point),
            Shape::Box { size } => out(point.abs() - size * 0.5, point, DMat3::IDENTITY),
            Shape::Cylinder { radius, length } => {
                let across = direction(around(point), DVec3::X);
                let axes = DMat3::from_cols(across, DVec3::Y, DVec3::ZERO);
                let sides = sides_of_rod(point, radius, length);
                out(sides, DVec3::new(1.0, point.y, 1.0), axes)
            }
            Shape::Torus { radius, .. } => direction(point - on_circle(point, radius), DVec3::Y),
            Shape::Mesh(ref grid) => grid.normal(point),
            Shape::HalfSpace => DVec3::Y,
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
    /// between edges; of a mesh unknown, and infinite too.
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

/// All points within a radius of a piece of the axis, which may be a point: its laws are those of
/// balls and capsules, without a branch, so that many points are computed at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rod {
    radius: f64,
    length: f64,
}

impl Rod {
    #[inline(always)]
    pub(crate) fn gap(self, point: DVec3) -> f64 {
        length(self.away(point)) - self.radius
    }

    #[inline(always)]
    pub(crate) fn normal(self, point: DVec3) -> DVec3 {
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

/// A vector at length one, or another where it has no direction.
#[inline(always)]
fn direction(vector: DVec3, other: DVec3) -> DVec3 {
    let length = length(vector);
    if 0.0 < length { vector / length } else { other }
}

/// The way from the axis.
fn around(point: DVec3) -> DVec3 {
    DVec3::new(point.x, 0.0, point.z)
}

/// The nearest point of a circle about the axis.
fn on_circle(point: DVec3, radius: f64) -> DVec3 {
    let away = around(point);
    let length = length(away);
    if 0.0 < length { away * (radius / length) } else { DVec3::X * radius }
}

/// How far a point is beyond the round side of a rod and beyond its end; it has no third side.
fn sides_of_rod(point: DVec3, radius: f64, long: f64) -> DVec3 {
    DVec3::new(length(around(point)) - radius, point.y.abs() - 0.5 * long, f64::MIN)
}

/// The distance from what has flat sides, by how far a point is beyond each.
fn beyond(sides: DVec3) -> f64 {
    length(sides.max(DVec3::ZERO)) + sides.max_element().min(0.0)
}

/// The direction out of what has flat sides: from the nearest point outside, through the nearest
/// side inside; `point` gives the signs of the axes.
fn out(sides: DVec3, point: DVec3, axes: DMat3) -> DVec3 {
    let outside = sides.max(DVec3::ZERO);
    let nearest = if outside != DVec3::ZERO {
        outside / length(outside)
    } else if sides.x == sides.max_element() {
        DVec3::X
    } else if sides.y == sides.max_element() {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let sign = DVec3::from_array(point.to_array().map(|x| if x < 0.0 { -1.0 } else { 1.0 }));
    axes * (nearest * sign)
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
