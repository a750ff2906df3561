//! Particles that move far in a substep: the side of a solid on which they end, the time and the
//! place of their landing, and their room.

use crate::common::{Random, weightless};
use crate::moving::{place, plate, scene};
use crate::table::{G, H, Measures, after, run, start};
use crate::walls::unmoved;
use msd_core::glam::DVec3;
use msd_core::{
    Friction, Integrator, Plane, Real, Scene, Settings, Shape, Shell, Simulation, Solid, Vector,
};

/// Ways of a substep of up to a hundred times the thickness of a plate, from either side.
pub fn thin_plates<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, mut random) = (Measures::default(), Random(7));
    for case in 0..12 {
        let (restitution, side) = ([0.0, 0.6][case % 2], [-1.0, 1.0][case / 2 % 2]);
        let thickness = [0.2, 0.02, 0.002][case / 4];
        let name = format!("{thickness} m, restitution {restitution}, side {side}");
        let speed = 5.0 + 20.0 * random.unit();
        let motion = (
            DVec3::new(0.3, side * (0.11 + random.unit()), 0.2),
            DVec3::new(0.5, -side * speed, 0.2),
        );
        let thrown = scene(motion, Solid { restitution, ..plate(thickness) });
        let thrown = Scene { world: weightless(), ..thrown };
        let simulation = after::<R>(&thrown, (integrator, 2), 20, (&mut measures, &name));
        let inside = 0.5 * thickness - place(&simulation).y * side;
        measures.see("inside, m", (inside, unmoved::<R>(1.0)), &name);
        let off = (simulation.velocity(0).to_f64().y * side - restitution * speed).abs();
        measures.see("off its speed, m/s", (off, 4.0 * R::EPSILON.to_f64() * speed), &name);
    }
    measures
}

/// A ball of 5 cm at 60 m/s is 12 cm further after a substep. A particle that it hits gets twice
/// the part of its velocity along the normal.
pub fn small_balls<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for offset in [0.0, 0.01, 0.03] {
        let name = format!("{offset} m aside");
        let ball = Solid {
            restitution: 1.0,
            velocity: DVec3::X * 60.0,
            position: DVec3::new(-1.03, offset, 0.0),
            ..Solid::new(Shape::Sphere { radius: 0.05 })
        };
        let hit = Scene { world: weightless(), ..scene((DVec3::ZERO, DVec3::ZERO), ball) };
        let simulation = after::<R>(&hit, (integrator, 8), 3, (&mut measures, &name));
        let sine: f64 = -offset / 0.05;
        let cosine = (1.0 - sine * sine).sqrt();
        let expected = DVec3::new(cosine, sine, 0.0) * (120.0 * cosine);
        let off = simulation.velocity(0).to_f64().distance(expected);
        // A passage ends within eight roundings of single precision of the surface, and a rounding
        // of the metre that the ball has come adds to it: that turns the normal.
        let noise = 8.0 * (f64::from(f32::EPSILON) * 0.13 + R::EPSILON.to_f64());
        let bound = noise / 0.05 * 120.0;
        measures.see("off its velocity, m/s", (off, bound), &name);
    }
    measures
}

