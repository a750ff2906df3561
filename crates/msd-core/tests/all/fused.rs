//! Substeps in one sweep have the bits of substeps in passes, on any number of threads.

use crate::common::state_bits;
use msd_core::glam::{DMat3, DVec3};
use msd_core::methods::{Method, Parts, StepContext};
use msd_core::stability::Region;
use msd_core::{
    Friction, Guide, Instructions, Integrator, Interaction, KeyFrame, Lead, Material, Part, Pin,
    Plane, Real, Scene, Settings, Shape, Simulation, Solid, shape,
};

/// Symplectic Euler in passes over all particles.
#[derive(Debug)]
struct Passes;

impl<R: Real> Method<R> for Passes {
    fn region(&self) -> Region {
        Region::SymplecticEuler
    }
    fn advance(&self, step: &mut StepContext<'_, R>) {
        let h = step.substep();
        for _ in 0..step.substeps() {
            let power = step.set_forces(step.time());
            let Parts { positions, velocities, forces, inverse_masses, .. } = step.parts();
            for i in 0..positions.len() {
                velocities[i] += forces[i] * (inverse_masses[i] * h);
                positions[i] += velocities[i] * h;
            }
            step.finish_substep(power * h.to_f64());
        }
    }
}

fn check<R: Real>(scene: &Scene, cut: usize) {
    let integrator = Integrator::SymplecticEuler;
    let settings = Settings { integrator, step: 0.01, substeps: 3, ..Settings::default() };
    let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
    simulation.queue(Interaction::Cut { spring: cut }).expect("a spring");
    for instructions in Instructions::ALL.into_iter().filter(|&set| set <= Instructions::best()) {
        let mut passes = simulation.clone();
        passes.set_method(Passes);
        let is_best = instructions == Instructions::best();
        let numbers = if is_best { &THREADS[..] } else { &THREADS[..THREADS.len().min(2)] };
        let mut fused: Vec<_> = numbers.iter().map(|&count| (count, simulation.clone())).collect();
        for (threads, fused) in &mut fused {
            fused.set_instructions(instructions);
            on_threads(*threads, || (0..4).for_each(|_| fused.step().expect("soft")));
        }
        (0..4).for_each(|_| passes.step().expect("soft"));
        for (threads, fused) in fused {
            let what = (scene.particles.len(), instructions.name(), threads);
            assert!(state_bits(&fused.state()) == state_bits(&passes.state()), "{what:?}");
            assert_eq!(fused.energy(), passes.energy(), "{what:?}");
            assert_eq!(fused.given().to_bits(), passes.given().to_bits(), "{what:?}");
        }
    }
}

#[cfg(feature = "parallel")]
const THREADS: [usize; 4] = [1, 2, 3, 7];
#[cfg(not(feature = "parallel"))]
const THREADS: [usize; 1] = [1];

#[cfg(feature = "parallel")]
fn on_threads(threads: usize, run: impl FnOnce() + Send) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads").install(run);
}
#[cfg(not(feature = "parallel"))]
fn on_threads(_: usize, run: impl FnOnce() + Send) {
    run();
}

fn lattice(size: [usize; 3], damping: f64) -> Scene {
    let material = Material { mass: 0.3, stiffness: 70.0, damping };
    let mut part = shape::block(size, 0.5, material).expect("a lattice");
    for (row, particle) in part.particles.iter_mut().enumerate() {
        let turn = (row * row % 1009) as f64;
        particle.position += 0.1 * DVec3::new(turn.sin(), turn.cos(), (2.0 * turn).sin());
        particle.velocity = DVec3::new(turn.cos(), -1.0, (3.0 * turn).sin());
    }
    Scene::of("lattice", part)
}

/// Adds a floor, a ball, moving pins and a guide.
fn furnish(scene: &mut Scene) {
    let friction = Friction::Coulomb(0.3);
    scene.planes.push(Plane { normal: DVec3::Y, offset: 0.1, restitution: 0.5, friction });
    let ball = Solid::new(Shape::Sphere { radius: 1.0 });
    scene.solids.push(Solid { position: DVec3::new(2.0, 0.0, 0.3), friction, ..ball });
    scene.pins = (3..6).map(|particle| Pin { particle, velocity: DVec3::X }).collect();
    let position = scene.particles[9].position;
    let keys = vec![KeyFrame { time: 0.1, position: position + DVec3::Y, axes: DMat3::IDENTITY }];
    let lead = Lead::Path { since: 0.0, position, velocity: DVec3::ZERO, keys };
    scene.guides.push(Guide { held: vec![(9, DVec3::ZERO)], lead, until: Some(0.02) });
}

#[test]
fn lattices_in_parts_move_with_the_bits_of_passes() {
    // Of two and four parts, and of two of which the first is shorter than springs reach.
    let long = [11, 12, 150];
    let wide = [170, 171, 1];
    for (size, damping) in
        [([61, 17, 15], 0.4), (wide, 0.4), (wide, 0.0), (long, 0.4), ([36; 3], 0.1)]
    {
        let mut scene = lattice(size, damping);
        assert!(100_000 < scene.springs.len(), "one part");
        check::<f32>(&scene, 7);
        furnish(&mut scene);
        check::<f32>(&scene, 100_000);
        check::<f64>(&scene, 50_000);
    }
}

#[test]
fn large_bodies_beside_small_ones_move_with_the_bits_of_passes() {
    let mut scene = lattice([9, 8, 7], 0.4);
    for size in [[170, 171, 1], [5, 4, 3], [11, 12, 150], [90, 90, 1], [6, 6, 6], [30, 30, 20]] {
        add(&mut scene, size);
    }
    check::<f32>(&scene, 0);
    furnish(&mut scene);
    check::<f64>(&scene, 99);
}

/// Adds a lattice beside the others.
fn add(scene: &mut Scene, size: [usize; 3]) {
    let mut other = lattice(size, 0.1);
    other.particles.iter_mut().for_each(|particle| particle.position.x += 40.0);
    let body = other.bodies.remove(0);
    let (particles, springs) = (other.particles, other.springs);
    scene.add(&body.name, Part { particles, springs, ..Default::default() });
}

#[test]
fn several_bodies_move_with_the_bits_of_passes() {
    let mut scene = lattice([9, 8, 7], 0.4);
    for size in [[40, 30, 1], [2, 2, 2], [1, 2, 1], [5, 3, 40], [70, 1, 1]] {
        add(&mut scene, size);
    }
    check::<f32>(&scene, 0);
    furnish(&mut scene);
    check::<f32>(&scene, 99);
    check::<f64>(&scene, 1);
}
