//! The compiled kernels give the bits of the plain loops, whatever the topology, the instructions,
//! the precision and the method.

mod common;

use common::{Random, bits, state_bits};
use msd_core::explicit::{self, Scratch, Substep};
use msd_core::forces::{add_spring_forces, set_external_forces};
use msd_core::glam::DVec3;
use msd_core::integrator::{Explicit, Family};
use msd_core::kernel::Kernel;
use msd_core::tangent::Tangent;
use msd_core::{
    Friction, Instructions, Integrator, Interaction, Material, Model, Particle, Pin, Plane, Real,
    Scene, Select, Settings, Simulation, Spring, State, Vector, collision, shape,
};
use proptest::prelude::*;

/// One step of plain loops: the oracle.
struct Oracle<R: Real> {
    model: Model<R>,
    state: State<R>,
    scratch: Scratch<R>,
    /// Energy taken away, joules.
    counted: f64,
}

impl<R: Real> Oracle<R> {
    fn of(simulation: &Simulation<R>, method: Explicit) -> Self {
        let (model, state) = (simulation.model().clone(), simulation.state());
        let scratch = Scratch::new(method, model.particle_count());
        Oracle { model, state, scratch, counted: 0.0 }
    }

    fn step(&mut self, method: Explicit, settings: Settings) {
        let (model, h) = (&self.model, settings.substep());
        let grabbed = !model.grabs().is_empty();
        let damped = model.is_damped() || grabbed || model.drag() != R::ZERO;
        for substep in 0..settings.substeps {
            let inverse_masses = model.inverse_masses();
            let substep = Substep { h: R::of(h), inverse_masses, warm: 0 < substep, damped };
            let mut force = |motion: msd_core::Motion<'_, R>, forces: &mut [R::Vec3]| {
                set_external_forces(model, motion, forces)
                    + add_spring_forces(model, motion, forces)
            };
            let Oracle { state, scratch, .. } = self;
            self.counted += explicit::advance(method, substep, state, scratch, &mut force);
            let contacts = collision::resolve(model, R::of(h), scratch.forces(), state);
            self.counted += contacts.energy;
        }
    }
}

/// Rows that a person might write, and some that nobody would: ends that coincide, springs twice,
/// particles alone, numbers of their own or all alike.
fn scenes() -> impl Strategy<Value = Scene> {
    // Columns are placed from 256 particles on.
    let counts = prop_oneof![4 => 1..201usize, 1 => 256..401usize];
    let numbers = (counts, any::<u64>(), 0.0..8.0, any::<[bool; 6]>());
    numbers.prop_map(|(count, seed, degree, [alike, damped, floor, lattice, drag, corner])| {
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
        let ends = |random: &mut Random| {
            let a = random.below(count);
            let near = [1, 7, 8, 9][random.below(4)];
            let b = if lattice { (a + near) % count } else { random.below(count) };
            [a, if a == b { (a + 1) % count } else { b }]
        };
        let mut spring = |ends: [usize; 2]| Spring {
            ends,
            rest_length: if alike { 1.0 } else { random.unit() },
            stiffness: if alike { 50.0 } else { 100.0 * random.unit() },
            damping: if damped { if alike { 0.5 } else { random.unit() } } else { 0.0 },
        };
        let mut other = Random(seed.rotate_left(7) | 1);
        let springs = (0..springs).map(|_| spring(ends(&mut other))).collect();
        let mut planes = Vec::new();
        if floor {
            let friction = Friction::Coulomb(0.3);
            planes.push(Plane { normal: DVec3::Y, offset: 1.0, restitution: 0.5, friction });
        }
        if corner {
            let friction = Friction::TangentialLoss(0.1);
            let normal = DVec3::new(1.0, 0.5, 0.0);
            planes.push(Plane { normal, offset: 0.5, restitution: 0.9, friction });
        }
        let pins = if 2 < count { vec![Pin { particle: 1, velocity: DVec3::Y }] } else { vec![] };
        let mut scene = Scene { particles, springs, planes, pins, ..Scene::default() };
        scene.world.drag = if drag { 0.01 } else { 0.0 };
        scene
    })
}

