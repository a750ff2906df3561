//! Surfaces that move: particles that lie on them, meet them and slide, against closed forms.

use crate::common::weightless;
use crate::table::{G, Measures, after, is_double};
use msd_core::glam::DVec3;
use msd_core::obstacles::Placed;
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, KeyFrame, Particle, Pin, Real, Scene, Settings, Shape, Simulation, Solid,
    Spring, Vector,
};
use std::f64::consts::FRAC_PI_2;

pub const MASS: f64 = 0.3;

/// The methods that book the work of carrying a particle in contacts; others have it in their
/// solutions.
const BOOKED: [Integrator; 5] = [
    Integrator::ExplicitEuler,
    Integrator::SymplecticEuler,
    Integrator::VelocityVerlet,
    Integrator::Rk4,
    Integrator::Xpbd,
];

pub fn scene((position, velocity): (DVec3, DVec3), solid: Solid) -> Scene {
    let particles = vec![Particle { position, velocity, mass: MASS }];
    Scene { particles, solids: vec![solid], ..Scene::default() }
}

/// The rounding of a length or a speed of so much in so many substeps: 1e-12 in f64, and in f32 a
/// rounding of it in each.
fn rounding<R: Real>(size: f64, substeps: u32) -> f64 {
    if is_double::<R>() { 1e-12 } else { f64::from(substeps) * R::EPSILON.to_f64() * size }
}

pub fn place<R: Real>(simulation: &Simulation<R>) -> DVec3 {
    simulation.position(0).to_f64()
}

pub fn plate(thickness: f64) -> Solid {
    let size = DVec3::new(4.0, thickness, 4.0);
    Solid::new(Shape::Box { size })
}

/// A solid that rises carries a particle on it at its speed, and the ledger has its work: m g v t.
pub fn rises<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, speed, name) = (Measures::default(), 0.7, "half space");
    let floor = Solid { velocity: DVec3::Y * speed, ..Solid::new(Shape::HalfSpace) };
    let scene = scene((DVec3::new(3.0, 0.0, -2.0), DVec3::Y * speed), floor);
    let before =
        Simulation::<R>::new(&scene, Settings::default()).expect("a scene").energy().total();
    let simulation = after::<R>(&scene, (integrator, 8), 60, (&mut measures, name));
    let off = place(&simulation).distance(DVec3::new(3.0, speed, -2.0));
    measures.see("off its place, m", (off, rounding::<R>(1.0, 480)), name);
    let work = MASS * G * speed;
    // Explicit Euler falls with the speed of a substep before, Runge-Kutta's method is off by less
    // than a thousandth.
    let late = match integrator {
        Integrator::ExplicitEuler => MASS * G * G / 480.0,
        Integrator::Rk4 => 1e-3 * work,
        _ => 0.0,
    };
    let drift = (simulation.energy().total() - before).abs();
    measures.see("imbalance, J", (drift, late + rounding::<R>(work, 480)), name);
    if BOOKED.contains(&integrator) {
        let off = (simulation.contacts().driven - work).abs();
        measures.see("off its work, J", (off, rounding::<R>(work, 480)), name);
    }
    measures
}

/// A solid that comes at 2 m/s returns a particle at rest at twice its speed. Its work, 8 m, is
/// booked; not by Dormand-Prince.
pub fn comes<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    let half_space = Solid {
        axes: rotation(DVec3::Z, -FRAC_PI_2),
        position: DVec3::X * -0.5,
        ..Solid::new(Shape::HalfSpace)
    };
    let size = DVec3::new(1.0, 4.0, 4.0);
    let wall = Solid { position: DVec3::X * -1.0, ..Solid::new(Shape::Box { size }) };
    for (solid, height, name) in [(half_space, 40.0, "half space"), (wall, 0.0, "box")] {
        let solid = Solid { velocity: DVec3::X * 2.0, restitution: 1.0, ..solid };
        let mut scene = scene((DVec3::Y * height, DVec3::ZERO), solid);
        scene.world = weightless();
        let simulation = after::<R>(&scene, (integrator, 8), 30, (&mut measures, name));
        let off = simulation.velocity(0).to_f64().distance(DVec3::X * 4.0);
        measures.see("off its speed, m/s", (off, rounding::<R>(1.0, 4)), name);
        let (energy, driven) = (simulation.energy(), simulation.contacts().driven);
        let bound = rounding::<R>(8.0 * MASS, 4);
        if integrator != Integrator::DormandPrince {
            measures.see("off its work, J", ((driven - 8.0 * MASS).abs(), bound), name);
        }
        measures.see("off its energy, J", ((energy.kinetic - 8.0 * MASS).abs(), bound), name);
        measures.see("imbalance, J", (energy.total().abs(), 1e-9f64.max(bound)), name);
    }
    measures
}

