//! Bodies that meet: they bear, stick, slide by Coulomb's law, keep momentum and do not cross.

mod bodies;
mod crossings;
mod overlaps;
mod pairs;
mod sliding;

use bodies::{Stuff, add_block, add_cloth};
use crossings::crossings;
use msd_core::glam::{DVec3, dvec3};
use msd_core::scene::Between;
use msd_core::{
    Error, Friction, Integrator, Pin, Plane, Real, Scene, Settings, Shell, Simulation, Vector,
    World,
};
use std::ops::Range;

const ALL: [Integrator; 7] = [
    Integrator::SymplecticEuler,
    Integrator::VelocityVerlet,
    Integrator::Rk4,
    Integrator::ExplicitEuler,
    Integrator::Xpbd,
    Integrator::BackwardEuler,
    Integrator::ImplicitMidpoint,
];
const IMPLICIT: [Integrator; 2] = [Integrator::BackwardEuler, Integrator::ImplicitMidpoint];
const G: f64 = 9.82;

fn shell(thickness: f64, friction: f64) -> Shell {
    Shell { thickness, friction, ..Shell::default() }
}

fn floor() -> Plane {
    let friction = Friction::Coulomb(0.5);
    Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction }
}

fn start<R: Real>(scene: &Scene, integrator: Integrator, substeps: u32) -> Simulation<R> {
    let settings = Settings { integrator, substeps, ..Settings::default() };
    Simulation::new(scene, settings).expect("a valid scene")
}

fn run<R: Real>(simulation: &mut Simulation<R>, seconds: f64) {
    for _ in 0..(seconds * 60.0).round() as usize {
        simulation.step().expect("a step");
    }
}

/// The centre of mass of some particles and its velocity.
fn centre<R: Real>(simulation: &Simulation<R>, particles: Range<usize>) -> (DVec3, DVec3) {
    let masses = simulation.model().masses();
    let mut sums = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for particle in particles {
        let mass = masses[particle].to_f64();
        sums.0 += simulation.position(particle).to_f64() * mass;
        sums.1 += simulation.velocity(particle).to_f64() * mass;
        sums.2 += mass;
    }
    (sums.0 / sums.2, sums.1 / sums.2)
}

/// Two cubes of gelatine, 6 cm, the upper 1 cm above the lower, which stands on the floor.
fn cubes() -> (Scene, [Range<usize>; 2]) {
    let mut scene = Scene { planes: vec![floor()], ..Scene::default() };
    let stuff = Stuff { young: 2e4, density: 1000.0, damping: 2e-3 };
    let (a, n) = (0.01, [7, 7, 7]);
    let low = add_block(&mut scene, n, (a, dvec3(0.0, 0.0, 0.0)), stuff, shell(1e-3, 0.5));
    let corner = dvec3(0.002, 0.06 + 0.002 + 0.01, 0.0013);
    let high = add_block(&mut scene, n, (a, corner), stuff, shell(1e-3, 0.5));
    (scene, [low, high])
}

#[test]
fn a_cube_on_its_twin_stays_on_it() {
    let (scene, [low, high]) = cubes();
    for integrator in ALL {
        for substeps in [32, 64] {
            let mut simulation = start::<f64>(&scene, integrator, substeps);
            run(&mut simulation, 1.5);
            let [below, above] =
                [low.clone(), high.clone()].map(|all| centre(&simulation, all).0.y);
            let apart = above - below;
            // A side and both thicknesses, 62 mm, less the compression by the weight: the lower
            // cube by some 3/2 ρ g L²/E, 1.3 mm above its centre, the upper by a half of that.
            assert!((0.0590..0.0620).contains(&apart), "{integrator} {substeps}: {apart}");
        }
    }
}

/// The same at long substeps, of which the springs alone ask explicit methods for 17 or more.
#[test]
fn implicit_methods_hold_a_cube_on_its_twin_at_long_substeps() {
    let (scene, bodies) = cubes();
    for integrator in IMPLICIT {
        for substeps in [2, 4, 8, 16] {
            holds_without_a_gain::<f64>(&scene, &bodies, integrator, substeps);
        }
        holds_without_a_gain::<f32>(&scene, &bodies, integrator, 4);
    }
}

