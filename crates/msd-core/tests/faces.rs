//! Particles with a radius against triangles: their push, its bits, what rests on and hits what.

mod common;
#[path = "common/touching.rs"]
mod touching;

use common::{Random, distance, weightless};
use msd_core::glam::DVec3;
use msd_core::{Integrator, Material, Scene, Settings, Simulation, Spring, State, Touch, shape};
use touching::{check_bits, corners, faced, over, particle, pinned, settings, simulation};

/// Triangles in fans of four particles, some of which are longer than all radii, among particles
/// without any, in three rows as follows: the third has no triangles, passes through the first and
/// through itself; some springs, and some exempt pairs.
fn cloud(seed: u64, count: usize) -> Scene {
    let mut random = Random(seed);
    let side = (count as f64).cbrt() * 0.12;
    let mut scene = Scene { world: weightless(), ..Scene::default() };
    for at in 0..count {
        // The last three of each eight stand about the one before them.
        let edge = if at % 24 < 8 { 0.5 } else { 0.15 };
        let position = match at % 8 {
            5.. => scene.particles[at / 8 * 8 + 4].position + (random.vector() - 0.5) * edge,
            _ => random.vector() * side,
        };
        scene.particles.push(particle(position, random.vector() - 0.5, 0.1 + random.unit()));
    }
    let rows: Vec<Vec<usize>> =
        (0..3).map(|row| (0..count).filter(|at| at / 8 % 3 == row).collect()).collect();
    for (row, (particles, radius)) in rows.into_iter().zip([0.04, 0.06, 0.05]).enumerate() {
        let fans = (row * 8..count - 7).step_by(24).filter(|_| row < 2);
        let triangles = fans.flat_map(|at| [[at + 4, at + 5, at + 6], [at + 6, at + 5, at + 7]]);
        let triangles = triangles.collect();
        let row = faced(particles, triangles, radius);
        scene.touches.push(Touch { damping: 3.0, friction: 0.4, ..row });
    }
    scene.touches[1].stiffness = 900.0;
    (scene.touches[2].itself, scene.touches[2].ignored) = (false, vec![0]);
    let spring =
        |at: usize| Spring { ends: [at, at + 5], rest_length: 0.1, stiffness: 50.0, damping: 0.1 };
    scene.springs = (0..count / 8).map(spring).collect();
    scene.exempt = (0..count / 8).map(|at| [at + 8, at]).collect();
    scene
}

/// The weights of the point of a triangle nearest to another (Ericson, 2005, section 5.1.5).
fn weights([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let [d1, d2] = [ab, ac].map(|edge| edge.dot(point - a));
    let [d3, d4] = [ab, ac].map(|edge| edge.dot(point - b));
    let [d5, d6] = [ab, ac].map(|edge| edge.dot(point - c));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        [1.0, 0.0, 0.0]
    } else if 0.0 <= d3 && d4 <= d3 {
        [0.0, 1.0, 0.0]
    } else if 0.0 <= d6 && d5 <= d6 {
        [0.0, 0.0, 1.0]
    } else if vc <= 0.0 && 0.0 <= d1 && d3 <= 0.0 {
        [1.0 - d1 / (d1 - d3), d1 / (d1 - d3), 0.0]
    } else if vb <= 0.0 && 0.0 <= d2 && d6 <= 0.0 {
        [1.0 - d2 / (d2 - d6), 0.0, d2 / (d2 - d6)]
    } else if va <= 0.0 && d3 <= d4 && d6 <= d5 {
        let part = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        [0.0, 1.0 - part, part]
    } else {
        [va, vb, vc].map(|area| area / (va + vb + vc))
    }
}

