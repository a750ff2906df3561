//! A cloth of 100 x 100 particles, with a radius or without.

use msd::core::glam::{DMat3, DVec3};
use msd::core::{Friction, Material, Plane, Scene, Shape, Solid, Touch, World, shape};

/// Makes the cloth, about to fall on a ball and the floor, or at rest far from anything.
pub fn scene(falls: bool, touches: bool) -> Scene {
    let material = Material { mass: 4e-4, stiffness: 60.0, damping: 0.01 };
    let mut part = shape::cloth([100, 100], 0.02, material).expect("a cloth");
    part.place(DMat3::from_rotation_x(1.5), DVec3::ZERO);
    let mut scene = Scene::default();
    scene.add("cloth", part);
    if falls {
        let friction = Friction::Coulomb(0.5);
        scene.planes.push(Plane { normal: DVec3::Y, offset: -1.0, restitution: 0.0, friction });
        let ball = Solid::new(Shape::Sphere { radius: 0.15 });
        scene.solids.push(Solid { position: DVec3::Y * -0.8, friction, ..ball });
    } else {
        scene.world = World { gravity: DVec3::ZERO, ..scene.world };
    }
    if touches {
        let touch = Touch {
            particles: (0..scene.particles.len()).collect(),
            radius: 0.009,
            stiffness: 60.0,
            damping: 0.01,
            friction: 0.5,
            itself: true,
            ignored: Vec::new(),
        };
        scene.add_touch(touch).expect("few pairs");
    }
    scene
}
