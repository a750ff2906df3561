//! Bad input: the refusal of every number and index out of its domain, and reports of divergence.

mod common;

use common::{simulation, two_masses};
use msd_core::glam::DVec3;
use msd_core::{
    Body, Error, Friction, Integrator, Material, Pin, Plane, Real, Scene, Settings, Simulation,
    State, shape,
};

fn refusal(change: impl FnOnce(&mut Scene)) -> String {
    let mut scene = two_masses([1.0, 1.0], 10.0, 0.0, 0.0);
    change(&mut scene);
    let made = Simulation::<f32>::new(&scene, Settings::default());
    made.expect_err("a scene that must be refused").to_string()
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
    // A step of thousands of millions of iterations would never end.
    let settings = Settings { newton: 1001, ..Settings::default() };
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

#[test]
fn a_state_that_does_not_fit_is_refused_and_nothing_changes() {
    let scene = two_masses([1.0, 1.0], 10.0, 0.0, 0.0);
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
    let mut scene = two_masses([1.0, 1.0], 10.0, 0.0, 0.0);
    let (normal, friction) = (DVec3::Y, Friction::Coulomb(0.0));
    scene.planes = vec![Plane { normal, offset: 2e6, restitution: 0.0, friction }];
    let error = Simulation::<f64>::new(&scene, Settings::default()).unwrap_err();
    let expected = "position of particle 0 is 2000000; it must be inside the world once the planes \
                    have pushed the particle out";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_normal_is_a_direction_however_long_it_is() {
    // The sum of its components overflows.
    let normal = DVec3::splat(f64::MAX);
    let mut scene = two_masses([1.0, 1.0], 10.0, 0.0, 0.0);
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
    let scene = two_masses([1.0, 1.0], 10.0, 0.0, 0.0);
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

#[test]
fn a_conversion_refuses_the_first_number_that_single_precision_cannot_hold() {
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = two_masses([1.0, 1.0], 10.0, 0.0, 0.0);
        change(&mut scene);
        let simulation = Simulation::<f64>::new(&scene, Settings::default()).expect("fits f64");
        simulation.convert::<f32>().map(drop).expect_err("does not fit f32").to_string()
    };
    let (normal, friction) = (DVec3::Y, Friction::Coulomb(0.0));
    let plane = Plane { normal, offset: -1e300, restitution: 0.0, friction };
    let message = refused(&|scene| scene.springs[0].rest_length = 1e300);
    assert_eq!(message, "rest length of spring 0 is 1e300; it must be finite and not negative");
    let message = refused(&|scene| scene.world.gravity.y = -1e300);
    assert_eq!(message, "gravity of world 0 is -1e300; it must be finite");
    let message = refused(&|scene| scene.world.drag = 1e300);
    assert_eq!(message, "drag of world 0 is 1e300; it must be finite and not negative");
    let message = refused(&|scene| scene.planes = vec![plane]);
    assert_eq!(message, "offset of plane 0 is -1e300; it must be finite");
    let message = refused(&|scene| scene.particles[1].velocity.z = 1e300);
    assert_eq!(message, "velocity of particle 1 is NaN; it must be finite");
}
