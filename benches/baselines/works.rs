//! Works on which a step is measured, named `scene/size`.

use msd_core::glam::{DMat3, DVec3};
use msd_core::{Friction, Material, Plane, Scene, Shape, Shell, Solid, shape};
use msd_scene::workloads;

/// Makes a scene by its name: `cloth/SIDE` and `irregular/PARTICLES`, whose springs have numbers of
/// their own, or `block/SIDE`, whose springs are alike; `own-block/SIDE` is a block with numbers of
/// their own. All have a plane; the cloth never reaches it, the others lie on it after half a
/// second, `rest/SIDE`, a block with numbers of their own, from the start. `drape/SIDE` is three
/// cloths that fall on a ball, and lie on it and on each other after a second.
pub fn scene(name: &str) -> Scene {
    let (kind, size) = name.split_once('/').expect("a name is scene/size");
    let size = size.parse().expect("a size is a number");
    if kind == "drape" {
        return drape(size);
    }
    let mut scene = match kind {
        "cloth" => workloads::cloth(size),
        "block" | "own-block" | "rest" => workloads::block(size),
        "irregular" => workloads::irregular(size),
        _ => panic!("no work is called {kind}"),
    }
    .expect("a size that fits into memory");
    if kind == "cloth" {
        let (normal, friction) = (DVec3::Y, Friction::Coulomb(0.0));
        scene.planes.push(Plane { normal, offset: -1e3, restitution: 0.0, friction });
    }
    if kind == "rest" {
        scene.particles.iter_mut().for_each(|particle| particle.position.y -= 1.0);
    }
    if kind != "block" {
        own_numbers(&mut scene);
    }
    scene
}

/// Makes three cloths of `side` x `side`, one above the other, about to fall on a ball: with 13,
/// the scene on which other engines are timed.
fn drape(side: usize) -> Scene {
    let material = Material { mass: 0.01, stiffness: 30.0, damping: 0.01 };
    let mut scene = Scene::default();
    for layer in 0..3 {
        let mut part = shape::cloth([side; 2], 0.08, material).expect("a cloth");
        let middle = -0.04 * (side - 1) as f64 * DVec3::new(1.0, 0.0, 1.0);
        let above = DVec3::Y * (0.35 + 0.1 * f64::from(layer));
        part.place(DMat3::from_rotation_x(core::f64::consts::FRAC_PI_2), middle + above);
        scene.add("cloth", part);
    }
    let friction = Friction::Coulomb(0.3);
    scene.planes.push(Plane { normal: DVec3::Y, offset: -0.6, restitution: 0.0, friction });
    scene.solids.push(Solid { friction, ..Solid::new(Shape::Sphere { radius: 0.3 }) });
    scene.shells = shells(&scene, 0.008, 0.3);
    scene
}

/// The surface of each body of a scene as a shell that meets itself and the others.
pub fn shells(scene: &Scene, thickness: f64, friction: f64) -> Vec<Shell> {
    let shell = |body| Shell { friction, itself: true, ..Shell::of(body, thickness) };
    scene.bodies.iter().map(shell).collect()
}

/// Gives every spring a stiffness, a damping and a rest length of its own, within a hundredth.
fn own_numbers(scene: &mut Scene) {
    for (row, spring) in scene.springs.iter_mut().enumerate() {
        spring.stiffness *= 1.0 + 1e-4 * (row % 97) as f64;
        spring.damping *= 1.0 + 1e-4 * (row % 89) as f64;
        spring.rest_length *= 1.0 + 1e-6 * (row % 83) as f64;
    }
}
