//! Particles with a radius: their push, its energy, its bits, and what rests on and hits what.

mod common;
#[path = "common/touching.rs"]
mod touching;

use common::{Random, distance, weightless};
use msd_core::glam::DVec3;
use msd_core::{
    Between, Friction, Integrator, Material, Pin, Plane, Scene, Settings, Simulation, Spring,
    State, Touch, Vector, World, shape,
};
use touching::{check_bits, particle, settings, simulation, touch};

/// A cloud in which many touch: three rows, of which the third passes through the first and through
/// itself, some springs, some exempt pairs, and particles without a radius.
fn cloud(seed: u64, count: usize) -> Scene {
    let mut random = Random(seed);
    let side = (count as f64).cbrt() * 0.1;
    let particles = (0..count)
        .map(|_| particle(random.vector() * side, random.vector() - 0.5, 0.1 + random.unit()))
        .collect();
    let rows: Vec<Vec<usize>> =
        (0..3).map(|row| (0..count).filter(|at| at % 4 == row).collect()).collect();
    let mut touches: Vec<Touch> = rows
        .into_iter()
        .zip([0.04, 0.06, 0.05])
        .map(|(particles, radius)| Touch {
            damping: 3.0,
            friction: 0.4,
            ..touch(particles, radius)
        })
        .collect();
    touches[1].stiffness = 900.0;
    (touches[2].itself, touches[2].ignored) = (false, vec![0]);
    let between = Between { row: 1, stiffness: Some(150.0), damping: None, friction: Some(0.2) };
    touches[2].between = vec![between];
    let spring =
        |at: usize| Spring { ends: [at, at + 5], rest_length: 0.1, stiffness: 50.0, damping: 0.1 };
    let springs = (0..count / 8).map(spring).collect();
    let exempt = (0..count / 8).map(|at| [at + 8, at]).collect();
    Scene { world: weightless(), particles, springs, touches, exempt, ..Scene::default() }
}

/// Forces and power by a plain loop over all pairs.
fn plainly(scene: &Scene, state: &State<f64>) -> (Vec<DVec3>, f64) {
    let count = scene.particles.len();
    let row_of = |at: usize| scene.touches.iter().position(|row| row.particles.contains(&at));
    let rows: Vec<_> = (0..count).map(row_of).collect();
    let joined = |a: usize, b: usize| {
        let is = |pair: [usize; 2]| pair == [a, b] || pair == [b, a];
        scene.springs.iter().any(|spring| is(spring.ends)) || scene.exempt.iter().any(|&p| is(p))
    };
    let (mut forces, mut power) = (vec![DVec3::ZERO; count], 0.0);
    for a in 0..count {
        for b in a + 1..count {
            let (Some(p), Some(q)) = (rows[a], rows[b]) else { continue };
            let (low, high) = (p.min(q), p.max(q));
            let [first, second] = [low, high].map(|row| &scene.touches[row]);
            let meet = if p == q { first.itself } else { !second.ignored.contains(&low) };
            let d = state.positions[b] - state.positions[a];
            let reach = first.radius + second.radius;
            if !meet || joined(a, b) || reach <= d.length() {
                continue;
            }
            let in_turn = |x: f64, y: f64| x * y / (x + y);
            let between = second.between.iter().find(|between| between.row == low);
            let Between { stiffness, damping, friction, .. } = between.copied().unwrap_or_default();
            let usual = in_turn(first.stiffness, second.stiffness);
            let k = stiffness.unwrap_or(usual);
            let c = damping.unwrap_or(in_turn(first.damping, second.damping) * k / usual);
            let mu = friction.unwrap_or((first.friction * second.friction).sqrt());
            let (n, v) = (d.normalize(), state.velocities[b] - state.velocities[a]);
            let overlap = reach - d.length();
            let push = (k * overlap - c * n.dot(v)).max(0.0);
            let slip = v - n * n.dot(v);
            let [m, o] = [a, b].map(|at| scene.particles[at].mass);
            let drag = ((k * in_turn(m, o)).sqrt() * slip.length()).min(mu * push);
            let force = n * push - slip.normalize_or_zero() * drag;
            forces[a] -= force;
            forces[b] += force;
            power -= force.dot(v) - k * overlap * n.dot(v);
        }
    }
    (forces, power)
}

