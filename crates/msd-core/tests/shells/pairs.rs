//! Laws of two shells that meet: restitution, friction by pair, points, and shells that are set.

use super::{ALL, G, crossings, cubes, run, shell, start};
use msd_core::glam::{DVec3, dvec3};
use msd_core::scene::Between;
use msd_core::{
    Instructions, Integrator, Particle, Pin, Real, Scene, Settings, Shape, Shell, ShellPassage,
    Simulation, Solid, Vector, World,
};

fn weightless() -> World {
    World { gravity: DVec3::ZERO, ..World::default() }
}

/// The residual of a velocity that the rows of a method take away, as a part of it: iterative
/// solves stop at a hundredth.
fn left_by(integrator: Integrator) -> f64 {
    if integrator.is_implicit() { 1e-2 } else { 1e-12 }
}

fn point(at: usize, thickness: f64) -> Shell {
    Shell { points: vec![at], ..shell(thickness, 0.0) }
}

/// Two balls that fly at each other head on, a metre apart.
fn balls(restitution: f64) -> Scene {
    let ball = |x: f64, speed: f64, mass| Particle {
        position: dvec3(x, 0.0, 0.0),
        velocity: dvec3(speed, 0.0, 0.0),
        mass,
    };
    let particles = vec![ball(-0.5, 1.0, 0.2), ball(0.5, -2.0, 0.3)];
    let shells = vec![Shell { restitution, ..point(0, 0.05) }, point(1, 0.05)];
    Scene { world: weightless(), particles, shells, ..Scene::default() }
}

#[test]
fn balls_part_at_the_speed_of_the_closed_form() {
    for restitution in [0.0, 0.5, 1.0] {
        for integrator in ALL {
            let mut simulation = start::<f64>(&balls(restitution), integrator, 8);
            run(&mut simulation, 0.5);
            let [a, b] = [0, 1].map(|at| simulation.velocity(at).x);
            // m u + m' u' stays, and u' − u turns about, times e.
            let centre = (0.2 * 1.0 - 0.3 * 2.0) / 0.5;
            let right = [centre - 0.6 * 3.0 * restitution, centre + 0.4 * 3.0 * restitution];
            let off = (a - right[0]).abs().max((b - right[1]).abs());
            let most = 3.0 * left_by(integrator);
            assert!(off < most, "{integrator}, e = {restitution}: {a} and {b}, not {right:?}");
            // Half the reduced mass times the loss of the square of the speed.
            let lost = 0.5 * 0.12 * 9.0 * (1.0 - restitution * restitution);
            let booked = simulation.dissipated();
            // The energy m v²/2 of 3 m/s and 0.12 kg, twice as sensitive as the speed.
            let most = 4.0 * 0.54 * left_by(integrator);
            assert!((booked - lost).abs() < most, "{integrator}: {booked} J of {lost} J");
        }
    }
}

#[test]
fn restitution_of_a_pair_stands_in_place_of_that_of_both() {
    let mut scene = balls(1.0);
    let between = Between { shell: 0, friction: None, restitution: Some(0.25) };
    scene.shells[1].between.push(between);
    let mut simulation = start::<f64>(&scene, Integrator::VelocityVerlet, 8);
    run(&mut simulation, 0.5);
    let parting = simulation.velocity(1).x - simulation.velocity(0).x;
    assert!((parting - 0.75).abs() < 1e-12, "{parting}");
}

/// A ball that lies on a pinned triangle, on a slope of one in ten.
fn on_a_slope(friction: [f64; 2], between: Option<f64>) -> Scene {
    let corner = |x, z| Particle { position: dvec3(x, 0.0, z), velocity: DVec3::ZERO, mass: 1.0 };
    let mut particles = vec![corner(-2.0, -2.0), corner(4.0, -2.0), corner(-2.0, 4.0)];
    particles.push(Particle { position: dvec3(0.0, 0.1 + 1e-6, 0.0), ..corner(0.0, 0.0) });
    let plate = Shell { triangles: vec![[0, 1, 2]], ..shell(0.06, friction[0]) };
    let mut ball = Shell { friction: friction[1], ..point(3, 0.04) };
    let said =
        between.map(|factor| Between { shell: 0, friction: Some(factor), restitution: None });
    ball.between.extend(said);
    let pins = (0..3).map(|particle| Pin { particle, velocity: DVec3::ZERO }).collect();
    let world = World { gravity: dvec3(0.1 * G, -G, 0.0), ..World::default() };
    Scene { world, particles, pins, shells: vec![plate, ball], ..Scene::default() }
}

