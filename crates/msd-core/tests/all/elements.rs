//! Elements and obstacles, built in and user-defined, under the checks of `msd_core::testing`.

use crate::common::{Random, random_scene, two_masses};
use msd_core::elements::springs::Springs;
use msd_core::elements::{Element, Motion, Vectors};
use msd_core::glam::DVec3;
use msd_core::obstacles::Obstacle;
use msd_core::{
    Integrator, Interaction, Particle, Pin, Real, Scene, Settings, Simulation, State, Vector,
    testing,
};
use proptest::prelude::*;

/// Springs to the origin of 3 N/m, with a damper of 0.2 N s/m.
#[derive(Debug)]
struct Bowl;

impl<R: Real> Element<R> for Bowl {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let mut power = 0.0;
        for particle in 0..motion.particle_count() {
            let (x, v) = (motion.position(particle), motion.velocity(particle));
            forces.add(particle, x * R::of(-3.0) - v * R::of(0.2));
            power += 0.2 * v.to_f64().length_squared();
        }
        power
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        motion.positions().map(|x| 1.5 * x.to_f64().length_squared()).sum()
    }
}

/// The springs alone of a scene, and its state.
fn springs(scene: &Scene) -> (Springs<f64>, State<f64>) {
    // One body and few particles, as the checks have it: the springs fit the slots of the checks.
    let simulation = Simulation::<f64>::new(scene, Settings::default()).expect("a valid scene");
    (simulation.model().springs().clone(), simulation.state())
}

