//! How much faster are copies of a scene together than alone? Per spring update of a copy.
//!
//! Group `ensemble`: for each scene the simple loops ([`forces::add_spring_forces`] and
//! [`explicit::advance`]), a simulation, and sixteen copies at once with each set of instructions.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use msd::core::explicit::{self, Scratch, Substep};
use msd::core::forces;
use msd::core::glam::DVec3;
use msd::core::integrator::Explicit;
use msd::core::kernel::Instructions;
use msd::core::{
    Ensemble, Integrator, Material, Model, Motion, Part, Particle, Pin, Scene, Settings,
    Simulation, Spring, shape,
};

const COPIES: usize = 16;
const SUBSTEPS: u32 = 8;
const MATERIAL: Material = Material { mass: 1.0, stiffness: 1000.0, damping: 2.0 };

fn settings() -> Settings {
    let integrator = Integrator::SymplecticEuler;
    Settings { integrator, step: 8.0 / 960.0, substeps: SUBSTEPS, ..Settings::default() }
}

/// Hung by its first particle, so that it moves for ever and never leaves the world.
fn hung(part: Part) -> Scene {
    let pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    Scene { pins, ..Scene::of("body", part) }
}

/// A thousand particles anywhere in a box, each joined to the 14 nearest.
fn nearest() -> Scene {
    let mut state = 5u64;
    let mut next = || {
        // Knuth, 1997, section 3.3.4.
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1u64 << 31) as f64
    };
    let position = |_| DVec3::new(next(), next(), next()) * 10.0;
    let positions: Vec<DVec3> = (0..1000).map(position).collect();
    let mut ends = Vec::new();
    for (a, from) in positions.iter().enumerate() {
        let mut others: Vec<usize> = (0..positions.len()).filter(|&b| b != a).collect();
        others
            .sort_by(|&b, &c| from.distance(positions[b]).total_cmp(&from.distance(positions[c])));
        ends.extend(others[..14].iter().map(|&b| [a.min(b), a.max(b)]));
    }
    ends.sort_unstable();
    ends.dedup();
    let particle =
        |&position: &DVec3| Particle { position, velocity: DVec3::ZERO, mass: MATERIAL.mass };
    let Material { stiffness, damping, .. } = MATERIAL;
    let spring = |&ends: &[usize; 2]| {
        let rest_length = positions[ends[0]].distance(positions[ends[1]]);
        Spring { ends, rest_length, stiffness, damping }
    };
    Scene {
        particles: positions.iter().map(particle).collect(),
        springs: ends.iter().map(spring).collect(),
        pins: vec![Pin { particle: 0, velocity: DVec3::ZERO }],
        ..Scene::default()
    }
}

/// A step of the simple loops.
fn simple(scene: &Scene) -> impl FnMut() {
    let (model, mut state) = Model::<f32>::new(scene).expect("a valid scene");
    let method = Explicit::SymplecticEuler;
    let mut scratch = Scratch::new(method, model.particle_count());
    let h = settings().substep() as f32;
    move || {
        for substep in 0..SUBSTEPS {
            let inverse_masses = model.inverse_masses();
            let substep = Substep { h, inverse_masses, warm: 0 < substep, damped: true };
            let mut force = |motion: Motion<'_, f32>, forces: &mut [_]| {
                forces::set_external_forces(&model, motion, forces)
                    + forces::add_spring_forces(&model, motion, forces)
            };
            explicit::advance(method, substep, &mut state, &mut scratch, &mut force);
        }
        assert!(state.positions[0].dot(state.positions[0]).is_finite(), "it is held there");
    }
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
    let part = |part: Result<Part, msd::core::Error>| hung(part.expect("a small lattice"));
    for (name, scene) in [
        ("cloth/31", part(shape::cloth([31, 31], 1.0, MATERIAL))),
        ("block/10", part(shape::block([10, 10, 10], 1.0, MATERIAL))),
        ("nearest/1000", nearest()),
    ] {
        let updates = u64::from(SUBSTEPS) * scene.springs.len() as u64;
        group.throughput(Throughput::Elements(updates));
        group.bench_function(format!("{name}/simple"), |bencher| bencher.iter(simple(&scene)));
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