/// A particle that would go through a box in a substep ends on the side where it went in, and one
/// that passes by goes on. The oracle is the intersection of a line with slabs.
pub fn ways_through_boxes<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, mut random) = (Measures::default(), Random(11));
    let (mut hits, mut misses) = (0, 0);
    for _ in 0..400 {
        let size = DVec3::new(0.02, 0.3, 0.2) + random.vector() * DVec3::new(0.03, 0.1, 0.1);
        let [from, to] = [0, 1].map(|_| (random.vector() - 0.5) * 0.8);
        let (way, half) = (to - from, size * 0.5);
        let [low, high] = [-half, half].map(|side| (side - from) / way);
        let (enters, leaves) = (low.min(high), low.max(high));
        let (part, end) = (enters.max_element(), leaves.min_element());
        let is_far = (from.abs() - half).max_element() > 1e-3 && way.length() > 0.3;
        // Of a way that grazes an edge, rounding decides.
        if !is_far || (part - end).abs() < 1e-3 || (part - 1.0).abs() < 1e-3 {
            continue;
        }
        let name = format!("{from:.3} to {to:.3} through {size:.3}");
        let velocity = way * 60.0;
        let thrown = scene((from, velocity), Solid::new(Shape::Box { size }));
        let thrown = Scene { world: weightless(), ..thrown };
        let simulation = after::<R>(&thrown, (integrator, 1), 1, (&mut measures, &name));
        let after = simulation.velocity(0).to_f64();
        let rounding = 16.0 * R::EPSILON.to_f64() * velocity.length();
        if !(0.0..1.0).contains(&part) || end < part {
            measures.see("turned, m/s", (after.distance(velocity), rounding), &name);
            misses += 1;
            continue;
        }
        let axis = enters.to_array().iter().position(|&enter| enter == part).expect("an axis");
        let normal = DVec3::AXES[axis] * -way[axis].signum();
        let inside = half[axis] - place(&simulation).dot(normal);
        measures.see("inside, m", (inside, unmoved::<R>(1.0)), &name);
        measures.see("goes on into it, m/s", (after.dot(normal).abs(), rounding), &name);
        hits += 1;
    }
    assert!(40 < hits && 40 < misses, "{hits} hits, {misses} misses");
    measures
}

/// Where a thrown particle is after a bounce shows the time of the impact: on a plane, which it
/// meets by its radius, and on a ball.
pub fn times_of_impacts<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, radius, seconds) = (Measures::default(), 0.05, 40.0 / 60.0);
    let friction = Friction::Coulomb(0.0);
    let plane = Plane { normal: DVec3::Y, offset: 0.0, restitution: 1.0, friction };
    let mut dropped = Scene { planes: vec![plane], ..Scene::default() };
    let shell = Shell { points: vec![0], thickness: radius, obstacles: true, ..Shell::default() };
    dropped.shells = vec![shell];
    let (middle, curve) = (DVec3::new(0.1, 0.7, -0.1), 0.8);
    let ball = Solid::new(Shape::Sphere { radius: curve });
    let ball = Solid { position: middle, restitution: 1.0, friction, ..ball };
    let thrown = Scene { solids: vec![ball], ..Scene::default() };
    type Gap<'a> = &'a dyn Fn(DVec3) -> f64;
    let cases: [(Scene, Gap, [DVec3; 2], f64, &str); 2] = [
        (dropped, &|x| x.y - radius, [DVec3::Y * 1.3, DVec3::X * 0.4], f64::INFINITY, "plane"),
        (
            thrown,
            &|x| x.distance(middle) - curve,
            [DVec3::new(-2.0, 1.3, 0.2), DVec3::new(3.0, 1.0, -0.2)],
            curve,
            "ball",
        ),
    ];
    for (surfaces, gap, [from, speed], curve, name) in cases {
        let flight =
            |from: DVec3, speed: DVec3, t: f64| from + speed * t - DVec3::Y * (0.5 * G * t * t);
        // The first root of a gap that falls until then.
        let (mut early, mut late) = (0.0, 0.53);
        assert!(gap(flight(from, speed, late)) < 0.0);
        for _ in 0..60 {
            let middle = 0.5 * (early + late);
            if gap(flight(from, speed, middle)) < 0.0 { late = middle } else { early = middle }
        }
        let (place, arrives) = (flight(from, speed, early), speed - DVec3::Y * (G * early));
        let normal = if name == "ball" { (place - middle).normalize() } else { DVec3::Y };
        let change = -2.0 * arrives.dot(normal);
        let since = seconds - early;
        let particles = scene((from, speed), plate(1.0)).particles;
        let thrown = Scene { particles, ..surfaces };
        let simulation = after::<R>(&thrown, (integrator, 8), 40, (&mut measures, name));
        let end = flight(place, arrives + normal * change, since);
        let off = simulation.position(0).to_f64().distance(end);
        // Late by t it is off by t times the change of its velocity: a nanosecond where the time is
        // located. Others are late by up to a substep, by as much again for the speed of half a
        // substep, and the normal turns by the way of it.
        let late = match integrator {
            Integrator::DormandPrince => 1e-9,
            _ => H * (2.0 + arrives.length() * since / curve),
        };
        let rounding = seconds / H * R::EPSILON.to_f64() * 4.0;
        measures.see("off its place, m", (off, late * change + rounding), name);
    }
    measures
}