/// A scene whose springs are those of a lattice, stretched at random.
fn shaken(seed: u64) -> Scene {
    let material = msd_core::Material { mass: 1.0, stiffness: 20.0, damping: 0.7 };
    let part = msd_core::shape::block([3, 4, 2], 1.0, material).expect("small");
    let mut scene = Scene::of("block", part);
    let mut random = Random(seed | 1);
    for particle in &mut scene.particles {
        particle.position += (random.vector() - 0.5) * 0.3;
        particle.velocity = random.vector() - 0.5;
    }
    scene
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn springs_pass_every_check(seed in any::<u64>()) {
        let (springs, state) = springs(&shaken(seed));
        let checks = [
            testing::check_gradient(&springs, &state),
            testing::check_products(&springs, &state),
            testing::check_reaction(&springs, &state),
            testing::check_rotation(&springs, &state),
        ];
        for check in checks {
            prop_assert_eq!(check, Ok(()));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Gravity, a uniform force and drag; a grab that is free and one at its largest force; a push.
    #[test]
    fn fields_grabs_and_pushes_pass_every_check(seed in any::<u64>()) {
        let mut random = Random(seed | 1);
        let mut vector = || random.vector() * 2.0 - 1.0;
        let mut scene = shaken(seed);
        (scene.world.gravity, scene.world.force, scene.world.drag) = (vector(), vector(), 0.3);
        let mut simulation = Simulation::<f64>::new(&scene, Settings::default()).expect("valid");
        let grab = |particle, target, max_force| {
            Interaction::Grab { particle, target, frequency: 0.3, damping_ratio: 0.7, max_force }
        };
        // At 0.3 Hz and 1 kg 3.6 N/m: a pull of 40 N ends 11 m away, one of 0.1 N at 3 cm.
        let far = DVec3::splat(5.0);
        let push = Interaction::Push { particle: 7, force: vector() };
        for interaction in [grab(3, vector(), 40.0), grab(11, far, 0.1), push] {
            simulation.queue(interaction).expect("a valid interaction");
        }
        simulation.apply_queued().expect("nothing overflows");
        let state = simulation.state();
        let elements: Vec<_> = simulation.model().elements_beside_springs().collect();
        prop_assert_eq!(elements.len(), 5);
        for element in elements {
            prop_assert_eq!(testing::check_gradient(element, &state), Ok(()));
        }
        simulation.queue(Interaction::Release { particle: 11 }).expect("it is held");
        simulation.apply_queued().expect("nothing overflows");
        // The largest force is taken as constant by the implicit methods, its turning left out.
        for element in simulation.model().elements_beside_springs() {
            prop_assert_eq!(testing::check_products(element, &state), Ok(()));
        }
    }
}

#[test]
fn an_element_of_a_callers_own_passes_the_checks_it_should_and_no_other() {
    let state = State {
        positions: vec![DVec3::new(0.3, -0.2, 0.9), DVec3::new(1.0, 2.0, -0.4)],
        velocities: vec![DVec3::X, DVec3::new(0.1, 0.2, 0.3)],
    };
    assert_eq!(testing::check_gradient(&Bowl, &state), Ok(()));
    assert_eq!(testing::check_products(&Bowl, &state), Ok(()));
    assert_eq!(testing::check_rotation(&Bowl, &state), Ok(()));
    assert!(testing::check_reaction(&Bowl, &state).is_err());
}

/// A wrong element: its energy is half of that of its forces.
#[derive(Debug)]
struct Wrong;

impl<R: Real> Element<R> for Wrong {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        Bowl.add_forces(motion, forces)
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        0.5 * Element::<R>::energy(&Bowl, motion)
    }
}

#[test]
fn a_wrong_element_is_found() {
    let state = State { positions: vec![DVec3::ONE], velocities: vec![DVec3::ZERO] };
    let error = testing::check_gradient(&Wrong, &state).unwrap_err();
    assert!(error.contains("work of the forces"), "{error}");
}

/// The frequency of one particle in the bowl, by every method that takes elements.
#[test]
fn every_method_an_energy_and_the_stable_step_see_an_element_of_a_callers_own() {
    let mut scene = two_masses([1.0, 1.0], 0.0, 0.0, 0.0);
    scene.particles.truncate(1);
    scene.springs.clear();
    scene.particles[0].position = DVec3::X;
    for integrator in Integrator::ALL {
        let settings = Settings { integrator, substeps: 200, ..Settings::default() };
        let mut simulation = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
        simulation.add_element(Bowl);
        let start = simulation.energy();
        assert!((start.own - 1.5).abs() < 1e-12, "{integrator}: {start:?}");
        for _ in 0..60 {
            simulation.step().expect("a calm run");
        }
        // x'' = −3 x − 0.2 x': w² = 3 − 0.01.
        let (w, t) = (2.99f64.sqrt(), 1.0);
        let exact = (-0.1f64 * t).exp() * ((w * t).cos() + 0.1 / w * (w * t).sin());
        let error = (simulation.position(0).x - exact).abs();
        // First-order methods at h = 1/12000 s.
        assert!(error < 3e-4, "{integrator}: {error}");
        let balance = simulation.energy().total() - start.total();
        let tolerance = match integrator {
            // Its numerical damping is not booked.
            Integrator::BackwardEuler | Integrator::Xpbd => 1e-3,
            // Euler adds E w² h t = 3.8e-4 J.
            _ => 4e-4,
        };
        assert!(balance.abs() < tolerance, "{integrator}: {balance}");
    }
    let mut simulation =
        Simulation::<f64>::new(&scene, Settings::default()).expect("a valid scene");
    assert_eq!(simulation.stable_substep(), f64::INFINITY);
    let handle = simulation.add_element(Bowl);
    // Verlet bears about 2 / w, a little less with a damper.
    let limit = simulation.stable_substep();
    assert!((limit / (2.0 / 3f64.sqrt()) - 1.0).abs() < 0.1, "{limit}");
    assert!(simulation.remove_element(handle) && !simulation.remove_element(handle));
    assert_eq!(simulation.stable_substep(), f64::INFINITY);
}

/// A constant force that reports the energy it supplies.
#[derive(Debug)]
struct Thrust;

impl<R: Real> Element<R> for Thrust {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        forces.add(0, R::Vec3::of(DVec3::X));
        -motion.velocity(0).to_f64().x
    }
}

#[test]
fn what_an_element_gives_is_no_gain_of_the_integrator() {
    let scene =
        Scene { world: crate::common::weightless(), ..two_masses([1.0, 1.0], 50.0, 0.1, 0.0) };
    for integrator in Integrator::ALL {
        let settings = Settings { integrator, ..Settings::default() };
        let mut pair = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
        pair.add_element(Thrust);
        let mut witness = msd_core::Witness::default();
        for _ in 0..600 {
            pair.step().expect("a calm run");
            witness.watch(&pair);
        }
        // Two kilograms under 1 N for 10 s.
        let given = pair.given();
        assert!((given - 25.0).abs() < 0.5, "{integrator}: {given} J");
        assert_eq!(witness.gain(), 0.0, "{integrator}");
    }
}

