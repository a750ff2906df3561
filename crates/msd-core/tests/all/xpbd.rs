//! Steps of XPBD, against their formula and against the true motion.

use crate::common::{Random, distance, run, simulation, tumbling_block, two_masses, weightless};
use msd_core::glam::DVec3;
use msd_core::{
    Friction, Instructions, Integrator, Material, Particle, Pin, Plane, Real, Scene, Settings,
    Simulation, Spring, Vector, shape,
};

const XPBD: Integrator = Integrator::Xpbd;

#[test]
fn it_converges_at_first_order_with_and_without_damping() {
    for damping in [0.0, 4.0] {
        let scene = tumbling_block(damping);
        let reference = run(&scene, Integrator::Rk4, 1.0 / 4096.0, 2048);
        let error =
            |h: f64| distance(&run(&scene, XPBD, h, (0.5 / h).round() as usize), &reference);
        let errors = [2048.0, 4096.0, 8192.0, 16384.0].map(|rate| error(1.0 / rate));
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            // The next term of the error is a fraction of about h w of the leading one.
            assert!((order - 1.0).abs() < 0.12, "b = {damping}: {order:.3} of {errors:?}");
        }
    }
}

#[test]
fn one_spring_alone_does_the_step_of_backward_euler() {
    // That checks stiffness and damping: the force is −k C − b dC/dt of the Kelvin-Voigt element.
    let (masses, stretch) = ([1.0, 3.0], 0.4);
    let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
    for (stiffness, damping) in [(300.0, 0.0), (300.0, 5.0), (0.0, 5.0), (300.0, 500.0)] {
        for h in [1.0 / 60.0, 1.0 / 6000.0] {
            let mut scene = two_masses(masses, stiffness, damping, stretch);
            scene.particles[1].velocity.x = 1.0;
            let mut simulation = simulation::<f64>(&scene, XPBD, h);
            let (w2, c) = (stiffness / reduced, damping / reduced);
            let (mut s, mut v) = (stretch, 1.0);
            for _ in 0..100 {
                simulation.step().unwrap();
                v = (v - h * w2 * s) / (1.0 + h * c + h * h * w2);
                s += h * v;
                let [a, b] = [0, 1].map(|end| simulation.position(end).x);
                // 100 roundings of positions of 1 m, and of velocities by 1 / h more.
                assert!((b - a - 1.0 - s).abs() < 1e-11, "k {stiffness}, b {damping}");
                let [a, b] = [0, 1].map(|end| simulation.velocity(end).x);
                assert!((b - a - v).abs() < 1e-14 * 100.0 / h);
            }
        }
    }
}

#[test]
fn a_damper_without_a_spring_takes_the_energy_that_the_motion_loses() {
    let loss = |h: f64| {
        let mut scene = two_masses([1.0, 3.0], 0.0, 2.0, 0.0);
        scene.particles[1].velocity.x = 1.0;
        let mut simulation = simulation::<f64>(&scene, XPBD, h);
        let before = simulation.energy().total();
        (0..(0.5 / h) as usize).for_each(|_| simulation.step().unwrap());
        let after = simulation.energy();
        // A quarter of the energy is in the motion that the damper sees.
        assert!(0.2 * before < after.dissipated);
        before - after.total()
    };
    // First order, and a fifth for the second.
    let (coarse, fine) = (loss(1.0 / 256.0), loss(1.0 / 1024.0));
    assert!(0.0 < fine && 3.2 * fine < coarse, "{coarse} to {fine}");
}

#[test]
fn an_undamped_chain_loses_its_energy() {
    let material = Material { mass: 1.0, stiffness: 10.0, damping: 0.0 };
    let mut scene = Scene::of("chain", shape::rope(5, 1.0, material).unwrap());
    scene.world = crate::common::weightless();
    scene.particles[4].position.x += 0.7;
    let h = 1.0 / 60.0;
    let mut simulation = simulation::<f64>(&scene, XPBD, h);
    let before = simulation.energy().total();
    (0..6000).for_each(|_| simulation.step().unwrap());
    // To first order in h the loss of a mode is that of backward Euler, (1 + h² w²) per step; the
    // slowest, which lasts longest, has w = 2 √(k/m) sin(π/10). A single pass loses no less than
    // half of that.
    let slowest = 2.0 * 10f64.sqrt() * (0.1 * std::f64::consts::PI).sin();
    let bound = (1.0 + 0.5 * (h * slowest).powi(2)).powi(-6000);
    let left = simulation.energy().total() / before;
    assert!(left < bound, "{left} of {bound}");
    assert_eq!(simulation.energy().dissipated, 0.0, "no damper took it");
}

#[test]
fn linear_momentum_is_kept_to_rounding() {
    let mut simulation = simulation::<f64>(&tumbling_block(4.0), XPBD, 1.0 / 60.0);
    let before = simulation.momentum();
    (0..600).for_each(|_| simulation.step().unwrap());
    let error = (simulation.momentum().linear - before.linear).length();
    // Each step rounds 27 positions of at most some 30 m a dozen times, and divides by h.
    let rounding = 27.0 * 12.0 * 30.0 * f64::EPSILON * 60.0 * 600.0;
    assert!(error < rounding, "{error} of {rounding}");
}