/// The force on a particle and the power that it dissipates, by a weighted mean of others.
fn pushed(
    (scene, state, [first, second]): (&Scene, &State<f64>, [&Touch; 2]),
    bead: usize,
    (points, weights): (&[usize], &[f64]),
    share: f64,
) -> Option<(DVec3, f64)> {
    let mean = |column: &[DVec3]| -> DVec3 {
        points.iter().zip(weights).map(|(&at, &weight)| column[at] * weight).sum()
    };
    let d = state.positions[bead] - mean(&state.positions);
    let v = state.velocities[bead] - mean(&state.velocities);
    let overlap = first.radius + second.radius - d.length();
    if overlap <= 0.0 {
        return None;
    }
    let in_turn = |x: f64, y: f64| x * y / (x + y);
    let k = share * in_turn(first.stiffness, second.stiffness);
    let c = share * in_turn(first.damping, second.damping);
    let mu = (first.friction * second.friction).sqrt();
    let n = d.normalize();
    let push = (k * overlap - c * n.dot(v)).max(0.0);
    let slip = v - n * n.dot(v);
    let inverse = |at: usize| 1.0 / scene.particles[at].mass;
    let squares = points.iter().zip(weights).map(|(&at, weight)| weight * weight * inverse(at));
    let mass = 1.0 / (inverse(bead) + squares.sum::<f64>());
    let drag = ((k * mass).sqrt() * slip.length()).min(mu * push);
    let force = n * push - slip.normalize_or_zero() * drag;
    Some((force, k * overlap * n.dot(v) - force.dot(v)))
}

/// Forces and power by a plain loop over all particles and their pairs and triangles.
fn plainly(scene: &Scene, state: &State<f64>) -> (Vec<DVec3>, f64) {
    let count = scene.particles.len();
    let row_of = |at: usize| scene.touches.iter().position(|row| row.particles.contains(&at));
    let rows: Vec<_> = (0..count).map(row_of).collect();
    let spared = |a: usize, b: usize| {
        let is = |pair: [usize; 2]| pair == [a, b] || pair == [b, a];
        scene.springs.iter().any(|spring| is(spring.ends)) || scene.exempt.iter().any(|&p| is(p))
    };
    let is_corner = |at: usize| {
        scene.touches.iter().any(|row| row.triangles.iter().any(|corners| corners.contains(&at)))
    };
    let (mut forces, mut power) = (vec![DVec3::ZERO; count], 0.0);
    let mut push = |bead: usize, points: &[usize], weights: &[f64], share: f64| {
        let [Some(p), Some(q)] = [rows[bead], rows[points[0]]] else { panic!("two beads") };
        let both = [p.min(q), p.max(q)].map(|row| &scene.touches[row]);
        let found = pushed((scene, state, both), bead, (points, weights), share);
        let Some((force, taken)) = found else { return };
        forces[bead] += force;
        points.iter().zip(weights).for_each(|(&at, &weight)| forces[at] -= force * weight);
        power += taken;
    };
    let meet = |a: usize, b: usize| {
        let (Some(p), Some(q)) = (rows[a], rows[b]) else { return false };
        let [first, second] = [p.min(q), p.max(q)];
        let ignores = scene.touches[second].ignored.contains(&first);
        if p == q { scene.touches[p].itself } else { !ignores }
    };
    for a in 0..count {
        for b in (a + 1..count).filter(|&b| !is_corner(a) && !is_corner(b)) {
            if meet(a, b) && !spared(a, b) {
                push(b, &[a], &[1.0], 1.0);
            }
        }
        for row in &scene.touches {
            let faces = |corners: &&[usize; 3]| {
                meet(a, corners[0]) && corners.iter().all(|&at| at != a && !spared(a, at))
            };
            let nearest = |corners: &[usize; 3]| {
                let places = corners.map(|at| state.positions[at]);
                let weights = weights(places, state.positions[a]);
                let point: DVec3 = places.iter().zip(weights).map(|(&at, by)| at * by).sum();
                ((state.positions[a] - point).length(), *corners, weights)
            };
            let all = row.triangles.iter().filter(faces).map(nearest);
            if let Some((_, corners, weights)) = all.min_by(|a, b| a.0.total_cmp(&b.0)) {
                push(a, &corners, &weights, if is_corner(a) { 0.5 } else { 1.0 });
            }
        }
    }
    (forces, power)
}

