//! Is every number and index checked at the door, and divergence reported?

mod common;

use common::{simulation, two_masses};
use msd_core::glam::DVec3;
use msd_core::{
    Body, Error, Friction, Integrator, Material, Model, Pin, Plane, Real, Scene, Settings,
    Simulation, State, shape,
};
use proptest::prelude::*;

fn refusal(change: impl FnOnce(&mut Scene)) -> String {
    let mut scene = two_masses([1.0, 1.0], 10.0, 0.0, 0.0);
    change(&mut scene);
    Model::<f32>::new(&scene).expect_err("a scene that must be refused").to_string()
}

#[test]
fn a_refusal_names_the_row_the_value_and_the_domain() {
    let positive = "it must be positive and finite";
    for (mass, shown) in [(0.0, "0"), (-1.0, "-1"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
        let message = refusal(|scene| scene.particles[1].mass = mass);
        assert_eq!(message, format!("mass of particle 1 is {shown}; {positive}"));
    }
    let message = refusal(|scene| scene.springs[0].stiffness = -2.0);
    assert_eq!(message, "stiffness of spring 0 is -2; it must be finite and not negative");
    let message = refusal(|scene| scene.springs[0].stiffness = 1e300);
    assert_eq!(message, "stiffness of spring 0 is 1e300; it must be finite and not negative");
    let message = refusal(|scene| scene.springs[0].ends = [0, 2]);
    assert_eq!(message, "spring 0 names particle 2, but there are only 2, counted from 0");
    let message = refusal(|scene| scene.springs[0].ends = [1, 1]);
    assert_eq!(message, "spring 0 joins particle 1 to itself; its two ends must differ");
    let message = refusal(|scene| *scene = Scene::default());
    assert_eq!(message, "the scene has no particles; give it at least one body");
}

#[test]
fn every_other_bad_row_is_refused_too() {
    let plane =
        Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.5, friction: Friction::Coulomb(0.5) };
    let pin = Pin { particle: 0, velocity: DVec3::ZERO };
    type Change = Box<dyn Fn(&mut Scene)>;
    let changes: Vec<(&str, Change)> = vec![
        ("a mass that single precision rounds to zero", Box::new(|s| s.particles[0].mass = 1e-60)),
        ("a mass without reciprocal", Box::new(|s| s.particles[0].mass = 1e-39)),
        ("NaN position", Box::new(|s| s.particles[0].position.y = f64::NAN)),
        ("position outside the world", Box::new(|s| s.particles[0].position.y = 2e6)),
        ("infinite velocity", Box::new(|s| s.particles[0].velocity.z = f64::INFINITY)),
        ("NaN rest length", Box::new(|s| s.springs[0].rest_length = f64::NAN)),
        ("negative damping", Box::new(|s| s.springs[0].damping = -1e-9)),
        ("damping too large for f32", Box::new(|s| s.springs[0].damping = 1e300)),
        ("NaN gravity", Box::new(|s| s.world.gravity.x = f64::NAN)),
        ("negative drag", Box::new(|s| s.world.drag = -1.0)),
        ("a world without extent", Box::new(|s| s.world.extent = 0.0)),
        ("no normal", Box::new(move |s| s.planes = vec![Plane { normal: DVec3::ZERO, ..plane }])),
        (
            "restitution 1.5",
            Box::new(move |s| s.planes = vec![Plane { restitution: 1.5, ..plane }]),
        ),
        (
            "negative friction",
            Box::new(move |s| {
                s.planes = vec![Plane { friction: Friction::Coulomb(-1.0), ..plane }];
            }),
        ),
        (
            "loss of more than all",
            Box::new(move |s| {
                s.planes = vec![Plane { friction: Friction::TangentialLoss(1.1), ..plane }];
            }),
        ),
        ("a pin of nobody", Box::new(move |s| s.pins = vec![Pin { particle: 2, ..pin }])),
        (
            "a body of more than there is",
            Box::new(|s| s.bodies = vec![Body { particles: 0..3, ..Body::default() }]),
        ),
        (
            "a body that ends before it starts",
            Box::new(|s| {
                #[allow(clippy::reversed_empty_ranges)]
                let particles = 2..1;
                s.bodies = vec![Body { particles, ..Body::default() }];
            }),
        ),
    ];
    for (what, change) in changes {
        let message = refusal(change);
        assert!(!message.contains('\n'), "{what}: {message}");
    }
}