fn check_forces<R: Real>(scene: &Scene) {
    let (model, state) = Model::<R>::new(scene).expect("a valid scene");
    let mut plain = vec![R::Vec3::ZERO; model.particle_count()];
    let mut power = set_external_forces(&model, state.motion(), &mut plain);
    power += add_spring_forces(&model, state.motion(), &mut plain);
    for instructions in Instructions::ALL {
        let mut kernel = Kernel::new(&model, instructions);
        let mut swept = vec![R::Vec3::ZERO; model.particle_count()];
        let swept_power = kernel.set_forces(&model, state.motion(), &mut swept);
        assert_eq!(bits::<R>(&swept), bits::<R>(&plain), "{}", instructions.name());
        // Each summand is rounded as often as a slice has rows, in the precision of the run.
        let rounding = 200.0 * R::EPSILON.to_f64() * power;
        assert!((swept_power - power).abs() <= rounding, "{swept_power} {power}");
    }
}

fn check_steps<R: Real>(scene: &Scene, queue: &[Interaction]) {
    for integrator in Integrator::EXPLICIT {
        let Family::Explicit(method) = integrator.family() else { unreachable!("by name") };
        let settings = Settings { integrator, step: 0.02, substeps: 3, ..Settings::default() };
        for instructions in Instructions::ALL {
            let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
            simulation.set_instructions(instructions);
            for &interaction in queue {
                simulation.queue(interaction).expect("a valid interaction");
            }
            simulation.apply_queued().expect("finite");
            let mut oracle = Oracle::of(&simulation, method);
            for _ in 0..3 {
                simulation.step().expect("short and soft");
                oracle.step(method, settings);
                let what = (integrator.name(), instructions.name());
                let (swept, plain) = (&simulation.state(), &oracle.state);
                assert_eq!(state_bits(swept), state_bits(plain), "{what:?}");
            }
            check_taken(&simulation, oracle.counted);
        }
    }
}

/// Vectors whose zeros are all positive: a product adds a zero where the plain loop has no spring.
fn numbers<R: Real>(vectors: &[R::Vec3]) -> Vec<Vec<u8>> {
    bits::<R>(&vectors.iter().map(|&vector| vector + R::Vec3::ZERO).collect::<Vec<_>>())
}

fn check_products<R: Real>(model: &Model<R>, state: &State<R>) {
    let tau = R::of(0.02);
    let mut tangent = Tangent::new(model);
    tangent.linearise(model, state.motion(), tau);
    let mut random = Random(5);
    let x: Vec<R::Vec3> =
        (0..model.particle_count()).map(|_| R::Vec3::of(random.vector() - 0.5)).collect();
    let mut plain = vec![R::Vec3::ZERO; x.len()];
    tangent.set_product(model.ends(), &x, &mut plain);
    let dots = x.iter().zip(&plain).map(|(&x, &y)| x.dot(y).to_f64());
    let (sum, sum_of_sizes) = dots.fold((0.0, 0.0), |(a, b), dot| (a + dot, b + dot.abs()));
    for instructions in Instructions::ALL {
        let mut kernel = Kernel::new(model, instructions);
        let mut swept = vec![R::Vec3::ZERO; x.len()];
        kernel.set_forces(model, state.motion(), &mut swept);
        kernel.linearise(model, tau);
        let dot = kernel.set_product(model, &x, &mut swept);
        assert_eq!(numbers::<R>(&swept), numbers::<R>(&plain), "{}", instructions.name());
        // The same summands in another order: each partial sum errs by half a rounding.
        let rounding = x.len() as f64 * f64::EPSILON * sum_of_sizes;
        assert!((dot - sum).abs() <= rounding, "{dot} {sum}");
        for (particle, inverse) in tangent.inverses().iter().enumerate() {
            assert_eq!(numbers::<R>(&kernel.inverse(particle)), numbers::<R>(inverse));
        }
    }
}

fn check_implicit_steps<R: Real>(scene: &Scene, queue: &[Interaction]) {
    for integrator in [Integrator::BackwardEuler, Integrator::ImplicitMidpoint] {
        let settings = Settings { integrator, step: 0.02, newton: 2, ..Settings::default() };
        let runs = Instructions::ALL.map(|instructions| {
            let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
            simulation.set_instructions(instructions);
            for &interaction in queue {
                simulation.queue(interaction).expect("a valid interaction");
            }
            let steps: Vec<bool> = (0..3).map(|_| simulation.step().is_ok()).collect();
            (steps, state_bits(&simulation.state()))
        });
        assert_eq!(runs[1], runs[0], "{integrator}");
        assert_eq!(runs[2], runs[0], "{integrator}");
    }
}

