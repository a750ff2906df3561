//! Every copy of an ensemble has the bits of a simulation of its own, whatever they differ in.

mod common;

use common::{Random, state_bits};
use msd_core::glam::DVec3;
use msd_core::kernel::Instructions;
use msd_core::{
    Ensemble, Error, Friction, Integrator, Interaction, Material, Motion, Particle, Pin, Plane,
    Real, Scene, Settings, Simulation, Spring, shape,
};
use proptest::prelude::*;

/// Pairs of particles, some of them twice.
fn topology(random: &mut Random, particles: usize) -> Vec<[usize; 2]> {
    let springs = if 1 < particles { random.below(5 * particles) } else { 0 };
    let ends = |_| {
        let (a, b) = (random.below(particles), random.below(particles));
        [a, if a == b { (a + 1) % particles } else { b }]
    };
    (0..springs).map(ends).collect()
}

/// A scene of that topology with numbers of its own; some are alike, absent, or no good.
fn scene(random: &mut Random, (particles, ends): (usize, &[[usize; 2]])) -> Scene {
    let (alike, damped) = (random.yes(), random.yes());
    let particle = |random: &mut Random| Particle {
        position: random.vector() * 4.0,
        velocity: random.vector() - 0.5,
        mass: if alike { 1.0 } else { 0.5 + random.unit() },
    };
    let mut rows: Vec<Particle> = (0..particles).map(|_| particle(random)).collect();
    // A spring whose ends coincide has no direction.
    if let (Some(&[a, b]), true) = (ends.first(), random.yes()) {
        rows[a].position = rows[b].position;
        rows[a].velocity = rows[b].velocity;
    }
    let spring = |&ends: &[usize; 2]| Spring {
        ends,
        rest_length: if alike { 1.0 } else { random.unit() },
        stiffness: if alike { 50.0 } else { 100.0 * random.unit() },
        damping: if damped { if alike { 0.5 } else { random.unit() } } else { 0.0 },
    };
    let springs = ends.iter().map(spring).collect();
    let planes = (0..random.below(3)).map(|_| plane(random)).collect();
    let mut scene = Scene { particles: rows, springs, planes, ..Scene::default() };
    if 2 < particles && random.yes() {
        scene.pins.push(Pin { particle: random.below(particles), velocity: random.vector() });
    }
    scene.world.gravity = if random.yes() { random.vector() * 20.0 - 10.0 } else { DVec3::ZERO };
    scene.world.drag = if random.yes() { 0.1 * random.unit() } else { 0.0 };
    scene.world.force = if random.yes() { random.vector() } else { DVec3::ZERO };
    // Some copies soon leave so small a world.
    scene.world.extent = if random.below(4) == 0 { 8.0 } else { 1e6 };
    scene
}

fn plane(random: &mut Random) -> Plane {
    Plane {
        normal: random.vector() + 0.1,
        offset: random.unit(),
        restitution: random.unit(),
        friction: if random.yes() {
            Friction::Coulomb(random.unit())
        } else {
            Friction::TangentialLoss(random.unit())
        },
    }
}

/// Copies of a random topology.
fn copies<R: Real>(seed: u64, integrator: Integrator, count: usize) -> Vec<Simulation<R>> {
    let mut random = Random(seed);
    let particles = 1 + random.below(40);
    let ends = topology(&mut random, particles);
    let substeps = 1 + random.below(3) as u32;
    let copy = |_| {
        loop {
            let scene = scene(&mut random, (particles, &ends));
            let step = 0.03 * (0.1 + random.unit());
            let settings = Settings { integrator, step, substeps, ..Settings::default() };
            // A plane may push a particle out of a small world: another one, then.
            if let Ok(simulation) = Simulation::new(&scene, settings) {
                return simulation;
            }
        }
    };
    (0..count).map(copy).collect()
}

/// Steps copies alone and together, and compares everything.
fn check<R: Real>(mut alone: Vec<Simulation<R>>, instructions: Instructions, steps: usize) {
    let mut together = Ensemble::new(&alone).expect("alike");
    together.set_instructions(instructions);
    let mut errors: Vec<Option<Error>> = vec![None; alone.len()];
    for _ in 0..steps {
        together.step();
        for (copy, simulation) in alone.iter_mut().enumerate() {
            let what = (copy, instructions.name(), simulation.settings().integrator.name());
            if errors[copy].is_none() {
                errors[copy] = simulation.step().err();
                assert_eq!(together.error(copy), errors[copy], "{what:?}");
            }
            let state = together.state(copy);
            assert_eq!(state_bits(&state), state_bits(simulation.state()), "{what:?}");
            assert_eq!(together.runs(copy), errors[copy].is_none(), "{what:?}");
            assert_eq!(together.steps(copy), simulation.steps(), "{what:?}");
            assert_eq!(together.time(copy).to_bits(), simulation.time().to_bits(), "{what:?}");
        }
    }
    assert_eq!(together.running(), errors.iter().filter(|error| error.is_none()).count());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 24 } else { 128 }))]

    #[test]
    fn every_copy_has_the_bits_of_a_simulation_of_its_own(
        seed in any::<u64>(),
        count in 1..34usize,
    ) {
        for integrator in Integrator::EXPLICIT {
            for instructions in Instructions::ALL {
                check(copies::<f32>(seed, integrator, count), instructions, 4);
                check(copies::<f64>(seed, integrator, count), instructions, 4);
            }
        }
    }
}

