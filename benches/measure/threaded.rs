//! The compiled kernel on the threads of a pool, and how works are stepped and counted.

use super::race::Rival;
use msd::core::{Integrator, Scene, Settings, Simulation};
use msd::scene::workloads;
use rayon::ThreadPool;

/// How the works are stepped: as `msd bench` does, by some method.
pub fn settings(integrator: Integrator) -> Settings {
    Settings { integrator, ..workloads::settings() }
}

/// Springs evaluated in a step.
pub fn updates(scene: &Scene, settings: Settings) -> f64 {
    let substeps = f64::from(settings.substeps);
    let evaluations = match settings.integrator {
        Integrator::Rk4 => 4.0 * substeps,
        // It evaluates once more per step.
        Integrator::VelocityVerlet => substeps + 1.0,
        _ => substeps,
    };
    evaluations * scene.springs.len() as f64
}

/// The compiled kernel on the threads of a pool.
pub fn threaded<'a>(scene: &Scene, settings: Settings, pool: &'a ThreadPool) -> Rival<'a> {
    let mut simulation = Simulation::<f32>::new(scene, settings).expect("a valid scene");
    let run = move |steps| {
        pool.install(|| (0..steps).for_each(|_| simulation.step().expect("stable")));
    };
    let name = pool.current_num_threads().to_string();
    Rival { name, updates: updates(scene, settings), run: Box::new(run) }
}