/// What was taken away is the same up to rounding, where no contact lets the balance tell it.
fn check_taken<R: Real>(simulation: &Simulation<R>, counted: f64) {
    let energy = simulation.energy();
    if simulation.model().planes().is_empty() {
        // As many roundings as a slice has rows, and of speeds that are differences of larger ones.
        let rounding = 1e3 * R::EPSILON.to_f64() * (counted.abs() + energy.kinetic);
        let taken = energy.dissipated;
        assert!((taken - counted).abs() <= rounding, "{taken} J, plain loops {counted} J");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 24 } else { 128 }))]

    #[test]
    fn forces_of_any_topology_have_the_bits_of_the_plain_loop(scene in scenes()) {
        check_forces::<f32>(&scene);
        check_forces::<f64>(&scene);
    }

    #[test]
    fn steps_of_any_topology_have_the_bits_of_plain_loops(scene in scenes()) {
        check_steps::<f32>(&scene, &[]);
        check_steps::<f64>(&scene, &[]);
    }
}

/// What is swept in runs: borders in the first slice and in the last, and in between.
#[test]
fn lattices_have_the_bits_of_plain_loops() {
    let material = Material { mass: 1.0, stiffness: 100.0, damping: 0.5 };
    let block = |sides| shape::block(sides, 1.0, material).expect("small");
    let cloth = shape::cloth([40, 37], 1.0, material).expect("small");
    let chain = shape::rope(200, 1.0, material);
    for part in [block([9, 8, 7]), block([1, 20, 3]), cloth, chain.expect("small")] {
        let mut scene = Scene::of("lattice", part);
        scene.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
        check_forces::<f32>(&scene);
        check_forces::<f64>(&scene);
        check_steps::<f32>(&scene, &[]);
        check_steps::<f64>(&scene, &[]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 24 } else { 128 }))]

    #[test]
    fn products_of_any_topology_have_the_numbers_of_the_plain_loop(scene in scenes()) {
        let (model, state) = Model::<f32>::new(&scene).expect("a valid scene");
        check_products(&model, &state);
        let (model, state) = Model::<f64>::new(&scene).expect("a valid scene");
        check_products(&model, &state);
    }

    #[test]
    fn implicit_steps_of_any_topology_have_the_same_bits_by_any_instructions(scene in scenes()) {
        check_implicit_steps::<f32>(&scene, &[]);
        check_implicit_steps::<f64>(&scene, &[]);
    }
}

/// More records than the near caches hold, in many parts: what is asked for ahead changes nothing.
#[test]
fn a_large_tangle_has_the_bits_of_plain_loops() {
    let mut random = Random(7);
    let material = Material { mass: 1.0, stiffness: 10.0, damping: 0.1 };
    let part = shape::cloth([160, 130], 1.0, material).expect("a cloth");
    let mut scene = Scene::of("tangle", part);
    let count = scene.particles.len();
    for spring in &mut scene.springs {
        let a = random.below(count);
        spring.ends = [a, (a + 1 + random.below(count - 1)) % count];
    }
    check_forces::<f32>(&scene);
    check_forces::<f64>(&scene);
}

/// Two particles that hold thousands of springs each, in one slice: no run serves them, and to look
/// for one takes no longer than to have none.
#[test]
fn hubs_are_compiled_in_time_and_have_the_bits_of_the_plain_loop() {
    let particle = |row: usize| Particle {
        position: DVec3::new(row as f64, (row % 7) as f64, 0.0),
        velocity: DVec3::Y,
        mass: 1.0,
    };
    let count = 60_000;
    let spring = |row: usize| Spring {
        ends: [row % 2, 2 + (row * 7919) % (count - 2)],
        rest_length: 1.0,
        stiffness: 1.0,
        damping: 0.1,
    };
    let scene = Scene {
        particles: (0..count).map(particle).collect(),
        springs: (0..count).map(spring).collect(),
        ..Scene::default()
    };
    check_forces::<f32>(&scene);
}