fn holds_without_a_gain<R: Real>(
    scene: &Scene,
    bodies: &[Range<usize>; 2],
    integrator: Integrator,
    substeps: u32,
) {
    let mut simulation = start::<R>(scene, integrator, substeps);
    let before = simulation.energy().total();
    // The energy of a fall by 1 cm; springs that are linearised once per substep are not better
    // than that.
    let tolerance = 5e-3 * 0.216 * G * 0.01;
    for _ in 0..90 {
        simulation.step().expect("a step");
        let gain = simulation.energy().total() - before;
        assert!(gain < tolerance, "{integrator} {substeps}: {gain} J");
    }
    let [below, above] = bodies.clone().map(|all| centre(&simulation, all).0.y);
    let apart = above - below;
    assert!((0.0595..0.0605).contains(&apart), "{integrator} {substeps}: {apart}");
}

/// A block on a plate that is tilted by 10 degrees: gravity is turned instead.
fn slope(friction: f64) -> (Scene, Range<usize>) {
    let (sine, cosine) = 10f64.to_radians().sin_cos();
    let gravity = dvec3(G * sine, -G * cosine, 0.0);
    let mut scene = Scene { world: World { gravity, ..World::default() }, ..Scene::default() };
    let stuff = Stuff { young: 2e4, density: 300.0, damping: 5e-3 };
    let thick = shell(2e-3, friction);
    let plate = add_block(&mut scene, [26, 3, 6], (0.05, DVec3::ZERO), stuff, thick.clone());
    let corner = dvec3(0.11, 0.1 + 4e-3 + 1e-4, 0.03);
    let block = add_block(&mut scene, [4, 4, 4], (0.05, corner), stuff, thick);
    let lowest = plate.filter(|&particle| scene.particles[particle].position.y == 0.0);
    scene.pins = lowest.map(|particle| Pin { particle, velocity: DVec3::ZERO }).collect();
    (scene, block)
}

#[test]
fn friction_holds_a_block_on_a_slope() {
    let (scene, block) = slope(0.5);
    for integrator in ALL {
        let mut simulation = start::<f64>(&scene, integrator, 16);
        run(&mut simulation, 12.0);
        let fastest = block.clone().map(|at| simulation.velocity(at).length()).fold(0.0, f64::max);
        assert!(fastest < 1e-9, "{integrator}: {fastest}");
    }
}

#[test]
fn a_block_slides_down_a_slope_by_coulombs_law() {
    let (scene, block) = slope(0.1);
    for (integrator, substeps) in ALL.into_iter().zip([16, 32, 32, 64, 32, 8, 8]) {
        let mut simulation = start::<f64>(&scene, integrator, substeps);
        run(&mut simulation, 0.6);
        // Least squares over the last 0.9 s.
        let mut rows = Vec::new();
        for frame in 0..54 {
            run(&mut simulation, 1.0 / 60.0);
            rows.push((f64::from(frame) / 60.0, centre(&simulation, block.clone()).1.x));
        }
        let count = rows.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| rows.iter().map(of).sum::<f64>() / count;
        let (time, speed) = (mean(|row| row.0), mean(|row| row.1));
        let slope = rows.iter().map(|row| (row.0 - time) * (row.1 - speed)).sum::<f64>()
            / rows.iter().map(|row| (row.0 - time).powi(2)).sum::<f64>();
        let (sine, cosine) = 10f64.to_radians().sin_cos();
        let right = G * (sine - 0.1 * cosine);
        assert!((slope / right - 1.0).abs() < 0.02, "{integrator}: {slope} instead of {right}");
    }
}