#[test]
fn forces_are_those_of_a_plain_loop() {
    for (seed, count) in [(1, 40), (2, 300), (3, 700)] {
        let scene = cloud(seed, count);
        let without = Scene { touches: vec![], ..scene.clone() };
        let [with, without] =
            [&scene, &without].map(|scene| simulation::<f64>(scene, Settings::default()));
        let (wanted, power) = plainly(&scene, &with.state());
        let ((forces, taken), (others, other)) = (with.forces(), without.forces());
        // A sum of a few tens of numbers, each rounded a few times.
        let largest = forces.iter().map(|force| force.length()).fold(0.0, f64::max);
        for (at, wanted) in wanted.iter().enumerate() {
            let off = (forces[at] - others[at] - *wanted).length();
            assert!(off < 1e-12 * largest, "{at} of {count}: {off} N");
        }
        assert!((taken - other - power).abs() < 1e-12 * taken, "{taken} {other} {power}");
        assert!(1.0 < largest && 0.0 < power);
    }
}

#[test]
fn bits_depend_neither_on_instructions_nor_on_the_list_of_pairs() {
    let scene = cloud(4, 500);
    check_bits::<f32>(&scene);
    check_bits::<f64>(&scene);
}

#[test]
fn the_push_is_the_gradient_of_its_energy() {
    let mut scene = cloud(5, 200);
    scene.springs.clear();
    scene.touches.iter_mut().for_each(|row| (row.damping, row.friction) = (0.0, 0.0));
    scene.touches[2].between[0].friction = Some(0.0);
    let simulation = simulation::<f64>(&scene, Settings::default());
    let mut random = Random(6);
    let directions: Vec<DVec3> = (0..200).map(|_| random.vector() - 0.5).collect();
    let (forces, power) = simulation.forces();
    assert_eq!(power, 0.0);
    let reach = 1e-7;
    let energy = |by: f64| {
        let mut state = simulation.state();
        let rows = state.positions.iter_mut().zip(&directions);
        rows.for_each(|(position, direction)| *position += *direction * by);
        simulation.energy_at(&state).elastic
    };
    let slope = (energy(reach) - energy(-reach)) / (2.0 * reach);
    let wanted: f64 = forces.iter().zip(&directions).map(|(f, d)| -f.dot(*d)).sum();
    // The energy has a second derivative that jumps where pairs open: an error of the first order.
    assert!((slope - wanted).abs() < 1e-4 * wanted.abs(), "{slope} instead of {wanted}");
}

/// Two soft blocks that meet, one turning.
fn collision(touch_of: impl Fn(Touch) -> Touch) -> Scene {
    let material = Material { mass: 0.01, stiffness: 300.0, damping: 0.02 };
    let mut scene = Scene { world: weightless(), ..Scene::default() };
    for (at, velocity, spin) in [(0.0, 0.6, 0.0), (0.45, -0.4, 2.0)] {
        let mut part = shape::block([4, 4, 4], 0.1, material).expect("a block");
        part.set_motion(DVec3::X * velocity, DVec3::Z * spin);
        part.place(msd_core::glam::DMat3::IDENTITY, DVec3::new(at, at * 0.2, 0.0));
        let first = scene.particles.len();
        let body = scene.add("block", part);
        let particles = scene.bodies[body].particles.clone().collect();
        assert_eq!(first, scene.bodies[body].particles.start);
        scene.add_touch(touch_of(touch(particles, 0.045))).expect("a few pairs");
    }
    scene
}