/// Without friction, on one that tilts at w about its middle: r'' = w² r − g sin w t, so that r =
/// r0 cosh w t − g / (2 w²) (sinh w t − sin w t).
pub fn tilts<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, name) = (Measures::default(), "half space");
    let (w, r, substeps) = (0.5f64, 1.0, 100);
    let way = r * w.cosh() - G / (2.0 * w * w) * (w.sinh() - w.sin());
    let end = DVec3::new(w.cos(), w.sin(), 0.0) * way;
    let floor = Solid { spin: DVec3::Z * w, ..Solid::new(Shape::HalfSpace) };
    let scene = scene((DVec3::X * r, DVec3::Y * (w * r)), floor);
    let simulation = after::<R>(&scene, (integrator, substeps), 60, (&mut measures, name));
    // A method of first order is late by less than two substeps at its last speed, 2.2 m/s.
    let late = 2.0 * 2.2 / (60.0 * f64::from(substeps));
    let bound = late + rounding::<R>(r, 60 * substeps);
    measures.see("off its place, m", (place(&simulation).distance(end), bound), name);
    measures
}

/// Through key frames: it lifts a particle on it by half a metre, with 3 m/s² at most, and the
/// particle stays.
pub fn lifts<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, name) = (Measures::default(), "half space");
    let flat = Solid::new(Shape::HalfSpace);
    let key = KeyFrame { time: 1.0, position: DVec3::Y * 0.5, axes: flat.axes };
    let scene = scene((DVec3::X, DVec3::ZERO), Solid { keys: vec![key], ..flat });
    let simulation = after::<R>(&scene, (integrator, 8), 120, (&mut measures, name));
    let off = place(&simulation).distance(DVec3::new(1.0, 0.5, 0.0));
    measures.see("off its place, m", (off, 1e-9f64.max(rounding::<R>(1.0, 960))), name);
    if BOOKED.contains(&integrator) {
        // Explicit methods of first order are off by the speed of half a substep.
        let work = MASS * G * 0.5;
        let off = (simulation.contacts().driven - work).abs();
        measures.see("off its work, J", (off, 1e-3 * work), name);
    }
    measures
}

/// A particle on a belt: friction speeds it up to that of the belt, which does twice the work that
/// becomes motion.
pub fn belt<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, name) = (Measures::default(), "box");
    let (speed, friction) = (1.0, 0.5);
    let solid =
        Solid { velocity: DVec3::X * speed, friction: Friction::Coulomb(friction), ..plate(0.4) };
    let scene = scene((DVec3::Y * 0.2, DVec3::ZERO), solid);
    let simulation = after::<R>(&scene, (integrator, 8), 30, (&mut measures, name));
    let off = (simulation.velocity(0).to_f64().x - speed).abs();
    measures.see("off its speed, m/s", (off, 1e-9f64.max(rounding::<R>(speed, 8))), name);
    let (contacts, work) = (simulation.contacts(), MASS * speed * speed);
    // By a substep of friction at most, at the speed of the belt.
    let bound = MASS * friction * G * speed / 480.0 + rounding::<R>(work, 240);
    measures.see("off its work, J", ((contacts.driven - work).abs(), bound), name);
    let taken = contacts.taken - contacts.added;
    measures.see("off its loss, J", ((taken - 0.5 * work).abs(), bound), name);
    measures.see("off what is given, J", ((simulation.given() - work).abs(), bound), name);
    measures
}

