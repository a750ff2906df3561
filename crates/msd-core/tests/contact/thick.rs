//! Particles of a thickness r, which meet a surface as points meet one that is r further out, and
//! half spaces, which are planes.

use crate::moving::{MASS, place, scene};
use crate::table::{H, Measures, after, is_double};
use msd_core::glam::{DMat3, DQuat, DVec3};
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, Material, Particle, Plane, Real, Scene, Shape, Shell, Solid, Vector,
    shape,
};
use std::f64::consts::FRAC_PI_2;

const RADIUS: f64 = 0.05;

/// Points of a radius that meet obstacles alone.
pub fn points(points: Vec<usize>) -> Vec<Shell> {
    vec![Shell { points, thickness: RADIUS, obstacles: true, ..Shell::default() }]
}

fn rough(normal: DVec3, offset: f64) -> Plane {
    Plane { normal, offset, restitution: 0.0, friction: Friction::Coulomb(0.6) }
}

/// On a slope that holds it and on top of a box, each beside a particle without a radius, which
/// lies on the surface itself.
pub fn rest<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    let normal = DVec3::new(0.3, 1.0, -0.2).normalize();
    let drop = |x| Particle { position: DVec3::new(x, 0.3, 0.0), ..still() };
    let particles = vec![drop(0.0), drop(2.0)];
    let pair = Scene { particles, shells: points(vec![0]), ..Scene::default() };
    let mut table = Solid::new(Shape::Box { size: DVec3::new(8.0, 1.0, 8.0) });
    (table.position.y, table.axes) = (-0.6, rotation(DVec3::Y, 0.4));
    let slope = Scene { planes: vec![rough(normal, -0.4)], ..pair.clone() };
    let table = Scene { solids: vec![table], ..pair };
    for (scene, normal, offset, name) in
        [(slope, normal, -0.4, "slope"), (table, DVec3::Y, -0.1, "box")]
    {
        let simulation = after::<R>(&scene, (integrator, 16), 120, (&mut measures, name));
        for (particle, radius) in [(0, RADIUS), (1, 0.0)] {
            let gap = simulation.position(particle).to_f64().dot(normal) - offset;
            // The rounding of a plane's gap, whose terms are less than a metre. Implicit methods
            // put a particle on a box half of their margin out, which grows with the box. Explicit
            // Euler falls by g h² in every other substep.
            let terms = if name == "box" { 512.0 } else { 8.0 };
            let falls =
                if integrator == Integrator::ExplicitEuler { 9.82 * H * H / 4.0 } else { 0.0 };
            let bound = terms * R::EPSILON.to_f64() + falls;
            measures.see("off its height, m", ((gap - radius).abs(), bound), name);
        }
    }
    measures
}

fn still() -> Particle {
    Particle { position: DVec3::ZERO, velocity: DVec3::ZERO, mass: MASS }
}

/// A soft block thrown onto a plane and over solids that are that much further out.
fn thrown(grown: f64) -> Scene {
    let material = Material { mass: 0.02, stiffness: 60.0, damping: 0.05 };
    let mut block = shape::block([3, 3, 3], 0.1, material).expect("a block");
    block.place(rotation(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.7), DVec3::new(0.12, 1.1, 0.03));
    block.set_motion(DVec3::new(0.3, -1.0, 0.1), DVec3::new(0.5, 1.0, 2.0));
    let mut ball = Solid::new(Shape::Sphere { radius: 0.3 + grown });
    (ball.position, ball.velocity) = (DVec3::Y * 0.4, DVec3::X * 0.05);
    ball.friction = Friction::Coulomb(0.2);
    let mut rod = Solid::new(Shape::Capsule { radius: 0.1 + grown, length: 2.0 });
    (rod.position, rod.axes) = (DVec3::new(0.5, 0.1, 0.0), rotation(DVec3::X, FRAC_PI_2));
    rod.friction = Friction::Coulomb(0.4);
    let planes = vec![rough(DVec3::Y, grown)];
    Scene { planes, solids: vec![ball, rod], ..Scene::of("block", block) }
}