#[test]
fn a_collision_keeps_momentum_under_every_method() {
    // Without friction, which is a couple on two particles that cannot spin.
    let scene = collision(|row| Touch { damping: 0.5, ..row });
    for integrator in
        Integrator::ALL.into_iter().filter(|&method| method != Integrator::ExplicitEuler)
    {
        let mut simulation = simulation::<f64>(&scene, settings(integrator, 40));
        let (before, energy) = (simulation.momentum(), simulation.energy().total());
        let first = simulation.centre_of_mass(0..64);
        let mut elastic = 0.0_f64;
        for _ in 0..60 {
            simulation.step().expect("a stable step");
            elastic = elastic.max(simulation.energy().elastic);
        }
        let after = simulation.momentum();
        // Linear momentum to rounding; angular, too, but where a solve is not exact.
        let scale = 0.64 * 0.6;
        assert!((after.linear - before.linear).length() < 1e-12 * scale, "{integrator}");
        let turned = (after.angular - before.angular).length() / before.angular.length();
        // Of the order of the solve, of the pass or of the tolerance.
        let most = match integrator {
            Integrator::BackwardEuler | Integrator::ImplicitMidpoint | Integrator::Xpbd => 5e-3,
            Integrator::DormandPrince => 1e-4,
            _ => 1e-8,
        };
        assert!(turned < most, "{integrator}: {turned}");
        assert!(1e-3 < elastic, "{integrator}: they met");
        let went = simulation.centre_of_mass(0..64) - first;
        assert!(went.x < 0.5, "{integrator}: stopped after {} m of 0.6", went.x);
        let gained = simulation.energy().total() - energy;
        assert!(gained < 1e-3 * energy, "{integrator}: gained {gained} of {energy} J");
    }
}

#[test]
fn energy_drifts_by_the_order_of_the_method() {
    let drift = |substeps: u32| {
        let scene = collision(|row| Touch { damping: 0.5, friction: 0.5, ..row });
        let mut simulation =
            simulation::<f64>(&scene, settings(Integrator::VelocityVerlet, substeps));
        let before = simulation.energy().total();
        (0..60).for_each(|_| simulation.step().expect("a stable step"));
        (simulation.energy().total() - before).abs() / before
    };
    let [coarse, fine] = [20, 80].map(drift);
    // A push with a damper jumps as it begins: of the first order, and mostly better.
    assert!(fine < 0.4 * coarse && fine < 1e-4, "{coarse} {fine}");
}

/// The distance of a collision from one of 16 times as many substeps, by the number of substeps.
fn errors(integrator: Integrator, counts: [u32; 3]) -> [f64; 3] {
    let scene = collision(|row| Touch { damping: 0.5, friction: 0.5, ..row });
    let end = |integrator, substeps| {
        let mut simulation = simulation::<f64>(&scene, settings(integrator, substeps));
        (0..30).for_each(|_| simulation.step().expect("a stable step"));
        simulation.state()
    };
    let reference = end(Integrator::VelocityVerlet, 16 * counts[2]);
    counts.map(|substeps| distance(&end(integrator, substeps), &reference))
}

/// A push with a damper jumps where it begins, at a time that no substep meets: of the first order
/// at worst, on the average of many contacts better.
#[test]
fn the_error_of_a_collision_falls_at_least_with_the_substep() {
    for integrator in [
        Integrator::SymplecticEuler,
        Integrator::VelocityVerlet,
        Integrator::Rk4,
        Integrator::BackwardEuler,
        Integrator::ImplicitMidpoint,
        Integrator::Xpbd,
    ] {
        let [first, second, third] = errors(integrator, [20, 40, 80]);
        println!("| {integrator} | {first:.1e} | {second:.1e} | {third:.1e} |");
        // Half for each doubling; one of the two may be a bad hit.
        assert!(third < 0.45 * first, "{integrator}: {first:e} {second:e} {third:e}");
    }
}

/// The speed at which two particles part, over that at which they met.
fn restitution(damping: f64, integrator: Integrator) -> f64 {
    let particles =
        vec![particle(DVec3::ZERO, DVec3::X, 0.1), particle(DVec3::X * 0.11, DVec3::ZERO, 0.3)];
    let touches = vec![Touch { damping, ..touch(vec![0, 1], 0.05) }];
    let scene = Scene { world: weightless(), particles, touches, ..Scene::default() };
    let settings = Settings { tolerance: 1e-10, ..settings(integrator, 2000) };
    let mut simulation = simulation::<f64>(&scene, settings);
    (0..40).for_each(|_| simulation.step().expect("a stable step"));
    assert!(0.1 < (simulation.position(1) - simulation.position(0)).length());
    simulation.velocity(1).x - simulation.velocity(0).x
}

