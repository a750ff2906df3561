//! Works on which a step is measured, named `scene/size`.

use msd_core::glam::DVec3;
use msd_core::{Friction, Plane, Scene};
use msd_scene::workloads;

/// Makes a scene by its name: `cloth/SIDE` and `irregular/PARTICLES`, whose springs have numbers of
/// their own, or `block/SIDE`, whose springs are alike; `own-block/SIDE` is a block with numbers of
/// their own. All have a plane; the cloth never reaches it, the others lie on it after half a
/// second, `rest/SIDE`, a block with numbers of their own, from the start. `drape/SIDE` is three
/// cloths that fall on a ball, and lie on it and on each other after a second.
pub fn scene(name: &str) -> Scene {
    let (kind, size) = name.split_once('/').expect("a name is scene/size");
    let size = size.parse().expect("a size is a number");
    let mut scene = match kind {
        "drape" => return workloads::drape(size).expect("a size that fits into memory"),
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

/// Gives every spring a stiffness, a damping and a rest length of its own, within a hundredth.
fn own_numbers(scene: &mut Scene) {
    for (row, spring) in scene.springs.iter_mut().enumerate() {
        spring.stiffness *= 1.0 + 1e-4 * (row % 97) as f64;
        spring.damping *= 1.0 + 1e-4 * (row % 89) as f64;
        spring.rest_length *= 1.0 + 1e-6 * (row % 83) as f64;
    }
}
