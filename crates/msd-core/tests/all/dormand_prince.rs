//! Tolerance, order and work of the adaptive method, with and without contact.

use crate::common::{distance, tumbling_block, two_masses};
use msd_core::elements::{Element, Motion, Vectors};
use msd_core::glam::{DMat3, DVec3};
use msd_core::{
    Error, Friction, Integrator, Material, Particle, Pin, Plane, Real, Scene, Settings, Simulation,
    State, Vector, shape,
};

const G: f64 = 9.82;

fn settings(step: f64, tolerance: f64) -> Settings {
    Settings { integrator: Integrator::DormandPrince, step, tolerance, ..Settings::default() }
}

fn simulation<R: Real>(scene: &Scene, step: f64, tolerance: f64) -> Simulation<R> {
    Simulation::new(scene, settings(step, tolerance)).expect("a valid scene")
}

fn run<R: Real>(scene: &Scene, (step, steps): (f64, usize), tolerance: f64) -> Simulation<R> {
    let mut simulation = simulation::<R>(scene, step, tolerance);
    for _ in 0..steps {
        simulation.step().expect("a tolerance within reach");
    }
    simulation
}

/// Runs to the end and returns the state in double precision.
fn state(scene: &Scene, time: (f64, usize), tolerance: f64) -> State<f64> {
    run::<f64>(scene, time, tolerance).state()
}

/// One particle above the plane y = 0.
fn ball(position: DVec3, velocity: DVec3, restitution: f64, friction: Friction) -> Scene {
    Scene {
        particles: vec![Particle { position, velocity, mass: 0.7 }],
        planes: vec![Plane { normal: DVec3::Y, offset: 0.0, restitution, friction }],
        ..Scene::default()
    }
}

const SMOOTH: Friction = Friction::Coulomb(0.0);

/// A block that turns as it falls on the plane y = 0.
fn falling_block(stiffness: f64, restitution: f64, friction: Friction) -> Scene {
    let material = Material { mass: 0.1, stiffness, damping: 0.5 };
    let mut part = shape::block([3, 3, 3], 0.5, material).unwrap();
    let turn = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(0.3);
    part.place(turn, DVec3::new(0.0, 1.2, 0.0));
    part.set_motion(DVec3::new(1.0, 0.0, 0.2), DVec3::new(0.0, 0.0, -1.0));
    let mut scene = Scene::of("block", part);
    scene.planes.push(Plane { normal: DVec3::Y, offset: 0.0, restitution, friction });
    scene
}

// Without contact.

#[test]
fn the_error_is_proportional_to_the_tolerance() {
    for damping in [0.0, 2.0] {
        let scene = tumbling_block(damping);
        let size = simulation::<f64>(&scene, 1.0, 1.0).model().size();
        let exact = state(&scene, (2.0, 1), 1e-13);
        let mut before = f64::INFINITY;
        for tolerance in [1e-3, 1e-5, 1e-7, 1e-9] {
            let error = distance(&state(&scene, (2.0, 1), tolerance), &exact) / size;
            // About w t = 20 substep errors of the size of the tolerance, less for local
            // extrapolation and damping.
            assert!(error <= 20.0 * tolerance, "{damping}, {tolerance}: {error}");
            // Two decades: the local error estimate is of order 5, so is the global error.
            let fall = before / error;
            assert!(15.0 <= fall, "{damping}, {tolerance}: error fell by {fall}");
            before = error;
        }
    }
}

#[test]
fn at_equal_substeps_the_order_is_five() {
    for damping in [0.0, 2.0] {
        let scene = tumbling_block(damping);
        // At tolerance 1 each step is a single substep.
        let go = |step: f64, steps: usize| {
            let done = run::<f64>(&scene, (step, steps), 1.0);
            assert_eq!(done.work().unwrap().substeps, steps as u64);
            done.state()
        };
        let exact = go(1.0 / 2048.0, 1024);
        let error = |steps: usize| distance(&go(0.5 / steps as f64, steps), &exact);
        let ratio = error(16) / error(32);
        // 2⁵, and the next order is not small yet.
        assert!((20.0..48.0).contains(&ratio), "{damping}: {ratio}");
    }
}