#[test]
fn it_does_not_explode_and_is_too_soft_by_what_one_pass_leaves() {
    // 40 particles on a string that one pass of Gauss and Seidel cannot hold at a frame step.
    let material = Material { mass: 1.0, stiffness: 1e6, damping: 0.0 };
    let mut scene = Scene::of("rope", shape::rope(40, 0.1, material).unwrap());
    scene.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    scene.world.gravity = DVec3::X * 9.82;
    let longest = |h: f64| {
        let mut simulation = simulation::<f64>(&scene, XPBD, h);
        let start = scene.particles[0].position.x;
        let mut longest = 0.0f64;
        for _ in 0..(2.0 / h) as usize {
            simulation.step().unwrap();
            longest = longest.max(simulation.position(39).x - start);
        }
        longest
    };
    // Hanging it is Σ i m g / k = 7.7 mm longer than 3.9 m, and at most twice that in the swing.
    let (frame, fine) = (longest(1.0 / 60.0), longest(1.0 / 15360.0));
    assert!(frame.is_finite() && 4.2 < frame, "{frame}");
    assert!(fine < 3.9 + 0.0154 + 0.01, "{fine}");
}

#[test]
fn a_hub_of_many_spokes_at_rest_gains_no_energy() {
    // To and fro a sweep is symmetric, and every motion but that of the whole dies out: the
    // remainder is at most the initial motion. On the way a motion of n spokes stores more by as
    // much as two sweeps are softer than the springs, which is less than k h² / m + 1 = 5.
    for spokes in [8, 16, 64] {
        let at = |spoke: usize| {
            let angle = std::f64::consts::TAU * spoke as f64 / spokes as f64;
            DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let mut random = crate::common::Random(7);
        let mut shaken = |position: DVec3| {
            let velocity = (random.vector() - 0.5) * 1e-6;
            Particle { position, velocity, mass: 1.0 }
        };
        let mut scene = Scene { world: crate::common::weightless(), ..Scene::default() };
        scene.particles.push(shaken(DVec3::ZERO));
        scene.particles.extend((0..spokes).map(|spoke| shaken(at(spoke))));
        for spoke in 0..spokes {
            for ends in [[0, 1 + spoke], [1 + spoke, 1 + (spoke + 1) % spokes]] {
                let [a, b] = ends.map(|end| scene.particles[end].position);
                let rest_length = (b - a).length();
                scene.springs.push(Spring { ends, rest_length, stiffness: 1000.0, damping: 0.0 });
            }
        }
        let mut simulation = simulation::<f64>(&scene, XPBD, 2.0 / 1000f64.sqrt());
        let moving = |run: &Simulation<f64>| run.energy().kinetic + run.energy().elastic;
        let before = moving(&simulation);
        let mut most = before;
        for _ in 0..400 {
            simulation.step().unwrap();
            most = most.max(moving(&simulation));
        }
        assert!(most < 5.0 * before, "{spokes} spokes: {} times", most / before);
        let after = moving(&simulation);
        assert!(after < before, "{spokes} spokes: {} times", after / before);
    }
}

#[test]
fn pins_hold_and_moving_pins_keep_their_velocity_to_the_bit() {
    let material = Material { mass: 1.0, stiffness: 1e6, damping: 1.0 };
    let mut scene = Scene::of("rope", shape::rope(6, 1.0, material).unwrap());
    let velocity = DVec3::new(0.25, 0.5, 0.0);
    scene.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }, Pin { particle: 5, velocity }];
    let mut simulation = simulation::<f64>(&scene, XPBD, 1.0 / 64.0);
    (0..64).for_each(|_| simulation.step().unwrap());
    assert_eq!(simulation.position(0), scene.particles[0].position);
    // 64 additions of a power of two times (1/4, 1/2, 0): exact.
    assert_eq!(simulation.position(5), scene.particles[5].position + velocity);
    assert_eq!(simulation.velocity(5), velocity);
}

#[test]
fn springs_without_length_stiffness_or_number_do_no_harm() {
    let mut scene = two_masses([1.0, 1.0], 100.0, 1.0, 0.0);
    scene.world.gravity = DVec3::NEG_Y * 9.82;
    let coincident = Scene { particles: vec![scene.particles[0]; 2], ..scene.clone() };
    let mut slack = scene.clone();
    (slack.springs[0].stiffness, slack.springs[0].rest_length) = (0.0, 0.0);
    let empty = Scene { springs: Vec::new(), ..scene.clone() };
    for scene in [coincident, slack, empty] {
        let mut simulation = simulation::<f32>(&scene, XPBD, 1.0 / 64.0);
        (0..64).for_each(|_| simulation.step().unwrap());
        // All of them fall, and nothing else. A velocity is a difference of positions of 5 m, here
        // rounded to 2^-22, times 64.
        let fell = simulation.velocities().map(|v| f64::from(v.y));
        fell.for_each(|v| assert!((v + 9.82).abs() < 1e-3, "{v}"));
    }
}

