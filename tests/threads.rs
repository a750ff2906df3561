//! Bit reproducibility of runs on any number of threads: state and energy dissipated.

use msd::core::glam::DVec3;
use msd::core::{
    Friction, Integrator, Material, Pin, Plane, Scene, Settings, Simulation, Spring, shape,
};
use rayon::ThreadPoolBuilder;

/// Large enough to be shared among threads, and not a multiple of what a thread takes at once.
fn scene(tangled: bool) -> Scene {
    let material = Material { mass: 1.0, stiffness: 100.0, damping: 0.5 };
    let part = shape::cloth([150, 131], 1.0, material).expect("a cloth");
    let mut scene = Scene::of("cloth", part);
    scene.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    let friction = Friction::Coulomb(0.3);
    scene.planes = vec![Plane { normal: DVec3::Y, offset: -0.01, restitution: 0.5, friction }];
    if tangled {
        let count = scene.particles.len();
        let tangle = |row: usize| Spring {
            ends: [row % count, (row + 1 + row * row % 997) % count],
            rest_length: 10.0,
            stiffness: 0.1,
            damping: 0.01,
        };
        scene.springs = (0..9 * count).map(tangle).collect();
    }
    scene
}

fn run(scene: &Scene, integrator: Integrator, threads: usize) -> (u64, u64) {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let settings = Settings { integrator, substeps: 4, ..Settings::default() };
        let mut simulation = Simulation::<f32>::new(scene, settings).expect("a valid scene");
        for _ in 0..10 {
            simulation.step().expect("soft");
        }
        let hash = msd::core::state_hash(&simulation.state());
        (hash, simulation.energy().dissipated.to_bits())
    })
}

#[test]
fn a_run_has_the_same_bits_on_any_number_of_threads() {
    for tangled in [false, true] {
        let scene = scene(tangled);
        for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4]
        {
            let alone = run(&scene, integrator, 1);
            for threads in [2, 3, 7] {
                assert_eq!(run(&scene, integrator, threads), alone, "{integrator}, {threads}");
            }
        }
    }
}
