//! Pins that follow key frames or a solid, and the work that they do.

use crate::common::weightless;
use msd_core::glam::{DMat3, DVec3};
use msd_core::{
    Guide, Instructions, Integrator, Interaction, KeyFrame, Lead, Particle, Real, Scene, Settings,
    Shape, Simulation, Solid, Spring, Vector, Witness,
};

const G: f64 = 9.82;
/// The way of the pin and the time that it takes, metres and seconds.
const WAY: f64 = 0.5;
const TIME: f64 = 1.0;
const REST: f64 = 0.25;

/// A pin that goes up from rest to rest, and a mass that hangs from it on a spring of a stiffness.
fn hung(stiffness: f64, gravity: f64) -> Scene {
    let particle = |y: f64| Particle { position: DVec3::Y * y, velocity: DVec3::ZERO, mass: 1.0 };
    let keys = vec![KeyFrame { time: TIME, position: DVec3::Y * WAY, axes: DMat3::IDENTITY }];
    let lead = Lead::Path { since: 0.0, position: DVec3::ZERO, velocity: DVec3::ZERO, keys };
    let mut scene = Scene {
        world: weightless(),
        particles: vec![particle(0.0), particle(-REST - gravity / stiffness)],
        springs: vec![Spring { ends: [0, 1], rest_length: REST, stiffness, damping: 0.0 }],
        guides: vec![Guide { held: vec![(0, DVec3::ZERO)], lead, until: None }],
        ..Scene::default()
    };
    scene.world.gravity = DVec3::NEG_Y * gravity;
    scene
}

fn start<R: Real>(scene: &Scene, integrator: Integrator, substeps: u32) -> Simulation<R> {
    let settings =
        Settings { integrator, step: 1.0 / 64.0, substeps, tolerance: 1e-7, ..Settings::default() };
    Simulation::new(scene, settings).expect("a valid scene")
}

/// The height of the pin and its speed at a time: a cubic with zero slopes at both ends.
fn path(time: f64) -> (f64, f64) {
    let part = (time / TIME).min(1.0);
    (WAY * part * part * (3.0 - 2.0 * part), 6.0 * WAY * part * (1.0 - part) / TIME)
}

fn is_on_its_path<R: Real>(integrator: Integrator) {
    let mut simulation = start::<R>(&hung(100.0, G), integrator, 16);
    for _ in 0..80 {
        simulation.step().unwrap();
        let (height, speed) = path(simulation.time());
        let at = simulation.position(0).to_f64();
        let moves = simulation.velocity(0).to_f64();
        // Rounded once to this precision; the cubic itself in double precision.
        let near = |a: f64, b: f64| (a - b).abs() <= R::EPSILON.to_f64() * b.abs() + 1e-15;
        assert!(near(at.y, height) && near(moves.y, speed), "{integrator}: {at}, {moves}");
        assert!(at.x == 0.0 && at.z == 0.0);
    }
}

#[test]
fn a_guided_particle_is_on_its_path_after_every_step() {
    for integrator in Integrator::ALL {
        is_on_its_path::<f32>(integrator);
        is_on_its_path::<f64>(integrator);
    }
}

/// The height of a mass that hangs from that pin: with w² = k/m it is p − p''/w² and a swing that
/// starts it from rest, as p has no fourth derivative.
fn driven(time: f64, stiffness: f64) -> f64 {
    let w = stiffness.sqrt();
    let (bend, jerk) = (6.0 * WAY / (TIME * TIME), -12.0 * WAY / (TIME * TIME * TIME));
    let swing = bend * (w * time).cos() + jerk * (w * time).sin() / w;
    path(time).0 - REST + (swing - bend - jerk * time) / stiffness
}