#[test]
fn friction_of_a_pair_is_the_mean_of_both_or_what_is_said_of_it() {
    for (friction, between, factor) in [
        ([0.05, 0.05], None, 0.05),
        // √(a b).
        ([0.02, 0.08], None, 0.04),
        ([0.5, 0.5], Some(0.03), 0.03),
        ([0.0, 0.0], Some(0.2), 0.1),
    ] {
        let scene = on_a_slope(friction, between);
        for integrator in ALL {
            let mut simulation = start::<f64>(&scene, integrator, 16);
            run(&mut simulation, 0.5);
            let (position, velocity) = (simulation.position(3), simulation.velocity(3));
            let right = (0.1 - factor) * G * 0.5;
            // It lies down in the first substeps, from a micrometre above: 1e-5 m/s.
            let off = (velocity.x - right).abs();
            let most = 1e-5 + left_by(integrator) * right.abs();
            assert!(off < most, "{integrator} {friction:?} {between:?}: {velocity}, not {right}");
            // Its heat is the work of friction, μ m G times the way, to two substeps of it, and its
            // loss as it lies down, having fallen for two.
            let heat = factor * G * position.x;
            let booked = simulation.dissipated();
            let most = 2.0 * factor * G * velocity.x / 960.0 + 2.0 * (G / 960.0).powi(2);
            assert!((booked - heat).abs() <= most, "{integrator}: {booked} J of {heat} J");
            assert!((position.y - 0.1).abs() < 2e-6, "{integrator}: at {}", position.y);
        }
    }
}

/// Balls that fall between those of a row, which is pinned, and a rope that catches one.
#[test]
fn points_lie_on_points_and_on_edges() {
    let at = |x, y| Particle { position: dvec3(x, y, 0.0), velocity: DVec3::ZERO, mass: 0.1 };
    let mut particles: Vec<_> = (0..4).map(|at_x| at(0.1 * f64::from(at_x), 0.0)).collect();
    particles.extend([at(0.15, 0.2), at(1.0, 0.0), at(2.0, 0.0), at(1.4, 0.2)]);
    let row = Shell { points: vec![0, 1, 2, 3], ..shell(0.05, 0.0) };
    let rope = Shell { edges: vec![[5, 6]], ..shell(0.05, 0.5) };
    let shells = vec![row, point(4, 0.05), rope, Shell { friction: 0.5, ..point(7, 0.05) }];
    let pins = [0, 1, 2, 3, 5, 6].map(|particle| Pin { particle, velocity: DVec3::ZERO }).to_vec();
    let scene = Scene { particles, pins, shells, ..Scene::default() };
    for integrator in ALL {
        let mut simulation = start::<f64>(&scene, integrator, 16);
        run(&mut simulation, 2.0);
        // On two that are as far apart as the ball is wide, and on the middle of the rope.
        let [on_points, on_rope] = [4, 7].map(|at| simulation.position(at).y);
        let right = f64::sqrt(0.01 - 0.0025);
        assert!((on_points - right).abs() < 1e-5, "{integrator}: {on_points}");
        assert!((on_rope - 0.1).abs() < 1e-5, "{integrator}: {on_rope}");
        assert!(simulation.velocity(4).length() < 1e-9, "{integrator}");
    }
}

/// Cubes whose shells are set as they run meet as those of a scene that has them.
#[test]
fn shells_that_are_set_are_those_of_a_scene_that_has_them() {
    let (scene, _) = cubes();
    let bare = Scene { shells: Vec::new(), ..scene.clone() };
    for integrator in ALL {
        let mut loaded = start::<f32>(&scene, integrator, 32);
        let mut set = start::<f32>(&bare, integrator, 32);
        set.set_shells(&scene.shells).expect("valid shells");
        for simulation in [&mut loaded, &mut set] {
            run(simulation, 0.5);
        }
        assert_eq!(loaded.state(), set.state(), "{integrator}");
    }
    let mut implicit = start::<f32>(&bare, Integrator::DormandPrince, 1);
    let refused = implicit.set_shells(&scene.shells).expect_err("its shells would meet");
    assert!(refused.to_string().contains("bodies touch"), "{refused}");
    assert!(implicit.model().shells().is_empty());
}

