//! Features that cost something: the same body with one more of them each.

use super::works;
use msd::core::glam::DVec3;
use msd::core::{Friction, Pin, Plane, Scene, Shape, Solid, Spring};

/// Of every spring, newtons per metre.
const STIFFNESS: f64 = 2200.0;

/// Makes a bare body, undamped and without a plane, and the same with one feature each. It hangs by
/// its first particle, so that it moves for ever and never leaves the world.
pub fn scenes(work: &str) -> Vec<(&'static str, Scene)> {
    let mut bare = works::scene(work);
    bare.planes.clear();
    bare.solids.clear();
    bare.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    for spring in &mut bare.springs {
        let [a, b] = spring.ends.map(|end| bare.particles[end].position);
        spring.rest_length = a.distance(b);
        (spring.stiffness, spring.damping) = (STIFFNESS, 0.0);
    }
    let with = |change: fn(&mut Scene)| {
        let mut scene = bare.clone();
        change(&mut scene);
        scene
    };
    let features: [(&'static str, Change); 8] = [
        ("damping", |scene| scene.springs.iter_mut().for_each(|spring| spring.damping = 1.0)),
        ("own-damping", |scene| each(scene, |spring, own| spring.damping = own)),
        ("own-stiffness", |scene| each(scene, |spring, own| spring.stiffness *= own)),
        ("own-rest-length", |scene| each(scene, |spring, own| spring.rest_length *= own)),
        ("plane", |scene| scene.planes.push(far_plane())),
        ("solid", |scene| scene.solids.push(far_solid())),
        ("drag", |scene| scene.world.drag = 0.01),
        ("all", |scene| {
            each(scene, |spring, own| {
                (spring.stiffness, spring.damping) = (STIFFNESS * own, own);
                spring.rest_length *= own;
            });
            scene.planes.push(far_plane());
            scene.world.drag = 0.01;
        }),
    ];
    let featured = features.map(|(name, change)| (name, with(change)));
    core::iter::once(("bare", bare)).chain(featured).collect()
}

type Change = fn(&mut Scene);

/// Changes each spring by a number near one of its own.
fn each(scene: &mut Scene, change: fn(&mut Spring, f64)) {
    for (row, spring) in scene.springs.iter_mut().enumerate() {
        change(spring, 1.0 + 1e-6 * (row % 97) as f64);
    }
}

/// A ball that nothing reaches.
fn far_solid() -> Solid {
    Solid { position: DVec3::Y * 1e3, ..Solid::new(Shape::Sphere { radius: 1.0 }) }
}

/// A plane that nothing reaches.
fn far_plane() -> Plane {
    let friction = Friction::Coulomb(0.5);
    Plane { normal: DVec3::Y, offset: -1e3, restitution: 0.5, friction }
}