#[test]
fn a_mass_on_a_spring_at_a_guided_pin_is_a_driven_oscillator() {
    let stiffness = 100.0;
    for integrator in Integrator::ALL {
        let error = |substeps: u32| {
            let mut simulation = start::<f64>(&hung(stiffness, 0.0), integrator, substeps);
            let mut largest = 0.0f64;
            for _ in 0..60 {
                simulation.step().unwrap();
                let exact = driven(simulation.time(), stiffness);
                largest = largest.max((simulation.position(1).y - exact).abs());
            }
            largest
        };
        let (coarse, fine) = (error(8), error(16));
        // 2 to the power of the order; the adaptive method chooses its substeps by the tolerance,
        // a local error of 1e-7 of the size 0.25 m, at most once in each of the 60 steps and more.
        let order = match integrator {
            Integrator::ExplicitEuler | Integrator::BackwardEuler | Integrator::Xpbd => 1,
            // Symplectic Euler is the leapfrog scheme, half a substep of the first acceleration
            // off: that is zero here.
            Integrator::SymplecticEuler
            | Integrator::VelocityVerlet
            | Integrator::ImplicitMidpoint => 2,
            Integrator::Rk4 => 4,
            _ => {
                assert!(fine < 1e-5, "{fine}");
                continue;
            }
        };
        let gain = coarse / fine;
        let expected = f64::from(1 << order);
        assert!((0.8..1.3).contains(&(gain / expected)), "{integrator}: {coarse}, {fine}");
    }
}

#[test]
fn lifting_a_mass_supplies_its_weight_times_the_height() {
    // Pin and mass, of 1 kg each, both lifted; stiff, so that little stays in the swing.
    let lifted = 2.0 * G * WAY;
    for integrator in Integrator::ALL {
        let mut simulation = start::<f64>(&hung(4000.0, G), integrator, 64);
        let before = simulation.energy();
        let mut drift = 0.0f64;
        for _ in 0..64 {
            simulation.step().unwrap();
            let drifts = (simulation.energy().total() - before.total()).abs();
            drift = drift.max(drifts);
        }
        let after = simulation.energy();
        let gained = after.gravitational - before.gravitational;
        assert!((gained - lifted).abs() < 0.02 * lifted, "{integrator}: {gained}");
        // First order methods miss half a substep of the largest power, 20 W, at times; they and
        // their own damping or gain of the swing, of 0.01 J, are the drift.
        let order = match integrator {
            Integrator::ExplicitEuler
            | Integrator::SymplecticEuler
            | Integrator::BackwardEuler
            | Integrator::Xpbd => 1e-2,
            Integrator::VelocityVerlet | Integrator::ImplicitMidpoint => 1e-4,
            _ => 1e-6,
        };
        assert!(drift < order * lifted, "{integrator}: {drift} J");
    }
}

#[test]
fn lowering_it_again_takes_the_work_back_as_dissipated() {
    let mut scene = hung(4000.0, G);
    let Lead::Path { keys, .. } = &mut scene.guides[0].lead else { panic!("a path") };
    keys.push(KeyFrame { time: 2.0 * TIME, position: DVec3::ZERO, axes: DMat3::IDENTITY });
    let mut simulation = start::<f64>(&scene, Integrator::Rk4, 64);
    let before = simulation.energy();
    (0..128).for_each(|_| simulation.step().unwrap());
    let after = simulation.energy();
    assert!(after.supplied > 2.0 * G * WAY && after.dissipated > 0.99 * 2.0 * G * WAY);
    assert!((after.total() - before.total()).abs() < 1e-5);
}

#[test]
fn the_work_of_a_steady_pin_is_supplied() {
    let mut scene = hung(100.0, G);
    scene.guides.clear();
    scene.pins = vec![msd_core::Pin { particle: 0, velocity: DVec3::Y * 0.5 }];
    let mut simulation = start::<f64>(&scene, Integrator::Rk4, 16);
    let before = simulation.energy();
    (0..64).for_each(|_| simulation.step().unwrap());
    let after = simulation.energy();
    assert!(after.mechanical() - before.mechanical() > 9.0);
    assert!((after.total() - before.total()).abs() < 1e-6);
}