/// Source of the closed form: Schwager and Pöschel, 2007, for a damped spring that never pulls.
#[test]
fn two_particles_part_at_the_speed_of_the_closed_form() {
    let (mass, k) = (0.075_f64, 200.0_f64);
    for ratio in [0.0, 0.05, 0.2, 0.5] {
        let natural = (k / mass).sqrt();
        let beta = ratio * natural;
        let w = (natural * natural - beta * beta).sqrt();
        let phase = (2.0 * beta * w / (w * w - beta * beta)).atan();
        let wanted = (-beta / w * (std::f64::consts::PI - phase)).exp();
        for integrator in Integrator::ALL {
            // c of the pair is half of that of each row, and 2 m β.
            let found = restitution(4.0 * mass * beta, integrator);
            // The first substep of the contact is missed in part: h v of a depth of v/w.
            let h_w = natural / 120_000.0;
            let most = if integrator == Integrator::DormandPrince { 1e-3 } else { 2.0 * h_w };
            assert!((found - wanted).abs() < most, "{ratio} {integrator}: {found}, not {wanted}");
        }
    }
}

#[test]
fn friction_holds_back_at_most_by_the_push_times_its_factor() {
    let force = |slip: f64| {
        let particles = vec![
            particle(DVec3::ZERO, DVec3::ZERO, 0.2),
            particle(DVec3::Y * 0.08, DVec3::Z * slip, 0.2),
        ];
        let touches = vec![Touch { friction: 0.5, ..touch(vec![0, 1], 0.05) }];
        let scene = Scene { world: weightless(), particles, touches, ..Scene::default() };
        simulation::<f64>(&scene, Settings::default()).forces().0[1]
    };
    // 200 N/m and 2 cm; the reduced mass is 0.1 kg.
    let (push, grip) = (4.0, (200.0_f64 * 0.1).sqrt());
    for (slip, wanted) in [(0.1, grip * 0.1), (0.4, grip * 0.4), (0.5, 2.0), (50.0, 2.0)] {
        let force = force(slip);
        assert!((force - DVec3::new(0.0, push, -wanted)).length() < 1e-12, "{slip}: {force}");
    }
}

/// A column of particles on the floor, each at rest on the one below.
#[test]
fn a_column_bears_the_sum_of_its_weights_and_does_not_creep() {
    let (count, mass, radius, k) = (8, 0.1, 0.05, 200.0);
    let mut height = 0.0;
    let mut particles = Vec::new();
    for at in 0..count {
        particles.push(particle(DVec3::Y * height, DVec3::ZERO, mass));
        height += 2.0 * radius - (count - 1 - at) as f64 * mass * 9.82 / k;
    }
    let touches =
        vec![Touch { damping: 0.8, friction: 0.5, ..touch((0..count).collect(), radius) }];
    let friction = Friction::Coulomb(0.5);
    let floor = Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction };
    let scene = Scene { particles, touches, planes: vec![floor], ..Scene::default() };
    for integrator in
        Integrator::ALL.into_iter().filter(|&method| method != Integrator::ExplicitEuler)
    {
        let mut simulation = simulation::<f64>(&scene, settings(integrator, 8));
        let start = simulation.state();
        let mut run = || {
            (0..1800).for_each(|_| simulation.step().expect("a stable step"));
            simulation.state()
        };
        let [half, whole] = [run(), run()];
        let creep = distance(&half, &whole);
        // One pass over a column in which each bears the next makes it too soft and slow.
        let most = if integrator == Integrator::Xpbd { [1e-5, 3e-3] } else { [1e-9; 2] };
        assert!(creep < most[0], "{integrator}: {creep} m in 30 s");
        let sagged = distance(&start, &whole);
        assert!(sagged < most[1], "{integrator}: {sagged} m from balance");
        let (forces, _) = simulation.forces();
        let weight = -(count as f64) * mass * 9.82;
        let most = if integrator == Integrator::Xpbd { 0.05 } else { 1e-6 } * weight.abs();
        assert!((forces[0].y - weight).abs() < most, "{integrator}: {} N", forces[0].y);
    }
}

