//! Bit reproducibility of large systems on any number of threads.
#![cfg(feature = "parallel")]

use msd_core::glam::{DMat3, DVec3};
use msd_core::{
    Bend, Friction, Guide, Integrator, KeyFrame, Lead, Material, Particle, Pin, Plane, Scene,
    Settings, Shell, Simulation, Spring, shape, state_hash,
};
use rayon::ThreadPoolBuilder;

/// State and energy dissipated after some steps.
fn run(scene: &Scene, integrator: Integrator, steps: usize, threads: usize) -> (u64, u64) {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let settings = Settings { integrator, substeps: 4, ..Settings::default() };
        let mut simulation = Simulation::<f32>::new(scene, settings).expect("a valid scene");
        for _ in 0..steps {
            simulation.step().expect("soft");
        }
        (state_hash(&simulation.state()), simulation.energy().dissipated.to_bits())
    })
}

/// Bodies of more than 100 000 springs, a cloth, a block and one without order, and a cloth of
/// fewer, of which only passes over particles are shared. Each with a number of steps.
fn scenes() -> [(Scene, usize); 4] {
    let material = Material { mass: 1.0, stiffness: 100.0, damping: 0.5 };
    let cloth = shape::cloth([250, 211], 1.0, material).expect("a cloth");
    let block = shape::block([61, 17, 19], 1.0, material).expect("a block");
    let mut mixed = shape::cloth([150, 131], 1.0, material).expect("a cloth");
    let count = mixed.particles.len();
    let spring = |row: usize| Spring {
        ends: [row % count, (row + 1 + row * row % 997) % count],
        rest_length: 10.0,
        stiffness: 0.1,
        damping: 0.01,
    };
    mixed.springs = (0..9 * count).map(spring).collect();
    let small = shape::cloth([150, 131], 1.0, material).expect("a cloth");
    [(cloth, 3), (block, 3), (mixed, 10), (small, 10)].map(|(part, steps)| {
        let mut scene = Scene::of("body", part);
        scene.world.drag = 0.01;
        scene.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
        let turn = DMat3::from_rotation_z(0.3);
        let start = scene.particles[7].position;
        let keys = vec![KeyFrame { time: 0.02, position: start + DVec3::Y, axes: turn }];
        let lead = Lead::Path { since: 0.0, position: start, velocity: DVec3::ZERO, keys };
        let held = (7..40).map(|at| (at, scene.particles[at].position - start)).collect();
        scene.guides = vec![Guide { held, lead, until: Some(0.04) }];
        let friction = Friction::Coulomb(0.3);
        scene.planes = vec![Plane { normal: DVec3::Y, offset: -0.01, restitution: 0.5, friction }];
        // Ends at the two sides of the body: extras.
        let last = scene.particles.len() - 1;
        let extra = |row: usize| Spring {
            ends: [row, last - row],
            rest_length: 10.0,
            stiffness: 0.1,
            damping: 0.01,
        };
        scene.springs.extend((0..100).map(extra));
        let bend = |row: usize| Bend::line([row, row + 1, row + 2], 0.1, 0.01);
        scene.bends.extend((0..last - 1).map(bend));
        (scene, steps)
    })
}

#[test]
fn a_large_system_has_the_same_bits_on_any_number_of_threads() {
    let scenes = scenes();
    let large = scenes.each_ref().map(|(scene, _)| 100_000 < scene.springs.len());
    assert_eq!(large, [true, true, true, false]);
    for (scene, steps) in scenes {
        for integrator in Integrator::EXPLICIT {
            let alone = run(&scene, integrator, steps, 1);
            for threads in [2, 3, 7] {
                let shared = run(&scene, integrator, steps, threads);
                assert_eq!(shared, alone, "{integrator}, {threads}");
            }
        }
    }
}

#[test]
fn what_falls_on_triangles_has_the_same_bits_on_any_number_of_threads() {
    let material = Material { mass: 0.1, stiffness: 100.0, damping: 0.5 };
    let cloth = shape::cloth([250, 211], 1.0, material).expect("a cloth");
    let mut scene = Scene::of("cloth", cloth);
    let cloth = scene.bodies[0].particles.end;
    let middle = scene.particles[125 + 105 * 250].position;
    for at in 0..40 {
        let beside = DVec3::new(f64::from(at) * 0.31, f64::from(at % 7) * 0.17, 0.12);
        let (position, velocity) = (middle + beside, -3.0 * DVec3::Z);
        scene.particles.push(Particle { position, velocity, mass: 0.02 });
    }
    let beads = (cloth..cloth + 40).collect();
    let restitution = 1.0;
    scene.shells = vec![
        Shell { friction: 0.5, ..Shell::of(&scene.bodies[0], 0.05) },
        Shell { points: beads, thickness: 0.05, friction: 0.5, restitution, ..Shell::default() },
    ];
    let run = |threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let settings = Settings { substeps: 32, ..Settings::default() };
            let mut simulation = Simulation::<f32>::new(&scene, settings).expect("a valid scene");
            (0..6).for_each(|_| simulation.step().expect("a stable step"));
            simulation.state()
        })
    };
    let alone = run(1);
    assert!(alone.velocities[cloth..].iter().all(|velocity| -2.0 < velocity.z), "they met it");
    assert_eq!(state_hash(&run(4)), state_hash(&alone));
}

#[test]
fn a_step_in_which_something_would_pass_is_refused_on_any_number_of_threads() {
    let material = Material { mass: 1.0, stiffness: 100.0, damping: 0.5 };
    let cloth = shape::cloth([250, 211], 1.0, material).expect("a cloth");
    let mut scene = Scene::of("cloth", cloth);
    let middle = scene.particles[125 + 105 * 250].position;
    // Through the cloth within the first step.
    let (position, velocity) = (middle + 2.2 * DVec3::Y, -200.0 * DVec3::Y);
    scene.particles.push(Particle { position, velocity, mass: 0.1 });
    let ball = vec![scene.particles.len() - 1];
    scene.shells = vec![
        Shell::of(&scene.bodies[0], 0.01),
        Shell { points: ball, thickness: 0.01, ..Shell::default() },
    ];
    let run = |threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut settings = Settings { substeps: 4, ..Settings::default() };
            let mut simulation = Simulation::<f32>::new(&scene, settings).expect("a valid scene");
            for _ in 0..2 {
                let before = state_hash(&simulation.state());
                while !simulation.step_unless_passing().expect("soft") {
                    assert_eq!(state_hash(&simulation.state()), before);
                    settings.substeps *= 2;
                    simulation.set_settings(settings).expect("valid settings");
                }
            }
            (simulation.steps(), settings.substeps, state_hash(&simulation.state()))
        })
    };
    let alone = run(1);
    // Less than twenty times both thicknesses, 0.4 m, in a substep: 16 of them at least.
    assert!(alone.0 == 2 && 16 <= alone.1, "{alone:?}");
    assert_eq!([run(2), run(3)], [alone; 2]);
}