#[test]
fn forces_are_those_of_a_plain_loop() {
    for (seed, count) in [(1, 48), (2, 240), (3, 720)] {
        let scene = cloud(seed, count);
        let without = Scene { touches: vec![], ..scene.clone() };
        let [with, without] =
            [&scene, &without].map(|scene| simulation::<f64>(scene, Settings::default()));
        let (wanted, power) = plainly(&scene, &with.state());
        let ((forces, taken), (others, other)) = (with.forces(), without.forces());
        // A sum of a few tens of numbers, each rounded a few times; weights of slivers more often.
        let largest = forces.iter().map(|force| force.length()).fold(0.0, f64::max);
        for (at, wanted) in wanted.iter().enumerate() {
            let off = (forces[at] - others[at] - *wanted).length();
            assert!(off < 1e-10 * largest, "{at} of {count}: {off} N");
        }
        assert!((taken - other - power).abs() < 1e-10 * taken, "{taken} {other} {power}");
        // Far more than pairs alone.
        let mut bare = scene.clone();
        bare.touches.iter_mut().for_each(|row| row.triangles.clear());
        let (pairs, _) = plainly(&bare, &with.state());
        let changed = pairs.iter().zip(&wanted).filter(|(a, b)| (**a - **b).length() > 1e-6);
        assert!(count / 4 < changed.count() && 1.0 < largest && 0.0 < power);
    }
}

#[test]
fn bits_depend_neither_on_instructions_nor_on_the_list() {
    let scene = cloud(4, 480);
    check_bits::<f32>(&scene);
    check_bits::<f64>(&scene);
}

/// A wide triangle that turns as it flies past a crowd: its corners and what it meets are in cells
/// that do not touch, and the crowd moves alike.
#[test]
fn what_comes_from_afar_is_met_whatever_the_list_was_made_at() {
    let mut random = Random(5);
    let mut scene = Scene { world: weightless(), ..Scene::default() };
    for corner in corners() {
        // As if it turned about x, 4 m away.
        let velocity = DVec3::new(0.0, -4.0 - 2.0 * corner.z, 0.0);
        scene.particles.push(particle(corner * 4.0 + DVec3::Y * 4.0, velocity, 1.0));
    }
    for _ in 0..200 {
        let place = (random.vector() - 0.5) * DVec3::new(2.0, 0.2, 1.5);
        scene.particles.push(particle(place, DVec3::Y, 0.01));
    }
    scene.touches =
        vec![faced(vec![0, 1, 2], vec![[0, 1, 2]], 0.03), faced((3..203).collect(), vec![], 0.03)];
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4] {
        let mut run = simulation::<f64>(&scene, settings(integrator, 16));
        let mut resumed = run.clone();
        for step in 0..70 {
            run.step().expect("a stable step");
            resumed.step().expect("a stable step");
            assert_eq!(run.ledger().passes(), resumed.ledger().passes(), "{integrator} {step}");
            let (scene, progress) = resumed.progress();
            resumed = Simulation::resume(&scene, &progress).expect("a checkpoint of this run");
        }
        assert_eq!(run.state(), resumed.state(), "{integrator}");
        let turned = run.state().velocities[3..].iter().filter(|v| v.y < 0.0).count();
        assert!(100 < turned, "{integrator}: it met {turned}");
    }
}

#[test]
fn the_push_is_the_gradient_of_its_energy() {
    let mut scene = cloud(5, 240);
    scene.springs.clear();
    scene.touches.iter_mut().for_each(|row| (row.damping, row.friction) = (0.0, 0.0));
    let simulation = simulation::<f64>(&scene, Settings::default());
    let mut random = Random(6);
    let directions: Vec<DVec3> = (0..240).map(|_| random.vector() - 0.5).collect();
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
    // The energy has a second derivative that jumps where contacts open: an error of the first
    // order.
    assert!((slope - wanted).abs() < 1e-4 * wanted.abs(), "{slope} instead of {wanted}");
}

