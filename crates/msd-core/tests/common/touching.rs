//! Small scenes in which particles with a radius touch, shared by the tests of them.
#![allow(dead_code)] // each test binary uses its own part of this file

use crate::common::weightless;
use msd_core::glam::DVec3;
use msd_core::{Instructions, Integrator, Particle, Pin, Real, Scene, Settings, Simulation, Touch};

/// A row that touches itself without loss.
pub fn touch(particles: Vec<usize>, radius: f64) -> Touch {
    Touch {
        particles,
        radius,
        stiffness: 400.0,
        damping: 0.0,
        friction: 0.0,
        triangles: Vec::new(),
        itself: true,
        obstacles: false,
        ignored: vec![],
        between: Vec::new(),
    }
}

/// The same with triangles.
pub fn faced(particles: Vec<usize>, triangles: Vec<[usize; 3]>, radius: f64) -> Touch {
    Touch { triangles, ..touch(particles, radius) }
}

pub fn particle(position: DVec3, velocity: DVec3, mass: f64) -> Particle {
    Particle { position, velocity, mass }
}

pub fn settings(integrator: Integrator, substeps: u32) -> Settings {
    Settings { integrator, substeps, ..Settings::default() }
}

pub fn simulation<R: Real>(scene: &Scene, settings: Settings) -> Simulation<R> {
    Simulation::new(scene, settings).expect("a valid scene")
}

/// Corners of a triangle in the plane y = 0 about the origin, of sides of about a metre.
pub fn corners() -> [DVec3; 3] {
    [DVec3::new(-0.5, 0.0, -0.3), DVec3::new(0.6, 0.0, -0.2), DVec3::new(-0.1, 0.0, 0.5)]
}

/// A triangle of three particles, the first three, and one more particle of another row over it,
/// the reach of which is 0.1 m and the stiffness 200 N/m.
pub fn over(corners: [Particle; 3], bead: Particle, change: impl Fn(Touch) -> Touch) -> Scene {
    let particles = corners.into_iter().chain([bead]).collect();
    let touches =
        vec![change(faced(vec![0, 1, 2], vec![[0, 1, 2]], 0.05)), change(touch(vec![3], 0.05))];
    Scene { world: weightless(), particles, touches, ..Scene::default() }
}

/// The scene with its first three particles pinned.
pub fn pinned(mut scene: Scene) -> Scene {
    scene.pins = (0..3).map(|particle| Pin { particle, velocity: DVec3::ZERO }).collect();
    scene
}

/// Asserts that under every method the bits of a run depend neither on instructions nor on when the
/// list of what is near was made: one of the runs is resumed after each step.
pub fn check_bits<R: Real>(scene: &Scene) {
    for integrator in Integrator::ALL {
        let at = |instructions| {
            let mut simulation = simulation::<R>(scene, settings(integrator, 20));
            simulation.set_instructions(instructions);
            simulation
        };
        let sets = Instructions::ALL.into_iter().filter(|&set| set <= Instructions::best());
        let mut runs: Vec<_> = sets.map(at).collect();
        let mut resumed = at(Instructions::best());
        for _ in 0..6 {
            runs.iter_mut().for_each(|run| run.step().expect("a stable step"));
            resumed.step().expect("a stable step");
            let (scene, progress) = resumed.progress();
            resumed = Simulation::resume(&scene, &progress).expect("a checkpoint of this run");
        }
        for run in &runs {
            assert_eq!(run.state(), resumed.state(), "{integrator} {}", R::NAME);
            assert_eq!(run.dissipated(), resumed.dissipated(), "{integrator} {}", R::NAME);
        }
    }
}