#[test]
fn a_free_particle_follows_the_parabola_to_rounding() {
    let scene = Scene { planes: vec![], ..ball(DVec3::Y, DVec3::new(1.0, 2.0, 3.0), 0.0, SMOOTH) };
    let done = run::<f64>(&scene, (1.0, 3), 1e-3);
    let exact = DVec3::Y + DVec3::new(3.0, 6.0 - 4.5 * G, 9.0);
    assert!((done.position(0) - exact).length() < 1e-13);
    assert_eq!(done.work().unwrap().substeps, 3);
}

#[test]
fn an_oscillator_follows_its_closed_form() {
    // Two masses of 2 kg: reduced mass 1, w² = 100 − 1, damped with rate 1.
    let scene = two_masses([2.0, 2.0], 100.0, 2.0, 0.1);
    let (w, t) = (99.0f64.sqrt(), 3.0f64);
    let stretch = 0.1 * (-t).exp() * ((w * t).cos() + (w * t).sin() / w);
    for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
        let done = run::<f64>(&scene, (1.0, 3), tolerance);
        let [a, b] = [0, 1].map(|particle| done.position(particle));
        let error = ((b - a).length() - 1.0 - stretch).abs();
        // The stretch is a tenth of the size, and damps earlier errors.
        assert!(error <= 3.0 * tolerance, "{tolerance}: {error}");
        // The energy that the damper took is an integral by the same weights.
        let energy = done.energy();
        let lost = 0.5 * 100.0 * 0.1 * 0.1 - (energy.kinetic + energy.elastic);
        // The damper takes 2 v² watts for a second, v from 1 m/s, off by tolerance / h, h < 0.1 s.
        let error = (energy.dissipated - lost).abs();
        assert!(error <= 100.0 * tolerance, "{tolerance}: {error}");
    }
}

#[test]
fn the_same_run_has_the_same_bits_and_resumes_from_its_state() {
    let scene = falling_block(500.0, 0.6, Friction::Coulomb(0.4));
    let whole = run::<f32>(&scene, (1.0 / 60.0, 90), 1e-4);
    assert_eq!(whole.state(), run::<f32>(&scene, (1.0 / 60.0, 90), 1e-4).state());
    let half = run::<f32>(&scene, (1.0 / 60.0, 45), 1e-4);
    let mut resumed = simulation::<f32>(&scene, 1.0 / 60.0, 1e-4);
    resumed.set_state(&half.state(), 45).unwrap();
    for _ in 45..90 {
        resumed.step().unwrap();
    }
    assert_eq!(whole.state(), resumed.state());
}

#[test]
fn a_step_split_in_two_agrees_within_the_tolerance() {
    let scene = tumbling_block(0.5);
    let size = simulation::<f64>(&scene, 1.0, 1.0).model().size();
    for tolerance in [1e-4, 1e-7] {
        let (whole, split) =
            (state(&scene, (1.0, 1), tolerance), state(&scene, (0.5, 2), tolerance));
        // Each is within ten tolerances of the truth.
        assert!(distance(&whole, &split) <= 20.0 * tolerance * size);
    }
}

// Contact.

/// Height of a ball dropped from 1 m at a time, metres.
fn height(restitution: f64, time: f64) -> f64 {
    let (mut at, mut speed) = ((2.0 / G).sqrt(), (2.0 * G).sqrt());
    if time < at {
        return 1.0 - 0.5 * G * time * time;
    }
    while 1e-9 < speed {
        speed *= restitution;
        let flight = 2.0 * speed / G;
        if time < at + flight {
            return speed * (time - at) - 0.5 * G * (time - at) * (time - at);
        }
        at += flight;
    }
    0.0
}