#[test]
fn what_is_removed_meets_nothing() {
    let (scene, [low, _]) = cubes();
    let mut simulation = start::<f64>(&scene, Integrator::VelocityVerlet, 32);
    run(&mut simulation, 0.5);
    for particle in low {
        simulation.remove_particle(particle).expect("a particle");
    }
    run(&mut simulation, 0.1);
    assert_eq!(crossings(&simulation), 0);
    let falls = simulation.velocity(scene.particles.len() - 1).y;
    assert!((falls + 0.1 * G).abs() < 0.1, "it falls at {falls}");
}

/// Instructions change no bit.
fn has_the_same_bits<R: Real>(scene: &Scene) {
    for integrator in ALL {
        let mut ends = Instructions::ALL
            .into_iter()
            .filter(|&set| set <= Instructions::best())
            .map(|instructions| {
                let mut simulation = start::<R>(scene, integrator, 32);
                simulation.set_instructions(instructions);
                run(&mut simulation, 0.4);
                (simulation.state(), simulation.dissipated())
            });
        let first = ends.next().expect("one set");
        assert!(ends.all(|end| end == first), "{integrator} {}", R::NAME);
    }
}

#[test]
fn bits_do_not_depend_on_instructions() {
    has_the_same_bits::<f32>(&cubes().0);
    has_the_same_bits::<f64>(&cubes().0);
}

/// A method may be any where no two shells meet.
#[test]
fn shells_that_meet_none_suit_every_method() {
    let scene = Scene { shells: vec![point(0, 0.05)], ..balls(0.0) };
    for integrator in Integrator::ALL {
        let settings = Settings { integrator, ..Settings::default() };
        let mut simulation = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
        run(&mut simulation, 0.5);
        let passed = simulation.position(0).to_f64().x;
        assert!((passed - 0.0).abs() < 1e-12, "{integrator}: {passed}");
    }
}

/// A ball between a pinned triangle and a box that comes down on it: it is pushed through, which is
/// counted, unless the box stops above.
#[test]
fn what_is_pushed_through_is_counted() {
    let corner = |x, z| Particle { position: dvec3(x, 0.0, z), velocity: DVec3::ZERO, mass: 1.0 };
    let mut particles = vec![corner(-2.0, -2.0), corner(4.0, -2.0), corner(-2.0, 4.0)];
    particles.push(Particle { position: dvec3(0.0, 0.15, 0.0), ..corner(0.0, 0.0) });
    let plate = Shell { triangles: vec![[0, 1, 2]], ..shell(0.01, 0.0) };
    let pins = (0..3).map(|particle| Pin { particle, velocity: DVec3::ZERO }).collect();
    let mut lid = Solid::new(Shape::Box { size: dvec3(1.0, 1.0, 1.0) });
    (lid.position, lid.velocity) = (dvec3(0.0, 0.7, 0.0), dvec3(0.0, -0.5, 0.0));
    let (shells, solids) = (vec![plate, point(3, 0.01)], vec![lid]);
    let scene = Scene { world: weightless(), particles, pins, shells, solids, ..Scene::default() };
    for integrator in [Integrator::VelocityVerlet, Integrator::Rk4, Integrator::ExplicitEuler] {
        let mut simulation = start::<f64>(&scene, integrator, 8);
        run(&mut simulation, 0.3);
        assert_eq!(simulation.ledger().passes(), 0, "{integrator} before");
        run(&mut simulation, 0.3);
        let height = simulation.position(3).y;
        assert!(height < 0.0 && 0 < simulation.ledger().passes(), "{integrator}: at {height}");
        let [ShellPassage { particles: [0, 3], time }] = simulation.ledger().passages()[..] else {
            panic!("{integrator}: {:?}", simulation.ledger().passages());
        };
        // The box is in the plane of the triangle after 0.4 s, and a substep is 2 ms long.
        assert!((time - 0.4).abs() < 0.01, "{integrator}: at {time} s");
    }
}