/// A particle squeezed between two that are pinned: k/2 from each side, so w² = 2 k / m along the
/// line, and −2 (k δ / L) / m across it.
#[test]
fn the_stable_substep_with_contact_closed_is_that_of_the_closed_form() {
    let particles = vec![
        particle(DVec3::ZERO, DVec3::ZERO, 1.0),
        particle(DVec3::X * 0.09, DVec3::X * 1e-6, 0.1),
        particle(DVec3::X * 0.18, DVec3::ZERO, 1.0),
    ];
    let pins = [0, 2].map(|particle| Pin { particle, velocity: DVec3::ZERO }).to_vec();
    let touches = vec![touch(vec![0, 1, 2], 0.05)];
    let scene = Scene { world: weightless(), particles, pins, touches, ..Scene::default() };
    let wanted = 2.0 / (2.0 * 200.0_f64 / 0.1).sqrt();
    let run = |step: f64| {
        let settings = Settings { step, ..settings(Integrator::SymplecticEuler, 1) };
        let mut simulation = simulation::<f64>(&scene, settings);
        let limit = simulation.stable_substep();
        (0..2000).for_each(|_| simulation.step().expect("inside the world"));
        (limit, (simulation.position(1).x - 0.09).abs())
    };
    let ((limit, below), (_, above)) = (run(0.995 * wanted), run(1.005 * wanted));
    assert!((limit / wanted - 1.0).abs() < 1e-9, "{limit} instead of {wanted}");
    assert!(below < 1e-6 && 1e-3 < above, "{below} {above}");
}

/// A row of damped balls is pressed together: it gives way sideways at any step, which is no limit,
/// and with many substeps velocity Verlet bears as much as symplectic Euler, or a little less.
#[test]
fn a_row_that_buckles_has_the_stable_substep_of_its_fastest_motion() {
    let ball = |at: usize| particle(DVec3::X * 0.09 * at as f64, DVec3::ZERO, 0.1);
    let particles = (0..5).map(ball).collect();
    let pins = [0, 4].map(|particle| Pin { particle, velocity: DVec3::ZERO }).to_vec();
    let touches = vec![Touch { damping: 1.0, ..touch((0..5).collect(), 0.05) }];
    let scene = Scene { world: weightless(), particles, pins, touches, ..Scene::default() };
    let limit = |integrator: Integrator, substeps: u32| {
        simulation::<f64>(&scene, settings(integrator, substeps)).stable_substep()
    };
    // The fastest of three between two that are held: 2 + sqrt 2 of the k/m and c/m of a pair.
    let factor = (2.0 + 2.0f64.sqrt()) / 0.1;
    let (half, stiffness) = (0.5 * 0.5 * factor, 200.0 * factor);
    let wanted = 2.0 / (half + (half * half + stiffness).sqrt());
    let euler = limit(Integrator::SymplecticEuler, 1);
    assert!((euler / wanted - 1.0).abs() < 1e-9, "{euler} instead of {wanted}");
    for substeps in [1, 10, 64, 100, 1000] {
        let verlet = limit(Integrator::VelocityVerlet, substeps);
        assert!((verlet / wanted - 1.0).abs() < 0.02, "{substeps}: {verlet}, not {wanted}");
    }
}

#[test]
fn pairs_that_are_close_at_rest_are_exempt() {
    let material = Material { mass: 0.01, stiffness: 100.0, damping: 0.0 };
    let mut scene = Scene { world: weightless(), ..Scene::default() };
    let body = scene.add("cloth", shape::cloth([6, 6], 0.1, material).expect("a cloth"));
    let particles: Vec<usize> = scene.bodies[body].particles.clone().collect();
    // Wider than two spacings: also particles that no spring joins.
    scene.add_touch(touch(particles, 0.11)).expect("a few pairs");
    assert!(!scene.exempt.is_empty());
    let simulation = simulation::<f64>(&scene, Settings::default());
    assert!(simulation.forces().0.iter().all(|force| force.length() < 1e-12));
}