#[test]
fn a_bouncing_ball_follows_its_closed_form_and_comes_to_rest_on_the_plane() {
    for restitution in [0.0, 0.5, 0.8, 1.0] {
        for (step, steps) in [(1.0 / 60.0, 360), (2.0, 3)] {
            for tolerance in [1e-3, 1e-6, 1e-9] {
                let scene = ball(DVec3::Y, DVec3::ZERO, restitution, SMOOTH);
                let mut ball = simulation::<f64>(&scene, step, tolerance);
                for _ in 0..steps {
                    ball.step().unwrap();
                    let found = ball.position(0).y;
                    let error = (found - height(restitution, ball.time())).abs();
                    // An impact is located within a hundredth of the tolerance. Later bounces
                    // multiply the time shift of a bounce of speed v by up to their number.
                    assert!(error <= tolerance, "{restitution}, {tolerance}: {error}");
                }
                if restitution < 0.9 {
                    // The series of bounces ends after (1 + e) / (1 − e) √(2 h / g) < 5 s.
                    assert_eq!(ball.position(0), DVec3::ZERO);
                    assert_eq!(ball.velocity(0), DVec3::ZERO);
                }
            }
        }
    }
}

#[test]
fn a_bouncing_cube_keeps_the_tolerance() {
    let scene = falling_block(500.0, 0.6, Friction::Coulomb(0.4));
    let size = simulation::<f64>(&scene, 1.0, 1.0).model().size();
    let exact = state(&scene, (1.0 / 60.0, 60), 1e-11);
    for tolerance in [1e-3, 1e-5, 1e-7, 1e-9] {
        let done = run::<f64>(&scene, (1.0 / 60.0, 60), tolerance);
        let error = distance(&done.state(), &exact) / size;
        // Some 150 impacts, slides and releases in a row, each of which makes the ones after it
        // early or late; 4.6e-2 at 1e-3 where they are not located.
        assert!(error <= 300.0 * tolerance && error <= 1e-2, "{tolerance}: {error}");
        let work = done.work().unwrap();
        assert!(work.substeps <= 2000 && work.events <= 300, "{work:?}");
    }
}

#[test]
fn a_slide_ends_where_coulomb_says() {
    let (mu, speed) = (0.3, 2.0);
    let scene = ball(DVec3::ZERO, DVec3::new(speed, 0.0, 0.0), 0.5, Friction::Coulomb(mu));
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let done = run::<f64>(&scene, (0.25, 4), tolerance);
        let stop = speed * speed / (2.0 * mu * G);
        let [at, v] = [done.position(0), done.velocity(0)];
        assert_eq!((at.y, v), (0.0, DVec3::ZERO));
        // A slide that would end within a tenth of the tolerance has ended.
        assert!((at.x - stop).abs() <= 0.2 * tolerance, "{tolerance}: {} {stop}", at.x);
        let lost = 0.5 * 0.7 * speed * speed;
        assert!((done.dissipated() - lost).abs() <= 10.0 * tolerance);
    }
}

#[test]
fn on_a_slope_friction_decides_between_sticking_and_sliding() {
    let angle = 0.4f64;
    let normal = DVec3::new(angle.sin(), angle.cos(), 0.0);
    for mu in [0.0, 0.3, 0.41, 0.43, 0.6] {
        let mut scene = ball(DVec3::ZERO, DVec3::ZERO, 0.5, Friction::Coulomb(mu));
        scene.planes[0].normal = normal;
        let done = run::<f64>(&scene, (0.5, 4), 1e-8);
        let pull = G * (angle.sin() - mu * angle.cos());
        // 2 s of uniform acceleration down the slope, or none.
        let way = if pull < 0.0 { 0.0 } else { 2.0 * pull };
        let exact = DVec3::new(angle.cos(), -angle.sin(), 0.0) * way;
        let error = (done.position(0) - exact).length();
        // The slide is a parabola; only rounding is left.
        assert!(error <= 1e-11, "{mu}: {error}");
    }
}

