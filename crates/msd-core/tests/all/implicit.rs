//! Implicit methods against the equations that they solve, at any step.

use crate::common::{distance, forces_at, positions, run, simulation, tumbling_block, two_masses};
use msd_core::glam::{DMat3, DVec3};
use msd_core::{
    Friction, Integrator, Material, Pin, Plane, Scene, Settings, Simulation, State, shape,
};

const BOTH: [Integrator; 2] = [Integrator::BackwardEuler, Integrator::ImplicitMidpoint];
const G: f64 = 9.82;

fn moved(state: &State<f64>, x: &[DVec3], (by_x, by_v): (f64, f64)) -> State<f64> {
    let add = |column: &[DVec3], by: f64| column.iter().zip(x).map(|(a, x)| *a + *x * by).collect();
    State { positions: add(&state.positions, by_x), velocities: add(&state.velocities, by_v) }
}

fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
}

#[test]
fn each_method_converges_at_its_order_with_and_without_damping() {
    for damping in [0.0, 4.0] {
        let scene = tumbling_block(damping);
        let reference = run(&scene, Integrator::Rk4, 1.0 / 4096.0, 2048);
        for (integrator, coarsest) in
            [(Integrator::BackwardEuler, 2048.0), (Integrator::ImplicitMidpoint, 256.0)]
        {
            let error = |halving: u32| {
                let h = 1.0 / (coarsest * f64::from(1 << halving));
                distance(&run(&scene, integrator, h, (0.5 / h).round() as usize), &reference)
            };
            let errors = [0, 1, 2, 3].map(error);
            for pair in errors.windows(2) {
                let order = (pair[0] / pair[1]).log2();
                let off = (order - f64::from(integrator.order())).abs();
                // The next term of the error is a fraction of about h w of the leading one.
                assert!(off < 0.12, "{integrator}, b = {damping}: {order:.3} of {errors:?}");
            }
        }
    }
}

#[test]
fn an_oscillator_follows_the_amplification_of_each_method() {
    // So small that no half step of ten radians carries one end through the other.
    let (masses, stiffness, stretch) = ([1.0, 3.0], 300.0, 0.04);
    let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
    let w = f64::sqrt(stiffness / reduced);
    for h in [0.1 / w, 1.0 / w, 10.0 / w] {
        for damping in [0.0, 5.0] {
            let scene = two_masses(masses, stiffness, damping, stretch);
            let (mut s, mut v) = ([stretch; 2], [0.0; 2]);
            let c = damping / reduced;
            let mut runs = BOTH.map(|method| simulation::<f64>(&scene, method, h));
            for _ in 0..50 {
                // Backward Euler: (1 + h c + h² w²) v' = v − h w² s, in closed form.
                v[0] = (v[0] - h * w * w * s[0]) / (1.0 + h * c + h * h * w * w);
                s[0] += h * v[0];
                // Midpoint: the same to the middle, and as far again.
                let half = 0.5 * h;
                let u = (v[1] - half * w * w * s[1]) / (1.0 + half * c + half * half * w * w);
                (s[1], v[1]) = (s[1] + h * u, 2.0 * u - v[1]);
                for (row, run) in runs.iter_mut().enumerate() {
                    run.step().unwrap();
                    let [a, b] = [0, 1].map(|end| run.position(end).x);
                    // Two particles in line: two iterations of conjugate gradients are exact. 50
                    // roundings, magnified by h w, of lengths of 1 m.
                    let error = (b - a - 1.0 - s[row]).abs();
                    assert!(error < 1e-12, "{}: {error}", BOTH[row]);
                }
            }
            if damping == 0.0 {
                // |amplification| = (1 + h² w²)^(−1/2) and 1 exactly, per step.
                let start = w * w * stretch * stretch;
                let energies =
                    [0, 1].map(|row| (w * w * s[row] * s[row] + v[row] * v[row]) / start);
                let expected = (1.0 + h * h * w * w).powi(-50);
                assert!((energies[0] / expected - 1.0).abs() < 1e-9);
                assert!((energies[1] - 1.0).abs() < 1e-9);
            }
        }
    }
}

/// Five particles in a row without damping, the last pulled out. It is the scene `chain`, but by
/// half as much, so that no spring is ever pressed through its own end.
fn chain() -> Scene {
    let material = Material { mass: 1.0, stiffness: 10.0, damping: 0.0 };
    let mut scene = Scene::of("chain", shape::rope(5, 1.0, material).unwrap());
    scene.world = crate::common::weightless();
    scene.particles[4].position.x += 0.7;
    scene
}

