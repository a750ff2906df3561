//! Thickness against obstacles: a particle of thickness r meets a surface as a point meets one that
//! is r further out.

use crate::common::distance;
use msd_core::glam::DVec3;
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, Material, Particle, Plane, Real, Scene, Settings, Shape, Shell,
    Simulation, Solid, State, Vector, shape,
};

const G: f64 = 9.82;
const RADIUS: f64 = 0.05;

/// Points of a radius that meet obstacles alone.
fn points(points: Vec<usize>) -> Shell {
    Shell { points, thickness: RADIUS, obstacles: true, ..Shell::default() }
}

/// The scene with all particles of a radius.
fn round(scene: Scene) -> Scene {
    Scene { shells: vec![points((0..scene.particles.len()).collect())], ..scene }
}

fn particle(position: DVec3, velocity: DVec3) -> Scene {
    let particles = vec![Particle { position, velocity, mass: 0.3 }];
    Scene { particles, ..Scene::default() }
}

fn simulation<R: Real>(scene: &Scene, integrator: Integrator, substeps: u32) -> Simulation<R> {
    let settings = Settings { integrator, substeps, ..Settings::default() };
    Simulation::new(scene, settings).expect("a valid scene")
}

fn after<R: Real>(scene: &Scene, integrator: Integrator, steps: usize) -> State<R> {
    let mut run = simulation::<R>(scene, integrator, 16);
    (0..steps).for_each(|_| run.step().expect("a calm run"));
    run.state()
}

fn rough_plane(normal: DVec3, offset: f64) -> Plane {
    Plane { normal, offset, restitution: 0.0, friction: Friction::Coulomb(0.6) }
}

/// On a slope that holds it, on the bottom of a corner, on top of a box: each beside a particle
/// without a radius, which lies on the surface itself.
fn rests<R: Real>(integrator: Integrator) {
    let normal = DVec3::new(0.3, 1.0, -0.2).normalize();
    let mut drop = particle(DVec3::new(0.0, 0.3, 0.0), DVec3::ZERO);
    drop.particles.push(Particle { position: DVec3::new(2.0, 0.3, 0.0), ..drop.particles[0] });
    drop.shells = vec![points(vec![0])];
    drop.planes = vec![rough_plane(normal, -0.4)];
    let state = after::<R>(&drop, integrator, 120);
    // The rounding of a plane's gap: the terms are less than a metre.
    let rounding = 8.0 * R::EPSILON.to_f64();
    for (particle, radius) in [(0, RADIUS), (1, 0.0)] {
        let gap = state.positions[particle].to_f64().dot(normal) + 0.4;
        assert!((gap - radius).abs() <= rounding, "{integrator} on a slope: {gap} of {radius}");
    }
    let mut table = Solid::new(Shape::Box { size: DVec3::new(8.0, 1.0, 8.0) });
    table.position.y = -0.6;
    table.axes = rotation(DVec3::Y, 0.4);
    drop.solids = vec![table];
    drop.planes.clear();
    let state = after::<R>(&drop, integrator, 120);
    for (particle, radius) in [(0, RADIUS), (1, 0.0)] {
        let height = state.positions[particle].to_f64().y + 0.1;
        // Implicit methods put it half of their margin out, which grows with the box.
        let margin = 64.0 * R::EPSILON.to_f64() * 8.0;
        assert!((height - radius).abs() <= margin, "{integrator} on a box: {height} of {radius}");
    }
}

#[test]
fn a_particle_rests_with_its_middle_a_radius_above() {
    for integrator in Integrator::ALL {
        rests::<f32>(integrator);
        rests::<f64>(integrator);
    }
}

/// A soft block thrown onto a plane and over a solid: in one scene with radii, in the other without
/// and with all surfaces that much further out.
fn thrown(grown: f64) -> Scene {
    let material = Material { mass: 0.02, stiffness: 60.0, damping: 0.05 };
    let mut block = shape::block([3, 3, 3], 0.1, material).expect("a block");
    let turn = rotation(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.7);
    for particle in &mut block.particles {
        particle.position = turn * particle.position + DVec3::new(0.12, 1.1, 0.03);
    }
    block.set_motion(DVec3::new(0.3, -1.0, 0.1), DVec3::new(0.5, 1.0, 2.0));
    let mut ball = Solid::new(Shape::Sphere { radius: 0.3 + grown });
    ball.position = DVec3::new(0.0, 0.4, 0.0);
    ball.friction = Friction::Coulomb(0.2);
    ball.velocity = DVec3::new(0.05, 0.0, 0.0);
    let mut rod = Solid::new(Shape::Capsule { radius: 0.1 + grown, length: 2.0 });
    rod.position = DVec3::new(0.5, 0.1, 0.0);
    rod.axes = rotation(DVec3::X, std::f64::consts::FRAC_PI_2);
    rod.friction = Friction::Coulomb(0.4);
    let plane = rough_plane(DVec3::Y, grown);
    Scene { planes: vec![plane], solids: vec![ball, rod], ..Scene::of("block", block) }
}

