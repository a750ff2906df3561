//! How long does one step take? Scene x integrator x precision, per spring update.
//!
//! `cargo bench --bench step` reports elements per second, where an element is one spring
//! evaluated once: a substep of RK4 counts each spring four times. The group `terms` shows that a
//! scene does not pay for what it lacks.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use msd::core::forces::{Incidence, add_spring_forces, add_spring_forces_by_particle};
use msd::core::glam::DVec3;
use msd::core::{
    Friction, Integrator, Interaction, Material, Model, Part, Pin, Plane, Real, Scene, Select,
    Settings, Simulation, Vector, shape,
};
use std::hint::black_box;

const SUBSTEPS: u32 = 8;

fn material() -> Material {
    Material { mass: 1.0, stiffness: 1000.0, damping: 2.0 }
}

fn scenes() -> [(&'static str, Part); 5] {
    let block = |n: usize| shape::block([n, n, n], 1.0, material());
    let cloth = |n: usize| shape::cloth([n, n], 1.0, material());
    let parts = [
        ("chain/100", shape::rope(100, 1.0, material())),
        ("cloth/31", cloth(31)),
        ("cloth/100", cloth(100)),
        ("block/10", block(10)),
        ("block/20", block(20)),
    ];
    parts.map(|(name, part)| (name, part.expect("a small lattice")))
}

/// Hung by its first particle, so that it moves for ever and never leaves the world.
fn hung(part: Part) -> Scene {
    let pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    Scene { pins, ..Scene::of("body", part) }
}

fn settings(integrator: Integrator) -> Settings {
    Settings {
        integrator,
        step: f64::from(SUBSTEPS) / 960.0,
        substeps: SUBSTEPS,
        ..Settings::default()
    }
}

fn evaluations(integrator: Integrator) -> u64 {
    let per_substep = if integrator == Integrator::Rk4 { 4 } else { 1 };
    // Velocity Verlet evaluates once more per step.
    u64::from(SUBSTEPS) * per_substep + u64::from(integrator == Integrator::VelocityVerlet)
}

fn bench_step<R: Real>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: String,
    scene: &Scene,
    integrator: Integrator,
) {
    let mut simulation = Simulation::<R>::new(scene, settings(integrator)).expect("a valid scene");
    let updates = simulation.model().spring_count() as u64 * evaluations(integrator);
    group.throughput(Throughput::Elements(updates));
    group.bench_function(name, |bencher| bencher.iter(|| simulation.step().expect("stable")));
}

fn steps(criterion: &mut Criterion) {
    for (name, part) in scenes() {
        let mut group = criterion.benchmark_group(name);
        let scene = hung(part);
        // Explicit Euler gains energy for ever: nothing to time that stays the same.
        for integrator in &Integrator::EXPLICIT[1..] {
            bench_step::<f32>(&mut group, format!("{integrator}/f32"), &scene, *integrator);
            bench_step::<f64>(&mut group, format!("{integrator}/f64"), &scene, *integrator);
        }
    }
}

/// A particle as a textbook would store it.
#[derive(Clone, Copy, Default)]
struct TextbookParticle {
    position: [f32; 3],
    velocity: [f32; 3],
    force: [f32; 3],
}

/// A spring as a textbook would store it.
struct TextbookSpring {
    ends: [usize; 2],
    rest_length: f32,
    stiffness: f32,
    damping: f32,
}

/// The named baseline: arrays of structs, a loop over springs, the formula as it is printed.
fn textbook(particles: &mut [TextbookParticle], springs: &[TextbookSpring]) {
    for spring in springs {
        let [a, b] = spring.ends;
        let (from, to) = (particles[a], particles[b]);
        let across = [0, 1, 2].map(|i| to.position[i] - from.position[i]);
        let length = across.iter().map(|d| d * d).sum::<f32>().sqrt();
        let unit = across.map(|d| d / length);
        let rate: f32 = (0..3).map(|i| (to.velocity[i] - from.velocity[i]) * unit[i]).sum();
        let pull = spring.stiffness * (length - spring.rest_length) + spring.damping * rate;
        for (i, unit) in unit.into_iter().enumerate() {
            particles[a].force[i] += pull * unit;
            particles[b].force[i] -= pull * unit;
        }
    }
}

fn textbook_rows(scene: &Scene) -> (Vec<TextbookParticle>, Vec<TextbookSpring>) {
    let particle = |p: &msd::core::Particle| TextbookParticle {
        position: p.position.as_vec3().to_array(),
        ..TextbookParticle::default()
    };
    let spring = |s: &msd::core::Spring| TextbookSpring {
        ends: s.ends,
        rest_length: s.rest_length as f32,
        stiffness: s.stiffness as f32,
        damping: s.damping as f32,
    };
    (scene.particles.iter().map(particle).collect(), scene.springs.iter().map(spring).collect())
}

/// The two algorithms of the source report and the textbook loop, forces alone.
fn algorithms(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("forces");
    for (name, part) in scenes() {
        let scene = hung(part);
        let (mut particles, springs) = textbook_rows(&scene);
        let (model, state) = Model::<f32>::new(&scene).expect("a valid scene");
        let incidence = Incidence::new(&model);
        let mut forces = vec![Vector::ZERO; model.particle_count()];
        group.throughput(Throughput::Elements(model.spring_count() as u64));
        group.bench_function(format!("textbook/{name}"), |bencher| {
            bencher.iter(|| textbook(black_box(&mut particles), black_box(&springs)));
        });
        group.bench_function(format!("by-spring/{name}"), |bencher| {
            bencher.iter(|| add_spring_forces(&model, state.motion(), black_box(&mut forces)));
        });
        group.bench_function(format!("by-particle/{name}"), |bencher| {
            let forces = black_box(&mut forces);
            bencher.iter(|| {
                add_spring_forces_by_particle(&model, &incidence, state.motion(), forces);
            });
        });
    }
}

/// The same cloth with one more term each.
fn terms(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("terms");
    let undamped = Material { damping: 0.0, ..material() };
    let bare = hung(shape::cloth([31, 31], 1.0, undamped).expect("a small lattice"));
    let damped = hung(shape::cloth([31, 31], 1.0, material()).expect("a small lattice"));
    let mut own = bare.clone();
    for (row, spring) in own.springs.iter_mut().enumerate() {
        spring.stiffness += row as f64 * 1e-3;
    }
    let mut floored = bare.clone();
    let friction = Friction::Coulomb(0.5);
    floored.planes = vec![Plane { normal: DVec3::Y, offset: -1e3, restitution: 0.5, friction }];
    let mut dragged = bare.clone();
    dragged.world.drag = 0.01;
    for (name, scene) in [
        ("bare", &bare),
        ("damping", &damped),
        ("own-stiffness", &own),
        ("plane", &floored),
        ("drag", &dragged),
    ] {
        bench_step::<f32>(&mut group, name.into(), scene, Integrator::SymplecticEuler);
    }
    // Terms that were set and unset again cost nothing either.
    let settings = settings(Integrator::SymplecticEuler);
    let mut simulation = Simulation::<f32>::new(&own, settings).expect("a valid scene");
    let springs = Select::All;
    let back = Interaction::SetStiffness { springs, value: material().stiffness };
    simulation.queue(back).expect("a valid stiffness");
    group.bench_function("own-stiffness-unset", |bencher| {
        bencher.iter(|| simulation.step().expect("stable"));
    });
}

criterion_group!(benches, steps, algorithms, terms);
criterion_main!(benches);
