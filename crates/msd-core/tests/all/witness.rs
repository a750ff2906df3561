//! The drift detector: gains of energy are reported, passing swings are not.

use crate::common::{simulation, tumbling_block, two_masses, weightless};
use msd_core::glam::{DMat3, DVec3};
use msd_core::{
    Energy, Friction, Integrator, Interaction, KeyFrame, Ledger, Material, Particle, Plane, Real,
    Scene, Settings, Shape, Simulation, Solid, Witness, World, shape,
};

/// The largest gain reported over a run.
fn told<R: Real>(simulation: &mut Simulation<R>, steps: usize) -> f64 {
    let mut witness = Witness::default();
    let mut most = 0.0;
    witness.watch(simulation);
    for _ in 0..steps {
        simulation.step().expect("a run that stays in the world");
        witness.watch(simulation);
        most = f64::max(most, witness.gain());
    }
    most
}

#[test]
fn explicit_euler_without_damping_is_told() {
    // h w = 0.1: the energy grows by h² w² per step, e-fold in 100 steps.
    let (k, h) = (50.0, 0.01);
    let scene = two_masses([1.0, 1.0], k, 0.0, 0.1);
    let mut simulation = simulation::<f64>(&scene, Integrator::ExplicitEuler, h);
    let before = simulation.energy().total();
    let gain = told(&mut simulation, 200);
    let grown = simulation.energy().total() - before;
    // At least that of the lowest of the last window: it grew by a sixth over a window, and the
    // last may be one window old.
    assert!(0.5 * grown < gain && gain <= grown, "{gain} of {grown}");
}

#[test]
fn a_witness_that_comes_late_or_starts_anew_tells_as_soon() {
    // A block in f32, where rounding counts, seen after no steps or as if after a million, and by a
    // witness that saw the end of those and was restarted.
    let settings = Settings { substeps: 60, ..Settings::default() };
    let mut start =
        Simulation::<f32>::new(&tumbling_block(0.0), Settings::default()).expect("a valid scene");
    start.set_settings(Settings { integrator: Integrator::ExplicitEuler, ..settings }).unwrap();
    let first_told = |steps: u64| {
        let mut simulation = start.clone();
        simulation.set_state(&start.state(), steps).unwrap();
        let mut witness = Witness::default();
        witness.watch(&simulation);
        witness.restart();
        witness.watch(&simulation);
        (1..2000).find(|_| {
            simulation.step().expect("a run that stays in the world");
            witness.watch(&simulation);
            0.0 < witness.gain()
        })
    };
    assert!(first_told(0).is_some());
    assert_eq!(first_told(0), first_told(1_000_000));
}

#[test]
fn symplectic_methods_up_to_the_limit_are_not() {
    let (k, w) = (50.0, 10.0);
    for (integrator, steps) in
        [(Integrator::VelocityVerlet, 10_000), (Integrator::SymplecticEuler, 10_000)]
    {
        // A share of the largest stable step; energy swings by a third at the first.
        for share in [0.5, 0.9, 0.99] {
            // So slow that the spring keeps its direction: near the limit it stretches seven
            // times as far as it should.
            for (stretch, speed) in [(0.1, 0.0), (0.0, 0.1), (0.05, -0.07)] {
                let mut scene = two_masses([1.0, 1.0], k, 0.0, stretch);
                scene.particles[1].velocity.x = speed;
                scene.particles[0].velocity.x = -speed;
                let mut simulation = simulation::<f64>(&scene, integrator, share * 2.0 / w);
                let gain = told(&mut simulation, steps);
                assert_eq!(gain, 0.0, "{integrator} at {share}, {stretch} m, {speed} m/s");
            }
        }
    }
}

#[test]
fn beyond_the_limit_it_is_told_before_the_run_leaves_the_world() {
    // A hundredth beyond: it grows by about 1.3 per step.
    let scene = two_masses([1.0, 1.0], 50.0, 0.0, 1e-12);
    let mut simulation = simulation::<f64>(&scene, Integrator::VelocityVerlet, 1.01 * 0.2);
    assert!(0.0 < told(&mut simulation, 100));
}