#[test]
fn a_slide_up_a_slope_turns_or_stays() {
    let angle = 0.4f64;
    let up = DVec3::new(-angle.cos(), angle.sin(), 0.0);
    for mu in [0.2, 0.6] {
        let mut scene = ball(DVec3::ZERO, up * 3.0, 0.5, Friction::Coulomb(mu));
        scene.planes[0].normal = DVec3::new(angle.sin(), angle.cos(), 0.0);
        let done = run::<f64>(&scene, (2.0, 1), 1e-7);
        let (brake, pull) =
            (G * (angle.sin() + mu * angle.cos()), G * (angle.sin() - mu * angle.cos()));
        let (time, way) = (3.0 / brake, 4.5 / brake);
        let back = 0.5 * pull.max(0.0) * (2.0 - time) * (2.0 - time);
        let error = (done.position(0) - up * (way - back)).length();
        assert!(error <= 1e-7, "{mu}: {error}");
    }
}

#[test]
fn bounces_with_friction_take_as_much_as_the_weight_presses() {
    // Until it stops, the impulses of bounces, hops too low to be made and the weight at rest are
    // those of the weight alone: μ g t, from the start of the first bounce on.
    let (mu, e) = (0.1, 0.5);
    let scene = ball(DVec3::Y, DVec3::new(3.0, 0.0, 0.0), e, Friction::Coulomb(mu));
    let first = (2.0 / G).sqrt();
    let time = 3.0;
    let speed = 3.0 - mu * ((2.0 * G).sqrt() + G * (time - first));
    for tolerance in [1e-4, 1e-6, 1e-8] {
        let done = run::<f64>(&scene, (0.5, 6), tolerance);
        let error = (done.velocity(0).x - speed).abs();
        assert!(error <= tolerance, "{tolerance}: {error}");
    }
}

#[test]
fn a_body_comes_to_rest_on_a_plane_and_does_not_creep() {
    for friction in [Friction::Coulomb(0.5), Friction::TangentialLoss(0.3)] {
        let mut scene = falling_block(500.0, 0.3, friction);
        for spring in &mut scene.springs {
            spring.damping = 5.0;
        }
        let mut block = run::<f64>(&scene, (0.1, 100), 1e-6);
        let (before, work) = (block.state(), block.work().unwrap());
        let lowest = before.positions.iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
        // On the plane to rounding.
        assert!(lowest.abs() < 1e-15, "{lowest}");
        for _ in 0..10 {
            block.step().unwrap();
        }
        // The residual is an oscillation that the dampers take.
        assert!(distance(&block.state(), &before) < 1e-8);
        // Dampers limit the substep to some 10 ms; nothing is located any more.
        let now = block.work().unwrap();
        assert!(now.evaluations - work.evaluations <= 1000 && now.events == work.events);
    }
}

#[test]
fn corners_hold_what_falls_into_them() {
    let plane = |normal: DVec3| Plane {
        normal,
        offset: 0.0,
        restitution: 0.6,
        friction: Friction::Coulomb(0.2),
    };
    let corners = [
        vec![plane(DVec3::Y), plane(DVec3::X), plane(DVec3::Z)],
        vec![plane(DVec3::new(1.0, 0.3, 0.0)), plane(DVec3::new(-1.0, 0.4, 0.0))],
        vec![plane(DVec3::Y), plane(DVec3::new(0.8, -0.6, 0.0)), plane(DVec3::Z)],
    ];
    for planes in corners {
        let start = DVec3::new(1.0, 4.0, 0.5);
        let velocity = DVec3::new(-2.0, 0.0, -1.0);
        let mut scene = ball(start, velocity, 0.5, SMOOTH);
        scene.planes = planes;
        let mut ball = simulation::<f64>(&scene, 0.1, 1e-5);
        for _ in 0..100 {
            ball.step().unwrap();
            for plane in ball.model().planes() {
                let d = plane.normal.dot(ball.position(0)) - plane.offset;
                assert!(-1e-5 <= d, "{d} in {scene:?}");
            }
        }
        assert_eq!(ball.velocity(0), DVec3::ZERO);
    }
}