/// A cloth of stiffnesses up to what no step of this length bears.
fn cloths(count: usize) -> Vec<Simulation<f32>> {
    let cloth = |copy: usize| {
        let stiffness = 100.0 * 3f64.powi(copy as i32);
        let material = Material { mass: 0.1, stiffness, damping: 0.01 };
        let scene = Scene::of("cloth", shape::cloth([8, 9], 0.1, material).expect("small"));
        let pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
        let scene = Scene { pins, ..scene };
        Simulation::new(&scene, Settings { substeps: 4, ..Settings::default() }).expect("valid")
    };
    (0..count).map(cloth).collect()
}

#[test]
fn copies_that_diverge_stop_as_alone_and_disturb_no_other() {
    for instructions in Instructions::ALL {
        check(cloths(17), instructions, 120);
    }
    let mut together = Ensemble::new(&cloths(17)).expect("alike");
    (0..120).for_each(|_| together.step());
    assert!(together.runs(0) && !together.runs(16));
    assert!((1..17).contains(&together.running()));
    assert!(matches!(together.error(16), Some(Error::Diverged(_))));
}

#[test]
fn copies_go_on_from_where_they_are() {
    let mut copies = cloths(3);
    for (count, copy) in copies.iter_mut().enumerate() {
        (0..count).for_each(|_| copy.step().expect("soft"));
        let faster = Settings { step: 0.01, ..copy.settings() };
        copy.set_settings(faster).expect("valid");
    }
    check(copies, Instructions::best(), 20);
}

#[test]
fn a_load_is_a_force_that_every_step_adds() {
    for integrator in Integrator::EXPLICIT {
        for instructions in Instructions::ALL {
            let mut alone = copies::<f64>(7, integrator, 20);
            let mut together = Ensemble::new(&alone).expect("alike");
            together.set_instructions(instructions);
            let count = alone[0].model().particle_count();
            let mut random = Random(3);
            let loads: Vec<Vec<DVec3>> =
                (0..10).map(|_| (0..count).map(|_| random.vector()).collect()).collect();
            for (copy, load) in loads.iter().enumerate() {
                together.set_load(copy, load).expect("as long");
            }
            for _ in 0..4 {
                together.step();
                for (copy, simulation) in alone.iter_mut().enumerate() {
                    let add = |_: Motion<'_, f64>, forces: &mut [DVec3]| {
                        for (force, &load) in
                            forces.iter_mut().zip(loads.get(copy).into_iter().flatten())
                        {
                            *force += load;
                        }
                    };
                    // A copy that has left the world stays where it was, here and there.
                    let _ = if together.runs(copy) { simulation.step_with(add) } else { Ok(()) };
                    let state = together.state(copy);
                    assert_eq!(state_bits(&state), state_bits(simulation.state()), "{copy}");
                }
            }
        }
    }
    let mut together = Ensemble::new(&cloths(1)).expect("alike");
    let refused = together.set_load(0, &[]);
    assert!(matches!(refused, Err(Error::WrongLength { what: "load", count: 0, expected: 72 })));
}

#[test]
fn speeds_are_norms_of_the_velocities() {
    let mut together = Ensemble::new(&copies::<f64>(11, Integrator::Rk4, 18)).expect("alike");
    together.step();
    for (copy, speed) in together.speeds().into_iter().enumerate() {
        let velocities = together.state(copy).velocities;
        let square: f64 = velocities.iter().map(|v| v.dot(*v)).sum();
        assert!(!together.runs(copy) || speed.to_bits() == square.sqrt().to_bits());
    }
}

#[test]
fn what_is_not_alike_is_refused_with_its_number() {
    assert_eq!(Ensemble::<f32>::new(&[]).err(), Some(Error::NoCopies));
    let refusal = |change: &dyn Fn(&mut Simulation<f32>)| {
        let mut copies = cloths(3);
        change(&mut copies[2]);
        Ensemble::new(&copies).expect_err("unlike").to_string()
    };
    let set = |change: fn(&mut Settings)| {
        move |copy: &mut Simulation<f32>| {
            let mut settings = copy.settings();
            change(&mut settings);
            copy.set_settings(settings).expect("valid");
        }
    };
    let queue =
        |interaction| move |copy: &mut Simulation<f32>| copy.queue(interaction).expect("valid");
    let hold = Interaction::Grab {
        particle: 1,
        target: DVec3::ZERO,
        frequency: 1.0,
        damping_ratio: 1.0,
        max_force: 1.0,
    };
    let held = refusal(&|copy| {
        copy.queue(hold).expect("valid");
        copy.apply_queued().expect("finite");
    });
    assert!(held.contains("copy 2 cannot run in an ensemble: a hand is on it"), "{held}");
    let waits = refusal(&queue(hold));
    assert!(waits.contains("interactions wait"), "{waits}");
    let cut = refusal(&|copy| {
        copy.queue(Interaction::Cut { spring: 5 }).expect("valid");
        copy.apply_queued().expect("finite");
    });
    assert!(cut.starts_with("what the springs join of copy 2 differs"), "{cut}");
    let substeps = refusal(&set(|settings| settings.substeps = 5));
    assert!(substeps.starts_with("the number of substeps of copy 2"), "{substeps}");
    let integrator = refusal(&set(|settings| settings.integrator = Integrator::Rk4));
    assert!(integrator.starts_with("the integrator of copy 2"), "{integrator}");
    let implicit = refusal(&set(|settings| settings.integrator = Integrator::Xpbd));
    assert!(implicit.contains("copy 2 cannot run in an ensemble: its integrator"), "{implicit}");
    let small = Scene::of(
        "one",
        shape::rope(2, 1.0, Material { mass: 1.0, stiffness: 1.0, damping: 0.0 }).expect("small"),
    );
    let other = refusal(&|copy| {
        *copy = Simulation::new(&small, copy.settings()).expect("valid");
    });
    assert!(other.starts_with("the number of particles of copy 2"), "{other}");
}
