//! Bad input: the refusal of every number and index out of its domain, and reports of divergence.

use crate::common::{simulation, two_masses};
use msd_core::glam::DVec3;
use msd_core::{
    Air, Body, Divergence, Error, Friction, Gust, Integrator, Interaction, Material, Particle, Pin,
    Plane, Real, Scene, Settings, Simulation, Spring, State, Vector, shape,
};
use std::ops::Range;

const NAN: f64 = f64::NAN;
const INF: f64 = f64::INFINITY;

/// A change to valid rows.
type Change<T> = fn(&mut T);

const PLANE: Plane =
    Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.5, friction: Friction::Coulomb(0.5) };

fn body(particles: Range<usize>) -> Body {
    Body { particles, ..Body::default() }
}

/// Scenes that single precision refuses, and its messages.
const ROWS: [(Change<Scene>, &str); 30] = [
    (|s| s.particles[1].mass = 0.0, "mass of particle 1 is 0; it must be positive and finite"),
    (|s| s.particles[1].mass = -1.0, "mass of particle 1 is -1; it must be positive and finite"),
    (|s| s.particles[1].mass = NAN, "mass of particle 1 is NaN; it must be positive and finite"),
    (|s| s.particles[1].mass = INF, "mass of particle 1 is inf; it must be positive and finite"),
    // Rounds to zero.
    (
        |s| s.particles[0].mass = 1e-60,
        "mass of particle 0 is 1e-60; it must be positive and finite",
    ),
    // Has no reciprocal.
    (
        |s| s.particles[0].mass = 1e-39,
        "mass of particle 0 is 1e-39; it must be positive and finite",
    ),
    (
        |s| s.particles[0].position.y = NAN,
        "position of particle 0 is NaN; it must be finite and inside the world",
    ),
    (
        |s| s.particles[0].position.y = 2e6,
        "position of particle 0 is 2000000; it must be finite and inside the world",
    ),
    (|s| s.particles[0].velocity.z = INF, "velocity of particle 0 is inf; it must be finite"),
    (
        |s| s.springs[0].stiffness = -2.0,
        "stiffness of spring 0 is -2; it must be finite and not negative",
    ),
    (
        |s| s.springs[0].stiffness = 1e300,
        "stiffness of spring 0 is 1e300; it must be finite and not negative",
    ),
    (
        |s| s.springs[0].rest_length = NAN,
        "rest length of spring 0 is NaN; it must be finite and not negative",
    ),
    (
        |s| s.springs[0].damping = -1e-9,
        "damping of spring 0 is -1e-9; it must be finite and not negative",
    ),
    (
        |s| s.springs[0].damping = 1e300,
        "damping of spring 0 is 1e300; it must be finite and not negative",
    ),
    (
        |s| s.springs[0].ends = [0, 2],
        "spring 0 names particle 2, but there are only 2, counted from 0",
    ),
    (
        |s| s.springs[0].ends = [1, 1],
        "spring 0 joins particle 1 to itself; its two ends must differ",
    ),
    (|s| *s = Scene::default(), "the scene has no particles; give it at least one body"),
    (|s| s.world.gravity.x = NAN, "gravity of world 0 is NaN; it must be finite"),
    (|s| s.world.drag = -1.0, "drag of world 0 is -1; it must be finite and not negative"),
    (
        |s| s.world.air = Some(Air { density: -1.0, ..Air::default() }),
        "density of air 0 is -1; it must be finite and not negative",
    ),
    (
        |s| s.world.air = Some(Air { lift: 2.0, ..Air::default() }),
        "lift coefficient of air 0 is 2; it must be from 0 to the drag coefficient",
    ),
    (
        |s| {
            let gust = Gust { length: 0.0, ..Gust::default() };
            s.world.air = Some(Air { gust, ..Air::default() });
        },
        "length of gusts of air 0 is 0; it must be positive and at most 1e12",
    ),
    (|s| s.world.extent = 0.0, "extent of world 0 is 0; it must be positive and at most 1e12"),
    (
        |s| s.planes = vec![Plane { normal: DVec3::ZERO, ..PLANE }],
        "normal of plane 0 is 0; it must be a finite vector that is not zero",
    ),
    (
        |s| s.planes = vec![Plane { restitution: 1.5, ..PLANE }],
        "restitution of plane 0 is 1.5; it must be from 0 to 1",
    ),
    (
        |s| s.planes = vec![Plane { friction: Friction::Coulomb(-1.0), ..PLANE }],
        "friction of plane 0 is -1; it must be finite and not negative",
    ),
    (
        |s| s.planes = vec![Plane { friction: Friction::TangentialLoss(1.1), ..PLANE }],
        "tangential loss of plane 0 is 1.1; it must be from 0 to 1",
    ),
    (
        |s| s.pins = vec![Pin { particle: 2, velocity: DVec3::ZERO }],
        "pin 0 names particle 2, but there are only 2, counted from 0",
    ),
    (
        |s| s.bodies = vec![body(0..3)],
        "body 0 names particle 3, but there are only 3, counted from 0",
    ),
    // Ends before it starts.
    (
        |s| s.bodies = vec![body(Range { start: 2, end: 1 })],
        "start of a range of body 0 is 2; it must be at most its end",
    ),
];