/// A well of 3 N/m without a damper.
#[derive(Debug)]
struct Well;

impl<R: Real> Element<R> for Well {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        forces.add(0, motion.position(0) * R::of(-3.0));
        0.0
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        1.5 * motion.position(0).to_f64().length_squared()
    }
}

/// Kinetic energy that comes out of an element does not count as a gain, but for explicit Euler's
/// own.
#[test]
fn what_a_conservative_element_gives_back_is_no_gain_of_the_integrator() {
    let mut scene = two_masses([1.0, 1.0], 50.0, 0.0, 0.1);
    scene.particles[0].position += DVec3::X;
    for integrator in Integrator::ALL {
        let settings = Settings { integrator, ..Settings::default() };
        let mut pair = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
        pair.add_element(Well);
        let mut witness = msd_core::Witness::default();
        for _ in 0..6000 {
            pair.step().expect("a calm run");
            witness.watch(&pair);
        }
        assert_eq!(pair.given(), 0.0, "{integrator}");
        let gains = integrator == Integrator::ExplicitEuler;
        assert_eq!(0.0 < witness.gain(), gains, "{integrator}: {} J", witness.gain());
    }
}

/// A ball of 1 m about a point that moves along x at 0.5 m/s.
#[derive(Debug)]
struct Ball;

impl<R: Real> Obstacle<R> for Ball {
    fn gap(&self, position: R::Vec3, time: f64) -> R {
        R::of((position.to_f64() - DVec3::X * (0.5 * time)).length() - 1.0)
    }

    fn normal(&self, position: R::Vec3, time: f64) -> R::Vec3 {
        R::Vec3::of((position.to_f64() - DVec3::X * (0.5 * time)).normalize())
    }

    fn velocity(&self, _: R::Vec3, _: f64) -> R::Vec3 {
        R::Vec3::of(DVec3::X * 0.5)
    }
}

#[test]
fn obstacles_pass_their_check() {
    let mut random = Random(11);
    let points: Vec<DVec3> = (0..50).map(|_| (random.vector() - 0.5) * 4.0).collect();
    assert_eq!(testing::check_obstacle(&Ball, &points, 0.7), Ok(()));
    let plane = msd_core::Plane {
        normal: DVec3::new(1.0, 2.0, -2.0),
        offset: 0.3,
        restitution: 0.5,
        friction: msd_core::Friction::Coulomb(0.2),
    };
    let scene = Scene { planes: vec![plane], ..shaken(1) };
    let simulation = Simulation::<f64>::new(&scene, Settings::default()).expect("a valid scene");
    assert_eq!(testing::check_obstacle(&simulation.model().planes()[0], &points, 0.0), Ok(()));
}

/// A particle slides off a smooth sphere where cos = 2/3, under every method that is accurate
/// enough to show it; no method lets it in.
#[test]
fn a_particle_leaves_a_sphere_at_two_thirds_of_its_height() {
    #[derive(Debug)]
    struct Still;
    impl<R: Real> Obstacle<R> for Still {
        fn gap(&self, position: R::Vec3, _: f64) -> R {
            R::of(position.to_f64().length() - 1.0)
        }
        fn normal(&self, position: R::Vec3, _: f64) -> R::Vec3 {
            R::Vec3::of(position.to_f64().normalize())
        }
    }
    let mut scene = two_masses([1.0, 1.0], 0.0, 0.0, 0.0);
    scene.particles.truncate(1);
    scene.springs.clear();
    scene.world = Default::default();
    // From an angle of 0.1 rad: m g (cos 0.1 − cos θ) = m v²/2, and it leaves where v² = g cos θ.
    scene.particles[0].position = DVec3::new(0.1f64.sin(), 0.1f64.cos(), 0.0);
    let leaves = 2.0 / 3.0 * 0.1f64.cos();
    for integrator in Integrator::ALL {
        let (step, substeps) = (1e-3, if integrator.is_adaptive() { 1 } else { 10 });
        let settings = Settings { integrator, step, substeps, ..Settings::default() };
        let mut simulation = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
        simulation.add_obstacle(Still).expect("inside the world");
        let mut last = 1.0;
        for _ in 0..2000 {
            simulation.step().expect("a calm run");
            let position = simulation.position(0);
            assert!(-1e-3 < position.length() - 1.0, "{integrator}: {position}");
            if position.length() < 1.0 + 1e-4 {
                last = position.y;
            }
        }
        // 0.1 mm above the surface is some hundredths of a radian after it was left.
        assert!((last - leaves).abs() < 0.05, "{integrator}: {last}, exactly {leaves}");
    }
}