/// A platform that lifts and shifts a particle that friction holds on it, fast: the particle weighs
/// a third at the end.
pub fn platform<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, name) = (Measures::default(), "box");
    let key = |time, position| KeyFrame { time, position, axes: rotation(DVec3::Y, 0.0) };
    let goal = DVec3::new(0.5, 1.0, 0.0);
    let solid = Solid {
        friction: Friction::Coulomb(1.0),
        keys: vec![key(1.0, DVec3::ZERO), key(2.0, goal)],
        ..plate(0.4)
    };
    let scene = scene((DVec3::Y * 0.2, DVec3::ZERO), solid);
    let simulation = after::<R>(&scene, (integrator, 50), 150, (&mut measures, name));
    let off = (place(&simulation) - DVec3::Y * 0.2).distance(goal);
    // Euler methods are off by h / 2 of the speeds at most, which change by 1.5 m/s.
    let bound = 1.5 / 3000.0 + rounding::<R>(1.0, 7500);
    measures.see("off its place, m", (off, bound), name);
    measures
}

/// A particle on a plate that is lifted and turned comes along.
pub fn lifts_and_turns<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, name) = (Measures::default(), "cylinder");
    let shape = Shape::Cylinder { radius: 1.0, length: 0.2 };
    let key = |(time, y, angle)| {
        let position = DVec3::Y * y;
        KeyFrame { time, position, axes: rotation(DVec3::Y, angle) }
    };
    let solid = Solid {
        position: DVec3::Y * -0.1,
        friction: Friction::Coulomb(0.8),
        keys: [(1.0, 0.2, 0.5), (2.0, 0.1, 0.9)].map(key).to_vec(),
        ..Solid::new(shape)
    };
    let start = DVec3::X * 0.4;
    let simulation = after::<R>(
        &scene((start, DVec3::ZERO), solid),
        (integrator, 50),
        132,
        (&mut measures, name),
    );
    let off = place(&simulation) - rotation(DVec3::Y, 0.9) * start - DVec3::Y * 0.2;
    let rounding = rounding::<R>(0.4, 6600);
    measures.see("off its height, m", (off.y.abs(), 1e-9f64.max(rounding)), name);
    // A path of chords: each substep adds (w h)² / 2 of the radius at most, at w = 0.9 rad/s.
    let drift = 6000.0 * 0.5 * (0.9f64 / 3000.0).powi(2) * 0.4;
    measures.see("off its place, m", (off.length(), 1e-6 + drift + rounding), name);
    measures
}

/// On a turntable below μ g / r a particle goes round with it; above it is flung off.
pub fn turntable_flings<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    let (friction, radius, substeps) = (0.5, 0.4, 200);
    let critical = (friction * G / radius).sqrt();
    for (share, stays) in [(0.9, true), (1.1, false)] {
        let name = format!("{share} of the critical rate");
        let solid = Solid {
            position: DVec3::Y * -0.1,
            spin: DVec3::Y * (share * critical),
            friction: Friction::Coulomb(friction),
            ..Solid::new(Shape::Cylinder { radius: 2.0, length: 0.2 })
        };
        let speed = solid.spin.cross(DVec3::X * radius);
        let simulation = after::<R>(
            &scene((DVec3::X * radius, speed), solid),
            (integrator, substeps),
            60,
            (&mut measures, &name),
        );
        let off = (place(&simulation).length() - radius).abs();
        // A path of chords: each substep adds (w h)² / 2 of the radius at most.
        let steps = f64::from(60 * substeps);
        let chords = steps * 0.5 * (share * critical / steps).powi(2);
        let drift = chords.exp_m1() * radius + rounding::<R>(radius, 60 * substeps);
        if stays {
            measures.see("goes out, m", (off, drift), &name);
        } else {
            // Ten times as far, or more.
            measures.see("stays, 1/m", (1.0 / off, 0.1 / drift), &name);
        }
    }
    measures
}