/// Settings that are refused, and the messages.
const SETTINGS: [(Change<Settings>, &str); 8] = [
    (|s| s.step = 0.0, "step of setting 0 is 0; it must be positive, finite and at most 1e6 s"),
    (|s| s.step = -1.0, "step of setting 0 is -1; it must be positive, finite and at most 1e6 s"),
    (|s| s.step = NAN, "step of setting 0 is NaN; it must be positive, finite and at most 1e6 s"),
    (|s| s.step = INF, "step of setting 0 is inf; it must be positive, finite and at most 1e6 s"),
    (
        |s| s.step = 1e-40,
        "step of setting 0 is 1e-40; it must be positive, finite and at most 1e6 s",
    ),
    (
        |s| s.step = 1e7,
        "step of setting 0 is 10000000; it must be positive, finite and at most 1e6 s",
    ),
    (|s| s.substeps = 0, "substeps of setting 0 is 0; it must be at least 1"),
    // A step of thousands of millions of iterations would never end.
    (|s| s.newton = 1001, "newton of setting 0 is 1001; it must be from 1 to 1000"),
];

fn pair() -> Scene {
    two_masses([1.0, 1.0], 10.0, 0.0, 0.0)
}

#[test]
fn a_refusal_names_the_row_the_value_and_the_domain() {
    let rows = ROWS.map(|(change, told)| {
        let mut scene = pair();
        change(&mut scene);
        (scene, Settings::default(), told)
    });
    let settings = SETTINGS.map(|(change, told)| {
        let mut settings = Settings { substeps: 1, ..Settings::default() };
        change(&mut settings);
        (pair(), settings, told)
    });
    for (scene, settings, told) in rows.into_iter().chain(settings) {
        let message = Simulation::<f32>::new(&scene, settings).expect_err(told).to_string();
        assert_eq!(message, told);
    }
}

#[test]
fn an_unknown_integrator_is_answered_with_the_list() {
    let error = "euler".parse::<Integrator>().unwrap_err();
    let names = "explicit-euler, symplectic-euler, velocity-verlet, rk4, dormand-prince, \
                 backward-euler, implicit-midpoint, xpbd";
    let expected = format!("unknown integrator 'euler'; it must be one of {names}");
    assert_eq!(error.to_string(), expected);
    for integrator in Integrator::ALL {
        assert_eq!(integrator.name().parse::<Integrator>().unwrap(), integrator);
    }
}

fn diverges<R: Real>(integrator: Integrator) {
    let material = Material { mass: 1.0, stiffness: 1e6, damping: 0.0 };
    let mut scene = Scene::of("rope", shape::rope(5, 1.0, material).unwrap());
    scene.particles[4].position.x += 0.5;
    let mut simulation = simulation::<R>(&scene, integrator, 1.0 / 60.0);
    let mut before = simulation.state();
    for step in 1..1000 {
        match simulation.step() {
            Ok(()) => before = simulation.state(),
            Err(Error::Diverged(report)) => {
                assert_eq!(report.step, step);
                assert!(report.particle < 5);
                assert_eq!(simulation.state(), before, "the last good state is kept");
                assert!(report.stable_substep.is_none_or(|stable| stable < report.substep));
                let message = report.to_string();
                assert!(message.contains("more substeps") || message.contains("another"));
                // It fails again in the same way rather than running on from a bad state.
                assert!(simulation.step().is_err());
                return;
            }
            Err(error) => panic!("{error}"),
        }
    }
    panic!("{integrator}: h w = 30 and it did not diverge");
}

#[test]
fn a_run_that_diverges_stops_at_the_last_good_state_and_says_where() {
    // The others are stable at any step or choose their own.
    for integrator in Integrator::EXPLICIT {
        diverges::<f32>(integrator);
        diverges::<f64>(integrator);
    }
}