/// A floor at y = 0 that fails a test where it is asked about a point with no moving particle.
#[derive(Debug)]
struct Asked;

/// Moving particles are at x of more than this, metres.
const MOVING: f64 = 1.0;

impl Asked {
    fn seen<R: Real>(position: R::Vec3) -> DVec3 {
        let position = position.to_f64();
        assert!(MOVING < position.x, "asked about {position}, where no particle moves");
        position
    }
}

impl<R: Real> Obstacle<R> for Asked {
    fn gap(&self, position: R::Vec3, _: f64) -> R {
        R::of(Asked::seen::<R>(position).y)
    }
    fn normal(&self, position: R::Vec3, _: f64) -> R::Vec3 {
        Asked::seen::<R>(position);
        R::Vec3::of(DVec3::Y)
    }
    fn velocity(&self, position: R::Vec3, _: f64) -> R::Vec3 {
        Asked::seen::<R>(position);
        R::Vec3::ZERO
    }
}

/// An obstacle ignores pinned particles, inside and outside, and the empty lanes of a record, which
/// are at the origin.
#[test]
fn an_obstacle_is_asked_about_moving_particles_alone() {
    // 19 particles: a record and three lanes of another.
    let mut scene = Scene::default();
    for number in 0..19 {
        let is_pinned = number % 3 == 0;
        let x = if is_pinned { -2.0 } else { 2.0 } * MOVING;
        let position = DVec3::new(x, 0.002 * f64::from(number - 9), f64::from(number));
        let position = if is_pinned { position } else { position.with_y(position.y.abs()) };
        scene.particles.push(Particle { position, velocity: DVec3::ZERO, mass: 1.0 });
        if is_pinned {
            scene.pins.push(Pin { particle: number as usize, velocity: DVec3::ZERO });
        }
    }
    fn run<R: Real>(scene: &Scene, settings: Settings) {
        let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
        simulation.add_obstacle(Asked).expect("inside the world");
        let mut contacts = 0;
        for _ in 0..10 {
            simulation.step().expect("a calm run");
            contacts += simulation.contacts().count;
        }
        assert!(0 < contacts, "{}: nothing fell on the floor", settings.integrator);
    }
    for integrator in Integrator::ALL {
        let settings = Settings { integrator, ..Settings::default() };
        run::<f32>(&scene, settings);
        run::<f64>(&scene, settings);
    }
}

#[test]
fn what_is_added_while_running_is_what_a_scene_with_it_has() {
    let scene = random_scene(5);
    let mut grown = Simulation::<f64>::new(
        &Scene { particles: scene.particles[..1].to_vec(), springs: vec![], ..scene.clone() },
        Settings::default(),
    )
    .expect("a valid scene");
    for &particle in &scene.particles[1..] {
        grown.add_particle(particle).expect("a valid particle");
    }
    for (row, &spring) in scene.springs.iter().enumerate() {
        assert_eq!(grown.add_spring(spring), Ok(row));
    }
    let mut whole = Simulation::<f64>::new(&scene, Settings::default()).expect("a valid scene");
    for _ in 0..10 {
        grown.step().expect("soft");
        whole.step().expect("soft");
    }
    assert_eq!(
        crate::common::state_bits(&grown.state()),
        crate::common::state_bits(&whole.state())
    );
}