#[test]
fn an_undamped_chain_keeps_its_energy_for_100_s_but_not_under_backward_euler() {
    let h = 1.0 / 60.0;
    // 2 √(k/m) sin(4π/10): the fastest of its modes.
    let fastest = 2.0 * 10f64.sqrt() * (0.4 * std::f64::consts::PI).sin();
    let slowest = 2.0 * 10f64.sqrt() * (0.1 * std::f64::consts::PI).sin();
    let verlet = (h * fastest).powi(2) / 4.0;
    // Midpoint keeps the energy of a linear system; 1e-6 of a kick is left unsolved in each of 6000
    // substeps, with any sign.
    for (integrator, bound) in
        [(Integrator::VelocityVerlet, verlet), (Integrator::ImplicitMidpoint, 1e-5)]
    {
        let mut simulation = simulation::<f64>(&chain(), integrator, h);
        let before = simulation.energy().total();
        for _ in 0..6000 {
            simulation.step().unwrap();
            let error = (simulation.energy().total() / before - 1.0).abs();
            assert!(error < bound, "{integrator}: {error} at {}", simulation.time());
        }
    }
    // Backward Euler divides the energy of a mode by 1 + h² w² per step; the slowest holds a share
    // of less than one of it all.
    let mut simulation = simulation::<f64>(&chain(), Integrator::BackwardEuler, h);
    let before = simulation.energy().total();
    (0..6000).for_each(|_| simulation.step().unwrap());
    let left = simulation.energy().total() / before;
    let bound = (1.0 + (h * slowest).powi(2)).powi(-6000);
    assert!(left < 1.01 * bound && bound < 2e-3, "{left}");
    assert_eq!(simulation.energy().dissipated, 0.0, "no damper took it");
}

#[test]
fn momentum_is_kept_to_the_tolerance_of_the_solve() {
    for (integrator, tolerance) in BOTH.into_iter().zip([1e-3, 1e-6]) {
        let scene = tumbling_block(4.0);
        let mut simulation = simulation::<f64>(&scene, integrator, 1.0 / 60.0);
        let before = simulation.momentum();
        let mut impulses = 0.0;
        for _ in 0..60 {
            let forces = forces_at(simulation.model(), &simulation.state());
            impulses += forces.iter().map(|f| f.length_squared()).sum::<f64>().sqrt() / 60.0;
            simulation.step().unwrap();
        }
        let error = (simulation.momentum().linear - before.linear).length();
        // The residual r of each solve is the missing impulse: |Σ r| ≤ √N |r|, and |r| is at most
        // the tolerance times the impulse but for the spread of the blocks, a factor of below 2.
        let bound = 2.0 * tolerance * 27f64.sqrt() * impulses;
        assert!(error < bound, "{integrator}: {error} of {bound}");
    }
}

#[test]
fn what_the_dampers_take_is_what_the_motion_loses_to_the_order_of_the_method() {
    for (integrator, coarse) in BOTH.into_iter().zip([1.0 / 1024.0, 1.0 / 128.0]) {
        let imbalance = |h: f64| {
            let mut simulation = simulation::<f64>(&tumbling_block(4.0), integrator, h);
            let before = simulation.energy();
            (0..(0.5 / h) as usize).for_each(|_| simulation.step().unwrap());
            let after = simulation.energy();
            assert!(0.1 * before.elastic < after.dissipated, "the dampers did some work");
            before.total() - after.total()
        };
        // A fifth for terms of higher order.
        let factor = 0.8 * 4f64.powi(integrator.order() as i32);
        let (coarse, fine) = (imbalance(coarse), imbalance(coarse / 4.0));
        assert!(fine.abs() * factor < coarse.abs(), "{integrator}: {coarse} to {fine}");
        // The numerical damping of backward Euler is not booked, so that it shows.
        assert!(integrator != Integrator::BackwardEuler || 0.0 < fine);
    }
}

#[test]
fn newton_iterations_solve_the_equation_itself() {
    let (scene, h) = (tumbling_block(4.0), 1.0 / 60.0);
    for integrator in BOTH {
        let residual = |newton: u32| {
            let settings =
                Settings { integrator, step: h, substeps: 1, newton, ..Settings::default() };
            let mut simulation = Simulation::<f64>::new(&scene, settings).unwrap();
            let before = simulation.state();
            simulation.step().unwrap();
            let after = simulation.state();
            let weight = if integrator == Integrator::BackwardEuler { 1.0 } else { 0.5 };
            let mix = |a: &[DVec3], b: &[DVec3]| -> Vec<DVec3> {
                a.iter().zip(b).map(|(a, b)| *a + (*b - *a) * weight).collect()
            };
            let stage = State {
                positions: mix(&before.positions, &after.positions),
                velocities: mix(&before.velocities, &after.velocities),
            };
            let forces = forces_at(simulation.model(), &stage);
            let kicks: Vec<DVec3> = forces.iter().map(|f| *f * h).collect();
            let gained = moved(&after, &before.velocities, (0.0, -1.0)).velocities;
            apart(&gained, &kicks) / kicks.iter().map(|kick| kick.length()).fold(0.0, f64::max)
        };
        // Each iteration lowers it at least by the share of the terms left out of the matrix.
        let [one, two, five] = [1, 2, 5].map(residual);
        assert!(two < 0.2 * one && five < 1e-3 * one, "{integrator}: {one}, {two}, {five}");
    }
}

