//! Flat walls through a point, made of planes, half spaces or boxes.

use crate::table::{G, H};
use msd_core::glam::{DMat3, DQuat, DVec3};
use msd_core::{Friction, Particle, Plane, Real, Scene, Shape, Solid};

/// Half of the side of a box, metres.
const HALF: f64 = 1.0;
/// The sides of a slab, metres.
const SLAB: DVec3 = DVec3::new(20.0, 1.0, 20.0);

/// The obstacle that walls are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Planes,
    HalfSpaces,
    Boxes,
    Slabs,
}

impl Kind {
    pub const ALL: [Kind; 3] = [Kind::Planes, Kind::HalfSpaces, Kind::Boxes];

    /// Distance of a point of a wall from the middle of the solid that computes it, metres.
    pub fn reach(self) -> f64 {
        match self {
            Kind::Planes | Kind::HalfSpaces => 0.0,
            Kind::Boxes => HALF * 3f64.sqrt(),
            Kind::Slabs => 0.5 * SLAB.length(),
        }
    }
}

/// Adds walls with these normals through a point, without bounce.
pub fn add_walls(scene: &mut Scene, kind: Kind, (foot, normals): (DVec3, &[DVec3]), friction: f64) {
    let friction = Friction::Coulomb(friction);
    for &normal in normals {
        let unit = normal.normalize();
        let axes = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Y, unit));
        let solid = |shape, position| Solid { position, axes, friction, ..Solid::new(shape) };
        match kind {
            Kind::Planes => {
                let offset = unit.dot(foot);
                scene.planes.push(Plane { normal, offset, restitution: 0.0, friction });
            }
            Kind::HalfSpaces => scene.solids.push(solid(Shape::HalfSpace, foot)),
            Kind::Boxes | Kind::Slabs => {
                let is_slab = kind == Kind::Slabs;
                let size = if is_slab { SLAB } else { DVec3::splat(2.0 * HALF) };
                scene.solids.push(solid(Shape::Box { size }, foot - unit * (0.5 * size.y)));
            }
        }
    }
}

/// A particle of 1 kg under the gravity of the default world.
pub fn particle(position: DVec3, velocity: DVec3) -> Scene {
    Scene { particles: vec![Particle { position, velocity, mass: 1.0 }], ..Scene::default() }
}

/// The speed below which something rests, metres per second.
///
/// In f64 1e-9: a millimetre in eleven days. Never less than rounding. Each impulse rounds, and
/// that of a steep wall is many times the weight of a substep. A place `reach` metres from where
/// gaps are measured, put back by two roundings in a substep, has that as its speed.
pub fn still<R: Real>(reach: f64) -> f64 {
    let epsilon = R::EPSILON.to_f64();
    (epsilon * (64.0 * G * H + 2.0 * reach / H)).max(1e-9)
}

/// Distance that a resting particle may move, metres: sixteen roundings, of a coordinate and of the
/// places of walls. Gaps count as closed within four roundings of each of their terms.
pub fn unmoved<R: Real>(reach: f64) -> f64 {
    16.0 * R::EPSILON.to_f64() * (1.0 + reach)
}
