//! Scenes and runs that change: grabs, pushes, pins that move, cuts, shuffled particles, planes.

use super::{assert_same, compare, device, prepared};
use msd_core::glam::DVec3;
use msd_core::{
    Bend, Body, Friction, Integrator, Interaction, Material, Pin, Plane, Scene, Select, Settings,
    Simulation, shape,
};
use msd_gpu::Ensemble;

const METHODS: [Integrator; 3] =
    [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4];

const MATERIAL: Material = Material { mass: 0.01, stiffness: 400.0, damping: 0.05 };

fn start(scene: &Scene, integrator: Integrator) -> Simulation<f32> {
    let settings = Settings { integrator, substeps: 10, ..Settings::default() };
    Simulation::new(scene, settings).expect("a scene that runs")
}

/// A block of soft springs that falls.
fn block() -> Scene {
    Scene::of("block", shape::block([6, 5, 4], 0.1, MATERIAL).expect("a block"))
}

fn floor(restitution: f64, friction: Friction) -> Plane {
    Plane { normal: DVec3::new(0.1, 1.0, 0.05), offset: -0.3, restitution, friction }
}

#[test]
fn a_fall_on_a_slope_with_friction_or_restitution_has_the_bits_of_the_processor() {
    let Some(device) = device() else { return };
    for friction in [Friction::Coulomb(0.0), Friction::Coulomb(0.4), Friction::TangentialLoss(0.3)]
    {
        for restitution in [0.0, 0.6, 1.0] {
            let scene = Scene { planes: vec![floor(restitution, friction)], ..block() };
            for integrator in METHODS {
                let what = format!("{friction:?} {restitution} {integrator:?}");
                let tally = compare(&what, &device, &start(&scene, integrator), 60);
                assert_eq!(tally.processor, 0, "{what}");
            }
        }
    }
}

#[test]
fn a_particle_in_a_corner_of_planes_is_left_to_the_processor() {
    let Some(device) = device() else { return };
    let [floor, wall] = [(DVec3::Y, -0.3), (DVec3::X, -0.4)].map(|(normal, offset)| Plane {
        normal,
        offset,
        ..floor(0.0, Friction::Coulomb(0.3))
    });
    let mut scene = Scene { planes: vec![floor, wall], ..block() };
    scene.particles.iter_mut().for_each(|particle| particle.velocity = DVec3::new(-2.0, 0.0, 0.0));
    for integrator in METHODS {
        let tally = compare("a corner", &device, &start(&scene, integrator), 60);
        assert!(0 < tally.processor && 0 < tally.device, "{tally:?}");
    }
}

#[test]
fn springs_in_any_order_and_with_numbers_of_their_own_have_the_bits_of_the_processor() {
    let Some(device) = device() else { return };
    let mut scene = block();
    let count = scene.particles.len();
    // 7 has no factor in common with the 120 particles.
    let moved = |particle: usize| particle * 7 % count;
    let mut particles = scene.particles.clone();
    (0..count).for_each(|particle| particles[moved(particle)] = scene.particles[particle]);
    scene.particles = particles;
    for (number, spring) in scene.springs.iter_mut().enumerate() {
        spring.ends = spring.ends.map(moved);
        spring.stiffness *= 1.0 + 0.01 * (number % 17) as f64;
    }
    scene.bodies = vec![Body { surface: Default::default(), ..scene.bodies[0].clone() }];
    scene.planes = vec![floor(0.0, Friction::Coulomb(0.4))];
    for integrator in METHODS {
        compare("shuffled", &device, &start(&scene, integrator), 30);
    }
}

#[test]
fn pins_that_move_drag_and_a_uniform_force_have_the_bits_of_the_processor() {
    let Some(device) = device() else { return };
    let mut scene = block();
    scene.pins = vec![
        Pin { particle: 0, velocity: DVec3::new(0.3, 0.1, -0.2) },
        // The sign of a zero is a bit, too.
        Pin { particle: 9, velocity: DVec3::new(-0.0, 0.2, -0.0) },
    ];
    scene.world.drag = 0.02;
    scene.world.force = DVec3::new(0.01, 0.0, 0.02);
    for integrator in METHODS {
        compare("pins", &device, &start(&scene, integrator), 30);
    }
}