#[test]
fn what_collides_in_free_space_keeps_its_momentum() {
    let world = World { gravity: DVec3::ZERO, ..World::default() };
    let mut scene = Scene { world, ..Scene::default() };
    let stuff = Stuff { young: 2e4, density: 200.0, damping: 5e-4 };
    let (n, a) = ([5, 5, 5], 0.05);
    let one = add_block(&mut scene, n, (a, dvec3(-0.25, 0.0, 0.0)), stuff, shell(2e-3, 0.5));
    let other = add_block(&mut scene, n, (a, dvec3(0.02, 0.033, 0.02)), stuff, shell(2e-3, 0.5));
    for (body, speed) in [(one.clone(), 1.0), (other.clone(), -1.0)] {
        scene.particles[body].iter_mut().for_each(|row| row.velocity = DVec3::X * speed);
    }
    for integrator in ALL {
        let mut simulation = start::<f64>(&scene, integrator, 64);
        let before = simulation.momentum();
        run(&mut simulation, 0.8);
        let after = simulation.momentum();
        let size = centre(&simulation, one.clone()).1.length() * 200.0 * 0.2f64.powi(3);
        let off =
            [(after.linear - before.linear).length(), (after.angular - before.angular).length()];
        let apart = centre(&simulation, other.clone()).1.x - centre(&simulation, one.clone()).1.x;
        let turned = match integrator {
            // The impulses that act in its stages are central at their start alone.
            Integrator::Rk4 => 1e-5,
            // Forces are central at the start of a substep, or where XPBD predicts its end: an
            // impulse m v that acts while ends move by h v, with h = 1/3840 s and v = 2 m/s.
            Integrator::ExplicitEuler | Integrator::Xpbd => 1e-3,
            // Those of a linearised stage nearly are at its positions.
            Integrator::BackwardEuler | Integrator::ImplicitMidpoint => 1e-4,
            _ => 1e-13,
        };
        let [linear, angular] = off.map(|off| off / size);
        assert!(linear < 1e-13 && angular < turned, "{integrator}: {linear}, {angular}");
        assert!(1.0 < apart, "{integrator}: {apart}");
    }
}

/// Two strips across each other, whose vertices do not meet: edges alone hold them.
#[test]
fn strips_whose_edges_alone_meet_hold_each_other() {
    let mut scene = Scene::default();
    let thick = Shell { itself: true, ..shell(2e-3, 0.5) };
    let places = [dvec3(-0.2, 0.0, -0.015), DVec3::X * 0.05, DVec3::Z * 0.03];
    let low = add_cloth(&mut scene, [9, 2], places, (1e-3, 100.0), thick.clone());
    let places = [dvec3(0.012, 0.1, -0.217), DVec3::Z * 0.05, DVec3::X * 0.03];
    let high = add_cloth(&mut scene, [9, 2], places, (1e-3, 100.0), thick.clone());
    for end in [0, 1, 16, 17] {
        scene.pins.push(Pin { particle: low.start + end, velocity: DVec3::ZERO });
        scene.particles[high.start + end].mass *= 5.0;
    }
    // The springs of explicit Euler gain energy here, shells or not.
    for integrator in ALL.into_iter().filter(|&method| method != Integrator::ExplicitEuler) {
        for substeps in [16, 32, 64] {
            let mut simulation = start::<f64>(&scene, integrator, substeps);
            let mut most = 0;
            for _ in 0..180 {
                simulation.step().expect("a step");
                most = most.max(crossings(&simulation));
            }
            assert_eq!(most, 0, "{integrator} {substeps}");
        }
    }
}

/// A cloth that falls on its edge, as implicit methods fold it at long substeps.
#[test]
fn a_cloth_that_folds_on_itself_does_not_cross_itself() {
    let scene = falling_cloth([12, 31]);
    for integrator in IMPLICIT {
        for substeps in [8, 16] {
            let mut simulation = start::<f64>(&scene, integrator, substeps);
            for _ in 0..72 {
                simulation.step().expect("a step");
                assert_eq!(crossings(&simulation), 0, "{integrator} {substeps}");
            }
        }
    }
}

/// A block that falls on a cloth at 10 m/s, by a tenth of its size in each of 8 substeps.
#[test]
fn a_cloth_catches_what_falls_on_it_fast() {
    let mut scene = Scene::default();
    let places = [dvec3(-0.3, 0.0, -0.3), DVec3::X * 0.03, DVec3::Z * 0.03];
    let cloth = add_cloth(&mut scene, [21, 21], places, (1e-3, 300.0), shell(3e-3, 0.3));
    let is_rim = |at: &usize| [at / 21, at % 21].iter().any(|&place| place == 0 || place == 20);
    let pin = |particle| Pin { particle, velocity: DVec3::ZERO };
    scene.pins = (0..cloth.len()).filter(is_rim).map(pin).collect();
    let stuff = Stuff { young: 1e5, density: 500.0, damping: 1e-3 };
    let corner = dvec3(-0.025, 0.05, -0.028);
    let block = add_block(&mut scene, [4, 4, 4], (0.02, corner), stuff, shell(2e-3, 0.3));
    scene.particles[block.clone()].iter_mut().for_each(|row| row.velocity = DVec3::Y * -10.0);
    for integrator in IMPLICIT {
        for substeps in [16, 64] {
            let mut simulation = start::<f64>(&scene, integrator, substeps);
            for _ in 0..18 {
                simulation.step().expect("a step");
                assert_eq!(crossings(&simulation), 0, "{integrator} {substeps}");
            }
            let (place, velocity) = centre(&simulation, block.clone());
            assert!(0.0 < place.y && 0.0 < velocity.y, "{integrator} {substeps}: {place}");
        }
    }
}

