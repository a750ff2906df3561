//! Solids of a shape: their surfaces, and what slides on, rests on and is pushed by them.

mod common;

use common::Random;
use msd_core::glam::DVec3;
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, Material, Neighbours, Particle, Pin, Real, Scene, Settings, Shape,
    Simulation, Solid, Spring, Vector, World, shape, testing,
};
use std::f64::consts::PI;

const G: f64 = 9.82;
const SHAPES: [Shape; 5] = [
    Shape::Sphere { radius: 0.7 },
    Shape::Capsule { radius: 0.4, length: 1.1 },
    Shape::Box { size: DVec3::new(0.8, 1.2, 0.5) },
    Shape::Cylinder { radius: 0.6, length: 0.9 },
    Shape::Torus { radius: 0.8, tube: 0.25 },
];

fn scene(position: DVec3, velocity: DVec3, solids: Vec<Solid>) -> Scene {
    let particles = vec![Particle { position, velocity, mass: 0.3 }];
    Scene { particles, solids, ..Scene::default() }
}

fn simulation<R: Real>(scene: &Scene, integrator: Integrator, substeps: u32) -> Simulation<R> {
    let settings = Settings { integrator, substeps, ..Settings::default() };
    Simulation::new(scene, settings).expect("a valid scene")
}

#[test]
fn the_normal_is_the_gradient_of_the_gap_still_and_moving() {
    let mut random = Random(3);
    for shape in SHAPES {
        let points: Vec<DVec3> = (0..200).map(|_| (random.vector() - 0.5) * 4.0).collect();
        let mut solid = Solid::new(shape);
        assert_eq!(testing::check_obstacle(&solid, &points, 0.0), Ok(()), "{shape:?}");
        solid.axes = rotation(DVec3::new(2.0, -1.0, 2.0) / 3.0, 0.8);
        solid.position = DVec3::new(0.2, 0.1, -0.3);
        (solid.velocity, solid.spin) = (DVec3::X * 0.4, DVec3::new(0.5, -0.2, 0.9));
        assert_eq!(testing::check_obstacle(&solid, &points, 1.7), Ok(()), "{shape:?}");
    }
}

#[test]
fn gaps_are_distances_and_nothing_is_beyond_the_reach() {
    let mut random = Random(5);
    for shape in SHAPES {
        for _ in 0..500 {
            let point = (random.vector() - 0.5) * 4.0;
            let gap = shape.gap(point);
            // From a point outside, the way back along the normal ends on the surface.
            if 0.0 < gap {
                let foot = point - shape.normal(point) * gap;
                assert!(shape.gap(foot).abs() < 1e-14, "{shape:?} {point}");
                assert!(foot.length() < shape.reach() + 1e-14, "{shape:?} {point}");
            }
        }
    }
    assert_eq!(SHAPES[2].gap(DVec3::new(0.7, 1.0, 0.0)), 0.5);
    assert_eq!(SHAPES[3].gap(DVec3::new(0.0, 0.2, 0.0)), 0.2 - 0.45);
    assert!((SHAPES[4].gap(DVec3::ZERO) - 0.55).abs() < 1e-15);
}

/// A ball without friction is left where the pressure ends: at a height of two thirds (v² = 2 g r
/// (1 − cos) and v² = g r cos).
#[test]
fn a_particle_leaves_a_smooth_ball_at_two_thirds_of_its_height() {
    for integrator in Integrator::ALL {
        let (sine, cosine) = 0.05f64.sin_cos();
        let start = DVec3::new(sine, cosine, 0.0);
        let scene = scene(start, DVec3::ZERO, vec![Solid::new(Shape::Sphere { radius: 1.0 })]);
        let settings = Settings { integrator, step: 1e-3, substeps: 10, ..Settings::default() };
        let mut run = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
        let mut height = 1.0;
        while run.position(0).length() < 1.0 + 1e-6 {
            height = run.position(0).y;
            run.step().expect("a calm run");
        }
        // The gap grows with 3 g t³/6 or so: a micrometre takes 6 ms, in which it falls by 14 mm.
        // Implicit midpoint lets go half a per cent early.
        let late = cosine * 2.0 / 3.0 - height;
        assert!((-5e-3..16e-3).contains(&late), "{integrator}: {late}");
    }
}