#[test]
fn a_step_that_is_not_positive_and_finite_is_refused() {
    let scene = two_masses([1.0, 1.0], 10.0, 0.0, 0.0);
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-40, 1e7] {
        let settings = Settings { step, substeps: 1, ..Settings::default() };
        assert!(Simulation::<f32>::new(&scene, settings).is_err(), "{step}");
    }
    let settings = Settings { substeps: 0, ..Settings::default() };
    assert!(Simulation::<f32>::new(&scene, settings).is_err());
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
    let mut before = simulation.state().clone();
    for step in 1..1000 {
        match simulation.step() {
            Ok(()) => before = simulation.state().clone(),
            Err(Error::Diverged(report)) => {
                assert_eq!(report.step, step);
                assert!(report.particle < 5);
                assert_eq!(*simulation.state(), before, "the last good state is kept");
                assert!(report.stable_substep.is_none_or(|stable| stable < report.substep));
                let message = report.to_string();
                assert!(message.contains("more substeps") || message.contains("another"));
                // It fails again in the same way rather than running on from nonsense.
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

#[test]
fn a_state_that_does_not_fit_is_refused_and_nothing_changes() {
    let scene = two_masses([1.0, 1.0], 10.0, 0.0, 0.0);
    let mut simulation = simulation::<f64>(&scene, Integrator::Rk4, 1e-3);
    let good = simulation.state().clone();
    let short = State { positions: vec![DVec3::ZERO], velocities: vec![DVec3::ZERO] };
    let mut far = good.clone();
    far.positions[1].x = 2e6;
    let mut broken = good.clone();
    broken.velocities[0].y = f64::NAN;
    for state in [short, far, broken] {
        assert!(simulation.set_state(&state, 0).is_err());
        assert_eq!(*simulation.state(), good);
    }
}

/// Numbers a careless or hostile file may hold.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..10.0,
        1 => prop::num::f64::ANY,
        1 => prop::sample::select(vec![0.0, 1e-300, 1e300, 1e-30, 1e30, 1e6, -1.0, f64::NAN]),
    ]
}

fn any_vector() -> impl Strategy<Value = DVec3> {
    (any_number(), any_number(), any_number()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

prop_compose! {
    fn any_scene()(
        rows in prop::collection::vec((any_vector(), any_vector(), any_number()), 0..6),
        springs in prop::collection::vec(
            ((0usize..7, 0usize..7), any_number(), any_number(), any_number()), 0..8),
        planes in prop::collection::vec((any_vector(), any_number(), any_number()), 0..3),
        gravity in any_vector(),
        drag in any_number(),
        pins in prop::collection::vec(0usize..7, 0..2),
    ) -> Scene {
        let particle = |(position, velocity, mass)| msd_core::Particle { position, velocity, mass };
        let spring = |((a, b), rest_length, stiffness, damping)|
            msd_core::Spring { ends: [a, b], rest_length, stiffness, damping };
        let pin = |particle| Pin { particle, velocity: DVec3::ZERO };
        let plane = |(normal, offset, restitution)|
            Plane { normal, offset, restitution, friction: Friction::Coulomb(0.5) };
        Scene {
            world: msd_core::World { gravity, drag, ..Default::default() },
            particles: rows.into_iter().map(particle).collect(),
            springs: springs.into_iter().map(spring).collect(),
            planes: planes.into_iter().map(plane).collect(),
            pins: pins.into_iter().map(pin).collect(),
            bodies: Vec::new(),
        }
    }
}

fn stays_finite_or_stops<R: Real>(scene: &Scene, integrator: Integrator) {
    let settings = Settings { integrator, ..Settings::default() };
    let Ok(mut simulation) = Simulation::<R>::new(scene, settings) else { return };
    for _ in 0..20 {
        if simulation.step().is_err() {
            break;
        }
    }
    for position in common::positions(&simulation) {
        assert!(position.is_finite(), "{position}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn any_scene_is_refused_or_stays_finite_or_stops(scene in any_scene(), method in 0usize..4) {
        stays_finite_or_stops::<f32>(&scene, Integrator::EXPLICIT[method]);
        stays_finite_or_stops::<f64>(&scene, Integrator::EXPLICIT[method]);
    }
}
