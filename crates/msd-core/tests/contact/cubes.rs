//! A soft cube in grooves, corners, between round solids and on slopes: it comes to rest.

use crate::table::{Measures, run, start};
use crate::walls::{Kind, add_walls};
use msd_core::glam::{DMat3, DQuat, DVec3};
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, Material, Real, Scene, Shape, Simulation, Solid, Vector, shape,
};
use std::f64::consts::FRAC_PI_2;

/// Between the particles of the small cube, metres.
const SPACING: f64 = 0.1;
/// Height above the support at which a cube starts, metres.
const DROP: f64 = 2e-3;

/// A cube of 27 particles, 20 cm and 0.8 kg about a point.
fn cube(axes: DMat3, middle: DVec3) -> Scene {
    let material = Material { mass: 0.03, stiffness: 300.0, damping: 1.5 };
    let mut cube = shape::block([3, 3, 3], SPACING, material).expect("a cube");
    cube.place(axes, middle);
    Scene::of("cube", cube)
}

/// The supports of a cube, with friction of 0.3.
fn scenes() -> Vec<(Scene, String)> {
    let mut scenes = Vec::new();
    for degrees in [20.0f64, 45.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        // The lower edges touch the walls where tan α times half a side is the height.
        let middle = DVec3::Y * (SPACING * (1.0 + sine / cosine) + DROP);
        let kinds = if degrees < 30.0 { &Kind::ALL[..] } else { &Kind::ALL[..1] };
        for &kind in kinds {
            let mut scene = cube(DMat3::IDENTITY, middle);
            let normals = [sine, -sine].map(|x| DVec3::new(x, cosine, 0.0));
            add_walls(&mut scene, kind, (DVec3::ZERO, &normals), 0.3);
            scenes.push((scene, format!("groove of ±{degrees}° of {kind:?}")));
        }
    }
    // The corner of a room that stands on it, and a cube that fits.
    let tip = DVec3::ONE.normalize();
    let axes = DMat3::from_quat(DQuat::from_rotation_arc(tip, DVec3::Y));
    let mut scene = cube(axes, DVec3::Y * (SPACING * 3f64.sqrt() + DROP));
    let normals = axes.to_cols_array_2d().map(DVec3::from);
    add_walls(&mut scene, Kind::Planes, (DVec3::ZERO, &normals), 0.3);
    scenes.push((scene, "corner of three planes".into()));
    // The lower edges of the cube lie on two cylinders.
    let (radius, away) = (0.4f64, 0.3f64);
    let height = (radius * radius - (away - SPACING).powi(2)).sqrt();
    let mut scene = cube(DMat3::IDENTITY, DVec3::Y * (height + SPACING + DROP));
    let axes = rotation(DVec3::X, FRAC_PI_2);
    let friction = Friction::Coulomb(0.3);
    let rod = Solid::new(Shape::Cylinder { radius, length: 3.0 });
    let at = |x| Solid { position: DVec3::X * x, axes, friction, ..rod.clone() };
    scene.solids = [-away, away].map(at).into();
    scenes.push((scene, "valley of two cylinders".into()));
    // A slope that holds: tan 10° is 0.18.
    let normal = DVec3::new(10f64.to_radians().tan(), 1.0, 0.0).normalize();
    let axes = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Y, normal));
    let mut scene = cube(axes, normal * (SPACING + DROP));
    add_walls(&mut scene, Kind::Planes, (DVec3::ZERO, &[normal]), 0.3);
    scenes.push((scene, "slope of 10°".into()));
    // The same against a wall that leans away from it.
    let (mut scene, _) = scenes[scenes.len() - 1].clone();
    let lean = axes * DVec3::new(1.0, 0.3, 0.0).normalize();
    let places = scene.particles.iter().map(|particle| particle.position.dot(lean));
    let foot = lean * (places.fold(f64::MAX, f64::min) - DROP);
    add_walls(&mut scene, Kind::Planes, (foot, &[lean]), 0.1);
    scenes.push((scene, "slope of 10° against a wall".into()));
    scenes
}

/// A cube of 343 particles that falls 8 cm into a valley of ±20°, as a user built it.
fn large() -> (Scene, String) {
    let material = Material { mass: 0.003, stiffness: 60.0, damping: 0.06 };
    let mut cube = shape::block([7, 7, 7], 0.05, material).expect("a cube");
    cube.place(DMat3::IDENTITY, DVec3::Y * 0.23);
    let mut scene = Scene::of("cube", cube);
    let (sine, cosine) = 20f64.to_radians().sin_cos();
    let normals = [sine, -sine].map(|x| DVec3::new(x, cosine, 0.0));
    add_walls(&mut scene, Kind::Planes, (DVec3::ZERO, &normals), 0.3);
    (scene, "groove of ±20° of Planes".into())
}

/// Energy of motion and in springs and fields.
fn mechanical<R: Real>(simulation: &Simulation<R>) -> f64 {
    let energy = simulation.energy();
    energy.total() - energy.dissipated
}

