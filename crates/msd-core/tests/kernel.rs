//! Bit equality of the fast kernels with plain loops.
//!
//! They agree whatever the topology, the instructions, the precision and the method.

mod common;
#[path = "common/oracle.rs"]
mod oracle;

use common::{Random, bits, state_bits};
use msd_core::elements::springs::Sum;
use msd_core::glam::DVec3;
use msd_core::{
    Friction, Instructions, Integrator, Interaction, Material, Particle, Pin, Plane, Real, Scene,
    Select, Settings, Simulation, Spring, shape,
};
use oracle::Oracle;
use proptest::prelude::*;

/// The sets of instructions that this machine has.
fn sets() -> impl Iterator<Item = Instructions> {
    Instructions::ALL.into_iter().filter(|&set| set <= Instructions::best())
}

/// Number of cases of a property: few where it is slow, in an emulator or in Miri.
const CASES: u32 = match (cfg!(debug_assertions), cfg!(target_arch = "x86_64"), cfg!(miri)) {
    (_, _, true) => 2,
    (false, _, _) => 128,
    (true, true, _) => 32,
    (true, false, _) => 8,
};

/// Rows that a user might write, and some that nobody would: ends that coincide, springs twice,
/// particles alone, numbers of their own or all alike, lattices with and without diagonals that
/// cross their ends, several bodies.
fn scenes() -> impl Strategy<Value = Scene> {
    // Columns are placed from 256 particles on, and bodies of as many have blocks of their own.
    let most: usize = if cfg!(miri) { 300 } else { 701 };
    let counts = prop_oneof![4 => 1..201usize, 2 => 256..most];
    let numbers = (counts, any::<u64>(), 0.0..8.0, any::<[bool; 7]>());
    numbers.prop_map(|(count, seed, degree, [alike, damped, floor, lattice, drag, lid, two])| {
        let mut random = Random(seed | 1);
        let particle = |random: &mut Random| Particle {
            position: random.vector() * 4.0,
            velocity: random.vector() - 0.5,
            mass: if alike { 1.0 } else { 0.5 + random.unit() },
        };
        let mut particles: Vec<Particle> = (0..count).map(|_| particle(&mut random)).collect();
        if 3 < count {
            particles[count / 2].position = particles[count / 2 - 1].position;
        }
        let springs = if 1 < count { (count as f64 * degree) as usize } else { 0 };
        let ends = |random: &mut Random, number: usize| {
            let a = if lattice { number % count } else { random.below(count) };
            let near = [1, 7, 8, 9, 7, 1, 57, 8][number / count % 8];
            // One in forty belongs to no family.
            let is_odd = random.below(40) == 0;
            let b = if lattice && !is_odd { (a + near) % count } else { random.below(count) };
            [a, if a == b { (a + 1) % count } else { b }]
        };
        let mut spring = |ends: [usize; 2]| Spring {
            ends,
            rest_length: if alike { 1.0 } else { random.unit() },
            stiffness: if alike { 50.0 } else { 100.0 * random.unit() },
            damping: if damped { if alike { 0.5 } else { random.unit() } } else { 0.0 },
        };
        let mut other = Random(seed.rotate_left(7) | 1);
        let springs = (0..springs).map(|number| spring(ends(&mut other, number))).collect();
        let mut planes = Vec::new();
        if floor {
            let friction = Friction::Coulomb(0.3);
            planes.push(Plane { normal: DVec3::Y, offset: 1.0, restitution: 0.5, friction });
        }
        // It meets the floor far from all particles: the oracle knows one plane at a time.
        if lid {
            let friction = Friction::TangentialLoss(0.1);
            let normal = DVec3::new(0.1, -1.0, 0.0);
            planes.push(Plane { normal, offset: -3.0, restitution: 0.9, friction });
        }
        let pins = if 2 < count { vec![Pin { particle: 1, velocity: DVec3::Y }] } else { vec![] };
        let mut scene = Scene { particles, springs, planes, pins, ..Scene::default() };
        if two {
            let half = count / 2;
            for particles in [0..half, half..count] {
                let body = msd_core::Body { particles, ..Default::default() };
                scene.bodies.push(body);
            }
        }
        scene.world.drag = if drag { 0.01 } else { 0.0 };
        scene
    })
}

/// Cuts, as a user makes them: one, a few, one twice.
fn cuts(scene: &Scene) -> Vec<Interaction> {
    let count = scene.springs.len();
    let springs: Vec<usize> =
        if count == 0 { vec![] } else { vec![0, count / 2, count / 2, count - 1] };
    springs.into_iter().map(|spring| Interaction::Cut { spring }).collect()
}

