//! Thickness against obstacles that is set while a simulation runs. `contact/` tests its effect.

use msd_core::glam::DVec3;
use msd_core::{Friction, Material, Plane, Scene, Settings, Shell, Simulation, shape};

const RADIUS: f64 = 0.05;

/// Points of a radius that meet obstacles alone.
fn points(points: Vec<usize>) -> Shell {
    Shell { points, thickness: RADIUS, obstacles: true, ..Shell::default() }
}

/// Where shells are set while a simulation runs, radii are those that were set; it is the same
/// in the other precision.
#[test]
fn radii_are_those_that_are_set() {
    let material = Material { mass: 0.1, stiffness: 10.0, damping: 0.1 };
    let mut rope = shape::rope(20, 1.0, material).expect("a rope");
    rope.particles.iter_mut().for_each(|particle| particle.position.y = 0.5);
    let friction = Friction::Coulomb(0.6);
    let plane = Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction };
    let scene = Scene { planes: vec![plane], ..Scene::of("rope", rope) };
    let settings = Settings { substeps: 16, ..Settings::default() };
    let mut run = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
    let odd = || points((0..20).filter(|particle| particle % 2 == 1).collect());
    run.set_shells(&[odd()]).expect("valid rows");
    let rest = |run: &mut Simulation<f64>| {
        (0..90).for_each(|_| run.step().expect("a calm run"));
        (0..20).map(|particle| run.position(particle).y).collect::<Vec<_>>()
    };
    for (particle, y) in rest(&mut run).into_iter().enumerate() {
        let radius = if particle % 2 == 1 { RADIUS } else { 0.0 };
        assert!((y - radius).abs() < 1e-12, "{particle}: {y}");
    }
    let converted = Simulation::<f32>::new(&Scene { shells: vec![odd()], ..scene }, run.settings());
    let mut single = converted.expect("a valid scene");
    (0..90).for_each(|_| single.step().expect("a calm run"));
    assert!((single.position(1).y - RADIUS as f32).abs() < 1e-6 && single.position(0).y == 0.0);
    run.set_shells(&[]).expect("none");
    assert!(rest(&mut run).into_iter().all(|y| y.abs() < 1e-12));
}