/// A cloth on the floor, and another that falls on it.
#[test]
fn a_cloth_lies_on_a_cloth_on_the_floor() {
    let mut scene = Scene { planes: vec![floor()], ..Scene::default() };
    let along = [DVec3::X * 0.04, DVec3::Z * 0.04];
    let low = [dvec3(0.0, 0.0, 0.0), along[0], along[1]];
    add_cloth(&mut scene, [9, 9], low, (1e-3, 40.0), shell(2e-3, 0.5));
    let high = [dvec3(0.05, 0.02, 0.07), along[0], along[1]];
    let upper = add_cloth(&mut scene, [5, 5], high, (1e-3, 40.0), shell(2e-3, 0.5));
    for integrator in ALL {
        let mut simulation = start::<f64>(&scene, integrator, 16);
        run(&mut simulation, 3.0);
        let fastest = upper.clone().map(|at| simulation.velocity(at).length()).fold(0.0, f64::max);
        let heights = upper.clone().map(|at| simulation.position(at).y);
        let [low, high] = heights.fold([1.0f64, 0.0], |[a, b], y| [a.min(y), b.max(y)]);
        assert!(0.0039 < low && high < 0.0041, "{integrator}: {low} to {high}");
        assert!(fastest < 1e-5, "{integrator}: {fastest} m/s");
        assert_eq!(crossings(&simulation), 0, "{integrator}");
    }
}

/// A run that was saved and resumed where cubes lie on each other, and one that was not.
#[test]
fn a_resumed_run_has_the_same_bits() {
    let (scene, _) = cubes();
    for integrator in ALL {
        let mut straight = start::<f32>(&scene, integrator, 32);
        run(&mut straight, 0.4);
        let (rows, progress) = straight.progress();
        assert!(!progress.impulses.is_empty());
        let mut resumed = Simulation::<f32>::resume(&rows, &progress).expect("a run");
        for simulation in [&mut straight, &mut resumed] {
            run(simulation, 0.2);
        }
        let [a, b] = [&straight, &resumed].map(|simulation| simulation.state());
        assert_eq!(a, b, "{integrator}");
        assert_eq!(straight.ledger(), resumed.ledger(), "{integrator}");
    }
}

/// A cloth of some particles that falls on its edge and folds.
fn falling_cloth(counts: [usize; 2]) -> Scene {
    let mut scene = Scene { planes: vec![floor()], ..Scene::default() };
    let places = [DVec3::Y * 0.05, DVec3::X * 0.02, DVec3::Y * 0.02];
    let thick = Shell { itself: true, ..shell(2e-3, 0.5) };
    let cloth = add_cloth(&mut scene, counts, places, (5e-4, 30.0), thick);
    for particle in &mut scene.particles[cloth] {
        particle.position.z += 0.01 * (30.0 * particle.position.y).sin();
    }
    scene
}

/// The same cloth, and the same run with new lists at each step.
#[test]
fn bits_do_not_depend_on_when_lists_were_made() {
    let scene = falling_cloth([8, 21]);
    for integrator in ALL.into_iter().filter(|&method| method != Integrator::ExplicitEuler) {
        let mut straight = start::<f32>(&scene, integrator, 32);
        let mut anew = straight.clone();
        for _ in 0..60 {
            for simulation in [&mut straight, &mut anew] {
                simulation.step().expect("a step");
            }
            let (rows, progress) = anew.progress();
            anew = Simulation::resume(&rows, &progress).expect("a run");
        }
        let (_, progress) = straight.progress();
        assert!(!progress.impulses.is_empty(), "{integrator}: it does not meet itself");
        assert_eq!(straight.state(), anew.state(), "{integrator}");
        assert_eq!(crossings(&straight), 0, "{integrator}");
    }
}

#[test]
fn steps_of_bodies_that_lie_on_each_other_allocate_nothing() {
    let (scene, _) = cubes();
    for integrator in ALL {
        let mut simulation = start::<f64>(&scene, integrator, 32);
        run(&mut simulation, 1.0);
        let asked = allocation_counter::measure(|| run(&mut simulation, 0.5));
        assert_eq!(asked.count_total, 0, "{integrator}");
    }
}