fn simulation<R: Real>(scene: &Scene, settings: Settings, queue: &[Interaction]) -> Simulation<R> {
    let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
    for &interaction in queue {
        simulation.queue(interaction).expect("a valid interaction");
    }
    simulation.apply_queued().expect("finite");
    simulation
}

fn check_forces<R: Real>(scene: &Scene, queue: &[Interaction]) {
    for instructions in sets() {
        let mut simulation = simulation::<R>(scene, Settings::default(), queue);
        simulation.set_instructions(instructions);
        let mut oracle = Oracle::of(&simulation);
        let power = oracle.evaluate(oracle.state.velocities.clone());
        let (swept, swept_power) = simulation.forces();
        assert_eq!(bits::<R>(&swept), bits::<R>(&oracle.forces), "{}", instructions.name());
        // Each summand is rounded once, in the precision of the run, and their sum in f64.
        let rounding = 200.0 * R::EPSILON.to_f64() * power.abs();
        assert!((swept_power - power).abs() <= rounding, "{swept_power} {power}");
    }
}

/// The energy of springs is the sum of that of each, with the same bits by all instructions.
fn check_energy<R: Real>(scene: &Scene, queue: &[Interaction]) {
    let simulation = simulation::<R>(scene, Settings::default(), queue);
    let energies: Vec<_> = sets()
        .map(|instructions| {
            let mut simulation = simulation.clone();
            simulation.set_instructions(instructions);
            simulation.energy()
        })
        .collect();
    assert!(energies.iter().all(|energy| *energy == energies[0]), "{energies:?}");
    let snapshot = simulation.snapshot();
    let each: f64 = (0..scene.springs.len()).map(|row| snapshot.elastic_energy(row)).sum();
    // Both are sums of as many terms, each not negative and rounded a few times.
    let rounding = (8 + scene.springs.len()) as f64 * f64::EPSILON * each;
    assert!((energies[0].elastic - each).abs() <= rounding, "{} {each}", energies[0].elastic);
}

fn check_steps<R: Real>(scene: &Scene, queue: &[Interaction]) {
    for integrator in Integrator::EXPLICIT {
        let settings = Settings { integrator, step: 0.02, substeps: 3, ..Settings::default() };
        for instructions in sets() {
            let mut simulation = simulation::<R>(scene, settings, queue);
            simulation.set_instructions(instructions);
            for _ in 0..3 {
                let before = simulation.clone();
                let mut oracle = Oracle::of(&before);
                oracle.step(settings);
                simulation.step().expect("short and soft");
                let what = (integrator.name(), instructions.name());
                assert_eq!(state_bits(&simulation.state()), state_bits(&oracle.state), "{what:?}");
                if scene.planes.is_empty() {
                    let booked = |run: &Simulation<R>| run.dissipated() - run.given();
                    let taken = booked(&simulation) - booked(&before);
                    // Rounded once per spring, and speeds are differences of larger ones.
                    let rounding = 1e3
                        * R::EPSILON.to_f64()
                        * (oracle.counted.abs() + simulation.energy().kinetic);
                    assert!((taken - oracle.counted).abs() <= rounding, "{what:?}: {taken} J");
                }
            }
        }
    }
}