/// Two flat sheets with triangles, one turning, that meet face to face.
fn collision() -> Scene {
    let material = Material { mass: 0.01, stiffness: 300.0, damping: 0.02 };
    let mut scene = Scene { world: weightless(), ..Scene::default() };
    for (away, velocity, spin) in [(0.0, 0.6, 0.0), (0.15, -0.4, 2.0)] {
        let mut part = shape::cloth([5, 5], 0.2, material).expect("a cloth");
        part.set_motion(DVec3::Z * velocity, DVec3::Z * spin);
        let place = DVec3::new(0.6 * away, 0.4 * away, away);
        part.place(msd_core::glam::DMat3::IDENTITY, place);
        let body = scene.add("cloth", part);
        let surface = &scene.bodies[body].surface;
        let corner = |at: u32| surface.corners[at as usize].particle as usize;
        let triangles = surface.triangles.iter().map(|triangle| triangle.map(corner)).collect();
        let particles = scene.bodies[body].particles.clone().collect();
        let row = faced(particles, triangles, 0.045);
        scene.add_touch(Touch { damping: 0.5, ..row }).expect("a few pairs");
    }
    scene
}

#[test]
fn a_collision_keeps_momentum_under_every_method() {
    // Without friction, which is a couple on particles that cannot spin.
    let scene = collision();
    for integrator in
        Integrator::ALL.into_iter().filter(|&method| method != Integrator::ExplicitEuler)
    {
        let mut simulation = simulation::<f64>(&scene, settings(integrator, 40));
        let (before, energy) = (simulation.momentum(), simulation.energy().total());
        let mut elastic = 0.0_f64;
        for _ in 0..30 {
            simulation.step().expect("a stable step");
            elastic = elastic.max(simulation.energy().elastic);
        }
        let after = simulation.momentum();
        // Linear momentum to rounding; angular, too, but where a solve is not exact.
        let scale = 0.25 * 0.6;
        assert!((after.linear - before.linear).length() < 1e-12 * scale, "{integrator}");
        let turned = (after.angular - before.angular).length() / before.angular.length();
        let most = match integrator {
            Integrator::BackwardEuler | Integrator::ImplicitMidpoint | Integrator::Xpbd => 5e-3,
            Integrator::DormandPrince => 1e-4,
            _ => 1e-8,
        };
        assert!(turned < most, "{integrator}: {turned}");
        assert!(1e-3 < elastic, "{integrator}: they met");
        let centres = [0..25, 25..50].map(|body| simulation.centre_of_mass(body).z);
        assert!(centres[0] < centres[1], "{integrator}: one is through the other {centres:?}");
        let gained = simulation.energy().total() - energy;
        // By h w of the elastic part, which symplectic Euler swings by.
        assert!(gained < 5e-3 * energy, "{integrator}: gained {gained} of {energy} J");
    }
}

/// The force on a particle that touches a roof of two triangles about the z axis, and one beside
/// it, given how steep its sides are.
fn over_roof(slope: f64) -> impl Fn(DVec3) -> DVec3 {
    let places = [
        DVec3::new(0.0, 0.0, -0.5),
        DVec3::new(0.0, 0.0, 0.5),
        DVec3::new(-0.5, -0.5 * slope, 0.0),
        DVec3::new(0.5, -0.5 * slope, 0.1),
        DVec3::new(0.4, -0.5 * slope, 0.9),
    ];
    let mut particles: Vec<_> =
        places.into_iter().map(|place| particle(place, DVec3::ZERO, 1.0)).collect();
    particles.push(particle(DVec3::Y * 0.05, DVec3::ZERO, 1.0));
    let triangles = vec![[0, 1, 2], [1, 0, 3], [1, 3, 4]];
    let touches = vec![faced((0..5).collect(), triangles, 0.05), faced(vec![5], vec![], 0.05)];
    let scene = Scene { world: weightless(), particles, touches, ..Scene::default() };
    let simulation = simulation::<f64>(&scene, Settings::default());
    move |place: DVec3| {
        let (mut simulation, mut state) = (simulation.clone(), simulation.state());
        state.positions[5] = place;
        simulation.set_state(&state, 0).expect("a state");
        simulation.forces().0[5]
    }
}