/// The part of the energy of motions by which a ledger may be off, with the fastest mode of the
/// body at w = 2 / (stable substep): in first order h w / 2, in second (h w)² / 8, and a hundredth
/// for contact.
fn part<R: Real>(simulation: &Simulation<R>, integrator: Integrator) -> f64 {
    let stable = simulation.stable_substep_of(Integrator::VelocityVerlet, 8);
    let along = simulation.settings().substep() / stable;
    let truncation = match integrator.order() {
        1 => along,
        2 => along * along / 2.0,
        _ => 0.0,
    };
    truncation + 0.01
}

/// Runs a cube until it has settled, and asks for its energy.
fn settle<R: Real>(
    (scene, name): &(Scene, String),
    (integrator, seconds): (Integrator, f64),
    measures: &mut Measures,
) -> Simulation<R> {
    let mut simulation = start::<R>(scene, integrator);
    let part = part(&simulation, integrator);
    let (before, first) = (simulation.energy().total(), mechanical(&simulation));
    let mut highest = f64::MIN;
    let ended = run(&mut simulation, seconds, |now| highest = highest.max(mechanical(now)));
    ended.unwrap_or_else(|error| measures.fail(&error, name));
    // A run that failed has nothing to be asked for.
    let stake = first - mechanical(&simulation);
    if stake <= 0.0 {
        return simulation;
    }
    // Backward Euler and XPBD damp by their nature, which no ledger has: they may lose, not gain.
    let gain = simulation.energy().total() - before;
    let damps = matches!(integrator, Integrator::BackwardEuler | Integrator::Xpbd);
    let off = if damps { gain } else { gain.abs() };
    measures.see("imbalance, J", (off, part * stake), name);
    measures.see("rise, J", (highest - first, part * stake), name);
    measures.see("added, J", (simulation.contacts().added, part * stake), name);
    simulation
}

/// After five seconds nothing is left of a motion: the slowest mode, in which the cube rocks,
/// decays by a factor e in less than 0.2 s.
pub fn cubes_rest<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for scene in scenes() {
        let mut simulation = settle::<R>(&scene, (integrator, 5.0), &mut measures);
        let mut fastest = 0f64;
        let ended = run(&mut simulation, 0.25, |now| {
            let speeds = now.velocities().map(|v| v.to_f64().length());
            fastest = speeds.fold(fastest, f64::max);
        });
        ended.unwrap_or_else(|error| measures.fail(&error, &scene.1));
        // In f32 springs round: 26 of 300 N/m by a rounding of 0.5 m, on 30 g, in a substep.
        let h = simulation.settings().substep();
        let rounding = 26.0 * 300.0 * R::EPSILON.to_f64() * 0.5 / 0.03 * h;
        measures.see("speed, m/s", (fastest, 1e-9f64.max(rounding)), &scene.1);
    }
    measures
}

/// It wobbles for long: its energy is asked for, not its rest.
pub fn large_cube_settles<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    settle::<R>(&large(), (integrator, 4.0), &mut measures);
    measures
}

/// A block of 343 particles that falls on a rough solid.
fn land<R: Real>(solid: Solid, integrator: Integrator) -> Measures {
    let (mut measures, name) = (Measures::default(), "block");
    let material = Material { mass: 0.01, stiffness: 60.0, damping: 0.05 };
    let mut block = shape::block([7, 7, 7], 0.1, material).expect("a block");
    block.place(DMat3::IDENTITY, DVec3::new(0.02, 1.0, 0.0));
    let solid = Solid { friction: Friction::Coulomb(0.5), ..solid };
    let scene = Scene { solids: vec![solid], ..Scene::of("block", block) };
    let mut simulation = start::<R>(&scene, integrator);
    let before = simulation.energy().total();
    // Methods of second order and above meet obstacles to the second.
    let part = match integrator {
        Integrator::Rk4 => part(&simulation, Integrator::VelocityVerlet),
        _ => part(&simulation, integrator),
    };
    let mut elastic = 0f64;
    let ended = run(&mut simulation, 0.6, |now| elastic = elastic.max(now.energy().elastic));
    if let Err(error) = ended {
        measures.fail(&error, name);
        return measures;
    }
    assert!(0 < simulation.contacts().count, "{integrator}: it has not landed");
    let gain = simulation.energy().total() - before;
    let damps = matches!(integrator, Integrator::BackwardEuler | Integrator::Xpbd);
    let off = if damps { gain } else { gain.abs() };
    measures.see("imbalance, J", (off, part * elastic), name);
    measures
}

pub fn lands_on_a_ball<R: Real>(integrator: Integrator) -> Measures {
    let ball = Solid::new(Shape::Sphere { radius: 0.25 });
    land::<R>(Solid { position: DVec3::Y * 0.2, ..ball }, integrator)
}

/// Contact points between the particles meet it.
pub fn lands_on_a_rod<R: Real>(integrator: Integrator) -> Measures {
    let rod = Solid::new(Shape::Capsule { radius: 0.03, length: 2.0 });
    let (position, axes) = (DVec3::new(0.05, 0.4, 0.0), rotation(DVec3::X, FRAC_PI_2));
    land::<R>(Solid { position, axes, springs: true, ..rod }, integrator)
}