/// Runs that have no oracle here have the same bits by all instructions.
fn check_instructions<R: Real>(
    scene: &Scene,
    integrators: impl IntoIterator<Item = Integrator>,
    queue: &[Interaction],
) {
    for integrator in integrators {
        let settings = Settings { integrator, step: 0.02, newton: 2, ..Settings::default() };
        let runs: Vec<_> = sets()
            .map(|instructions| {
                let mut simulation = simulation::<R>(scene, settings, queue);
                simulation.set_instructions(instructions);
                let steps: Vec<bool> = (0..3).map(|_| simulation.step().is_ok()).collect();
                (steps, state_bits(&simulation.state()))
            })
            .collect();
        assert!(runs.iter().all(|run| *run == runs[0]), "{integrator}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn forces_have_the_bits_of_the_plain_loop(scene in scenes()) {
        check_forces::<f32>(&scene, &[]);
        check_forces::<f64>(&scene, &cuts(&scene));
        check_energy::<f32>(&scene, &cuts(&scene));
        check_energy::<f64>(&scene, &[]);
    }

    #[test]
    fn explicit_steps_have_the_bits_of_plain_loops(scene in scenes()) {
        let last = scene.particles.len() - 1;
        let grab = Interaction::Grab {
            particle: last,
            target: DVec3::ONE,
            frequency: 3.0,
            damping_ratio: 1.0,
            max_force: 50.0,
        };
        check_steps::<f32>(&scene, &[&cuts(&scene)[..], &[grab]].concat());
        check_steps::<f64>(&scene, &[]);
    }

    #[test]
    fn other_steps_have_the_same_bits_by_all_instructions(scene in scenes()) {
        let others = || Integrator::ALL.into_iter().filter(|it| !Integrator::EXPLICIT.contains(it));
        check_instructions::<f32>(&scene, others(), &cuts(&scene));
        check_instructions::<f64>(&scene, others(), &[]);
    }

    #[test]
    fn steps_in_a_groove_have_the_same_bits_by_all_instructions(mut scene in scenes()) {
        let walls = [(1.0, Friction::Coulomb(0.3)), (-1.0, Friction::TangentialLoss(0.1))];
        for (x, friction) in walls {
            let normal = DVec3::new(x, 1.0, 0.0);
            scene.planes.push(Plane { normal, offset: 2.0 * x, restitution: 0.5, friction });
        }
        check_instructions::<f32>(&scene, Integrator::ALL, &[]);
    }
}

#[test]
fn lattices_of_all_shapes_have_the_bits_of_the_plain_loop() {
    let sizes = [[1, 1, 1], [1, 1, 2], [2, 2, 2], [1, 33, 1], [5, 7, 1]];
    let larger = [[3, 3, 3], [31, 31, 1], [10, 10, 10], [7, 11, 13], [40, 2, 2], [3, 1, 40]];
    for size in sizes.into_iter().chain(larger.into_iter().filter(|_| !cfg!(miri))) {
        let material = Material { mass: 0.3, stiffness: 70.0, damping: 0.4 };
        let mut part = shape::block(size, 0.5, material).expect("small");
        let mut random = Random(9);
        for particle in &mut part.particles {
            particle.position += random.vector() * 0.2;
            particle.velocity += random.vector();
        }
        let scene = Scene::of("block", part);
        check_forces::<f32>(&scene, &[]);
        check_forces::<f64>(&scene, &cuts(&scene));
        let springs = Select::Range(0, scene.springs.len() / 2);
        let stiffer = Interaction::SetStiffness { springs, value: 91.0 };
        check_forces::<f32>(&scene, &[stiffer]);
        check_energy::<f32>(&scene, &[stiffer]);
        check_energy::<f64>(&scene, &cuts(&scene));
    }
}

#[test]
#[cfg_attr(miri, ignore = "it would take an hour")]
fn bodies_of_different_widths_keep_their_sums_apart() {
    let material = Material { mass: 0.3, stiffness: 70.0, damping: 0.4 };
    // Each large enough for a block of its own, with halos of different lengths.
    let sizes = [[20, 40, 1], [7, 7, 7], [300, 1, 1], [17, 18, 1], [9, 8, 7]];
    let mut scene = Scene::default();
    let mut random = Random(4);
    for (row, size) in sizes.into_iter().enumerate() {
        let mut part = shape::block(size, 0.5, material).expect("small");
        for particle in &mut part.particles {
            particle.position += random.vector() * 0.2;
            particle.velocity += random.vector();
        }
        scene.add(format!("body {row}"), part);
    }
    // And springs between them.
    for row in 0..40 {
        let ends = [row * 31, 1000 + row * 17];
        scene.springs.push(Spring { ends, rest_length: 1.0, stiffness: 3.0, damping: 0.1 });
    }
    check_forces::<f32>(&scene, &[]);
    check_forces::<f64>(&scene, &cuts(&scene));
    check_steps::<f32>(&scene, &[]);
}

/// A large block without segments, too, is in parts.
#[test]
fn a_large_unstructured_block_has_the_bits_of_the_plain_loop() {
    let count = 12_000;
    let mut random = Random(5);
    let particle = |random: &mut Random| Particle {
        position: random.vector() * 20.0,
        velocity: random.vector() - 0.5,
        mass: 1.0,
    };
    let particles: Vec<Particle> = (0..count).map(|_| particle(&mut random)).collect();
    let spring = |row: usize| Spring {
        ends: [row % count, (row % count + 1 + random.below(149)) % count],
        rest_length: random.unit(),
        stiffness: 100.0 * random.unit(),
        damping: random.unit(),
    };
    let springs = (0..12 * count).map(spring).collect();
    let scene = Scene { particles, springs, ..Scene::default() };
    let simulation = simulation::<f32>(&scene, Settings::default(), &[]);
    let model = simulation.model();
    let sums: Vec<Sum> = model.springs().turns(model.slots()).map(|turn| turn.2[1]).collect();
    let parts: Vec<Sum> = sums.iter().copied().filter(|sum| *sum != Sum::Named).collect();
    let is_first = |sum: &Sum| *sum == parts[0];
    assert!(!parts.is_empty() && !parts.iter().all(is_first), "one part");
    check_forces::<f32>(&scene, &cuts(&scene));
    check_forces::<f64>(&scene, &[]);
}

#[test]
#[cfg_attr(miri, ignore = "it would take an hour")]
fn large_lattices_have_the_bits_of_the_plain_loop() {
    let sizes = [[61, 17, 15], [170, 171, 1], [300, 290, 1]];
    for size in sizes.into_iter().take(if cfg!(debug_assertions) { 1 } else { 3 }) {
        let material = Material { mass: 0.3, stiffness: 70.0, damping: 0.4 };
        let mut part = shape::block(size, 0.5, material).expect("a lattice");
        assert!(100_000 < part.springs.len());
        let mut random = Random(9);
        for particle in &mut part.particles {
            particle.position += random.vector() * 0.2;
            particle.velocity += random.vector();
        }
        let scene = Scene::of("lattice", part);
        let mut queue = cuts(&scene);
        let simulation = simulation::<f32>(&scene, Settings::default(), &[]);
        let model = simulation.model();
        let sums: Vec<[Sum; 2]> = model.springs().turns(model.slots()).map(|turn| turn.2).collect();
        let is_later = |sums: &[Sum; 2]| matches!(sums[1], Sum::Later(_));
        let is_carried = |sums: &[Sum; 2]| sums[0] == Sum::Carried;
        assert!(sums.iter().any(is_later) && sums.iter().any(is_carried), "{size:?}: one part");
        check_forces::<f32>(&scene, &queue);
        queue.push(Interaction::SetStiffness { springs: Select::Range(0, 5000), value: 91.0 });
        check_forces::<f64>(&scene, &queue);
    }
}

/// Whether a number is one that some processors take a hundred cycles for.
fn is_subnormal(number: f64) -> bool {
    number != 0.0 && number.abs() < f64::from(f32::MIN_POSITIVE)
}

#[test]
#[cfg_attr(miri, ignore = "it would take an hour")]
fn a_motion_that_spreads_into_a_body_at_rest_is_never_subnormal() {
    // Each substep dampers hand on a thousandth of a motion by one more particle. Without a least
    // motion a shell of subnormal numbers would run through the body, and stay in it.
    let material = Material { mass: 1.0, stiffness: 2200.0, damping: 1.0 };
    let mut scene = Scene::of("bar", shape::block([4, 4, 60], 1.0, material).expect("a lattice"));
    scene.world.gravity = DVec3::ZERO;
    scene.particles[0].velocity = DVec3::new(1.0, 0.5, 0.25);
    for integrator in Integrator::EXPLICIT {
        let settings = Settings { integrator, substeps: 12, ..Settings::default() };
        let mut simulation = Simulation::<f32>::new(&scene, settings).expect("valid");
        for _ in 0..30 {
            simulation.step().expect("stable");
            let (forces, _) = simulation.forces();
            let velocities = simulation.state().velocities;
            let mut numbers = forces.iter().chain(&velocities).flat_map(|v| v.to_array());
            assert!(!numbers.any(|number| is_subnormal(number.into())), "{integrator}");
        }
        let far = simulation.state().velocities[959];
        assert_eq!(far.to_array(), [0.0; 3], "{integrator}: the motion has come all the way");
    }
}

#[test]
fn faint_motions_have_the_bits_of_the_plain_loop() {
    for exponent in (-150..=-20).step_by(10) {
        let material = Material { mass: 1.0, stiffness: 2.0, damping: 1.0 };
        let mut scene = Scene::of("block", shape::block([4; 3], 1.0, material).expect("a lattice"));
        let mut random = Random(7);
        for particle in &mut scene.particles {
            particle.velocity = random.vector() * f64::powi(2.0, exponent);
        }
        check_forces::<f32>(&scene, &[]);
        check_forces::<f64>(&scene, &[]);
    }
}