/// Friction takes back some of the way of a substep, along a tangent. Velocity Verlet and RK4 put a
/// particle that lands on the ball itself; the others leave it above by the square of the way.
pub fn lands_on_rough_balls<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for friction in [0.1, 2.0] {
        let name = format!("friction {friction}");
        let friction = Friction::Coulomb(friction);
        let ball = Solid { friction, ..Solid::new(Shape::Sphere { radius: 0.5 }) };
        let motion = (DVec3::new(-0.1, 0.7, 0.05), DVec3::new(0.8, -2.0, 0.3));
        let settings = Settings { integrator, substeps: 1, ..Settings::default() };
        let thrown = Scene { world: weightless(), ..scene(motion, ball) };
        let start = Simulation::<R>::new(&thrown, settings);
        let mut first = None;
        let ended = run(&mut start.expect("a valid scene"), 0.2, |now| {
            if 0 < now.contacts().count && first.is_none() {
                first = Some((place(now).length() - 0.5).abs());
            }
        });
        ended.unwrap_or_else(|error| measures.fail(&error, &name));
        let way = motion.1.length() / 60.0;
        let above = match integrator {
            Integrator::VelocityVerlet | Integrator::Rk4 => 0.0,
            _ => way * way / (2.0 * 0.5),
        };
        let gap = first.unwrap_or(f64::NAN);
        measures.see("off the ball, m", (gap, above + unmoved::<R>(2.0)), &name);
    }
    measures
}

/// A ball that goes into the floor leaves particles there no room; one that stays above it does, as
/// does a groove of 60°. Dormand-Prince meets one after the other, in no time.
pub fn rooms<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    if integrator == Integrator::DormandPrince {
        return measures;
    }
    let plane = |x: f64, y: f64| {
        let friction = Friction::Coulomb(0.3);
        Plane { normal: DVec3::new(x, y, 0.0), offset: 0.0, restitution: 0.0, friction }
    };
    let ball = |speed: f64| {
        let ball = Solid::new(Shape::Sphere { radius: 0.25 });
        vec![Solid { position: DVec3::Y * 0.6, velocity: DVec3::Y * -speed, ..ball }]
    };
    let (floor, steep) = (vec![plane(0.0, 1.0)], 3f64.sqrt());
    let groove = vec![plane(steep, 1.0), plane(-steep, 1.0)];
    let cases = [
        (floor.clone(), ball(2.0), true, "a ball that goes into the floor"),
        (floor, ball(1.0), false, "a ball that stays above"),
        (groove, Vec::new(), false, "a groove"),
    ];
    for (planes, solids, expected, name) in cases {
        let motion = (DVec3::new(0.01, 0.1, 0.0), DVec3::new(0.0, -1.0, 0.0));
        let particles = scene(motion, plate(1.0)).particles;
        let mut simulation =
            start::<R>(&Scene { particles, planes, solids, ..Scene::default() }, integrator);
        let ended = run(&mut simulation, 20.0 / 60.0, |_| {});
        ended.unwrap_or_else(|error| measures.fail(&error, name));
        let is_wrong = simulation.contacts().squeezed != expected;
        measures.see("wrong about its room", (f64::from(u8::from(is_wrong)), 0.5), name);
    }
    measures
}