#[test]
fn radii_are_surfaces_that_much_further_out() {
    for integrator in Integrator::ALL {
        let (points, beads) = (thrown(RADIUS), round(thrown(0.0)));
        let mut ends = Vec::new();
        for scene in [&points, &beads] {
            let state = after::<f64>(scene, integrator, 90);
            ends.push(state);
        }
        // Rounding is all that differs; it grows as the block tumbles.
        let off = distance(&ends[0], &ends[1]);
        assert!(off < 1e-7, "{integrator}: {off}");
        let lowest = ends[1].positions.iter().map(|x| x.y).fold(1.0, f64::min);
        assert!((lowest - RADIUS).abs() < 1e-3, "{integrator}: it has come down to {lowest}");
    }
}

/// A particle that is dropped meets the floor where it has fallen its height less its radius.
#[test]
fn the_time_of_an_impact_is_right_to_a_nanosecond() {
    let (height, thrown) = (1.3, DVec3::new(0.4, 0.0, 0.0));
    let mut scene = round(particle(DVec3::new(0.0, height, 0.0), thrown));
    scene.planes = vec![Plane {
        normal: DVec3::Y,
        offset: 0.0,
        restitution: 1.0,
        friction: Friction::Coulomb(0.0),
    }];
    let mut run = simulation::<f64>(&scene, Integrator::DormandPrince, 1);
    (0..40).for_each(|_| run.step().expect("a calm run"));
    let impact = f64::sqrt(2.0 * (height - RADIUS) / G);
    let since = 40.0 / 60.0 - impact;
    let end = RADIUS + (G * impact) * since - 0.5 * G * since * since;
    // Late by t it is off by t times the change of its velocity.
    let off = (run.position(0).y - end).abs();
    assert!(off < 1e-9 * 2.0 * G * impact, "{off} m");
    assert!((run.position(0).x - 0.4 * 40.0 / 60.0).abs() < 1e-12);
}

/// A round particle on a smooth ball goes round at the sum of the radii, and leaves it at two
/// thirds of that height.
#[test]
fn a_particle_rolls_off_a_ball_at_two_thirds_of_the_sum_of_the_radii() {
    let reach = 0.95 + RADIUS;
    for integrator in Integrator::ALL {
        let (sine, cosine) = 0.05f64.sin_cos();
        let mut scene = round(particle(DVec3::new(sine, cosine, 0.0) * reach, DVec3::ZERO));
        scene.solids = vec![Solid::new(Shape::Sphere { radius: 0.95 })];
        let settings = Settings { integrator, step: 1e-3, substeps: 10, ..Settings::default() };
        let mut run = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
        let mut height = 1.0;
        while run.position(0).length() < reach + 1e-6 {
            assert!(reach - 1e-6 < run.position(0).length(), "{integrator}: inside");
            height = run.position(0).y;
            run.step().expect("a calm run");
        }
        // As of a point in `solids.rs`: a micrometre takes 6 ms, and 14 mm.
        let late = cosine * 2.0 / 3.0 - height;
        assert!((-5e-3..16e-3).contains(&late), "{integrator}: {late}");
    }
}

/// Where shells are set while a simulation runs, radii are those that were set; it is the same
/// in the other precision.
#[test]
fn radii_are_those_that_are_set() {
    let material = Material { mass: 0.1, stiffness: 10.0, damping: 0.1 };
    let mut rope = shape::rope(20, 1.0, material).expect("a rope");
    rope.particles.iter_mut().for_each(|particle| particle.position.y = 0.5);
    let scene = Scene { planes: vec![rough_plane(DVec3::Y, 0.0)], ..Scene::of("rope", rope) };
    let mut run = simulation::<f64>(&scene, Integrator::default(), 16);
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