/// Below the critical slope of a tilted box a particle stays, above it slides with g (sin − μ cos).
#[test]
fn a_tilted_box_holds_or_lets_slide() {
    let friction = 0.5f64;
    for integrator in Integrator::ALL {
        for (degrees, slides) in [(25.0f64, false), (35.0, true)] {
            let angle = degrees.to_radians();
            let mut ramp = Solid::new(Shape::Box { size: DVec3::new(20.0, 1.0, 20.0) });
            ramp.axes = rotation(DVec3::Z, angle);
            ramp.friction = Friction::Coulomb(friction);
            let start = ramp.axes * (DVec3::Y * 0.5);
            let mut run = simulation::<f64>(&scene(start, DVec3::ZERO, vec![ramp]), integrator, 8);
            for _ in 0..60 {
                run.step().expect("a calm run");
            }
            let way = (run.position(0) - start).length();
            let a = G * (angle.sin() - friction * angle.cos());
            if slides {
                // First-order methods are off by a h t / 2.
                let late = a / 480.0;
                assert!((way - 0.5 * a).abs() < late, "{integrator}: {way} of {}", 0.5 * a);
            } else {
                assert!(way < 1e-12, "{integrator}: {way}");
            }
        }
    }
}

/// A wall that comes at 2 m/s returns a particle at rest with twice its speed, and the ledger knows
/// whose work that was.
#[test]
fn a_moving_wall_drives_what_it_hits() {
    for integrator in Integrator::ALL {
        let mut wall = Solid::new(Shape::Box { size: DVec3::new(1.0, 4.0, 4.0) });
        (wall.position, wall.velocity) = (DVec3::X * -1.0, DVec3::X * 2.0);
        wall.restitution = 1.0;
        let mut scene = scene(DVec3::ZERO, DVec3::ZERO, vec![wall]);
        scene.world = World { gravity: DVec3::ZERO, ..World::default() };
        let mut run = simulation::<f64>(&scene, integrator, 8);
        for _ in 0..30 {
            run.step().expect("a calm run");
        }
        let velocity = run.velocity(0);
        assert!((velocity - DVec3::X * 4.0).length() < 1e-12, "{integrator}: {velocity}");
        let energy = run.energy();
        assert!(energy.total().abs() < 1e-9, "{integrator}: {energy:?}");
    }
}

/// On a turntable below μ g / r a particle goes round with it; above it is flung off.
#[test]
fn a_turntable_carries_what_friction_holds() {
    let (friction, radius) = (0.5, 0.4);
    let critical = (friction * G / radius).sqrt();
    for integrator in [Integrator::VelocityVerlet, Integrator::SymplecticEuler] {
        for (share, stays) in [(0.9, true), (1.1, false)] {
            let mut table = Solid::new(Shape::Cylinder { radius: 2.0, length: 0.2 });
            table.position = DVec3::Y * -0.1;
            table.spin = DVec3::Y * (share * critical);
            table.friction = Friction::Coulomb(friction);
            let speed = table.spin.cross(DVec3::X * radius);
            let mut run =
                simulation::<f64>(&scene(DVec3::X * radius, speed, vec![table]), integrator, 200);
            for _ in 0..60 {
                run.step().expect("a calm run");
            }
            let off = run.position(0).length() - radius;
            // A path of chords: each substep adds (w h)²/2 of the radius at most.
            let drift = 60.0 * 200.0 * 0.5 * (share * critical / 12_000.0).powi(2) * radius;
            assert_eq!(off.abs() <= drift, stays, "{integrator} at {share}: {off}, {drift}");
        }
    }
}