#[test]
fn rows_that_make_no_sense_are_refused() {
    let refused = |change: fn(&mut Scene), words: &str| {
        let mut scene = cloud(7, 40);
        change(&mut scene);
        let error = Simulation::<f64>::new(&scene, Settings::default()).expect_err(words);
        assert!(error.to_string().contains(words), "{error}");
    };
    refused(|scene| scene.touches[1].radius = 0.0, "radius of touch 1 is 0");
    refused(|scene| scene.touches[0].stiffness = f64::NAN, "stiffness of touch 0 is NaN");
    refused(|scene| scene.touches[0].damping = -1.0, "damping of touch 0 is -1");
    refused(|scene| scene.touches[2].friction = f64::INFINITY, "friction of touch 2");
    refused(|scene| scene.touches[2].particles[0] = 0, "in one row of touches, once");
    refused(|scene| scene.touches[0].particles[0] = 99, "touch 0");
    refused(|scene| scene.touches[1].ignored.push(1), "touch 1");
    refused(|scene| scene.touches[2].between[0].row = 2, "touch 2");
    let twice =
        |scene: &mut Scene| scene.touches[2].between.push(Between { row: 1, ..Between::default() });
    refused(twice, "other row of touch 2 is 1; it must be named once");
    refused(
        |scene| scene.touches[2].between[0].stiffness = Some(0.0),
        "stiffness between rows of touch 2 is 0",
    );
    refused(
        |scene| scene.touches[2].between[0].friction = Some(-0.5),
        "friction between rows of touch 2 is -0.5",
    );
    let follows = "damping that follows from the stiffness between rows of touch 2 is";
    // Softer than the smallest number, and a factor beyond the largest.
    let soft: fn(&mut Scene) = |scene| scene.touches[1].stiffness = 5e-324;
    refused(soft, &format!("{follows} inf; it must be finite and not negative"));
    let undamped = |scene: &mut Scene| {
        scene.touches[1].stiffness = 5e-324;
        scene.touches[1].damping = 0.0;
    };
    refused(undamped, &format!("{follows} NaN"));
    let mut stiff = cloud(7, 40);
    stiff.touches[2].between[0].stiffness = Some(1e12);
    stiff.touches[1].stiffness = 1e-30;
    Simulation::<f64>::new(&stiff, Settings::default()).expect("finite in double precision");
    let error = Simulation::<f32>::new(&stiff, Settings::default()).expect_err("beyond single");
    assert!(error.to_string().contains(follows), "{error}");
    refused(|scene| scene.exempt.push([0, 40]), "exempt pair");
    let mut scene = cloud(7, 4000);
    scene.particles.iter_mut().for_each(|particle| particle.position = DVec3::ONE);
    let error = Simulation::<f32>::new(&scene, Settings::default()).expect_err("a point");
    assert!(error.to_string().contains("pairs of particles closer than their radii"), "{error}");
}

#[test]
fn what_is_removed_touches_nothing() {
    let scene = cloud(8, 300);
    let mut simulation = simulation::<f64>(&scene, Settings::default());
    simulation.step().expect("a stable step");
    (0..150).for_each(|at| simulation.remove_particle(at).expect("a particle"));
    simulation.step().expect("a stable step");
    let (forces, _) = simulation.forces();
    assert!(forces[..150].iter().all(|&force| force == DVec3::ZERO));
    let (scene, progress) = simulation.progress();
    let resumed: Simulation<f64> = Simulation::resume(&scene, &progress).expect("a checkpoint");
    assert_eq!(resumed.forces(), (forces, simulation.forces().1));
    let single = simulation.convert::<f32>().expect("numbers that fit");
    let off = single.forces().0[200].to_f64() - simulation.forces().0[200];
    assert!(off.length() < 1e-3);
}