/// A rope of stiff springs and of masses 1 : 10 000 in turn, slightly aside of the vertical.
fn extreme_rope() -> Scene {
    let material = Material { mass: 0.01, stiffness: 1e8, damping: 0.0 };
    let mut scene = Scene::of("rope", shape::rope(11, 0.1, material).unwrap());
    let aside = 0.07f64;
    for (row, particle) in scene.particles.iter_mut().enumerate() {
        let along = DVec3::new(aside.sin(), -aside.cos(), 0.0);
        particle.position = along * (0.1 * row as f64);
        particle.mass = if row % 2 == 0 { 0.01 } else { 100.0 };
    }
    scene.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    scene
}

#[test]
fn backward_euler_runs_an_extreme_rope_at_frame_steps() {
    let scene = extreme_rope();
    let mut simulation = simulation::<f64>(&scene, Integrator::BackwardEuler, 1.0 / 60.0);
    (0..60).for_each(|_| simulation.step().unwrap());
    // Verlet is stable below 1.4e-5 s here.
    let reference = run(&scene, Integrator::VelocityVerlet, 1e-5, 100_000);
    let error = distance(&simulation.state(), &reference);
    // A swing of 0.07 m; h w² t / 2 of it, w² = g / (about 0.7 m), is lost in 1 s.
    assert!(error < 0.01, "{error} of a rope of 1 m");
    for _ in 60..600 {
        simulation.step().unwrap();
        let reach = simulation.positions().map(|x| x.length()).fold(0.0, f64::max);
        assert!(reach < 1.01, "{reach}");
    }
}

#[test]
fn backward_euler_and_the_f32_run_of_it_survive_what_no_step_resolves() {
    let mut scene = extreme_rope();
    // Level: it swings through, with tensions that change within a frame.
    scene.particles.iter_mut().enumerate().for_each(|(row, particle)| {
        particle.position = DVec3::X * (0.1 * row as f64);
    });
    let mut single = simulation::<f32>(&scene, Integrator::BackwardEuler, 1.0 / 60.0);
    let mut double = simulation::<f64>(&scene, Integrator::BackwardEuler, 1.0 / 60.0);
    for _ in 0..600 {
        single.step().unwrap();
        double.step().unwrap();
        let reach = positions(&single)
            .iter()
            .chain(&positions(&double))
            .map(|x| x.length())
            .fold(0.0, f64::max);
        assert!(reach < 1.1, "{reach}");
    }
}

fn block_on_floor(friction: Friction, speed: f64, count: usize) -> Scene {
    let material = Material { mass: 1.0, stiffness: 5000.0, damping: 50.0 };
    let mut part = shape::block([count; 3], 0.5, material).unwrap();
    part.place(DMat3::IDENTITY, DVec3::Y * (0.25 * (count - 1) as f64));
    part.set_motion(DVec3::X * speed, DVec3::ZERO);
    let mut scene = Scene::of("block", part);
    scene.planes = vec![Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.3, friction }];
    scene
}

fn centre(simulation: &Simulation<f64>) -> DVec3 {
    let positions = positions(simulation);
    positions.iter().sum::<DVec3>() / positions.len() as f64
}

