//! How much faster are copies of a scene together than alone? Per spring update of a copy.
//!
//! Group `ensemble`: for each scene the plain loops, a simulation, and sixteen copies at once with
//! each set of instructions.

#[path = "baselines/simple.rs"]
mod simple;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use msd::core::glam::DVec3;
use msd::core::kernel::Instructions;
use msd::core::{
    Ensemble, Error, Integrator, Material, Part, Pin, Scene, Settings, Simulation, shape,
};
use msd::lab::peers;
use simple::Simple;

const COPIES: usize = 16;
const SUBSTEPS: u32 = 8;
const MATERIAL: Material = Material { mass: 1.0, stiffness: 1000.0, damping: 2.0 };

fn settings() -> Settings {
    let integrator = Integrator::SymplecticEuler;
    Settings { integrator, step: 8.0 / 960.0, substeps: SUBSTEPS, ..Settings::default() }
}

/// Hung by its first particle above nothing, so that it moves for ever and never leaves the world.
fn hung(scene: Scene) -> Scene {
    let pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    Scene { pins, planes: Vec::new(), ..scene }
}

fn copies(scene: &Scene) -> Ensemble<f32> {
    let copy = |copy: usize| {
        let mut scene = scene.clone();
        let factor = 1.0 + 0.01 * copy as f64;
        scene.springs.iter_mut().for_each(|spring| spring.stiffness *= factor);
        Simulation::new(&scene, settings()).expect("a valid scene")
    };
    Ensemble::new(&(0..COPIES).map(copy).collect::<Vec<_>>()).expect("alike")
}

fn ensemble(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("ensemble");
    let lattice = |part: Result<Part, Error>| Scene::of("body", part.expect("a small lattice"));
    for (name, scene) in [
        ("cloth/31", lattice(shape::cloth([31, 31], 1.0, MATERIAL))),
        ("block/10", lattice(shape::block([10, 10, 10], 1.0, MATERIAL))),
        ("irregular/1000", peers::irregular(1000).expect("a small tangle")),
    ] {
        let scene = hung(scene);
        let updates = u64::from(SUBSTEPS) * scene.springs.len() as u64;
        group.throughput(Throughput::Elements(updates));
        let mut simple = Simple::<f32>::new(&scene, settings());
        group.bench_function(format!("{name}/simple"), |bencher| bencher.iter(|| simple.step()));
        let mut alone = Simulation::<f32>::new(&scene, settings()).expect("a valid scene");
        group.bench_function(format!("{name}/alone"), |bencher| {
            bencher.iter(|| alone.step().expect("stable"));
        });
        group.throughput(Throughput::Elements(updates * COPIES as u64));
        for instructions in Instructions::ALL {
            let mut together = copies(&scene);
            together.set_instructions(instructions);
            let name = format!("{name}/together/{}", instructions.name());
            group.bench_function(name, |bencher| bencher.iter(|| together.step()));
            assert_eq!(together.running(), COPIES, "stable");
        }
    }
    group.finish();
}

criterion_group!(benches, ensemble);
criterion_main!(benches);