#[test]
fn a_run_resumed_or_repeated_gives_the_same_bits() {
    let mut scene = tumbling_block(4.0);
    scene.world = msd_core::World { drag: 0.1, ..Default::default() };
    let friction = Friction::Coulomb(0.5);
    scene.planes = vec![Plane { normal: DVec3::Y, offset: -2.0, restitution: 0.7, friction }];
    let settings = Settings { integrator: XPBD, substeps: 4, ..Settings::default() };
    let mut whole = Simulation::<f32>::new(&scene, settings).unwrap();
    (0..45).for_each(|_| whole.step().unwrap());
    let state = whole.state();
    (0..45).for_each(|_| whole.step().unwrap());
    let mut resumed = Simulation::<f32>::new(&scene, settings).unwrap();
    resumed.set_state(&state, 45).unwrap();
    (0..45).for_each(|_| resumed.step().unwrap());
    assert_eq!(whole.state(), resumed.state());
}

/// Positions and velocities after a substep without outside forces: one spring after the other in
/// the order of the scene, and back.
fn plain_substep<R: Real>(scene: &Scene, cut: &[usize], h: R) -> Vec<[R::Vec3; 2]> {
    let starts: Vec<R::Vec3> = scene.particles.iter().map(|p| R::Vec3::of(p.position)).collect();
    let mut ways: Vec<R::Vec3> =
        scene.particles.iter().map(|p| R::Vec3::of(p.velocity) * h).collect();
    let mut weights: Vec<R> = scene.particles.iter().map(|p| R::ONE / R::of(p.mass)).collect();
    scene.pins.iter().for_each(|pin| weights[pin.particle] = R::ZERO);
    let mut sums = vec![R::ZERO; scene.springs.len()];
    let there = (0..scene.springs.len()).filter(|row| !cut.contains(row));
    for row in there.clone().chain(there.rev()) {
        let Spring { ends: [a, b], rest_length, stiffness, damping } = scene.springs[row];
        let (parted, start) = (ways[b] - ways[a], starts[b] - starts[a]);
        let across = start + parted;
        let square = across.dot(across);
        if square < R::SHORTEST_SQUARED {
            continue;
        }
        let (length, k, c) = (square.sqrt(), R::of(stiffness) * h * h, R::of(damping) * h);
        let u = across * (R::ONE / length);
        let pull = k * (length - R::of(rest_length)) + c * u.dot(parted) - sums[row];
        let pull = pull / (R::ONE + (k + c) * (weights[a] + weights[b]));
        sums[row] += pull;
        ways[a] += u * pull * weights[a];
        ways[b] -= u * pull * weights[b];
    }
    let ends = starts.iter().zip(&ways);
    ends.map(|(&start, &way)| [start + way, way * (R::ONE / h)]).collect()
}

fn check_substep<R: Real>(scene: &Scene, cut: &[usize]) {
    let h = 1.0 / 60.0;
    let expected = plain_substep::<R>(scene, cut, R::of(h));
    for instructions in Instructions::ALL {
        let mut simulation = simulation::<R>(scene, XPBD, h);
        simulation.set_instructions(instructions);
        cut.iter().for_each(|&spring| simulation.remove_spring(spring).unwrap());
        simulation.step().unwrap();
        let found = simulation.positions().zip(simulation.velocities());
        for (particle, (found, expected)) in found.map(<[_; 2]>::from).zip(&expected).enumerate() {
            assert!(found == *expected, "{} {particle}: {found:?}", instructions.name());
        }
    }
}

#[test]
fn springs_sixteen_at_a_time_move_as_one_after_the_other_to_the_bit() {
    let material = Material { mass: 1.5, stiffness: 3e4, damping: 20.0 };
    let mut scene = Scene::of("cloth", shape::cloth([19, 13], 0.5, material).unwrap());
    scene.add("rope", shape::rope(40, 0.25, material).unwrap());
    scene.world = weightless();
    let mut random = Random(3);
    scene.particles.iter_mut().for_each(|particle| particle.velocity = random.vector());
    // A hub, springs between any two particles, and one without direction.
    let count = scene.particles.len();
    let any = |random: &mut Random| (random.vector().x * count as f64) as usize;
    for row in 0..300 {
        let [a, b] = [if row < 100 { 5 } else { any(&mut random) }, any(&mut random)];
        if a != b {
            let (rest_length, stiffness) = (random.vector().y, 1e4 * random.vector().z);
            scene.springs.push(Spring { ends: [a, b], rest_length, stiffness, damping: 0.5 });
        }
    }
    scene.springs.insert(0, Spring { ends: [7, 21], ..scene.springs[0] });
    scene.particles[21] = scene.particles[7];
    scene.pins = [0, 12, 250].map(|particle| Pin { particle, velocity: DVec3::ZERO }).into();
    scene.pins.iter().for_each(|pin| scene.particles[pin.particle].velocity = DVec3::ZERO);
    for cut in [&[][..], &[3, 40, 41, 900]] {
        check_substep::<f32>(&scene, cut);
        check_substep::<f64>(&scene, cut);
    }
}