#[test]
fn a_particle_put_inside_a_plane_comes_out() {
    let mut ball = simulation::<f64>(&ball(DVec3::Y, DVec3::ZERO, 0.5, SMOOTH), 1.0 / 60.0, 1e-4);
    let inside = DVec3::new(0.0, -3.0, 0.0);
    let state = State { positions: vec![inside], velocities: vec![DVec3::ZERO] };
    ball.set_state(&state, 0).unwrap();
    ball.step().unwrap();
    assert_eq!(ball.position(0), DVec3::ZERO);
}

#[test]
fn planes_do_not_touch_what_is_pinned() {
    let mut scene = ball(DVec3::Y, DVec3::ZERO, 0.5, SMOOTH);
    scene.pins.push(Pin { particle: 0, velocity: -DVec3::Y });
    let done = run::<f64>(&scene, (0.5, 4), 1e-4);
    assert!((done.position(0) + DVec3::Y).length() < 1e-14);
    assert_eq!(done.work().unwrap().events, 0);
}

#[test]
fn elastic_bounces_without_friction_keep_the_energy() {
    let mut scene = falling_block(500.0, 1.0, SMOOTH);
    for spring in &mut scene.springs {
        spring.damping = 0.0;
    }
    for tolerance in [1e-6, 1e-8] {
        let mut block = simulation::<f64>(&scene, 0.1, tolerance);
        let mechanical = |block: &Simulation<f64>| block.energy().total() - block.dissipated();
        let before = mechanical(&block);
        for _ in 0..100 {
            block.step().unwrap();
        }
        let change = (mechanical(&block) - before).abs() / before;
        // Nothing is damped: at worst the errors of all substeps add up, squared in the energy.
        let work = block.work().unwrap();
        assert!(change <= 2.0 * work.substeps as f64 * tolerance, "{tolerance}: {change}");
        assert!(100 < work.events, "{work:?}");
    }
}

#[test]
fn verlet_with_short_substeps_converges_to_it() {
    let scene = falling_block(500.0, 0.6, Friction::Coulomb(0.4));
    let exact = state(&scene, (1.0 / 60.0, 40), 1e-9);
    let [rough, fine] = [20, 320].map(|substeps| {
        let settings = Settings { substeps, ..Settings::default() };
        let mut verlet = Simulation::<f64>::new(&scene, settings).unwrap();
        for _ in 0..40 {
            verlet.step().unwrap();
        }
        distance(&verlet.state(), &exact)
    });
    // Contact at the end of substeps is of first order, a sixteenth; which impacts fall early in a
    // substep is chance.
    assert!(fine < rough / 8.0, "{fine}, before {rough}");
    assert!(fine < 2e-3 * simulation::<f64>(&scene, 1.0, 1.0).model().size());
}

#[test]
fn single_precision_keeps_what_it_can() {
    let scene = tumbling_block(0.5);
    let exact = state(&scene, (2.0, 1), 1e-11);
    for tolerance in [1e-3, 1e-5, 1e-12] {
        let done = run::<f32>(&scene, (2.0, 1), tolerance);
        let error = distance(&done.state().convert(), &exact);
        // The tolerance is at least 64 roundings, 7.6e-6; the size is 3.5 m.
        let kept = f64::max(tolerance, 64.0 * f64::from(f32::EPSILON));
        assert!(error <= 10.0 * 3.5 * kept, "{tolerance}: {error}");
    }
    let scene = falling_block(500.0, 0.6, Friction::Coulomb(0.4));
    let exact = state(&scene, (1.0 / 60.0, 60), 1e-10);
    let done = run::<f32>(&scene, (1.0 / 60.0, 60), 1e-5);
    let error = distance(&done.state().convert(), &exact);
    // As in double precision, see above; the size is 1.7 m.
    assert!(error <= 1.7 * 300.0 * 1e-5, "{error}");
}