#[test]
fn what_is_removed_pulls_no_more_and_weighs_nothing() {
    let scene = Scene { world: Default::default(), ..two_masses([1.0, 3.0], 50.0, 0.0, 0.5) };
    let mut pair = Simulation::<f64>::new(&scene, Settings::default()).expect("a valid scene");
    pair.queue(Interaction::Push { particle: 1, force: DVec3::X }).expect("a valid push");
    pair.remove_particle(1).expect("there is one");
    pair.step().expect("a calm run");
    assert_eq!(pair.model().spring_count(), 0);
    assert!((pair.velocity(0) - DVec3::Y * (-9.82 / 60.0)).length() < 1e-12);
    assert_eq!((pair.velocity(1), pair.energy().elastic), (DVec3::ZERO, 0.0));
    assert!(pair.remove_particle(2).is_err() && pair.remove_spring(1).is_err());
    // It resumes from a checkpoint to the bit.
    let (rows, progress) = pair.progress();
    let mut resumed = Simulation::<f64>::resume(&rows, &progress).expect("a run of ours");
    pair.step().expect("a calm run");
    resumed.step().expect("a calm run");
    assert_eq!(pair.state(), resumed.state());
}

/// A force away from the origin, stiffer than a substep bears.
#[derive(Debug)]
struct Repulsion;

impl<R: Real> Element<R> for Repulsion {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        forces.add(0, motion.position(0) * R::of(1e5));
        0.0
    }
}

#[test]
fn what_repels_one_particle_does_not_take_gravity_from_the_others() {
    let mut scene = two_masses([1.0, 1.0], 0.0, 0.0, 0.0);
    scene.world = Default::default();
    let settings = Settings { integrator: Integrator::BackwardEuler, ..Settings::default() };
    let mut pair = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
    pair.add_element(Repulsion);
    pair.step().expect("one step stays in the world");
    // Free fall for a step, to the tolerance of the solve.
    let fallen = pair.velocity(1).y;
    assert!((fallen + 9.82 / 60.0).abs() < 2e-3, "{fallen}");
}

#[test]
fn a_run_that_diverged_goes_on_with_a_shorter_step() {
    let material = msd_core::Material { mass: 1e-3, stiffness: 1e6, damping: 0.0 };
    let mut scene = Scene::of("cloth", msd_core::shape::cloth([4, 4], 1.0, material).unwrap());
    scene.particles[0].position.x += 0.3;
    let settings = Settings { substeps: 400, ..Settings::default() };
    let mut cloth = Simulation::<f32>::new(&scene, settings).expect("a valid scene");
    assert!(cloth.step().is_err());
    let before = cloth.state();
    let fine = Settings { step: 1e-4, substeps: 100, ..settings };
    cloth.set_settings(fine).expect("a valid step");
    cloth.step().expect("a stable step");
    // As if it had never diverged.
    let mut other = Simulation::<f32>::new(&scene, fine).expect("a valid scene");
    other.set_state(&before, 0).expect("a state of this scene");
    other.step().expect("a stable step");
    assert_eq!(
        crate::common::state_bits(&cloth.state()),
        crate::common::state_bits(&other.state())
    );
}

#[test]
fn a_plane_that_would_push_a_particle_out_of_the_world_is_refused_and_nothing_is_removed_twice() {
    let scene = two_masses([1.0, 1.0], 50.0, 0.0, 0.0);
    let mut pair = Simulation::<f64>::new(&scene, Settings::default()).expect("a valid scene");
    let before = pair.state();
    let plane = msd_core::Plane {
        normal: DVec3::Y,
        offset: 1e9,
        restitution: 0.0,
        friction: msd_core::Friction::Coulomb(0.0),
    };
    assert!(pair.add_plane(&plane).is_err());
    assert_eq!((pair.state(), pair.model().planes().len()), (before, 0));
    pair.queue(Interaction::Pin { particle: 0, velocity: DVec3::X }).expect("a valid pin");
    pair.remove_particle(0).expect("there is one");
    pair.remove_particle(0).expect("it keeps its number");
    pair.step().expect("a calm run");
    assert_eq!(pair.velocity(0), DVec3::ZERO);
    assert_eq!(pair.given(), 0.0);
}