/// A floor that returns more energy than it took. A plane that rises faster than anything falls
/// would do it; here a faulty contact throws the particle up at each landing.
#[test]
fn a_contact_that_adds_energy_is_told() {
    let mut witness = Witness::default();
    let (g, mut speed) = (9.82, 1.0);
    for bounce in 0..40 {
        for part in 0..16 {
            let time = 2.0 * speed / g * f64::from(part) / 16.0;
            let (height, now) = (speed * time - 0.5 * g * time * time, speed - g * time);
            let energy =
                Energy { kinetic: 0.5 * now * now, gravitational: g * height, ..Energy::default() };
            witness.see(energy, 1e-16);
        }
        // A bounce with a restitution of 1.02.
        speed *= 1.02;
        assert!(bounce < 20 || 0.0 < witness.gain(), "bounce {bounce}");
    }
}

#[test]
fn a_body_on_a_floor_that_loses_energy_is_not_told() {
    for restitution in [0.0, 0.5, 1.0] {
        let material = Material { mass: 0.1, stiffness: 1000.0, damping: 1.0 };
        let mut part = shape::block([2, 2, 2], 0.25, material).unwrap();
        part.set_motion(DVec3::new(3.0, 0.0, 1.0), DVec3::new(0.0, 0.0, 2.0));
        let floor =
            Plane { normal: DVec3::Y, offset: -1.0, restitution, friction: Friction::Coulomb(0.5) };
        let scene = Scene { planes: vec![floor], ..Scene::of("block", part) };
        for integrator in Integrator::ALL {
            if integrator == Integrator::ExplicitEuler {
                continue;
            }
            let settings = Settings { integrator, ..Settings::default() };
            let mut simulation = Simulation::<f64>::new(&scene, settings).unwrap();
            let gain = told(&mut simulation, 200);
            assert_eq!(gain, 0.0, "{integrator}, restitution {restitution}");
        }
    }
}

#[test]
fn rounding_in_single_precision_is_not_told_at_the_origin_or_far_away() {
    for distance in [0.0, 1e3, 1e5] {
        let scene = tumbling_block(0.0).moved(DVec3::splat(distance));
        let mut simulation = simulation::<f32>(&scene, Integrator::VelocityVerlet, 1e-3);
        assert_eq!(told(&mut simulation, 2000), 0.0, "{distance} m away");
    }
}

#[test]
fn rounding_of_many_substeps_hides_no_loss_and_is_none() {
    // Backward Euler damps a motion of frequency w by h w² of its energy per second: a fifth in
    // 4 s. All roundings of 122 880 substeps, if they had one sign, would be as much.
    let scene = two_masses([1.0, 1.0], 768.0, 0.0, 0.1);
    for (integrator, steps) in [
        (Integrator::BackwardEuler, 240),
        (Integrator::VelocityVerlet, 1200),
        (Integrator::Rk4, 1200),
    ] {
        let settings = Settings { integrator, substeps: 512, ..Settings::default() };
        let mut simulation = Simulation::<f32>::new(&scene, settings).expect("a valid scene");
        let mut witness = Witness::default();
        witness.watch(&simulation);
        let mut said = 0.0;
        for _ in 0..steps {
            simulation.step().expect("a run that stays in the world");
            witness.watch(&simulation);
            said = f64::max(said, witness.loss().max(witness.rise()).max(witness.surplus()));
        }
        assert_eq!(0.0 < said, integrator == Integrator::BackwardEuler, "{integrator}: {said} J");
    }
    for distance in [0.0, 100.0, 1e3] {
        let scene = tumbling_block(0.0).moved(DVec3::splat(distance));
        let mut simulation = simulation::<f32>(&scene, Integrator::VelocityVerlet, 1e-3);
        let mut witness = Witness::default();
        witness.watch(&simulation);
        for _ in 0..4000 {
            simulation.step().expect("a run that stays in the world");
            witness.watch(&simulation);
            let said = [witness.loss(), witness.rise(), witness.surplus()];
            assert_eq!(said, [0.0; 3], "{distance} m away");
        }
    }
}