#[test]
fn what_pins_that_move_drive_in_is_not_measured() {
    let Some(device) = device() else { return };
    for (velocity, is_measured) in [(DVec3::X, false), (DVec3::ZERO, true)] {
        let scene = Scene { pins: vec![Pin { particle: 0, velocity }], ..block() };
        let mut simulation = start(&scene, Integrator::VelocityVerlet);
        prepared(&device, &simulation).advance(&mut simulation, 3).expect("a run");
        let supplied = simulation.energy().supplied;
        assert_eq!(supplied == 0.0, is_measured, "{supplied}");
        assert_eq!(supplied.is_nan(), !is_measured, "{supplied}");
    }
}

#[test]
fn input_acts_at_the_same_steps_with_the_same_bits() {
    let Some(device) = device() else { return };
    let scene = Scene { planes: vec![floor(0.3, Friction::Coulomb(0.2))], ..block() };
    let target = DVec3::new(0.4, 0.6, 0.1);
    let grab = |target| Interaction::Grab {
        particle: 7,
        target,
        frequency: 3.0,
        damping_ratio: 1.0,
        max_force: 0.5,
    };
    let acts = [
        (3, grab(target)),
        (6, grab(2.0 * target)),
        (9, Interaction::Push { particle: 11, force: DVec3::new(0.0, 2.0, 0.0) }),
        (12, Interaction::Cut { spring: 40 }),
        (15, Interaction::SetStiffness { springs: Select::Body(0), value: 300.0 }),
        (18, Interaction::Release { particle: 7 }),
        (21, Interaction::Pin { particle: 3, velocity: DVec3::ZERO }),
        (24, Interaction::SetGravity { value: DVec3::new(1.0, -5.0, 0.0) }),
        (27, Interaction::AddPlane { plane: floor(0.0, Friction::Coulomb(0.9)) }),
    ];
    for integrator in METHODS {
        let (mut here, mut there) = (start(&scene, integrator), start(&scene, integrator));
        let mut gpu = prepared(&device, &there);
        for (step, act) in acts {
            let wait = step - here.steps();
            (0..wait).for_each(|_| here.step().expect("a stable step"));
            gpu.advance(&mut there, wait).expect("stable steps");
            assert_same(&format!("before {act:?}"), &here, &there);
            here.queue(act).expect("an interaction");
            there.queue(act).expect("an interaction");
        }
        (0..10).for_each(|_| here.step().expect("a stable step"));
        gpu.advance(&mut there, 10).expect("stable steps");
        assert_same("at the end", &here, &there);
    }
}

#[test]
fn a_large_lattice_in_parts_has_the_bits_of_the_processor() {
    let Some(device) = device() else { return };
    let cloth = shape::cloth([120, 120], 0.05, MATERIAL).expect("a cloth");
    let mut scene = Scene::of("cloth", cloth);
    scene.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    for integrator in METHODS {
        compare("cloth/120", &device, &start(&scene, integrator), 3);
    }
}

#[test]
fn a_state_that_the_user_sets_is_that_of_the_next_step() {
    let Some(device) = device() else { return };
    let begun = start(&block(), Integrator::VelocityVerlet);
    let (mut here, mut there) = (begun.clone(), begun.clone());
    let mut gpu = prepared(&device, &there);
    let mut advance = |here: &mut Simulation<f32>, there: &mut Simulation<f32>| {
        (0..5).for_each(|_| here.step().expect("a step"));
        gpu.advance(there, 5).expect("a run");
        assert_same("after a state was set", here, there);
    };
    advance(&mut here, &mut there);
    let mut other = begun.state();
    other.velocities[3].x = 1.0;
    for simulation in [&mut here, &mut there] {
        simulation.set_state(&other, 0).expect("a valid state");
    }
    advance(&mut here, &mut there);
}

#[test]
fn a_mass_that_the_user_sets_is_that_of_the_next_step() {
    let Some(device) = device() else { return };
    let mut here = start(&block(), Integrator::SymplecticEuler);
    let mut there = here.clone();
    let mut gpu = prepared(&device, &there);
    for mass in [0.02, 0.3] {
        let masses = Interaction::SetMass { particles: Select::One(5), value: mass };
        for simulation in [&mut here, &mut there] {
            simulation.queue(masses).expect("a mass");
            simulation.apply_queued().expect("a good state");
        }
        gpu.renew_check();
        (0..5).for_each(|_| here.step().expect("a step"));
        gpu.advance(&mut there, 5).expect("a run");
        assert_same("after a mass was set", &here, &there);
    }
}