#[test]
fn absurd_scenes_end_in_a_state_or_an_error() {
    let absurd = |stiffness: f64, damping: f64, speed: f64| {
        let material = Material { mass: 1e-3, stiffness, damping };
        let mut part = shape::rope(2, 1.0, material).unwrap();
        part.set_motion(DVec3::new(speed, -speed, 0.0), DVec3::ONE);
        let mut scene = Scene::of("rope", part);
        let friction = Friction::Coulomb(0.5);
        for (normal, restitution) in [(DVec3::Y, 1.0), (-DVec3::Y, 1.0), (DVec3::X, 0.0)] {
            scene.planes.push(Plane { normal, offset: -1.0, restitution, friction });
        }
        scene
    };
    for (stiffness, damping, speed, tolerance) in [
        (1e12, 0.0, 1.0, 1e-14),
        (1e12, 0.0, 1e6, 1.0),
        (1e6, 1e12, 1.0, 1e-14),
        (1e6, 1e12, 1.0, 1.0),
        (100.0, 0.1, 1e6, 1.0),
    ] {
        let scene = absurd(stiffness, damping, speed);
        let mut rope = simulation::<f64>(&scene, 1.0 / 60.0, tolerance);
        let before = rope.state();
        match rope.step() {
            Ok(()) => {}
            Err(Error::Unreachable { .. } | Error::Diverged(_)) => {
                assert_eq!(rope.state(), before);
            }
            Err(other) => panic!("{other}"),
        }
        // The bound on attempts, seven evaluations each and at most two more per event.
        assert!(rope.work().unwrap().evaluations <= 8_000_000);
    }
}

/// A force of NaN.
#[derive(Debug)]
struct Broken;

impl<R: Real> Element<R> for Broken {
    fn add_forces(&self, _: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        forces.add(0, R::Vec3::of(DVec3::NAN));
        0.0
    }
}

#[test]
fn a_tolerance_out_of_reach_is_an_error_that_says_so() {
    // A NaN force cannot be integrated.
    let scene = Scene { planes: vec![], ..ball(DVec3::Y, DVec3::ZERO, 0.5, SMOOTH) };
    let mut ball = simulation::<f64>(&scene, 0.1, 1e-4);
    ball.step().unwrap();
    let before = ball.state();
    let broken = ball.add_element(Broken);
    let error = ball.step().unwrap_err();
    let Error::Unreachable { tolerance, particle, step, time } = error else { panic!("{error}") };
    assert_eq!((tolerance, particle, step, time), (1e-4, 0, 2, 0.1));
    assert!(error.to_string().contains("larger tolerance"), "{error}");
    assert_eq!(ball.state(), before);
    // The next step is not spoiled.
    assert!(ball.remove_element(broken));
    ball.step().unwrap();
}

#[test]
fn a_step_that_takes_more_evaluations_than_it_may_fails_and_keeps_the_state() {
    let scene = falling_block(1e8, 0.3, Friction::Coulomb(0.5));
    let mut block = simulation::<f64>(&scene, 1.0 / 60.0, 1e-9);
    let mut free = block.clone();
    let before = block.state();
    block.set_most_evaluations(50);
    let error = block.step().unwrap_err();
    let Error::TooManyEvaluations { most, done, step, .. } = error else { panic!("{error}") };
    assert_eq!((most, step, block.steps()), (50, 1, 0));
    assert!((0.0..1.0).contains(&done) && error.is_of_step(), "{error}");
    assert_eq!(block.state(), before);
    // The bound, and the excess of the last attempt.
    assert!(block.work().unwrap().evaluations <= 50 + 8);
    // A bound that is not reached changes no bit.
    block.set_most_evaluations(10_000_000);
    block.step().unwrap();
    free.step().unwrap();
    assert_eq!(block.state(), free.state());
}