#[test]
fn what_a_hand_does_is_not_told_and_what_comes_after_it_is() {
    let scene = two_masses([1.0, 1.0], 50.0, 0.0, 0.1);
    let mut simulation = simulation::<f64>(&scene, Integrator::VelocityVerlet, 0.05);
    let target = DVec3::new(5.0, 0.0, 0.0);
    let grab = Interaction::Grab {
        particle: 0,
        target,
        frequency: 1.0,
        damping_ratio: 0.1,
        max_force: 1e3,
    };
    simulation.queue(grab).unwrap();
    assert_eq!(told(&mut simulation, 500), 0.0, "the hand gave it");
    simulation.queue(Interaction::Release { particle: 0 }).unwrap();
    simulation.apply_queued().unwrap();
    let settings = simulation.settings();
    let integrator = Integrator::ExplicitEuler;
    simulation.set_settings(Settings { integrator, ..settings }).unwrap();
    // h w = 0.5: a quarter more energy in each step.
    assert!(0.0 < told(&mut simulation, 40));
}

#[test]
fn an_energy_that_is_no_number_is_an_infinite_gain() {
    let mut witness = Witness::default();
    witness.see(Energy::default(), 0.0);
    witness.see(Energy { kinetic: f64::INFINITY, ..Energy::default() }, 0.0);
    assert_eq!(witness.gain(), f64::INFINITY);
    witness.restart();
    assert_eq!(witness.gain(), 0.0);
}

/// A scene far away, falling on a floor, which must be moved.
fn on_a_slope() -> Scene {
    let particle =
        Particle { position: DVec3::new(0.25, 1.0, 0.5), velocity: DVec3::ZERO, mass: 1.0 };
    let slope = Plane {
        normal: DVec3::new(0.0, 3.0, 4.0),
        offset: -2.0,
        restitution: 0.5,
        friction: Friction::Coulomb(0.1),
    };
    Scene {
        particles: vec![particle],
        planes: vec![slope],
        world: World::default(),
        ..Scene::default()
    }
}

#[test]
fn a_scene_runs_the_same_wherever_its_origin_is() {
    let by = DVec3::new(1024.0, -512.0, 256.0);
    let (here, there) = (on_a_slope(), on_a_slope().moved(by));
    let (recentred, origin) = there.recentred();
    let run = |scene: &Scene| crate::common::run(scene, Integrator::VelocityVerlet, 1e-3, 2000);
    let (here, there, back) = (run(&here), run(&there), run(&recentred));
    let expected = here.positions[0];
    // Rounding of a coordinate of 1 km, 1e-13 m, over 2000 steps of a path without bifurcation.
    assert!((there.positions[0] - by - expected).length() < 1e-9);
    assert!((back.positions[0] + origin - by - expected).length() < 1e-9);
    assert!(recentred.particles[0].position.abs().max_element() <= 1.0);
}

#[test]
fn a_scene_without_particles_or_with_a_plane_without_direction_is_moved_all_the_same() {
    let mut scene = on_a_slope();
    scene.particles.clear();
    scene.planes[0].normal = DVec3::ZERO;
    let (moved, origin) = scene.recentred();
    assert_eq!(origin, DVec3::ZERO);
    assert_eq!(moved.planes[0].offset, -2.0);
    assert_eq!(weightless().gravity, DVec3::ZERO);
}

#[test]
fn a_gain_that_dampers_dissipate_at_once_is_in_the_balance() {
    // The kinetic energy of a mass that a damper would stop is kept up by a faulty method: it stays
    // constant while the damper books its work.
    let mut witness = Witness::default();
    for sample in 0..512 {
        let dissipated = 0.01 * f64::from(sample);
        witness.see(Energy { kinetic: 1.0, dissipated, ..Energy::default() }, 1e-16);
    }
    assert!((witness.imbalance() - 5.11).abs() < 1e-12, "{}", witness.imbalance());
}

#[test]
fn falls_within_a_substep_at_rest_are_not_in_the_balance() {
    let mut witness = Witness::default();
    (0..16).for_each(|_| witness.see(Energy { kinetic: 1.0, ..Energy::default() }, 0.0));
    let rest = |dissipated: f64| Energy { kinetic: 1e-9, dissipated, ..Energy::default() };
    (0..16_000).for_each(|sample| witness.see(rest(1.0 + 1e-4 * f64::from(sample)), 0.0));
    assert!(witness.imbalance().abs() < 1e-8, "{}", witness.imbalance());
}