/// Errors halve with the substep, or fall faster.
#[test]
fn contact_of_bodies_is_of_first_order() {
    let (scene, [_, high]) = cubes();
    let path = |integrator, substeps: u32| -> Vec<DVec3> {
        let mut simulation = start::<f64>(&scene, integrator, substeps);
        let mut see = || {
            simulation.step().expect("a step");
            centre(&simulation, high.clone()).0
        };
        (0..15).map(|_| see()).collect()
    };
    for integrator in ALL {
        // Implicit methods cost ten times as much, and do with longer substeps.
        let unit = if integrator.is_implicit() { 1 } else { 2 };
        let reference = path(integrator, 256 * unit);
        let errors = [16, 32, 64].map(|substeps| {
            let pairs = reference.iter().zip(path(integrator, unit * substeps));
            pairs.map(|(a, b)| (*a - b).length()).fold(0.0, f64::max)
        });
        // Implicit midpoint has nearly no error to lose: 0.02 mm at its longer substeps.
        let falls_by = if integrator == Integrator::ImplicitMidpoint { 1.2 } else { 3.5 };
        let most = if integrator == Integrator::ImplicitMidpoint { 4e-5 } else { 1.0 };
        // Against a reference that is four times as fine, 1/16 - 1/256 and 1/64 - 1/256: by 5.
        let converges = falls_by * errors[2] < errors[0] && errors[0] < most;
        println!("{integrator} {unit}: {:.3?} mm", errors.map(|error| 1e3 * error));
        assert!(converges, "{integrator}: {errors:?}");
    }
}

#[test]
fn a_run_that_diverges_stops_at_the_last_good_state() {
    let (scene, _) = cubes();
    for integrator in Integrator::EXPLICIT {
        let mut simulation = start::<f32>(&scene, integrator, 1);
        let error = (0..600).find_map(|_| simulation.step().err());
        assert!(matches!(error, Some(Error::Diverged(_))), "{integrator}: {error:?}");
        assert!(simulation.state().positions.iter().all(|at| at.to_f64().is_finite()));
    }
}

#[test]
fn shells_out_of_their_domain_are_refused() {
    let (scene, _) = cubes();
    let refuse_with = |change: &dyn Fn(&mut Shell)| {
        let mut scene = scene.clone();
        change(&mut scene.shells[1]);
        Simulation::<f32>::new(&scene, Settings::default()).expect_err("a fault").to_string()
    };
    let refuse = |change: fn(&mut Shell)| refuse_with(&change);
    let thin = refuse(|shell| shell.thickness = 0.0);
    assert_eq!(thin, "thickness of shell 1 is 0; it must be positive and finite");
    let rough = refuse(|shell| shell.friction = -1.0);
    assert!(rough.starts_with("friction of shell 1 is -1"), "{rough}");
    let far = refuse(|shell| shell.edges.push([400, 1_000_000]));
    assert!(far.contains("shell 1 names particle 1000000"), "{far}");
    let shared = refuse(|shell| shell.edges.push([0, 1]));
    assert!(shared.contains("it must be in one shell"), "{shared}");
    let springy = refuse(|shell| shell.restitution = 1.5);
    assert_eq!(springy, "restitution of shell 1 is 1.5; it must be from 0 to 1");
    let between = |shell, friction| Between { shell, friction, restitution: None };
    let twice = [between(0, None); 2];
    let twice = refuse_with(&|shell| shell.between.extend(twice));
    assert!(twice.contains("other shell of shell 1 is 0; it must be named once"), "{twice}");
    let later = refuse_with(&|shell| shell.between.push(between(1, None)));
    assert!(later.contains("shell before it"), "{later}");
    let slippery = refuse_with(&|shell| shell.between.push(between(0, Some(-1.0))));
    assert!(slippery.contains("friction between shells of shell 1 is -1"), "{slippery}");
    let folded = refuse(|shell| shell.edges.push([400, 400]));
    assert!(folded.contains("between different particles"), "{folded}");
}

#[test]
fn a_method_that_does_not_let_shells_meet_is_refused_by_name() {
    let settings = Settings { integrator: Integrator::DormandPrince, ..Settings::default() };
    let refused = Simulation::<f32>::new(&cubes().0, settings);
    assert!(matches!(refused, Err(Error::Unable { .. })), "{refused:?}");
}