/// What a kernel remembers from step to step is forgotten whenever it no longer holds.
#[test]
fn nothing_stale_is_remembered() {
    let material = Material { mass: 1.0, stiffness: 100.0, damping: 0.0 };
    let mut scene = Scene::of("block", shape::block([5, 4, 3], 1.0, material).expect("small"));
    let friction = Friction::Coulomb(0.3);
    scene.planes = vec![Plane { normal: DVec3::Y, offset: -0.3, restitution: 0.5, friction }];
    let settings = Settings { substeps: 3, ..Settings::default() };
    let mut kept = Simulation::<f32>::new(&scene, settings).expect("a valid scene");
    let mut fresh = kept.clone();
    let particle = 7;
    let queue = [
        Interaction::Push { particle, force: DVec3::X },
        Interaction::SetMass { particles: Select::One(3), value: 2.0 },
        Interaction::Pin { particle, velocity: DVec3::ZERO },
        Interaction::Unpin { particle },
        Interaction::Impulse { particles: Select::All, impulse: DVec3::Z },
        Interaction::Cut { spring: 5 },
        Interaction::SetGravity { value: DVec3::X },
        Interaction::Freeze { springs: Select::All },
    ];
    let earlier = kept.state();
    for step in 0..48 {
        for simulation in [&mut kept, &mut fresh] {
            if step % 3 == 0 {
                simulation.queue(queue[step / 3 % queue.len()]).expect("valid");
            }
            if step == 20 {
                simulation.set_state(&earlier, 0).expect("a state of this scene");
            }
            if step % 6 == 0 {
                let integrator = [Integrator::VelocityVerlet, Integrator::Rk4][step / 6 % 2];
                simulation.set_settings(Settings { integrator, ..settings }).expect("valid");
            }
        }
        // A kernel that is new remembers nothing.
        fresh.set_instructions(Instructions::best());
        for simulation in [&mut kept, &mut fresh] {
            if step % 5 == 4 {
                simulation
                    .step_with(|_, forces| forces[0] += msd_core::glam::Vec3A::X)
                    .expect("calm");
            } else {
                simulation.step().expect("calm");
            }
        }
        assert_eq!(kept.state(), fresh.state(), "step {step}");
    }
}

/// A lattice with a hand on it, cut twice.
#[test]
fn grabs_pushes_and_cuts_have_the_bits_of_plain_loops() {
    let material = Material { mass: 1.0, stiffness: 100.0, damping: 0.5 };
    let scene = Scene::of("block", shape::block([5, 4, 3], 1.0, material).expect("small"));
    let grab = |particle| Interaction::Grab {
        particle,
        target: DVec3::new(3.0, 9.0, 1.0),
        frequency: 2.0,
        damping_ratio: 0.7,
        max_force: 20.0,
    };
    let cut = |spring| Interaction::Cut { spring };
    let queue = [
        grab(7),
        cut(3),
        grab(50),
        cut(200),
        Interaction::Pin { particle: 20, velocity: DVec3::X },
        Interaction::SetMass { particles: Select::One(21), value: 3.0 },
        Interaction::SetStiffness { springs: Select::Range(10, 30), value: 70.0 },
    ];
    check_steps::<f32>(&scene, &queue);
    check_steps::<f64>(&scene, &queue);
    check_implicit_steps::<f32>(&scene, &queue);
    check_implicit_steps::<f64>(&scene, &queue);
    let mut simulation = Simulation::<f64>::new(&scene, Settings::default()).expect("valid");
    queue.iter().for_each(|&interaction| simulation.queue(interaction).expect("valid"));
    simulation.apply_queued().expect("finite");
    check_products(simulation.model(), &simulation.state());
}

/// A mass that is rounded away beside its springs leaves a block without an inverse.
#[test]
fn blocks_that_rounding_spoils_have_the_numbers_of_the_plain_loop() {
    let material = Material { mass: 1e-9, stiffness: 1e12, damping: 0.0 };
    let scene = Scene::of("chain", shape::cloth([40, 1], 1.0, material).expect("small"));
    let (model, state) = Model::<f32>::new(&scene).expect("valid");
    check_products(&model, &state);
}