#[test]
fn a_step_that_is_refused_passes_its_check_on_to_another_scene() {
    let Some(device) = device() else { return };
    let free = block();
    // Its lowest corner lies on a floor and at a wall from the start.
    let low = free.particles.iter().fold(DVec3::MAX, |low, at| low.min(at.position));
    let planes = [(DVec3::Y, low.y), (DVec3::X, low.x)].map(|(normal, offset)| Plane {
        normal,
        offset,
        ..floor(0.0, Friction::Coulomb(0.3))
    });
    let cornered = Scene { planes: planes.to_vec(), ..free.clone() };
    let mut both = [cornered, free].map(|scene| start(&scene, Integrator::VelocityVerlet));
    let mut ensemble = pollster::block_on(Ensemble::new(&device, &both)).expect("two scenes");
    ensemble.advance(&mut both, 30).expect("a run");
    ensemble.finish_check().expect("the bits of the processor");
    let tally = ensemble.tally();
    assert!(0 < tally.processor && 0 < tally.checked, "{tally:?}");
}

/// A sheet with bends of three particles along its rows, and of four across its edges.
fn sheet(damping: f64) -> Scene {
    let [rows, columns] = [12, 9];
    let sheet = shape::cloth([rows, columns], 0.1, MATERIAL).expect("a cloth");
    let mut scene = Scene::of("sheet", sheet);
    let at = |particle: usize| scene.particles[particle].position;
    let mut bends = Vec::new();
    for corner in (0..rows - 1).flat_map(|y| (0..columns - 2).map(move |x| y * columns + x)) {
        bends.push(Bend::line([corner, corner + 1, corner + 2], 30.0, damping));
        let hinge = [corner + 1, corner + columns, corner, corner + columns + 1];
        let hinge = Bend::hinge(hinge, hinge.map(at), 0.02).expect("two triangles");
        bends.push(Bend { damping, ..hinge });
    }
    scene.bends = bends;
    let pin = |particle| Pin { particle, velocity: DVec3::ZERO };
    scene.pins = vec![pin(0), pin((rows - 1) * columns)];
    scene
}

#[test]
fn bends_have_the_bits_of_the_processor_and_tear_with_their_springs() {
    let Some(device) = device() else { return };
    for (damping, integrator) in [0.0, 0.02].into_iter().flat_map(|b| METHODS.map(|m| (b, m))) {
        let (mut here, mut there) = {
            let start = start(&sheet(damping), integrator);
            (start.clone(), start)
        };
        let mut gpu = prepared(&device, &there);
        for spring in [None, Some(7), Some(40)] {
            if let Some(spring) = spring {
                for simulation in [&mut here, &mut there] {
                    let cut = Interaction::Cut { spring };
                    simulation.queue(cut).expect("a spring of the sheet");
                }
            }
            (0..20).for_each(|_| here.step().expect("a step"));
            gpu.advance(&mut there, 20).expect("a run");
            assert_same(&format!("a sheet that bends by {integrator:?}"), &here, &there);
        }
        assert_eq!(gpu.tally().processor, 2);
        assert!(here.model().bends().count() < sheet(damping).bends.len());
    }
}

#[test]
fn scenes_with_and_without_bends_step_together() {
    let Some(device) = device() else { return };
    let scenes = [block(), sheet(0.0), block(), sheet(0.02)];
    let mut there = scenes.map(|scene| start(&scene, Integrator::VelocityVerlet));
    let mut here = there.clone();
    let ensemble = pollster::block_on(Ensemble::new(&device, &there));
    let ended = ensemble.expect("scenes for a device").advance(&mut there, 20).map(<[_]>::to_vec);
    assert_eq!(ended.expect("a run"), vec![None; 4]);
    for (here, there) in here.iter_mut().zip(&there) {
        (0..20).for_each(|_| here.step().expect("a step"));
        assert_same("scenes with and without bends", here, there);
    }
}