/// A solid that goes through key frames gives a particle at rest twice the speed that it has when
/// they meet.
pub fn keyed_wall<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, name) = (Measures::default(), "box");
    let mut wall = Solid::new(Shape::Box { size: DVec3::new(1.0, 4.0, 4.0) });
    (wall.position, wall.restitution) = (DVec3::X * -1.0, 1.0);
    let key = |(time, x)| KeyFrame { time, position: DVec3::X * x, axes: wall.axes };
    wall.keys = [(0.3, -0.7), (0.6, 0.3), (1.0, 0.4)].map(key).to_vec();
    let (mut early, mut late) = (0.3, 0.6);
    for _ in 0..60 {
        let middle = 0.5 * (early + late);
        if Placed::new(&wall, middle).middle.x < -0.5 { early = middle } else { late = middle }
    }
    let speed = 2.0 * Placed::new(&wall, early).velocity.x;
    assert!(3.0 < speed, "it comes fast: {speed}");
    let scene = Scene { world: weightless(), ..scene((DVec3::ZERO, DVec3::ZERO), wall) };
    let simulation = after::<R>(&scene, (integrator, 8), 60, (&mut measures, name));
    // The others take the velocity at the end of the substep in which they meet: it changes by less
    // than 20 m/s². Dormand-Prince locates the impact.
    let is_located = integrator == Integrator::DormandPrince;
    let late = if is_located { 1e-7 } else { 2.0 * 20.0 / 480.0 };
    let off = simulation.velocity(0).to_f64().distance(DVec3::X * speed);
    measures.see("off its speed, m/s", (off, late + rounding::<R>(speed, 480)), name);
    let drift = simulation.energy().total().abs();
    measures.see(
        "imbalance, J",
        (drift, 1e-9f64.max(rounding::<R>(MASS * speed * speed, 8))),
        name,
    );
    measures
}

/// One presses a spring together by key frames, and stays: its work is the energy of the spring, 2
/// J, and nothing is lost.
pub fn pressing_wall<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    let particle = |x: f64| Particle { position: DVec3::X * x, velocity: DVec3::ZERO, mass: 0.01 };
    let mut wall = Solid::new(Shape::Box { size: DVec3::splat(0.4) });
    wall.position = DVec3::X * 1.2;
    wall.keys = vec![KeyFrame { time: 1.0, position: DVec3::X * 1.1, axes: wall.axes }];
    let scene = Scene {
        world: weightless(),
        particles: vec![particle(0.0), particle(1.0)],
        springs: vec![Spring { ends: [0, 1], rest_length: 1.0, stiffness: 400.0, damping: 0.0 }],
        pins: vec![Pin { particle: 0, velocity: DVec3::ZERO }],
        solids: vec![wall],
        ..Scene::default()
    };
    for substeps in [4, 32] {
        let name = format!("{substeps} substeps");
        let simulation = after::<R>(&scene, (integrator, substeps), 90, (&mut measures, &name));
        // A method of first order takes the force of either end of each substep: half of the way in
        // one, 0.1 m in a second, times 40 N. A method of second order is off by (h w)²/8 of the
        // energy, Dormand-Prince by its tolerance times 40 N in each step. Implicit midpoint is
        // exact.
        let h = simulation.settings().substep();
        let late = match integrator {
            Integrator::DormandPrince => 90.0 * 1e-6 * 40.0,
            Integrator::ImplicitMidpoint => 1e-9,
            _ if integrator.order() == 1 => 6.0 * h,
            _ => h * h * 400.0 / 0.01 / 8.0 * 2.0,
        };
        let bound = late + rounding::<R>(2.0, 90 * substeps);
        let energy = simulation.energy();
        measures.see("off its work, J", ((energy.supplied - 2.0).abs(), bound), &name);
        measures.see("lost, J", (energy.dissipated.abs(), bound), &name);
        let off = (simulation.position(1).to_f64().x - 0.9).abs();
        measures.see("off its place, m", (off, 1e-12f64.max(8.0 * R::EPSILON.to_f64())), &name);
    }
    measures
}
