//! Turntables: a box or a cylinder that turns about the vertical below a particle or a block.

use crate::table::{G, H, Measures, run, start};
use crate::walls::{particle, still};
use msd_core::glam::{DMat3, DVec3};
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, KeyFrame, Material, Real, Scene, Shape, Simulation, Solid, Vector, shape,
};

/// Radians per second.
const RATE: f64 = 2.0;
/// It takes 0.8 s to turn by 90°, from where on the corners of a box are others.
const SECONDS: f64 = 2.0;
/// From the middle of a solid to the farthest place of a particle in it, metres.
const REACH: f64 = 2.9;
/// Where a particle lies, metres.
const PLACE: DVec3 = DVec3::new(0.31, 0.0, 0.17);

/// Solids whose tops are at height 0, and their names.
fn turntables(friction: f64) -> Vec<(Solid, String)> {
    let size = DVec3::new(4.0, 0.2, 4.0);
    let shapes = [Shape::Box { size }, Shape::Cylinder { radius: 2.0, length: 0.2 }];
    let friction = Friction::Coulomb(friction);
    let mut turntables = Vec::new();
    for shape in shapes {
        let position = DVec3::Y * -0.1;
        let still = Solid { position, friction, ..Solid::new(shape) };
        let spin = Solid { spin: DVec3::Y * RATE, ..still.clone() };
        // A key frame each half second, up to ten radians.
        let key = |n: u32| {
            let time = 0.5 * f64::from(n);
            KeyFrame { time, position, axes: rotation(DVec3::Y, RATE * time) }
        };
        let keyed = Solid { keys: (1..=10).map(key).collect(), ..still.clone() };
        for (kind, solid) in [("spin", spin), ("key frames", keyed)] {
            let name = format!("{:?} by {kind}", solid.shape);
            turntables.push((solid, name));
        }
    }
    turntables
}

/// 1e-9 of the thickness of its support, and four roundings of the farthest coordinate.
fn level<R: Real>() -> f64 {
    0.2e-9 + 8.0 * R::EPSILON.to_f64() * REACH
}

/// A turntable without friction does nothing to a particle at rest on it.
pub fn smooth_turntables<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for (solid, name) in turntables(0.0) {
        let mut scene = particle(PLACE, DVec3::ZERO);
        scene.solids = vec![solid];
        let mut simulation = start::<R>(&scene, integrator);
        let before = simulation.energy().total();
        let (mut moved, mut fastest) = (0f64, 0f64);
        let ended = run(&mut simulation, SECONDS, |now| {
            moved = moved.max(now.position(0).to_f64().distance(PLACE));
            fastest = fastest.max(now.velocity(0).to_f64().length());
        });
        ended.unwrap_or_else(|error| measures.fail(&error, &name));
        measures.see("moved, m", (moved, level::<R>()), &name);
        measures.see("speed, m/s", (fastest, still::<R>(REACH)), &name);
        // The weight at the speed that counts as still.
        let work = G * SECONDS * still::<R>(REACH);
        let gain = simulation.energy().total() - before;
        measures.see("gain, J", (gain, work), &name);
        measures.see("added, J", (simulation.contacts().added, work), &name);
    }
    measures
}

/// Friction carries a particle that starts at the speed of the surface: it goes round.
pub fn rough_turntables<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for (solid, name) in turntables(0.5).into_iter().filter(|(solid, _)| solid.keys.is_empty()) {
        let mut scene = particle(PLACE, solid.spin.cross(PLACE));
        scene.solids = vec![solid];
        let mut simulation = start::<R>(&scene, integrator);
        let before = simulation.energy().total();
        let mut height = 0f64;
        let ended = run(&mut simulation, SECONDS, |now| {
            height = height.max(now.position(0).to_f64().y.abs());
        });
        ended.unwrap_or_else(|error| measures.fail(&error, &name));
        measures.see("height, m", (height, level::<R>()), &name);
        // Straight on for a substep is ω² h / 2 of the radius further out each second.
        let (radius, speed) = (PLACE.length(), RATE * PLACE.length());
        let out = radius * RATE * RATE * H * SECONDS;
        let place = rotation(DVec3::Y, RATE * SECONDS) * PLACE;
        let off = simulation.position(0).to_f64().distance(place);
        measures.see("off its place, m", (off, out), &name);
        // The friction of a substep is right to first order: m v² ω h of work in each radian.
        let work = speed * speed * RATE * H * RATE * SECONDS;
        let gain = simulation.energy().total() - before;
        measures.see("gain, J", (gain, work), &name);
    }
    measures
}

