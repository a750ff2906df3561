//! Particles held by several surfaces at once: in grooves, corners, and between round solids.

use crate::common::Random;
use crate::table::{G, Measures, run, start};
use crate::walls::{Kind, add_walls, particle, still, unmoved};
use msd_core::glam::{DMat3, DVec3};
use msd_core::scene::solid::rotation;
use msd_core::{Friction, Integrator, Real, Scene, Shape, Simulation, Solid, Vector};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Smooth and rough.
const FRICTIONS: [f64; 2] = [0.0, 0.3];

/// A scene in whose lowest point a particle may lie.
struct Pit {
    walls: Scene,
    foot: DVec3,
    /// The largest length that gaps are computed from, metres.
    reach: f64,
    /// The factor of a rounding of the gaps where walls of α meet: 1 / cos α in height, 1 / sin α
    /// aside.
    steep: f64,
    friction: f64,
    name: String,
}

/// Grooves along z of ±10 to ±80 degrees, through the origin and elsewhere.
fn grooves() -> Vec<Pit> {
    let mut grooves = Vec::new();
    for kind in Kind::ALL {
        for degrees in [10, 20, 30, 40, 50, 60, 70, 80] {
            for friction in FRICTIONS {
                for foot in [DVec3::ZERO, DVec3::new(0.3, -0.2, 0.1)] {
                    // Where the origin is does not matter to boxes.
                    if kind == Kind::Boxes && foot == DVec3::ZERO {
                        continue;
                    }
                    let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
                    let normals = [sine, -sine].map(|x| DVec3::new(x, cosine, 0.0));
                    let mut walls = Scene::default();
                    add_walls(&mut walls, kind, (foot, &normals), friction);
                    let (reach, steep) = (foot.length() + kind.reach(), 1.0 / sine.min(cosine));
                    let name = format!("{kind:?} of ±{degrees}°, friction {friction}, at {foot}");
                    grooves.push(Pit { walls, foot, reach, steep, friction, name });
                }
            }
        }
    }
    grooves
}

/// Corners of three planes at twenty random tilts: their horizontal parts surround the vertical, so
/// that gravity presses on all three.
fn corners() -> Vec<Pit> {
    let mut random = Random(37);
    let mut corners = Vec::new();
    for number in 0..20 {
        let turn = random.unit() * TAU;
        let normals = [0.0, 1.0, 2.0].map(|third| {
            let around = turn + TAU / 3.0 * third + (random.unit() - 0.5) * 0.8;
            let (sine, cosine) = (10.0 + 60.0 * random.unit()).to_radians().sin_cos();
            DVec3::new(sine * around.cos(), cosine, sine * around.sin())
        });
        for friction in FRICTIONS {
            let foot = if number % 2 == 0 { DVec3::ZERO } else { DVec3::new(0.3, -0.2, 0.1) };
            let mut walls = Scene::default();
            add_walls(&mut walls, Kind::Planes, (foot, &normals), friction);
            // The place of a corner follows three gaps by the inverse of its normals.
            let inverse =
                DMat3::from_cols_array_2d(&normals.map(|normal| normal.to_array())).inverse();
            let steep = inverse.to_cols_array().map(f64::abs).into_iter().fold(1.0, f64::max);
            let reach = foot.length();
            let name = format!("corner {number}, friction {friction}");
            corners.push(Pit { walls, foot, reach, steep, friction, name });
        }
    }
    corners
}

/// Between two cylinders, two capsules and three balls that overlap: where they meet, their normals
/// are as far from the vertical as the walls of grooves.
fn valleys() -> Vec<Pit> {
    let radius = 0.5;
    let rod = |shape, x| {
        let axes = rotation(DVec3::X, FRAC_PI_2);
        Solid { position: DVec3::X * x, axes, ..Solid::new(shape) }
    };
    let mut valleys = Vec::new();
    for degrees in [10, 20, 30, 40, 50, 60, 70, 80] {
        for friction in FRICTIONS {
            let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
            let away = radius * sine;
            let cylinder = Shape::Cylinder { radius, length: 3.0 };
            let capsule = Shape::Capsule { radius, length: 3.0 };
            let ball = |turn: f64| {
                let position = DVec3::new(turn.cos(), 0.0, turn.sin()) * away;
                Solid { position, ..Solid::new(Shape::Sphere { radius }) }
            };
            let kinds = [
                ("cylinders", [away, -away].map(|x| rod(cylinder.clone(), x)).to_vec()),
                ("capsules", [away, -away].map(|x| rod(capsule.clone(), x)).to_vec()),
                ("balls", [0.3, 0.3 + TAU / 3.0, 0.3 - TAU / 3.0].map(ball).to_vec()),
            ];
            for (kind, mut solids) in kinds {
                let friction_law = Friction::Coulomb(friction);
                solids.iter_mut().for_each(|solid| solid.friction = friction_law);
                let walls = Scene { solids, ..Scene::default() };
                let foot = DVec3::Y * radius * cosine;
                let name = format!("{kind} of ±{degrees}°, friction {friction}");
                let (reach, steep) = (radius + away, 1.0 / sine.min(cosine));
                valleys.push(Pit { walls, foot, reach, steep, friction, name });
            }
        }
    }
    valleys
}