#[test]
fn a_particle_that_lies_still_gains_nothing_but_rounding() {
    let gravity = DVec3::new(4.304_804_661_468_74, -8.826_157_534_657_82, 0.0);
    let particle = Particle { position: DVec3::ZERO, velocity: DVec3::ZERO, mass: 1.0 };
    let friction = Friction::Coulomb(0.5);
    let plane = Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction };
    let scene = Scene {
        particles: vec![particle],
        world: World { gravity, ..World::default() },
        planes: vec![plane],
        ..Scene::default()
    };
    for integrator in Integrator::ALL {
        let settings = Settings { integrator, ..Settings::default() };
        let mut single = Simulation::<f32>::new(&scene, settings).expect("a valid scene");
        assert_eq!(told(&mut single, 600), 0.0, "{integrator} in f32");
        let mut double = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
        assert_eq!(told(&mut double, 600), 0.0, "{integrator} in f64");
    }
}

#[test]
fn rounding_about_the_middle_of_a_solid_is_no_gain() {
    // A particle at the origin, whose own coordinates round by nothing, on solids that move later.
    // It is put back onto their surfaces to the rounding of half a metre, and of a hundred.
    let shapes = [Shape::Box { size: DVec3::new(2.0, 1.0, 2.0) }, Shape::Sphere { radius: 100.3 }];
    for (shape, height) in shapes.into_iter().zip([0.5, 100.3]) {
        let below = DVec3::Y * -height;
        let key = |time: f64, rise: f64| KeyFrame {
            time,
            position: below + DVec3::Y * rise,
            axes: DMat3::IDENTITY,
        };
        let keys = vec![key(2.0, 0.0), key(3.0, 1.0)];
        let solids = vec![Solid { position: below, keys, ..Solid::new(shape.clone()) }];
        let particles = vec![Particle { position: DVec3::ZERO, velocity: DVec3::ZERO, mass: 1.0 }];
        let scene = Scene { particles, solids, ..Scene::default() };
        for integrator in Integrator::ALL {
            let settings = Settings { integrator, substeps: 50, ..Settings::default() };
            let mut simulation = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
            assert_eq!(told(&mut simulation, 100), 0.0, "{integrator} on {shape:?}");
        }
    }
}

/// A witness that looked at each step of a run.
fn witnessed(simulation: &mut Simulation<f64>, steps: usize) -> Witness {
    let mut witness = Witness::default();
    witness.watch(simulation);
    for _ in 0..steps {
        simulation.step().expect("a run that stays in the world");
        witness.watch(simulation);
    }
    witness
}

#[test]
fn energy_that_nothing_took_is_a_loss_and_what_dampers_took_is_none() {
    let decays = |booked: f64| {
        let mut witness = Witness::default();
        for sample in 0..160 {
            let lost = 0.005 * f64::from(sample);
            let kinetic = 1.0 - lost;
            witness.see(Energy { kinetic, dissipated: booked * lost, ..Energy::default() }, 0.0);
        }
        witness.loss()
    };
    // The highest of the last window, which begins at sample 144.
    assert!((decays(0.0) - 0.005 * 144.0).abs() < 1e-12, "{}", decays(0.0));
    assert_eq!(decays(1.0), 0.0);
    // A tenth of the energy in motion is allowed.
    assert_eq!(decays(0.9), 0.0);
}

#[test]
fn what_backward_euler_damps_by_itself_is_a_loss_by_its_closed_form() {
    // Both amplitudes of an oscillator fall by √(1 + h² w²) in a step, w² = 2 k / m.
    let mut random = crate::common::Random(3);
    for _ in 0..100 {
        let (k, h) = (20.0 + 80.0 * random.unit(), 0.01 + 0.02 * random.unit());
        let scene = two_masses([1.0, 1.0], k, 0.0, 0.1);
        let mut run = simulation::<f64>(&scene, Integrator::BackwardEuler, h);
        let start = run.energy().total();
        let loss = witnessed(&mut run, 159).loss();
        // The highest of the last four samples: no energy swings by this method.
        let left = (1.0 + 2.0 * k * h * h).powi(-156);
        let expected = start * (1.0 - left);
        // The solve leaves 1e-6 of its residual, 160 times.
        assert!((loss - expected).abs() < 2e-4 * start, "k {k}, h {h}: {loss}, {expected}");
        let mut run = simulation::<f64>(&scene, Integrator::VelocityVerlet, h);
        assert_eq!(witnessed(&mut run, 159).loss(), 0.0, "k {k}, h {h}");
    }
}