#[test]
fn a_block_that_lies_on_the_floor_lies_still_in_balance() {
    for friction in [Friction::Coulomb(0.5), Friction::TangentialLoss(0.3)] {
        let scene = block_on_floor(friction, 0.0, 3);
        for integrator in BOTH {
            let mut simulation = simulation::<f64>(&scene, integrator, 1.0 / 60.0);
            (0..600).for_each(|_| simulation.step().unwrap());
            let (state, dissipated) = (simulation.state(), simulation.dissipated());
            (0..60).for_each(|_| simulation.step().unwrap());
            // It lies still to rounding, and no energy is taken or given.
            assert!(distance(&simulation.state(), &state) < 1e-9, "{integrator}");
            assert!((simulation.dissipated() - dissipated).abs() < 1e-9);
            // The same at any step. Particles off the floor are in balance, those on it press with
            // the weight of all and are held within the cone of friction. Rounding times stiffness.
            let forces = forces_at(simulation.model(), &state);
            let mut pressed = 0.0;
            for (x, f) in state.positions.iter().zip(&forces) {
                if 0.25 < x.y {
                    assert!(f.length() < 1e-8, "{integrator}: {f} N");
                    continue;
                }
                // Six roundings in single precision above the floor, but on it.
                assert!(0.0 <= x.y && x.y < 1e-5, "{}", x.y);
                pressed -= f.y;
                let along = DVec3::new(f.x, 0.0, f.z).length();
                if friction == Friction::Coulomb(0.5) {
                    assert!(along < -0.5 * f.y + 1e-8, "{integrator}: {f} N");
                } else {
                    assert!(along < 1e-8, "{integrator}: {f} N");
                }
            }
            assert!((pressed - 27.0 * G).abs() < 1e-7);
        }
    }
}

#[test]
fn a_block_slides_v_squared_over_two_mu_g() {
    let (speed, factor) = (3.0, 0.4);
    let exact = speed * speed / (2.0 * factor * G);
    for integrator in BOTH {
        for count in [1, 3] {
            let scene = block_on_floor(Friction::Coulomb(factor), speed, count);
            let mut simulation = simulation::<f64>(&scene, integrator, 1.0 / 60.0);
            let start = centre(&simulation).x;
            (0..180).for_each(|_| simulation.step().unwrap());
            let slid = centre(&simulation).x - start;
            // First order: each substep slides on at the speed of its start or end. A block also
            // comes to rest with a shear of some μ m g / k = 2 mm.
            let tolerance = speed / 60.0;
            assert!((slid - exact).abs() < tolerance, "{integrator}: {slid} of {exact}");
            assert!(simulation.energy().kinetic < 1e-6);
            // Friction took the energy of the slide: counted at the end of each substep, too little
            // by a part μ g h / v = 2 % for backward Euler, and something goes into the springs'
            // sway.
            let moving = 0.5 * speed * speed * (count * count * count) as f64;
            let share = simulation.dissipated() / moving;
            assert!((share - 1.0).abs() < 0.05, "{integrator}, {count}: {share}");
        }
    }
}

#[test]
fn friction_holds_a_block_on_a_slope_below_its_angle_and_not_above() {
    // Three layers press on the lowest particles: friction must count all of their weight, and hold
    // no more than that.
    for (slope, holds) in [(0.2, true), (0.8, false)] {
        let mut scene = block_on_floor(Friction::Coulomb(0.4), 0.0, 3);
        let angle = f64::atan(slope);
        scene.world.gravity = DVec3::new(angle.sin(), -angle.cos(), 0.0) * G;
        for integrator in BOTH {
            let mut simulation = simulation::<f64>(&scene, integrator, 1.0 / 60.0);
            (0..60).for_each(|_| simulation.step().unwrap());
            let start = centre(&simulation).x;
            (0..60).for_each(|_| simulation.step().unwrap());
            let slid = centre(&simulation).x - start;
            if holds {
                // The rest of its sway: 0.1 mm of some 2 mm of shear.
                assert!(slid.abs() < 1e-4, "{integrator}: {slid}");
            } else {
                // g (sin − μ cos) t² / 2 from rest: 3 / 2 of it in the second second. The first
                // order of the method is h / t, and the block takes a few steps to lean.
                let exact = 1.5 * G * (angle.sin() - 0.4 * angle.cos());
                assert!((slid / exact - 1.0).abs() < 0.05, "{integrator}: {slid} of {exact}");
            }
        }
    }
}

#[test]
fn a_plane_does_not_hold_what_leaves_it() {
    // A stretched spring along the normal: the upper mass pulls the lower one off the floor.
    let mut scene = two_masses([1.0, 1.0], 100.0, 0.0, 0.0);
    scene.particles[0].position = DVec3::ZERO;
    scene.particles[1].position = DVec3::Y * 2.0;
    let friction = Friction::Coulomb(0.5);
    scene.planes = vec![Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction }];
    for integrator in BOTH {
        let mut held = simulation::<f64>(&scene, integrator, 1.0 / 60.0);
        let free = Scene { planes: Vec::new(), ..scene.clone() };
        let mut free = simulation::<f64>(&free, integrator, 1.0 / 60.0);
        for _ in 0..6 {
            held.step().unwrap();
            free.step().unwrap();
        }
        // The second solve starts where the first ended: the same but for its tolerance.
        assert!(0.05 < held.position(0).y);
        assert!(distance(&held.state(), &free.state()) < 2e-3, "{integrator}");
    }
}