/// A heap that is too stiff for its step, on a floor, with everything that books energy.
fn stiff_heap(factor: f64) -> Scene {
    let material = Material { mass: 0.05, stiffness: 400.0 * factor, damping: 0.5 * factor };
    let mut part = shape::block([4, 4, 4], 0.1, material).expect("a block");
    part.set_motion(DVec3::new(0.3, -2.0, 0.1), DVec3::new(1.0, 2.0, 3.0));
    let floor = Plane { offset: -0.2, ..PLANE };
    Scene { planes: vec![floor], ..Scene::of("heap", part) }
}

fn holds_only_numbers<R: Real>(scene: &Scene, integrator: Integrator, substeps: u32) {
    let settings = Settings { integrator, substeps, ..Settings::default() };
    let mut run = Simulation::<R>::new(scene, settings).expect("a scene");
    let is_good = |run: &Simulation<R>| {
        let crossing = 2.0 * scene.world.extent / settings.substep();
        let speeds = run.state().velocities;
        let is_slow = speeds.iter().all(|speed| speed.to_f64().abs().max_element() <= crossing);
        run.energy().total().is_finite() && (is_slow || integrator.is_adaptive())
    };
    for step in 1..200 {
        let failed = run.step().is_err();
        assert!(is_good(&run), "{integrator}, {substeps}: step {step}, {:?}", run.energy());
        if failed {
            return;
        }
    }
}

/// Energies are infinite long before positions are, where a method ends on a kick.
#[test]
fn a_run_that_diverges_keeps_finite_energies_and_speeds() {
    for factor in [1.0, 1e2, 1e4, 1e8, 1e16] {
        let scene = stiff_heap(factor);
        for integrator in Integrator::ALL {
            if integrator == Integrator::DormandPrince && 1e2 < factor {
                continue;
            }
            for substeps in [1, 3, 8] {
                holds_only_numbers::<f32>(&scene, integrator, substeps);
                holds_only_numbers::<f64>(&scene, integrator, substeps);
            }
        }
    }
}

#[test]
fn a_prediction_about_a_state_that_flew_apart_is_no_advice() {
    let report = |stable| Divergence {
        particle: 3,
        step: 7,
        time: 0.1,
        substep: 2e-3,
        stable_substep: Some(stable),
    };
    let [far, near] = [2.475e-16, 1e-3].map(|stable| report(stable).to_string());
    assert!(far.contains("start again with more substeps") && !far.contains("e-16"), "{far}");
    assert!(near.contains("at most 1.000e-3 s is predicted stable"), "{near}");
}

#[test]
fn a_state_that_does_not_fit_is_refused_and_nothing_changes() {
    let scene = pair();
    let mut simulation = simulation::<f64>(&scene, Integrator::Rk4, 1e-3);
    let good = simulation.state();
    let short = State { positions: vec![DVec3::ZERO], velocities: vec![DVec3::ZERO] };
    let mut far = good.clone();
    far.positions[1].x = 2e6;
    let mut broken = good.clone();
    broken.velocities[0].y = f64::NAN;
    for state in [short, far, broken] {
        assert!(simulation.set_state(&state, 0).is_err());
        assert_eq!(simulation.state(), good);
    }
}