/// The drift detector after a second of a run.
fn watched(scene: &Scene, integrator: Integrator, substeps: u32) -> Witness {
    let mut simulation = start::<f32>(scene, integrator, substeps);
    let mut witness = Witness::default();
    for _ in 0..64 {
        witness.watch(&simulation);
        simulation.step().unwrap();
    }
    witness
}

#[test]
fn energy_that_a_method_adds_is_seen_while_a_pin_moves() {
    for integrator in Integrator::ALL {
        // h w is 0.23: explicit Euler adds h² w² of the swing in each of 128 substeps, which makes
        // it a thousand times as large, some joules.
        let seen = watched(&hung(900.0, G), integrator, 2);
        let is_euler = integrator == Integrator::ExplicitEuler;
        let damps = matches!(integrator, Integrator::BackwardEuler | Integrator::Xpbd);
        assert_eq!(0.0 < seen.gain().max(seen.surplus()), is_euler, "{integrator}: {seen:?}");
        assert!(damps || is_euler || seen.loss() == 0.0, "{integrator}: {seen:?}");
    }
}

#[test]
fn a_pin_that_jumps_within_four_substeps_is_in_no_account() {
    let mut scene = hung(100.0, G);
    let Lead::Path { keys, .. } = &mut scene.guides[0].lead else { panic!("a path") };
    // A substep is a 256th of a second: 5 of them, then 3, then 3 at rest.
    let place = |time: f64, y: f64| KeyFrame {
        time: time / 256.0,
        position: DVec3::Y * y,
        axes: DMat3::IDENTITY,
    };
    *keys = vec![place(5.0, 0.1), place(8.0, 0.2), place(11.0, 0.2)];
    let mut simulation = start::<f64>(&scene, Integrator::VelocityVerlet, 4);
    let mut handled = Vec::new();
    for _ in 0..4 {
        simulation.step().unwrap();
        handled.push(simulation.is_handled());
    }
    assert_eq!(handled, [false, true, false, false]);
}

#[test]
fn a_step_in_which_a_pin_jumps_is_not_refused_for_the_energy_that_it_gives() {
    let mut scene = hung(2000.0, G);
    let Lead::Path { keys, .. } = &mut scene.guides[0].lead else { panic!("a path") };
    // Half of a substep: no method sees it move.
    keys[0].time = 1.0 / 512.0;
    let mut simulation = start::<f64>(&scene, Integrator::VelocityVerlet, 4);
    assert!(simulation.step_unless_passing().unwrap() && simulation.is_handled());
    assert_eq!(simulation.given(), 0.0);
}

#[test]
fn who_pins_a_particle_that_flies_takes_its_energy_and_who_moves_it_gives_it() {
    let mut scene = hung(100.0, 0.0);
    (scene.guides, scene.springs) = (Vec::new(), Vec::new());
    scene.particles[1].velocity = DVec3::Y * 2.0;
    let mut simulation = start::<f64>(&scene, Integrator::VelocityVerlet, 4);
    for (speed, dissipated, supplied) in [(1.0, 1.5, 0.0), (3.0, 1.5, 4.0), (0.0, 6.0, 4.0)] {
        let pin = Interaction::Pin { particle: 1, velocity: DVec3::X * speed };
        simulation.queue(pin).unwrap();
        simulation.step().unwrap();
        let energy = simulation.energy();
        assert_eq!((energy.dissipated, energy.supplied), (dissipated, supplied));
        assert_eq!(energy.total(), 2.0);
    }
}

/// A solid that turns about z a radian a second and moves, and a particle a metre from its middle.
fn turning() -> Scene {
    let mut scene = hung(100.0, 0.0);
    scene.solids = vec![Solid {
        position: DVec3::Y * 9.0,
        velocity: DVec3::X * 0.5,
        spin: DVec3::Z,
        ..Solid::new(Shape::Sphere { radius: 0.1 })
    }];
    scene.guides[0].lead = Lead::Solid(0);
    scene.guides[0].held = vec![(0, DVec3::X)];
    scene
}