#[test]
fn corners_hold_in_all_their_directions() {
    let mut scene = block_on_floor(Friction::Coulomb(0.3), 0.0, 3);
    let friction = Friction::Coulomb(0.0);
    let plane = |normal, offset| Plane { normal, offset, restitution: 0.0, friction };
    scene.planes.push(plane(DVec3::X, -0.5));
    scene.planes.push(plane(DVec3::new(0.0, 0.6, 0.8), -0.4));
    scene.world.gravity = DVec3::new(-4.0, -9.0, -3.0);
    for integrator in BOTH {
        let mut simulation = simulation::<f64>(&scene, integrator, 1.0 / 60.0);
        (0..600).for_each(|_| simulation.step().unwrap());
        let before = simulation.state();
        (0..60).for_each(|_| simulation.step().unwrap());
        assert!(distance(&simulation.state(), &before) < 1e-6, "{integrator}");
        for plane in simulation.model().planes() {
            for x in positions(&simulation) {
                assert!(-1e-9 < plane.normal.dot(x) - plane.offset);
            }
        }
    }
}

#[test]
fn pins_hold_and_moving_pins_keep_their_velocity_to_the_bit() {
    let material = Material { mass: 1.0, stiffness: 1e6, damping: 1.0 };
    let mut scene = Scene::of("rope", shape::rope(6, 1.0, material).unwrap());
    let velocity = DVec3::new(0.25, 0.5, 0.0);
    scene.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }, Pin { particle: 5, velocity }];
    for integrator in BOTH {
        let mut simulation = simulation::<f64>(&scene, integrator, 1.0 / 64.0);
        (0..64).for_each(|_| simulation.step().unwrap());
        assert_eq!(simulation.position(0), scene.particles[0].position);
        // 64 additions of a power of two times (1/4, 1/2, 0): exact.
        assert_eq!(simulation.position(5), scene.particles[5].position + velocity);
        assert_eq!(simulation.velocity(5), velocity);
    }
}

#[test]
fn single_and_double_precision_agree_to_single_precision() {
    for integrator in BOTH {
        let mut single = simulation::<f32>(&tumbling_block(4.0), integrator, 1.0 / 240.0);
        let mut double = simulation::<f64>(&tumbling_block(4.0), integrator, 1.0 / 240.0);
        for _ in 0..240 {
            single.step().unwrap();
            double.step().unwrap();
        }
        let pairs = positions(&single).into_iter().zip(positions(&double));
        let worst = pairs.map(|(a, b)| (a - b).length()).fold(0.0, f64::max);
        // 240 roundings of coordinates below 4 m, amplified by up to 10, and of solves of which a
        // few may end an iteration apart.
        assert!(0.0 < worst && worst < 1e-4, "{integrator}: {worst}");
    }
}

#[test]
fn a_run_resumed_or_repeated_gives_the_same_bits() {
    let mut scene = block_on_floor(Friction::Coulomb(0.4), 2.0, 3);
    scene.world.drag = 0.1;
    for integrator in BOTH {
        let mut whole = simulation::<f32>(&scene, integrator, 1.0 / 60.0);
        (0..30).for_each(|_| whole.step().unwrap());
        let state = whole.state();
        (0..30).for_each(|_| whole.step().unwrap());
        let mut resumed = simulation::<f32>(&scene, integrator, 1.0 / 60.0);
        resumed.set_state(&state, 30).unwrap();
        (0..30).for_each(|_| resumed.step().unwrap());
        assert_eq!(whole.state(), resumed.state(), "{integrator}");
    }
}

#[test]
fn springs_without_length_stiffness_or_number_do_no_harm() {
    let mut scene = two_masses([1.0, 1.0], 100.0, 1.0, 0.0);
    scene.world.gravity = DVec3::NEG_Y * G;
    let coincident = Scene { particles: vec![scene.particles[0]; 2], ..scene.clone() };
    let mut slack = scene.clone();
    (slack.springs[0].stiffness, slack.springs[0].rest_length) = (0.0, 0.0);
    let empty = Scene { springs: Vec::new(), ..scene.clone() };
    for scene in [coincident, slack, empty] {
        for integrator in BOTH {
            let mut simulation = simulation::<f32>(&scene, integrator, 1.0 / 64.0);
            (0..64).for_each(|_| simulation.step().unwrap());
            // All of them fall, and nothing else: v = g t, to single precision.
            let fell = simulation.velocities().map(|v| f64::from(v.y));
            fell.for_each(|v| assert!((v + G).abs() < 1e-4, "{integrator}: {v}"));
        }
    }
}