fn speed<R: Real>(simulation: &Simulation<R>) -> f64 {
    simulation.velocity(0).to_f64().length()
}

/// Starts at rest at the foot: stays there for two seconds, and nothing is booked.
fn hold<R: Real>(pits: Vec<Pit>, integrator: Integrator) -> Measures {
    let (mut measures, seconds) = (Measures::default(), 2.0);
    for Pit { walls, foot, reach, steep, name, .. } in pits {
        let scene = Scene { particles: particle(foot, DVec3::ZERO).particles, ..walls };
        let mut simulation = start::<R>(&scene, integrator);
        let before = simulation.position(0).to_f64();
        let (mut fastest, mut moved) = (0f64, 0f64);
        let ended = run(&mut simulation, seconds, |now| {
            fastest = fastest.max(speed(now));
            moved = moved.max(now.position(0).to_f64().distance(before));
        });
        ended.unwrap_or_else(|error| measures.fail(&error, &name));
        measures.see("speed, m/s", (fastest, still::<R>(steep * reach)), &name);
        measures.see("moved, m", (moved, steep * unmoved::<R>(reach)), &name);
        // The weight, 1 kg, at the speed that counts as still.
        let booked = G * seconds * still::<R>(steep * reach);
        measures.see("dissipated, J", (simulation.dissipated().abs(), booked), &name);
        // The falls of explicit Euler, which the walls put back, are booked with either sign.
        if integrator != Integrator::ExplicitEuler {
            measures.see("added, J", (simulation.contacts().added, booked), &name);
        }
    }
    measures
}

/// Let go 3 mm above the foot and a little aside: comes to rest. Without friction it slides to and
/// fro, and ends at the foot: walls of ±10° keep cos 20° of the speed at each pass, and the times
/// of passes, 2 v / (g sin 10°) each, sum to 1.1 s where the first has 6 cm/s, the rest of the
/// fall.
fn stop<R: Real>(pits: Vec<Pit>, integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for Pit { walls, foot, reach, steep, friction, name } in pits {
        let position = foot + DVec3::new(5e-4, 3e-3, 0.0);
        let scene = Scene { particles: particle(position, DVec3::ZERO).particles, ..walls };
        let mut simulation = start::<R>(&scene, integrator);
        let before = simulation.energy().total();
        let mut fastest = 0f64;
        let ended = run(&mut simulation, 1.75, |_| {})
            .and_then(|()| run(&mut simulation, 0.25, |now| fastest = fastest.max(speed(now))));
        ended.unwrap_or_else(|error| measures.fail(&error, &name));
        measures.see("speed, m/s", (fastest, still::<R>(steep * reach)), &name);
        if friction == 0.0 {
            let moved = simulation.position(0).to_f64().distance(foot);
            measures.see("from the foot, m", (moved, steep * unmoved::<R>(reach)), &name);
        }
        // At stake is m g 3 mm. A ledger is off by contacts that are found late in a substep, of a
        // fall of 12 substeps: a fifth.
        let stake = G * 3e-3;
        let gain = (simulation.energy().total() - before).abs();
        measures.see("gain, J", (gain, 0.2 * stake), &name);
        if integrator != Integrator::ExplicitEuler {
            measures.see("added, J", (simulation.contacts().added, 0.2 * stake), &name);
        }
    }
    measures
}

pub fn grooves_hold<R: Real>(integrator: Integrator) -> Measures {
    hold::<R>(grooves(), integrator)
}

pub fn grooves_stop<R: Real>(integrator: Integrator) -> Measures {
    stop::<R>(grooves(), integrator)
}

pub fn corners_hold<R: Real>(integrator: Integrator) -> Measures {
    hold::<R>(corners(), integrator)
}

pub fn corners_stop<R: Real>(integrator: Integrator) -> Measures {
    stop::<R>(corners(), integrator)
}

pub fn valleys_hold<R: Real>(integrator: Integrator) -> Measures {
    hold::<R>(valleys(), integrator)
}

pub fn valleys_stop<R: Real>(integrator: Integrator) -> Measures {
    stop::<R>(valleys(), integrator)
}