#[test]
fn a_hundred_oscillators_that_gain_or_lose_energy_by_their_method_are_all_told() {
    let mut random = crate::common::Random(5);
    for _ in 0..100 {
        let scene = two_masses([1.0, 1.0], 20.0 + 80.0 * random.unit(), 0.0, 0.1);
        let w = (2.0 * scene.springs[0].stiffness).sqrt();
        // Explicit Euler: the energy grows by 1 + h² w² in a step.
        let z = 0.06 + 0.1 * random.unit();
        let mut run = simulation::<f64>(&scene, Integrator::ExplicitEuler, z / w);
        let witness = witnessed(&mut run, 159);
        assert!(0.0 < witness.gain() && 0.0 < witness.surplus(), "explicit Euler, h w = {z}");
        // Its gain is at least that of the lowest of the last window, from sample 144 on.
        let grown = (1.0 + z * z).powi(144) - 1.0;
        let stored = 0.1 * 0.1 * scene.springs[0].stiffness / 2.0;
        assert!(grown < 1.01 * witness.gain() / stored, "{} of {grown}", witness.gain() / stored);
        // RK4: the energy shrinks by 1 − z⁶/72 + z⁸/576 in a step.
        let z = 0.9 + 1.5 * random.unit();
        let mut run = simulation::<f64>(&scene, Integrator::Rk4, z / w);
        let left = 1.0 - z.powi(6) / 72.0 + z.powi(8) / 576.0;
        let lost = witnessed(&mut run, 159).loss() / stored;
        assert!((lost - (1.0 - left.powi(156))).abs() < 1e-2, "RK4, h w = {z}: {lost}");
        // Velocity Verlet a little beyond its limit of 2.
        let z = 2.005 + 0.02 * random.unit();
        let mut run = simulation::<f64>(&scene, Integrator::VelocityVerlet, z / w);
        let mut witness = Witness::default();
        let is_told = (0..400).any(|_| {
            witness.watch(&run);
            0.0 < witness.gain() || run.step().is_err()
        });
        assert!(is_told && run.step().is_ok(), "velocity Verlet, h w = {z}");
    }
}

/// A block that is thrown onto a floor, some of which the method and its bounces get wrong.
fn thrown(random: &mut crate::common::Random) -> (Scene, f64) {
    let stiffness = 10f64.powf(1.0 + 2.0 * random.unit());
    let material = Material { mass: 0.05, stiffness, damping: 0.01 * random.unit() };
    let mut block = shape::block([3, 3, 3], 0.1, material).expect("a block");
    block.set_motion(DVec3::Y * (-2.0 * random.unit()), random.vector() * 4.0);
    block.particles.iter_mut().for_each(|particle| particle.position.y += 0.4);
    let plane = Plane {
        normal: DVec3::Y,
        offset: 0.0,
        restitution: if random.yes() { 0.0 } else { random.unit() },
        friction: Friction::Coulomb(0.4),
    };
    // The stiffest of its modes is below that of a particle between walls.
    let stable = 2.0 / (4.0 * 26.0 * stiffness / material.mass).sqrt();
    (Scene { planes: vec![plane], ..Scene::of("block", block) }, stable)
}

#[test]
fn of_a_hundred_thrown_blocks_each_that_lacks_or_gains_energy_for_a_while_is_told() {
    const WINDOW: usize = 16;
    let mut random = crate::common::Random(17);
    let mut off = [0, 0];
    for seed in 0..100 {
        let (scene, stable) = thrown(&mut random);
        let methods = [Integrator::VelocityVerlet, Integrator::SymplecticEuler, Integrator::Rk4];
        let (integrator, step) = (methods[random.below(3)], 1.0 / 60.0);
        let substeps = (step / (2.0 * stable)).ceil() as u32;
        let settings = Settings { integrator, substeps, ..Settings::default() };
        let mut run = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
        let (mut witness, mut totals, mut most) = (Witness::default(), Vec::new(), 0.0);
        let mut told = [false; 2];
        for _ in 0..120 {
            let energy = witness.watch(&run);
            told[0] |= 0.0 < witness.gain().max(witness.rise());
            told[1] |= 0.0 < witness.loss();
            most = f64::max(most, energy.kinetic + energy.elastic);
            totals.push(energy.total());
            run.step().expect("a stable step");
        }
        let change = |total: &f64| total - totals[0];
        let lasting = |sign: f64| {
            let common = |window: &[f64]| {
                window.iter().map(|total| sign * change(total)).fold(f64::INFINITY, f64::min)
            };
            totals.windows(WINDOW).map(common).fold(0.0, f64::max)
        };
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            let is_wrong = 0.1 * most < lasting(sign);
            off[side] += usize::from(is_wrong);
            assert!(told[side] || !is_wrong, "{integrator}, {seed}: {} of {most}", lasting(sign));
            // Nor is a run reported that is right to a twentieth: the energy that a mode takes
            // comes and goes.
            assert!(!told[side] || 0.05 * most < lasting(sign), "{integrator}, {seed}: {told:?}");
        }
    }
    assert!(5 <= off[0] && 5 <= off[1], "too few are wrong: {off:?}");
}