#[test]
fn solids_are_kept_by_checkpoints_conversions_and_moves() {
    let mut ball = Solid::new(Shape::Sphere { radius: 1.0 });
    ball.spin = DVec3::Z;
    let start = scene(DVec3::Y, DVec3::X * 0.1, vec![ball]);
    let mut run = simulation::<f64>(&start, Integrator::VelocityVerlet, 8);
    (0..20).for_each(|_| run.step().expect("a calm run"));
    let (rows, progress) = run.progress();
    assert_eq!(rows.solids, [ball]);
    let mut resumed = Simulation::<f64>::resume(&rows, &progress).expect("a checkpoint");
    (0..20).for_each(|_| (run.step().unwrap(), resumed.step().unwrap()).0);
    assert_eq!(run.state(), resumed.state());
    assert_eq!(run.convert::<f32>().expect("it fits").model().solids(), [ball]);
    let moved = start.moved(DVec3::X * 3.0);
    assert_eq!(moved.solids[0].position, DVec3::X * 3.0);
    let far = scene(DVec3::Y * 9.0, DVec3::ZERO, vec![ball]);
    assert_eq!(Vector::to_f64(simulation::<f32>(&far, Integrator::Rk4, 1).position(0)).y, 9.0);
}

#[test]
fn what_is_no_solid_is_refused() {
    let refused = |change: &dyn Fn(&mut Solid)| {
        let mut solid = Solid::new(Shape::Sphere { radius: 1.0 });
        change(&mut solid);
        let scene = scene(DVec3::Y * 3.0, DVec3::ZERO, vec![solid]);
        Simulation::<f64>::new(&scene, Settings::default()).expect_err("refused").to_string()
    };
    let radius = refused(&|solid| solid.shape = Shape::Sphere { radius: 0.0 });
    assert!(radius.contains("radius") && radius.contains("solid 0"), "{radius}");
    let tube = refused(&|solid| solid.shape = Shape::Torus { radius: 1.0, tube: 1.0 });
    assert!(tube.contains("smaller than the radius"), "{tube}");
    assert!(refused(&|solid| solid.spin.y = f64::NAN).contains("spin"));
    assert!(refused(&|solid| solid.axes.x_axis.x = 2.0).contains("rotation"));
    assert!(refused(&|solid| solid.axes.x_axis.x = f64::NAN).contains("rotation"));
    assert!(refused(&|solid| solid.restitution = 1.5).contains("restitution"));
}

/// A rope that is drawn over a capsule at rest: the pulls at its two ends are as exp(μ angle)
/// (Euler and Eytelwein). It turns by π/32 at each particle, which is nearer than 0.1 % to a curve.
#[test]
fn a_rope_drawn_over_a_capsule_pulls_as_the_exponential_of_friction_and_angle() {
    let (radius, friction, speed) = (0.5, 0.3, 0.1);
    let (corners, straight) = (32, 8);
    let turn = PI / f64::from(corners);
    let spacing = 2.0 * radius * (turn / 2.0).sin();
    let mut path = Vec::new();
    for row in 0..straight {
        let depth = spacing * f64::from(straight - row);
        path.push((DVec3::new(-radius, -depth, 0.0), DVec3::Y));
    }
    for corner in 0..=corners {
        let (sine, cosine) = (PI - turn * f64::from(corner)).sin_cos();
        path.push((DVec3::new(cosine, sine, 0.0) * radius, DVec3::new(sine, -cosine, 0.0)));
    }
    for row in 1..=straight {
        path.push((DVec3::new(radius, -spacing * f64::from(row), 0.0), -DVec3::Y));
    }
    let particle = |&(position, along): &(DVec3, DVec3)| Particle {
        position,
        velocity: along * speed,
        mass: 1e-3,
    };
    let (stiffness, pull) = (5e4, 20.0);
    let rest_length = spacing - pull / stiffness;
    let last = path.len() - 1;
    let spring = |a| Spring { ends: [a, a + 1], rest_length, stiffness, damping: 5.0 };
    let mut capsule = Solid::new(Shape::Capsule { radius, length: 1.0 });
    capsule.axes = rotation(DVec3::X, PI / 2.0);
    capsule.friction = Friction::Coulomb(friction);
    let scene = Scene {
        world: World { gravity: DVec3::ZERO, ..World::default() },
        particles: path.iter().map(particle).collect(),
        springs: (0..last).map(spring).collect(),
        pins: [0, last].map(|row| Pin { particle: row, velocity: path[row].1 * speed }).into(),
        solids: vec![capsule],
        ..Scene::default()
    };
    let settings = Settings { step: 1e-3, substeps: 50, ..Settings::default() };
    let mut run = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
    let (mut before, mut behind) = (0.0, 0.0);
    // Once it slips all along, for as long as one particle takes to the place of the next.
    let (first, count) = (200, (1e3 * spacing / speed) as usize);
    for step in 0..first + count {
        run.step().expect("a calm run");
        if first <= step {
            let stretch = |a| (run.position(a + 1) - run.position(a)).length() - rest_length;
            before += stretch(0);
            behind += stretch(last - 1);
        }
    }
    let ratio = behind / before / (friction * PI).exp();
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
}