#[test]
fn a_plane_that_pushes_a_particle_out_of_the_world_is_refused_at_the_start() {
    let mut scene = pair();
    let (normal, friction) = (DVec3::Y, Friction::Coulomb(0.0));
    scene.planes = vec![Plane { normal, offset: 2e6, restitution: 0.0, friction }];
    let error = Simulation::<f64>::new(&scene, Settings::default()).unwrap_err();
    let expected = "position of particle 0 is 2000000; it must be inside the world once the \
                    obstacles have pushed the particle out";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_normal_is_a_direction_however_long_it_is() {
    // The sum of its components overflows.
    let normal = DVec3::splat(f64::MAX);
    let mut scene = pair();
    let friction = Friction::Coulomb(0.0);
    scene.planes = vec![Plane { normal, offset: -5.0, restitution: 0.0, friction }];
    let made = Simulation::<f64>::new(&scene, Settings::default()).expect("a direction");
    // A root and a division, each rounded once.
    let direction = DVec3::splat(1.0 / 3f64.sqrt());
    assert!((made.model().planes()[0].normal - direction).length() <= 2.0 * f64::EPSILON);
}

#[test]
fn a_part_whose_indices_overflow_when_it_is_added_is_refused() {
    let part = || shape::rope(3, 1.0, Material::default()).expect("a rope");
    let mut scene = Scene::of("rope", part());
    let mut broken = part();
    broken.springs[0].ends[1] = usize::MAX;
    scene.add("broken", broken);
    let made = Simulation::<f32>::new(&scene, Settings::default());
    let message = made.unwrap_err().to_string();
    assert!(message.starts_with("spring 2 names particle 18446744073709551615, but"), "{message}");
    let mut scene = Scene::of("rope", part());
    let mut broken = shape::cloth([2, 2], 1.0, Material::default()).expect("a cloth");
    broken.surface.corners[0].particle = u32::MAX;
    scene.add("broken", broken);
    let made = Simulation::<f32>::new(&scene, Settings::default());
    let message = made.unwrap_err().to_string();
    assert!(message.starts_with("body 1 names particle 4294967295, but"), "{message}");
}

#[test]
fn a_count_of_steps_that_is_not_exact_as_a_number_is_refused() {
    let scene = pair();
    let mut simulation = simulation::<f64>(&scene, Integrator::Rk4, 1.0 / 1024.0);
    let state = simulation.state();
    assert!(simulation.set_state(&state, u64::MAX).is_err());
    let message = simulation.set_state(&state, 1 << 53).unwrap_err().to_string();
    assert_eq!(message, "number of step 0 is 9.007199254740992e15; it must be less than 2^53");
    assert_eq!(simulation.steps(), 0);
    // Time, exact with such a step, still moves; with one more count it would stand still.
    simulation.set_state(&state, (1 << 53) - 2).expect("exact");
    let time = simulation.time();
    simulation.step().expect("the last step");
    assert!(time < simulation.time());
    let before = simulation.progress();
    assert!(matches!(simulation.step(), Err(Error::OutOfDomain { .. })));
    assert!(simulation.progress() == before);
}

/// Scenes that single precision cannot hold, and the messages.
const TOO_LARGE: [(Change<Scene>, &str); 5] = [
    (
        |s| s.springs[0].rest_length = 1e300,
        "rest length of spring 0 is 1e300; it must be finite and not negative",
    ),
    (|s| s.world.gravity.y = -1e300, "gravity of world 0 is -1e300; it must be finite"),
    (|s| s.world.drag = 1e300, "drag of world 0 is 1e300; it must be finite and not negative"),
    (
        |s| s.planes = vec![Plane { offset: -1e300, ..PLANE }],
        "offset of plane 0 is -1e300; it must be finite",
    ),
    (|s| s.particles[1].velocity.z = 1e300, "velocity of particle 1 is 1e300; it must be finite"),
];

#[test]
fn a_conversion_refuses_the_first_number_that_single_precision_cannot_hold() {
    for (change, told) in TOO_LARGE {
        let mut scene = pair();
        change(&mut scene);
        let simulation = Simulation::<f64>::new(&scene, Settings::default()).expect("fits f64");
        let refused = simulation.convert::<f32>().map(drop).expect_err("does not fit f32");
        assert_eq!(refused.to_string(), told);
    }
}

fn stays_or_stops<R: Real>(scene: &Scene, settings: Settings, grab: Interaction) {
    let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
    simulation.queue(grab).expect("a valid grab");
    let before = simulation.state();
    match simulation.step() {
        Ok(()) => assert!(simulation.velocities().all(|velocity| velocity.to_f64().is_finite())),
        Err(error) => assert!(error.is_of_step() && simulation.state() == before, "{error}"),
    }
}

#[test]
fn a_stiff_spring_at_a_step_of_two_days_stays_finite_or_stops() {
    let at = |position: DVec3, mass: f64| Particle { position, velocity: DVec3::ZERO, mass };
    let particles = vec![
        at(DVec3::ZERO, 1.0),
        at(DVec3::new(1.538634774417177, 0.0, -6.878246084922843), 1.0),
        at(DVec3::X * 3.186601437874644e-7, 28.58702464219551),
    ];
    let (rest_length, stiffness) = (718957.4692480877, 10950988734.15963);
    let spring = Spring { ends: [2, 1], rest_length, stiffness, damping: 0.15714273900911857 };
    let pin =
        Pin { particle: 1, velocity: DVec3::new(2.7346772680124976, -0.6970281232953149, 0.0) };
    let scene = Scene { particles, springs: vec![spring], pins: vec![pin], ..Scene::default() };
    let (integrator, step) = (Integrator::BackwardEuler, 189068.89150655887);
    let settings = Settings { integrator, step, substeps: 1, ..Settings::default() };
    let (target, max_force) = (DVec3::ZERO, f64::MAX);
    let grab =
        Interaction::Grab { particle: 0, target, frequency: 1.0, damping_ratio: 1.0, max_force };
    stays_or_stops::<f32>(&scene, settings, grab);
    stays_or_stops::<f64>(&scene, settings, grab);
}