/// Two scenes that are the same: rounding alone differs, and grows as a block tumbles.
fn compare<R: Real>(
    scenes: [&Scene; 2],
    integrator: Integrator,
    (steps, roundings): (u32, f64),
    (measures, name): (&mut Measures, &str),
) {
    let [one, other] =
        scenes.map(|scene| after::<R>(scene, (integrator, 16), steps, (measures, name)));
    let pairs = one.positions().zip(other.positions());
    let off = pairs.map(|(a, b)| (a - b).to_f64().length()).fold(0.0, f64::max);
    measures.see("apart, m", (off, roundings * R::EPSILON.to_f64()), name);
    let met = one.contacts().count.min(other.contacts().count);
    measures.see("never met", (1.0 / met as f64, 1.0), name);
}

/// In one scene particles have radii, in the other all surfaces are that much further out.
pub fn further_out<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    let beads = Scene { shells: points((0..27).collect()), ..thrown(0.0) };
    let steps = if is_double::<R>() { 90 } else { 40 };
    compare::<R>([&thrown(RADIUS), &beads], integrator, (steps, 4.5e8), (&mut measures, "block"));
    measures
}

/// A half space that stands still, turned about its normal, with another point of the surface as
/// its middle, and a plane: a particle that falls on a slope, bounces or not, and slides; a block
/// that is thrown over a level floor. (Of a block on a slope rounding decides when a corner comes
/// to rest.)
pub fn half_spaces<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    let material = Material { mass: 0.1, stiffness: 400.0, damping: 0.5 };
    let mut block = shape::block([3, 3, 3], 0.5, material).expect("a block");
    block.place(DMat3::IDENTITY, DVec3::Y * 1.3);
    block.set_motion(DVec3::new(3.0, 1.0, -2.0), DVec3::ZERO);
    let slope = rotation(DVec3::Z, 0.3) * DVec3::Y;
    let particle = scene((DVec3::Y * 0.8, DVec3::X * 0.4), Solid::new(Shape::HalfSpace));
    let cases = [(particle, slope, "particle"), (Scene::of("block", block), DVec3::Y, "block")];
    for (free, normal, name) in cases {
        for restitution in [0.0, 0.5] {
            let name = format!("{name}, restitution {restitution}");
            let friction = Friction::Coulomb(0.2);
            let turn = DQuat::from_rotation_arc(DVec3::Y, normal);
            let half_space = Solid {
                position: normal * 0.1 + turn * DVec3::new(0.3, 0.0, 0.7),
                axes: DMat3::from_quat(turn) * rotation(DVec3::Y, 0.9),
                restitution,
                friction,
                ..Solid::new(Shape::HalfSpace)
            };
            let planes = vec![Plane { normal, offset: 0.1, restitution, friction }];
            let plain = Scene { planes, solids: Vec::new(), ..free.clone() };
            let other = Scene { solids: vec![half_space], ..free.clone() };
            // Positions of a metre, rounded a thousand times; solvers stop at a residual.
            compare::<R>([&plain, &other], integrator, (60, 4.5e4), (&mut measures, &name));
        }
    }
    measures
}

/// Neither planes nor half spaces have an end: a particle that falls a thousand kilometres away
/// lies on them.
pub fn fall_far_away<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    let solid = Solid { springs: true, ..Solid::new(Shape::HalfSpace) };
    for away in [DVec3::ZERO, DVec3::X * 1e5, DVec3::new(-9e5, 0.0, 8e5)] {
        for height in [1e-6, 1e-3, 0.5] {
            let above = scene((away + DVec3::Y * height, DVec3::ZERO), solid.clone());
            let planes = vec![rough(DVec3::Y, 0.0)];
            let plane = Scene { planes, solids: Vec::new(), ..above.clone() };
            for (scene, kind) in [(plane, "plane"), (above, "half space")] {
                let name = format!("{kind}, {height} m above {away}");
                let simulation = after::<R>(&scene, (integrator, 8), 60, (&mut measures, &name));
                // Each substep rounds the change of the speed, and the way at that speed.
                let falls = if integrator == Integrator::ExplicitEuler { 1.0 } else { 0.0 };
                let bound = 9.82 * H * H * (falls + 16.0 * R::EPSILON.to_f64());
                measures.see("off its height, m", (place(&simulation).y.abs(), bound), &name);
            }
        }
    }
    measures
}
