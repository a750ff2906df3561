//! Cost of predicting the largest stable substep, beside that of one evaluation of the forces.
//!
//! The ratio shows how often a run can afford it.

#[path = "baselines/forces.rs"]
mod forces;

use criterion::{Criterion, criterion_group, criterion_main};
use forces::{Forces, Motion};
use msd::core::stability::Estimator;
use msd::core::{Integrator, Material, Scene, Settings, Simulation, shape};

/// A lattice with dampers that go with the stiffness, and with some that do not.
fn scenes() -> [(&'static str, Scene); 4] {
    let material = Material { mass: 1.0, stiffness: 1e4, damping: 20.0 };
    let cloth = Scene::of("cloth", shape::cloth([31, 31], 1.0, material).expect("a valid cloth"));
    let block = shape::block([10, 10, 10], 1.0, material).expect("a valid block");
    let block = Scene::of("block", block);
    let uneven = |mut scene: Scene| {
        for (row, spring) in scene.springs.iter_mut().enumerate() {
            spring.damping *= (row % 7) as f64;
        }
        scene
    };
    let [uneven_cloth, uneven_block] = [cloth.clone(), block.clone()].map(uneven);
    [
        ("cloth/31", cloth),
        ("cloth/31/uneven", uneven_cloth),
        ("block/10", block),
        ("block/10/uneven", uneven_block),
    ]
}

fn predictions(criterion: &mut Criterion) {
    for (name, scene) in scenes() {
        let mut group = criterion.benchmark_group(format!("stability/{name}"));
        group.sample_size(20);
        let settings = |integrator| Settings { integrator, substeps: 8, ..Settings::default() };
        let simulation = Simulation::<f32>::new(&scene, settings(Integrator::VelocityVerlet));
        let mut simulation = simulation.expect("a valid scene");
        let (forces, state) = (Forces::<f32>::new(&scene), simulation.state());
        let motion = Motion { positions: &state.positions, velocities: &state.velocities };
        let mut column = state.positions.clone();
        group.bench_function("forces", |bencher| {
            bencher.iter(|| {
                forces.set_external(motion, &mut column);
                forces.add_springs(motion, &mut column)
            });
        });
        let mut estimator = Estimator::default();
        for integrator in [Integrator::VelocityVerlet, Integrator::Rk4] {
            simulation.set_settings(settings(integrator)).expect("valid settings");
            group.bench_function(format!("limit/{integrator}"), |bencher| {
                bencher.iter(|| simulation.stable_substep_by(&mut estimator));
            });
        }
    }
}

criterion_group!(benches, predictions);
criterion_main!(benches);