/// The force is the stiffness times a vector that no motion changes by more than its own length
/// where the distance has no ridge: on the outer side of a surface.
#[test]
fn the_force_is_continuous_over_edges_and_corners() {
    for slope in [0.0, 0.4] {
        let force = over_roof(slope);
        // Over the ridge, along it, around its end and over a corner that three triangles have.
        let paths = [
            [DVec3::new(-0.3, 0.06, 0.1), DVec3::new(0.3, 0.06, 0.13)],
            [DVec3::new(0.01, 0.05, 0.2), DVec3::new(0.01, 0.05, 0.8)],
            [DVec3::new(0.1, 0.03, 0.2), DVec3::new(-0.1, 0.05, 0.6)],
            [DVec3::new(-0.02, 0.06, -0.3), DVec3::new(-0.02, 0.02, -0.62)],
        ];
        for [from, to] in paths {
            let steps = 2000;
            let stride = (to - from).length() / f64::from(steps);
            let mut last = force(from);
            let mut pushed = 0;
            for step in 1..=steps {
                let here = force(from.lerp(to, f64::from(step) / f64::from(steps)));
                // k reach n / L turns no faster than this with L at least 2 cm.
                let most = 200.0 * stride * (0.1 / 0.02);
                assert!((here - last).length() <= most, "{slope} {from} {step}: {last} {here}");
                pushed += i32::from(here != DVec3::ZERO);
                last = here;
            }
            assert!(steps / 5 < pushed, "{slope} {from}: {pushed}");
        }
    }
}

/// Two that are corners both push each other from both sides as a pair does.
#[test]
fn two_corners_push_each_other_as_a_pair() {
    let tip = |y: f64, way: f64| {
        [DVec3::new(0.0, y, 0.0), DVec3::new(0.3, y + way, 0.2), DVec3::new(-0.3, y + way, 0.1)]
    };
    let places = tip(0.0, -1.0).into_iter().chain(tip(0.08, 1.0));
    let particles = places.map(|place| particle(place, DVec3::ZERO, 1.0)).collect();
    let touches = vec![
        faced(vec![0, 1, 2], vec![[0, 1, 2]], 0.05),
        faced(vec![3, 4, 5], vec![[3, 4, 5]], 0.05),
    ];
    let scene = Scene { world: weightless(), particles, touches, ..Scene::default() };
    let mut bare = scene.clone();
    bare.touches.iter_mut().for_each(|row| row.triangles.clear());
    let [with, without] =
        [&scene, &bare].map(|scene| simulation::<f64>(scene, Settings::default()).forces().0);
    assert!((with[3] - DVec3::Y * 4.0).length() < 1e-12, "{}", with[3]);
    for (with, without) in with.iter().zip(without) {
        assert!((*with - without).length() < 1e-12);
    }
}

/// Source of the closed form: Schwager and Pöschel, 2007, for a damped spring that never pulls.
#[test]
fn a_particle_parts_from_a_triangle_at_the_speed_of_the_closed_form() {
    // Over the centre the triangle moves as a whole: 0.9 kg.
    let (mass, k) = (0.09_f64, 200.0_f64);
    let centre = corners().into_iter().sum::<DVec3>() / 3.0;
    for ratio in [0.0, 0.05, 0.2, 0.5] {
        let natural = (k / mass).sqrt();
        let beta = ratio * natural;
        let w = (natural * natural - beta * beta).sqrt();
        let phase = (2.0 * beta * w / (w * w - beta * beta)).atan();
        let wanted = (-beta / w * (std::f64::consts::PI - phase)).exp();
        let scene = over(
            corners().map(|corner| particle(corner, DVec3::ZERO, 0.3)),
            particle(centre + DVec3::Y * 0.11, -DVec3::Y, 0.1),
            // c of the two is half of that of each row, and 2 m β.
            |row| Touch { damping: 4.0 * mass * beta, ..row },
        );
        for integrator in Integrator::ALL {
            let settings = Settings { tolerance: 1e-10, ..settings(integrator, 2000) };
            let mut simulation = simulation::<f64>(&scene, settings);
            (0..40).for_each(|_| simulation.step().expect("a stable step"));
            let velocities = simulation.state().velocities;
            let found = velocities[3].y - velocities[..3].iter().map(|v| v.y).sum::<f64>() / 3.0;
            // The first substep of the contact is missed in part: h v of a depth of v/w.
            let h_w = natural / 120_000.0;
            let most = if integrator == Integrator::DormandPrince { 1e-3 } else { 2.0 * h_w };
            assert!((found - wanted).abs() < most, "{ratio} {integrator}: {found}, not {wanted}");
        }
    }
}