#[test]
fn a_hundred_lifts_are_no_errors_and_the_work_is_that_of_the_weight() {
    // A mass on a plate that rises between two key frames and stops, or goes down again.
    let mut random = crate::common::Random(11);
    for _ in 0..100 {
        let (begin, takes) = (0.2 * random.unit(), 0.5 + random.unit());
        // A cubic between two key frames has an acceleration of at most 6 height / takes², here 5:
        // the mass stays on the plate.
        let (mass, height) =
            (0.1 + 5.0 * random.unit(), takes * takes * (0.05 + 0.75 * random.unit()));
        let below = DVec3::Y * -0.5;
        let key = |time: f64, rise: f64| {
            let position = below + DVec3::Y * rise;
            KeyFrame { time, position, axes: DMat3::IDENTITY }
        };
        let mut keys = vec![key(begin, 0.0), key(begin + takes, height)];
        let returns = random.yes();
        if returns {
            keys.push(key(begin + 2.5 * takes, 0.0));
        }
        let shape = Shape::Box { size: DVec3::new(2.0, 1.0, 2.0) };
        let solids = vec![Solid { position: below, keys, ..Solid::new(shape) }];
        let particles = vec![Particle { position: DVec3::ZERO, velocity: DVec3::ZERO, mass }];
        let scene = Scene { particles, solids, ..Scene::default() };
        // Explicit Euler does add energy, in every fall within a substep.
        for integrator in Integrator::ALL.into_iter().filter(|&it| it != Integrator::ExplicitEuler)
        {
            let settings = Settings { integrator, ..Settings::default() };
            let mut run = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
            let start = run.energy();
            let witness = witnessed(&mut run, 240);
            let found = [witness.gain(), witness.surplus(), witness.loss()];
            assert_eq!(found, [0.0; 3], "{integrator}, {height} m in {takes} s");
            let energy = run.energy();
            let rise = if returns { 0.0 } else { height };
            let weight = 9.82 * mass * rise;
            let work = energy.supplied - energy.dissipated;
            // In a substep h it may fall, or be slowed, by (g + 5 m/s²) h before contact is felt,
            // and that is booked or not, m ((g + 5) h)²/2 in each of the 4 s / h.
            let allowed = 0.5 * mass * 14.82f64.powi(2) * run.settings().substep() * 4.0;
            assert!((work - weight).abs() < allowed, "{integrator}: {work} of {weight} J");
            let raised = energy.gravitational - start.gravitational;
            assert!((raised - weight).abs() < allowed, "{integrator}: {raised} of {weight} J");
            // To the tolerance of Dormand-Prince.
            let least = -1e-3 * mass * 9.82 * height;
            assert!(least < energy.dissipated, "{integrator}: {}", energy.dissipated);
        }
    }
}

#[test]
fn an_energy_that_nobody_measured_is_neither_gained_nor_lost_and_resumes() {
    let scene = tumbling_block(0.5);
    let mut simulation = simulation::<f32>(&scene, Integrator::VelocityVerlet, 1.0 / 480.0);
    let mut witness = Witness::default();
    witness.watch(&simulation);
    for _ in 0..100 {
        simulation.step().expect("a run that stays in the world");
        // As after a step of a graphics device.
        simulation.set_ledger(Ledger::of(f64::NAN));
        witness.watch(&simulation);
        let told = [witness.gain(), witness.loss(), witness.rise(), witness.surplus()];
        assert_eq!(told, [0.0; 4]);
    }
    let (rows, progress) = simulation.progress();
    let resumed = Simulation::<f32>::resume(&rows, &progress).expect("a run that goes on");
    assert!(resumed.energy().dissipated.is_nan() && resumed.energy().kinetic.is_finite());
}
