//! Solids that start in each other come apart, without speed or tangles.

use super::*;
use msd_core::Spring;

/// The distance at which the cubes stop each other, metres, and the speed at which they are pushed
/// apart, metres per second: by that distance in 50 ms.
const STOP: f64 = 2e-3;
const PUSHED: f64 = STOP / 0.05;

/// Two cubes of gelatine of 6 cm in free space, the second one put into the first one from above.
fn overlapping(offset: DVec3) -> (Scene, [Range<usize>; 2]) {
    let stuff = Stuff { young: 2e4, density: 1000.0, damping: 2e-3 };
    let world = World { gravity: DVec3::ZERO, ..World::default() };
    let mut scene = Scene { world, ..Scene::default() };
    let thick = shell(STOP / 2.0, 0.5);
    let first = add_block(&mut scene, [7; 3], (0.01, DVec3::ZERO), stuff, thick.clone());
    let corner = dvec3(0.0, 0.06, 0.0) + offset;
    let second = add_block(&mut scene, [7; 3], (0.01, corner), stuff, thick);
    (scene, [first, second])
}

/// Height of the second body above the first one, metres; negative where both overlap.
fn clearance<R: Real>(simulation: &Simulation<R>, [first, second]: &[Range<usize>; 2]) -> f64 {
    let height = |particle: usize| simulation.position(particle).to_f64().y;
    let top = first.clone().map(height).fold(f64::MIN, f64::max);
    second.clone().map(height).fold(f64::MAX, f64::min) - top
}

fn come_apart<R: Real>(
    (scene, bodies): &(Scene, [Range<usize>; 2]),
    integrator: Integrator,
    substeps: u32,
) {
    let name = format!("{integrator} at {substeps} substeps in {}", R::NAME);
    let mut simulation = start::<R>(scene, integrator, substeps);
    let mut fastest = 0.0f64;
    for _ in 0..60 {
        simulation.step().expect("a step");
        let [own, other] = bodies.clone().map(|all| centre(&simulation, all).1);
        fastest = fastest.max((own - other).length());
    }
    let clearance = clearance(&simulation, bodies);
    assert!(0.9 * STOP < clearance, "{name}: {clearance} m");
    // A particle that a moving wall drives leaves it at twice the speed of the wall at most.
    assert!(fastest < 2.0 * PUSHED, "{name}: {fastest} m/s");
    // The work of pushes is booked; a tenth of it is the first order of the Eulers in an
    // oscillation of some 30 Hz.
    let energy = simulation.energy();
    assert!(energy.total().abs() < 0.1 * energy.supplied, "{name}: {energy:?}");
}

#[test]
fn cubes_that_start_in_each_other_come_apart() {
    for depth in [0.004, 0.015] {
        for offset in [DVec3::ZERO, dvec3(0.013, 0.0, -0.004)] {
            let scene = overlapping(offset - DVec3::Y * depth);
            ALL.into_iter().for_each(|integrator| come_apart::<f64>(&scene, integrator, 32));
            come_apart::<f32>(&scene, Integrator::VelocityVerlet, 32);
        }
    }
}

#[test]
fn a_cube_that_starts_in_its_twin_ends_upon_it() {
    let (mut scene, bodies) = overlapping(dvec3(0.002, -0.01, 0.0013));
    scene.world.gravity = -G * DVec3::Y;
    scene.planes = vec![floor()];
    use Integrator::{BackwardEuler, Rk4, VelocityVerlet, Xpbd};
    for integrator in [VelocityVerlet, Rk4, Xpbd, BackwardEuler] {
        let mut simulation = start::<f64>(&scene, integrator, 32);
        run(&mut simulation, 2.0);
        let [below, above] = bodies.clone().map(|all| centre(&simulation, all).0.y);
        let apart = above - below;
        // As if it had been dropped on it.
        assert!((0.0590..0.0620).contains(&apart), "{integrator}: {apart} m");
        assert_eq!(crossings(&simulation), 0, "{integrator}");
    }
}

#[test]
fn a_cloth_that_starts_in_a_cube_leaves_it() {
    let (mut scene, [cube, second]) = overlapping(DVec3::Y);
    let corner = dvec3(-0.0213, 0.0553, -0.0217);
    let sides = [corner, DVec3::X * 0.01, DVec3::Z * 0.01];
    let cloth = add_cloth(&mut scene, [11; 2], sides, (1e-4, 20.0), shell(STOP / 2.0, 0.5));
    let above = cloth.filter(|&particle| {
        let DVec3 { x, z, .. } = scene.particles[particle].position;
        [x, z].iter().all(|across| (0.0..=0.06).contains(across))
    });
    let above: Vec<usize> = above.collect();
    let mut simulation = start::<f64>(&scene, Integrator::VelocityVerlet, 32);
    run(&mut simulation, 1.0);
    let height = |particle: usize| simulation.position(particle).y;
    let top = cube.map(height).fold(f64::MIN, f64::max);
    let lowest = above.into_iter().map(height).fold(f64::MAX, f64::min);
    // Ordinary rows take over at a half; the cube swings on.
    assert!(0.5 * STOP < lowest - top, "{} m", lowest - top);
    assert!(lowest - top < 2.0 * PUSHED, "{} m", lowest - top);
    assert_eq!(centre(&simulation, second).1, DVec3::ZERO);
}

#[test]
fn what_is_all_inside_or_joined_by_springs_stays_where_it_starts() {
    let (mut joined, bodies) = overlapping(-0.01 * DVec3::Y);
    let link =
        Spring { ends: [0, bodies[1].start], rest_length: 0.05, stiffness: 1.0, damping: 0.0 };
    joined.springs.push(link);
    let mut simulation = start::<f64>(&joined, Integrator::VelocityVerlet, 32);
    run(&mut simulation, 0.5);
    assert!(clearance(&simulation, &bodies) < -0.009);

    let (mut inside, _) = overlapping(DVec3::Y);
    let stuff = Stuff { young: 2e4, density: 1000.0, damping: 2e-3 };
    let small = (0.01, DVec3::splat(0.02));
    let small = add_block(&mut inside, [3; 3], small, stuff, shell(STOP / 2.0, 0.5));
    let mut simulation = start::<f64>(&inside, Integrator::VelocityVerlet, 32);
    run(&mut simulation, 0.5);
    assert!((centre(&simulation, small).0 - DVec3::splat(0.03)).length() < 1e-12);
}

#[test]
fn a_run_that_goes_on_from_its_impulses_pushes_on_to_the_same_bits() {
    let (scene, _) = overlapping(dvec3(0.013, -0.004, -0.004));
    let mut one = start::<f64>(&scene, Integrator::VelocityVerlet, 32);
    run(&mut one, 0.05);
    let mut other = start::<f64>(&scene, Integrator::VelocityVerlet, 32);
    other.set_state(&one.state(), one.steps()).expect("a state of the same scene");
    other.set_impulses(&one.impulses());
    for _ in 0..6 {
        run(&mut one, 0.05);
        run(&mut other, 0.05);
        for particle in 0..scene.particles.len() {
            assert_eq!(one.position(particle), other.position(particle));
        }
    }
}