#[test]
fn a_weight_at_rest_is_shared_by_the_weights_under_every_method() {
    let [a, b, c] = corners();
    let (parts, g) = ([0.5, 0.3, 0.2], 10.0);
    let under = a * parts[0] + b * parts[1] + c * parts[2];
    let mut scene = pinned(over(
        corners().map(|corner| particle(corner, DVec3::ZERO, 1.0)),
        particle(under + DVec3::Y * 0.1, DVec3::ZERO, 1.0),
        |row| Touch { damping: 8.0, friction: 0.5, ..row },
    ));
    scene.world.gravity = -g * DVec3::Y;
    for integrator in Integrator::ALL {
        let mut simulation = simulation::<f64>(&scene, settings(integrator, 8));
        (0..900).for_each(|_| simulation.step().expect("a stable step"));
        let place = simulation.position(3);
        // m g / k of 200 N/m; what is left of the motion after 15 s at c/2m = 2 / s.
        assert!((place - under - DVec3::Y * 0.05).length() < 1e-9, "{integrator}: {place}");
        for (at, part) in parts.into_iter().enumerate() {
            let wanted = -DVec3::Y * g * (1.0 + part);
            let force = simulation.forces().0[at];
            assert!((force - wanted).length() < 1e-6, "{integrator}: {force}, not {wanted}");
        }
    }
}

#[test]
fn rows_that_make_no_sense_are_refused() {
    let refused = |triangle: [usize; 3], words: &str| {
        let mut scene = cloud(7, 48);
        scene.touches[1].triangles.push(triangle);
        let error = Simulation::<f64>::new(&scene, Settings::default()).expect_err(words);
        assert!(error.to_string().contains(words), "{error}");
    };
    refused([8, 9, 8], "triangle of touch 1 is 4; it must be three different particles");
    refused([8, 9, 16], "corner of touch 1 is 16; it must be a particle of the row");
    refused([8, 9, 48], "touch 1");
    let mut scene = cloud(7, 48);
    scene.touches[1].triangles = vec![[12, 13, 14]; 40_000];
    let error = Simulation::<f64>::new(&scene, Settings::default()).expect_err("one place");
    assert!(error.to_string().contains("closer than their radii"), "{error}");
}

#[test]
fn what_is_removed_takes_its_triangles_with_it() {
    let scene = cloud(8, 240);
    let mut simulation = simulation::<f64>(&scene, Settings::default());
    simulation.step().expect("a stable step");
    // Every fan loses a corner of both triangles.
    (0..30).for_each(|at| simulation.remove_particle(8 * at + 5).expect("a particle"));
    let rows = simulation.model().touches().rows().0;
    assert!(rows.iter().all(|row| row.triangles.is_empty()));
    simulation.step().expect("a stable step");
    let (forces, _) = simulation.forces();
    assert!((0..30).all(|at| forces[8 * at + 5] == DVec3::ZERO));
    let (scene, progress) = simulation.progress();
    let resumed: Simulation<f64> = Simulation::resume(&scene, &progress).expect("a checkpoint");
    assert_eq!(resumed.forces(), (forces, simulation.forces().1));
}

/// A push with a damper jumps where it begins, at a time that no substep meets: of the first order
/// at worst. Those that solve would not come to the same end by another derivative.
#[test]
fn the_error_of_a_collision_falls_at_least_with_the_substep() {
    let scene = collision();
    let end = |integrator, substeps| {
        let settings = Settings { tolerance: 1e-9, ..settings(integrator, substeps) };
        let mut simulation = simulation::<f64>(&scene, settings);
        (0..20).for_each(|_| simulation.step().expect("a stable step"));
        simulation.state()
    };
    let reference = end(Integrator::VelocityVerlet, 1280);
    for integrator in
        Integrator::ALL.into_iter().filter(|&method| method != Integrator::ExplicitEuler)
    {
        let [coarse, fine] = [20, 80].map(|count| distance(&end(integrator, count), &reference));
        // A quarter, and a bad hit; of Dormand-Prince the error of the reference, h v.
        let most = if integrator == Integrator::DormandPrince { 3e-4 } else { 0.45 * coarse };
        assert!(fine < most, "{integrator}: {coarse:e} {fine:e}");
    }
}