/// Dormand-Prince finds when a thrown particle meets a ball: where it is after the bounce tells the
/// time to within a nanosecond.
#[test]
fn the_time_of_an_impact_on_a_ball_is_right_to_a_nanosecond() {
    let mut ball = Solid::new(Shape::Sphere { radius: 0.8 });
    (ball.position, ball.restitution) = (DVec3::new(0.1, 0.7, -0.1), 1.0);
    ball.friction = Friction::Coulomb(0.0);
    let (start, thrown) = (DVec3::new(-2.0, 1.3, 0.2), DVec3::new(3.0, 1.0, -0.2));
    let flight =
        |from: DVec3, speed: DVec3, t: f64| from + speed * t - DVec3::Y * (G * t * t / 2.0);
    let gap = |t: f64| (flight(start, thrown, t) - ball.position).length() - 0.8;
    // The first root of a gap that falls until then.
    let (mut early, mut late) = (0.0, 0.5);
    assert!(gap(late) < 0.0);
    while early < (early + late) / 2.0 && (early + late) / 2.0 < late {
        let middle = (early + late) / 2.0;
        if gap(middle) < 0.0 { late = middle } else { early = middle }
    }
    let (place, speed) = (flight(start, thrown, early), thrown - DVec3::Y * (G * early));
    let normal = (place - ball.position).normalize();
    let change = -2.0 * speed.dot(normal);
    let scene = scene(start, thrown, vec![ball]);
    let mut run = simulation::<f64>(&scene, Integrator::DormandPrince, 1);
    (0..40).for_each(|_| run.step().expect("a calm run"));
    let end = flight(place, speed + normal * change, 40.0 / 60.0 - early);
    let off = (run.position(0) - end).length();
    // Late by t it is off by t times the change of its velocity.
    assert!(off < 1e-9 * change, "{off} after a change of {change} m/s at {early} s");
}

/// What a ball meets at 10 m/s is taken along in front of it: nothing of a cloth is left inside the
/// ball or behind it.
#[test]
fn a_ball_at_ten_metres_per_second_takes_a_cloth_along() {
    for integrator in [
        Integrator::SymplecticEuler,
        Integrator::VelocityVerlet,
        Integrator::BackwardEuler,
        Integrator::Xpbd,
    ] {
        let material = Material { mass: 1e-3, stiffness: 200.0, damping: 0.02 };
        let cloth = shape::lattice([21, 21, 1], Neighbours::All, 0.05, material).expect("a cloth");
        let mut scene = Scene::of("cloth", cloth);
        scene.world.gravity = DVec3::ZERO;
        let mut ball = Solid::new(Shape::Sphere { radius: 0.2 });
        (ball.position, ball.velocity) = (DVec3::new(0.013, 0.007, -0.3), DVec3::Z * 10.0);
        scene.solids.push(ball);
        let mut run = simulation::<f64>(&scene, integrator, 32);
        (0..6).for_each(|_| run.step().expect("a calm run"));
        let middle = ball.position + ball.velocity * 0.1;
        for (row, particle) in scene.particles.iter().enumerate() {
            let off = particle.position - ball.position;
            let now = run.position(row) - middle;
            // Contact ends a substep on the surface; a rounding of it is left.
            assert!(0.2 - 1e-9 < now.length(), "{integrator}: {row} is inside, {now}");
            let was_in_front = off.x.hypot(off.y) < 0.15;
            assert!(!was_in_front || 0.0 < now.z, "{integrator}: {row} is behind, {now}");
        }
    }
}