#[test]
fn a_pin_that_follows_a_solid_turns_and_moves_with_it() {
    for integrator in Integrator::ALL {
        let mut simulation = start::<f64>(&turning(), integrator, 16);
        for _ in 0..32 {
            simulation.step().unwrap();
            let (sin, cos) = simulation.time().sin_cos();
            let exact = DVec3::new(0.5 * simulation.time() + cos, 9.0 + sin, 0.0);
            let moves = DVec3::new(0.5 - sin, cos, 0.0);
            assert!((simulation.position(0) - exact).length() < 1e-14, "{integrator}");
            assert!((simulation.velocity(0) - moves).length() < 1e-14, "{integrator}");
        }
    }
}

#[test]
fn a_pin_that_ends_leaves_its_particle_in_free_flight() {
    for integrator in Integrator::ALL {
        let mut scene = hung(100.0, G);
        scene.springs.clear();
        scene.guides[0].until = Some(0.5);
        let mut simulation = start::<f64>(&scene, integrator, 64);
        let mut freed = Vec::new();
        for step in 1..=64 {
            simulation.step().unwrap();
            freed.extend(simulation.has_freed_pins().then_some(step));
            assert_eq!(simulation.model().is_pinned(0), step < 32);
        }
        assert_eq!(freed, [32]);
        let (height, speed) = path(0.5);
        let exact = height + speed * 0.5 - 0.5 * G * 0.25;
        // A method of first order is late by g h t / 2.
        let error = (simulation.position(0).y - exact).abs();
        assert!(error <= 0.51 * G * 0.5 / 4096.0, "{integrator}: {error}");
    }
}

#[test]
fn a_pin_that_ends_at_once_is_free_after_the_first_step() {
    let mut scene = hung(100.0, G);
    scene.guides[0].until = Some(1e-9);
    let mut simulation = start::<f64>(&scene, Integrator::VelocityVerlet, 16);
    simulation.step().unwrap();
    assert!(!simulation.model().is_pinned(0) && simulation.has_freed_pins());
}

#[test]
fn a_run_goes_back_before_the_end_of_a_pin_and_takes_the_same_way() {
    let mut scene = hung(100.0, G);
    scene.guides[0].until = Some(0.5);
    let mut simulation = start::<f64>(&scene, Integrator::VelocityVerlet, 16);
    (0..30).for_each(|_| simulation.step().unwrap());
    let kept = simulation.state();
    (0..10).for_each(|_| simulation.step().unwrap());
    let end = simulation.state();
    simulation.set_state(&kept, 30).unwrap();
    assert!(simulation.model().is_pinned(0) && simulation.state() == kept);
    (0..10).for_each(|_| simulation.step().unwrap());
    assert_eq!(simulation.state(), end);
}

fn resumes<R: Real>(integrator: Integrator) {
    let mut scene = turning();
    scene.guides[0].until = Some(0.75);
    for steps in [0, 20, 47, 48, 50] {
        let mut simulation = start::<R>(&scene, integrator, 8);
        (0..steps).for_each(|_| simulation.step().unwrap());
        let (rows, progress) = simulation.progress();
        let mut other = Simulation::<R>::resume(&rows, &progress).unwrap();
        assert_eq!(other.has_freed_pins(), simulation.has_freed_pins());
        for _ in 0..40 {
            simulation.step().unwrap();
            other.step().unwrap();
        }
        assert_eq!(other.state(), simulation.state(), "{integrator} after {steps} steps");
        assert_eq!(other.ledger(), simulation.ledger());
    }
}

#[test]
fn a_run_with_guides_resumes_to_the_bit() {
    for integrator in Integrator::ALL {
        resumes::<f32>(integrator);
        resumes::<f64>(integrator);
    }
}

#[test]
fn guided_runs_have_the_same_bits_by_all_instructions() {
    for integrator in Integrator::ALL {
        let run = |instructions| {
            let mut simulation = start::<f32>(&turning(), integrator, 8);
            simulation.set_instructions(instructions);
            (0..40).for_each(|_| simulation.step().unwrap());
            simulation.state()
        };
        assert_eq!(run(Instructions::Plain), run(Instructions::best()), "{integrator}");
    }
}