/// A cube of 20 cm and 0.8 kg whose slowest mode decays by a factor e in less than 0.1 s, as it
/// stands flat.
fn block(spin: f64) -> Scene {
    let material = Material { mass: 0.03, stiffness: 300.0, damping: 1.5 };
    let mut block = shape::block([3, 3, 3], 0.1, material).expect("a block");
    block.place(DMat3::IDENTITY, DVec3::Y * 0.1);
    block.set_motion(DVec3::ZERO, DVec3::Y * spin);
    Scene::of("block", block)
}

/// The largest range of the height of a particle from 1.5 s to 3 s, and the run at 3 s.
fn watch<R: Real>(
    scene: &Scene,
    integrator: Integrator,
    (measures, name): (&mut Measures, &str),
) -> (f64, Simulation<R>) {
    let mut simulation = start::<R>(scene, integrator);
    let count = scene.particles.len();
    let mut ranges = vec![(f64::MAX, f64::MIN); count];
    let ended = run(&mut simulation, 1.5, |_| {}).and_then(|()| {
        run(&mut simulation, 1.5, |now| {
            for (particle, (low, high)) in ranges.iter_mut().enumerate() {
                let y = now.position(particle).to_f64().y;
                (*low, *high) = (low.min(y), high.max(y));
            }
        })
    });
    ended.unwrap_or_else(|error| measures.fail(&error, name));
    (ranges.into_iter().map(|(low, high)| high - low).fold(0.0, f64::max), simulation)
}

/// The energy at stake while the block settles, joules: its weight over the depth by which springs
/// are compressed, less than a centimetre. A twentieth of it is the truncation of a method.
const SETTLES: f64 = 0.03 * 27.0 * G * 0.01;

pub fn blocks_on_smooth<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for (solid, name) in turntables(0.0) {
        let scene = Scene { solids: vec![solid], ..block(0.0) };
        let before = start::<R>(&scene, integrator).energy().total();
        let (varies, simulation) = watch::<R>(&scene, integrator, (&mut measures, &name));
        // In f32 springs round: a force that is off by k ε x moves an end by about a rounding of x.
        measures.see("height varies, m", (varies, level::<R>() + 0.2e-9), &name);
        let gain = simulation.energy().total() - before;
        measures.see("gain, J", (gain, 0.05 * SETTLES), &name);
        measures.see("added, J", (simulation.contacts().added, 0.05 * SETTLES), &name);
    }
    measures
}

/// Friction carries it. Its sole goes straight on within a substep, is stretched by that, and slips
/// back now and then: its height cannot stay within 1e-9. A thousandth of it is a sixtieth of the
/// work of a contact that was lost and found again.
pub fn blocks_on_rough<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for (solid, name) in turntables(0.5).into_iter().filter(|(solid, _)| solid.keys.is_empty()) {
        let scene = Scene { solids: vec![solid], ..block(RATE) };
        let before = start::<R>(&scene, integrator).energy().total();
        let (varies, simulation) = watch::<R>(&scene, integrator, (&mut measures, &name));
        measures.see("height varies, m", (varies, 0.2e-3), &name);
        // Of every particle as of one that is carried, and the settling.
        let speed = RATE * 0.14;
        let work = 0.03 * 27.0 * speed * speed * RATE * H * RATE * 3.0 + 0.05 * SETTLES;
        let gain = simulation.energy().total() - before;
        measures.see("gain, J", (gain, work), &name);
    }
    measures
}