/// Rows that are set on a simulation give the bits of a scene that has them; rows that are refused
/// leave those before.
#[test]
fn rows_that_are_set_are_those_of_a_scene_that_has_them() {
    let scene = cloud(11, 120);
    let run = |mut simulation: Simulation<f64>| {
        (0..30).for_each(|_| simulation.step().expect("a calm run"));
        simulation.state()
    };
    let settings = settings(Integrator::default(), 32);
    let touching = simulation::<f64>(&scene, settings);
    let bare = Scene { touches: vec![], exempt: vec![], ..scene.clone() };
    let mut set = simulation::<f64>(&bare, settings);
    set.set_touches(&scene.touches, &scene.exempt).expect("valid rows");
    let mut refused = scene.touches.clone();
    refused[1].radius = -1.0;
    let error = set.set_touches(&refused, &[]).expect_err("a negative radius").to_string();
    assert!(error.contains("radius of touch 1 is -1"), "{error}");
    assert_eq!(set.model().touches().rows(), (&*scene.touches, &*scene.exempt));
    assert_eq!(run(set), run(touching));
    let mut cleared = simulation::<f64>(&scene, settings);
    cleared.set_touches(&[], &[]).expect("no rows");
    assert_eq!(run(cleared), run(simulation::<f64>(&bare, settings)));
}

/// A particle that is pinned and one that lies on it, of two rows with a law of their own between.
#[test]
fn what_lies_on_another_body_sinks_in_by_its_weight_over_the_stiffness_of_the_pair() {
    let (stiffness, g) = (250.0, 10.0);
    let between = Between { row: 0, stiffness: Some(stiffness), ..Between::default() };
    let above = Touch { damping: 4.0, between: vec![between], ..touch(vec![1], 0.05) };
    let below = Touch { damping: 4.0, ..touch(vec![0], 0.05) };
    let scene = Scene {
        particles: vec![
            particle(DVec3::ZERO, DVec3::ZERO, 1.0),
            particle(0.1 * DVec3::Y, DVec3::ZERO, 1.0),
        ],
        touches: vec![below, above],
        pins: vec![Pin { particle: 0, velocity: DVec3::ZERO }],
        world: World { gravity: -g * DVec3::Y, ..World::default() },
        ..Scene::default()
    };
    for integrator in Integrator::ALL {
        let mut simulation: Simulation<f64> = simulation(&scene, settings(integrator, 8));
        (0..900).for_each(|_| simulation.step().expect("a stable step"));
        let overlap = 0.1 - simulation.positions().nth(1).expect("two").y;
        // What is left of the motion: c/2m = 1.25 / s, for 15 s.
        assert!((overlap - g / stiffness).abs() < 1e-6, "{integrator}: {overlap}");
    }
}

/// A particle slides over a pinned one in the middle of its way: without friction between the two
/// it keeps its speed, whatever the friction of each.
#[test]
fn friction_of_a_pair_stands_in_place_of_that_of_both() {
    let lost = |friction| {
        let rough = |particle| Touch { friction: 0.5, ..touch(vec![particle], 0.05) };
        let between = Between { row: 0, friction, ..Between::default() };
        let scene = Scene {
            particles: vec![
                particle(DVec3::ZERO, DVec3::ZERO, 1.0),
                particle(DVec3::new(-0.2, 0.095, 0.0), DVec3::X, 1.0),
            ],
            touches: vec![rough(0), Touch { between: vec![between], ..rough(1) }],
            pins: vec![Pin { particle: 0, velocity: DVec3::ZERO }],
            world: weightless(),
            ..Scene::default()
        };
        let mut simulation: Simulation<f64> =
            simulation(&scene, settings(Integrator::VelocityVerlet, 64));
        (0..24).for_each(|_| simulation.step().expect("a stable step"));
        simulation.energy().dissipated
    };
    assert_eq!(lost(Some(0.0)), 0.0);
    // While so little slows it, what friction takes is in proportion to its factor.
    let (little, twice) = (lost(Some(0.01)), lost(Some(0.02)));
    assert!(0.0 < little && (twice / little - 2.0).abs() < 0.02, "{little}, {twice}");
    assert_eq!(lost(None), lost(Some(0.5)));
}