#[test]
fn who_pins_or_frees_a_guided_particle_takes_it_from_its_guide() {
    for interaction in [
        Interaction::Pin { particle: 0, velocity: DVec3::ZERO },
        Interaction::Unpin { particle: 0 },
    ] {
        let mut simulation = start::<f64>(&hung(100.0, 0.0), Integrator::VelocityVerlet, 16);
        (0..32).for_each(|_| simulation.step().unwrap());
        let before = simulation.position(0).y;
        simulation.queue(interaction).unwrap();
        (0..32).for_each(|_| simulation.step().unwrap());
        let is_pin = matches!(interaction, Interaction::Pin { .. });
        assert_eq!(simulation.model().is_pinned(0), is_pin);
        assert_eq!(simulation.position(0).y == before, is_pin);
        assert!(simulation.progress().1.guides.is_empty());
    }
}

#[test]
fn bad_guides_are_refused() {
    type Change = fn(&mut Guide);
    let cases: [(Change, &str); 6] = [
        (
            |guide| guide.held[0].0 = 9,
            "guide 0 names particle 9, but there are only 2, counted from 0",
        ),
        (
            |guide| guide.held.push(guide.held[0]),
            "particle of guide 0 is 0; it must be guided once",
        ),
        (|guide| guide.until = Some(0.0), "end of guide 0 is 0; it must be positive and finite"),
        (
            |guide| guide.lead = Lead::Solid(0),
            "guide 0 names solid 0, but there are only 0, counted from 0",
        ),
        (|guide| guide.held[0].1.x = f64::NAN, "place of guide 0 is NaN; it must be finite"),
        (
            |guide| {
                let Lead::Path { keys, .. } = &mut guide.lead else { return };
                keys[0].time = 0.0;
            },
            "time of a key frame of guide 0 is 0; it must be later than the one before",
        ),
    ];
    for (change, expected) in cases {
        let mut scene = hung(100.0, 0.0);
        change(&mut scene.guides[0]);
        let refused = Simulation::<f32>::new(&scene, Settings::default()).unwrap_err();
        assert_eq!(refused.to_string(), expected);
    }
}

#[test]
fn a_run_that_starts_on_the_way_moves_as_the_one_that_came_there() {
    let mut scene = hung(100.0, G);
    let keys = vec![KeyFrame { time: TIME, position: DVec3::X * WAY, axes: DMat3::IDENTITY }];
    let ball = || Solid::new(Shape::Sphere { radius: 0.1 });
    scene.solids = vec![
        Solid { position: DVec3::Z, keys, ..ball() },
        Solid { position: DVec3::Z * 3.0, spin: DVec3::Y, ..ball() },
    ];
    for (solid, until) in [(0, Some(0.75)), (1, None), (1, Some(0.25))] {
        let position = scene.solids[solid].position + DVec3::X * 0.5;
        let held = vec![(scene.particles.len(), DVec3::X * 0.5)];
        scene.particles.push(Particle { position, velocity: DVec3::ZERO, mass: 1.0 });
        scene.guides.push(Guide { held, lead: Lead::Solid(solid), until });
    }
    let mut run = start::<f64>(&scene, Integrator::VelocityVerlet, 16);
    (0..32).for_each(|_| run.step().unwrap());
    let (mut rows, progress) = run.progress();
    rows.guides.clone_from(&progress.guides);
    assert_eq!(progress.time(), run.time());
    let mut later = start::<f64>(&rows.from_time(progress.time()), Integrator::VelocityVerlet, 16);
    for _ in 0..32 {
        run.step().unwrap();
        later.step().unwrap();
        for particle in 0..scene.particles.len() {
            let apart = run.position(particle).to_f64() - later.position(particle).to_f64();
            // Times are multiples of 1/1024: ways differ by roundings of metres.
            assert!(apart.length() <= 1e-13, "particle {particle} at {} s: {apart}", run.time());
        }
    }
}
