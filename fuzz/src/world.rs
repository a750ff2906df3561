//! Small scenes made of bytes, and the settings by which they are stepped.

use super::numbers::{any, decade, index, positive, vector};
use arbitrary::{Result, Unstructured};
use core::ops::Range;
use msd_core::glam::DVec3;
use msd_core::scene::Between;
use msd_core::scene::solid::rotation;
use msd_core::{
    Air, Bend, Body, Corner, DistanceGrid, Friction, Gust, Integrator, KeyFrame, Particle, Pin,
    Plane, Scene, Settings, Shape, Shell, Solid, Spring, Surface, Volume, World,
};
use std::sync::Arc;

/// The methods that take a step in a time known before.
const FIXED: [Integrator; 7] = [
    Integrator::ExplicitEuler,
    Integrator::SymplecticEuler,
    Integrator::VelocityVerlet,
    Integrator::Rk4,
    Integrator::BackwardEuler,
    Integrator::ImplicitMidpoint,
    Integrator::Xpbd,
];

/// A scene of a few rows, mostly valid ones.
pub fn scene(u: &mut Unstructured) -> Result<Scene> {
    let (particles, springs) = (u.int_in_range(1..=6)?, u.int_in_range(0..=8)?);
    let mut scene = Scene { world: world(u)?, ..Scene::default() };
    for place in 0..particles {
        scene.particles.push(particle(u, place)?);
    }
    for _ in 0..springs {
        let ends = [index(u, particles)?, index(u, particles)?];
        let (rest_length, stiffness, damping) = (positive(u)?, positive(u)?, positive(u)?);
        // Two bytes that agree are no reason to give the scene up.
        if ends[0] != ends[1] {
            scene.springs.push(Spring { ends, rest_length, stiffness, damping });
        }
    }
    for _ in 0..u.int_in_range(0..=2)? {
        scene.planes.push(plane(u)?);
    }
    if u.ratio(1, 4)? {
        scene.solids.push(solid(u)?);
    }
    if u.ratio(1, 4)? {
        scene.pins.push(Pin { particle: index(u, particles)?, velocity: vector(u)? });
    }
    if u.arbitrary()? {
        let count = scene.springs.len();
        let (first, last) = (index(u, particles + 1)?, index(u, particles + 1)?);
        scene.bodies.push(Body {
            name: "body".into(),
            particles: first.min(last)..first.max(last),
            springs: 0..index(u, count + 1)?,
            ..Body::default()
        });
    }
    if scene.world.air.is_some() {
        scene.bodies.push(sail(u, particles as u32)?);
    }
    if u.ratio(1, 3)? {
        shells(u, particles, &mut scene)?;
    }
    for _ in 0..u.int_in_range(0..=2)? {
        let mut particle = || index(u, particles);
        let at = [particle()?, particle()?, particle()?, particle()?];
        let (stiffness, damping) = (positive(u)?, positive(u)?);
        let differ = (1..4).all(|end| !at[..end].contains(&at[end]));
        scene.bends.push(match u.arbitrary()? {
            true => Bend::line([at[0], at[1], at[2]], stiffness, damping),
            false if differ => Bend { rest: decade(u)?, ..Bend::twist(at, stiffness, damping) },
            false => Bend::twist(at, stiffness, damping),
        });
    }
    for _ in 0..u.int_in_range(0..=1)? {
        let mut cell = [0; 8];
        for corner in &mut cell {
            *corner = index(u, particles)?;
        }
        let (rest_volume, modulus, damping) = (positive(u)?, positive(u)?, positive(u)?);
        let sign = if u.arbitrary()? { 1.0 } else { -1.0 };
        let (modulus, damping) = (sign * modulus, sign * damping);
        scene.volumes.push(Volume { particles: cell, rest_volume, modulus, damping });
    }
    Ok(scene)
}

/// A body without particles of its own, whose surface is a strip of triangles.
fn sail(u: &mut Unstructured, particles: u32) -> Result<Body> {
    let corners = (0..particles).map(|particle| Corner { particle, uv: [0.0; 2] }).collect();
    let triangles = (2..particles).map(|third| [third - 2, third - 1, third]).collect();
    let surface = Surface { corners, triangles, two_sided: u.arbitrary()? };
    Ok(Body { name: "sail".into(), surface, ..Body::default() })
}

/// Lets the first particles meet, in one shell or two.
fn shells(u: &mut Unstructured, particles: usize, scene: &mut Scene) -> Result<()> {
    let cut = index(u, particles + 1)?.min(particles);
    for particles in [0..cut, cut..particles] {
        let ignored = if u.ratio(1, 4)? { (0..scene.shells.len()).collect() } else { Vec::new() };
        let (thickness, friction) = (decade(u)?.abs(), positive(u)?);
        let flags: u8 = u.arbitrary()?;
        let mut shell = Shell {
            thickness,
            friction,
            restitution: f64::from(u.arbitrary::<u8>()?) / 255.0,
            itself: flags & 1 != 0,
            obstacles: flags & 2 != 0,
            ignored,
            ..Shell::default()
        };
        // A strip, a rope or points of them.
        match flags >> 2 & 3 {
            0 => shell.points = particles.clone().collect(),
            1 => shell.edges = particles.clone().skip(1).map(|end| [end - 1, end]).collect(),
            _ => {
                let thirds = particles.clone().skip(2);
                shell.triangles = thirds.map(|third| [third - 2, third - 1, third]).collect();
            }
        }
        for row in 0..scene.shells.len() {
            let friction = if u.arbitrary()? { Some(positive(u)?) } else { None };
            let restitution = if u.arbitrary()? { Some(0.5) } else { None };
            shell.between.push(Between { shell: row, friction, restitution });
        }
        if u.arbitrary()? && !particles.is_empty() {
            shell.exempt.push([particles.start, particles.end - 1]);
        }
        scene.shells.push(shell);
        if u.arbitrary()? {
            break;
        }
    }
    Ok(())
}

/// Breaks what holds a scene together, or leaves it as it is: most often.
pub(crate) fn spoil(scene: &mut Scene, choice: u8) {
    let body = |particles, surface| {
        let name = "spoilt".into();
        Body { name, particles, surface, ..Body::default() }
    };
    let corners = |particle| vec![Corner { particle, uv: [0.0; 2] }];
    let surface = |corners, triangles| Surface { corners, triangles, two_sided: true };
    match choice % 32 {
        1 => scene.particles.clear(),
        2 => {
            let (ends, rest_length) = ([0, 0], 1.0);
            scene.springs.push(Spring { ends, rest_length, stiffness: 1.0, damping: 0.0 });
        }
        3 => scene.bodies.push(body(Range { start: 1, end: 0 }, Surface::default())),
        4 => scene.bodies.push(body(0..1, surface(corners(u32::MAX), Vec::new()))),
        5 => scene.bodies.push(body(0..1, surface(corners(0), vec![[0, 0, 1]]))),
        6 => scene.bodies.push(body(0..1, surface(corners(0), vec![[0, 0, 0]]))),
        7 => scene.shells.iter_mut().for_each(|row| row.exempt.push([0, usize::MAX])),
        8 => scene.shells.iter_mut().for_each(|row| row.points.push(usize::MAX)),
        9 => scene.shells.iter_mut().for_each(|row| row.triangles.push([0, 0, usize::MAX])),
        10 => scene.shells.iter_mut().for_each(|row| row.ignored.push(7)),
        11 => {
            let between = Between { shell: 7, ..Between::default() };
            scene.shells.iter_mut().for_each(|row| row.between.push(between));
        }
        _ => (),
    }
}

/// A particle near its place on a row along x, or anywhere.
fn particle(u: &mut Unstructured, place: usize) -> Result<Particle> {
    let (position, velocity) = match u.arbitrary::<u8>()? % 8 {
        0 => (vector(u)?, vector(u)?),
        1 => (DVec3::ZERO, DVec3::ZERO),
        2 => (DVec3::X * decade(u)?, DVec3::Y * decade(u)?),
        _ => (DVec3::X * place as f64, DVec3::ZERO),
    };
    Ok(Particle { position, velocity, mass: positive(u)? })
}

fn world(u: &mut Unstructured) -> Result<World> {
    let default = World::default();
    Ok(match u.arbitrary::<u8>()? % 4 {
        0 => World { gravity: vector(u)?, force: vector(u)?, drag: positive(u)?, ..default },
        1 => World { extent: positive(u)?, drag: positive(u)?, ..default },
        2 => World { air: Some(air(u)?), ..default },
        _ => default,
    })
}

fn air(u: &mut Unstructured) -> Result<Air> {
    let mut number = || Ok(0.01 + f64::from(u.arbitrary::<u8>()?) / 64.0);
    let (drag, part, strength) = (number()?, number()?, number()?);
    let (length, time) = (number()?, number()?);
    let gust = Gust { strength, length, time, seed: u.arbitrary()?, origin: DVec3::ZERO };
    Ok(Air { density: decade(u)?, velocity: slow(u)?, drag, lift: drag * part.min(1.0), gust })
}

pub(crate) fn plane(u: &mut Unstructured) -> Result<Plane> {
    let (normal, offset) = match u.arbitrary::<u8>()? % 4 {
        0 => (vector(u)?, any(u)?),
        1 => (DVec3::X, decade(u)?),
        _ => (DVec3::Y, -0.5),
    };
    Ok(Plane { normal, offset, restitution: fraction(u)?, friction: friction(u)? })
}

/// A vector of numbers up to 32: with more of any numbers hardly a scene would be valid.
fn slow(u: &mut Unstructured) -> Result<DVec3> {
    let mut number = || Ok(f64::from(u.arbitrary::<i16>()?) / 1024.0);
    Ok(DVec3::new(number()?, number()?, number()?))
}

fn solid(u: &mut Unstructured) -> Result<Solid> {
    let mut length = || Ok(0.1 + f64::from(u.arbitrary::<u8>()?) / 64.0);
    let (radius, other, third) = (length()?, length()?, length()?);
    let shape = match u.arbitrary::<u8>()? % 7 {
        0 => Shape::Sphere { radius },
        1 => Shape::Capsule { radius, length: other },
        2 => Shape::Box { size: DVec3::new(radius, other, third) },
        3 => Shape::Cylinder { radius, length: other },
        4 => Shape::Torus { radius, tube: 0.3 * radius },
        5 => Shape::HalfSpace,
        _ => Shape::Mesh(Arc::new(grid(u, other)?)),
    };
    let (position, restitution) = (slow(u)?, fraction(u)?);
    let solid = Solid {
        position,
        restitution,
        friction: friction(u)?,
        springs: radius < other,
        ..Solid::new(shape)
    };
    if u.ratio(1, 3)? {
        return Ok(Solid { keys: key_frames(u)?, ..solid });
    }
    let spin = if u.ratio(1, 8)? { vector(u)? } else { slow(u)? };
    Ok(Solid { velocity: slow(u)?, spin, ..solid })
}

/// Any distances on a few points.
fn grid(u: &mut Unstructured, cell: f64) -> Result<DistanceGrid> {
    let mut count = || Ok(2 + usize::from(u.arbitrary::<u8>()? % 3));
    let counts = [count()?, count()?, count()?];
    let mut distances = Vec::new();
    for _ in 0..counts.into_iter().product() {
        distances.push(f64::from(u.arbitrary::<i8>()?) / 64.0);
    }
    let (low, reach) = (slow(u)?, 0.1 + f64::from(u.arbitrary::<u8>()?) / 32.0);
    let (corners, triangles) = (vec![low; 3], vec![[0, 1, 2]]);
    Ok(DistanceGrid { low, cell, counts, distances, reach, error: 0.0, corners, triangles })
}

/// A few key frames, mostly in order.
fn key_frames(u: &mut Unstructured) -> Result<Vec<KeyFrame>> {
    let (mut time, mut frames) = (0.0, Vec::new());
    for _ in 0..u.arbitrary::<u8>()? % 4 {
        time += f64::from(u.arbitrary::<u8>()?) / 256.0;
        let position = if u.ratio(1, 8)? { vector(u)? } else { slow(u)? };
        let angle = f64::from(u.arbitrary::<i8>()?) / 16.0;
        frames.push(KeyFrame { time, position, axes: rotation(DVec3::Y, angle) });
    }
    Ok(frames)
}

/// A number that is mostly from 0 to 1.
pub(crate) fn fraction(u: &mut Unstructured) -> Result<f64> {
    let byte: u8 = u.arbitrary()?;
    if byte < 240 { Ok(f64::from(byte) / 239.0) } else { any(u) }
}

/// Either law of friction.
pub(crate) fn friction(u: &mut Unstructured) -> Result<Friction> {
    Ok(match u.arbitrary()? {
        true => Friction::Coulomb(positive(u)?),
        false => Friction::TangentialLoss(fraction(u)?),
    })
}

/// Any method with few substeps of any length.
pub(crate) fn settings(u: &mut Unstructured) -> Result<Settings> {
    let byte = u.arbitrary::<u8>()?;
    let integrator = match byte % 64 {
        // Seldom: where its tolerance is out of reach it tries for a second.
        0 => Integrator::DormandPrince,
        _ => FIXED[usize::from(byte) % FIXED.len()],
    };
    let step = match u.arbitrary::<u8>()? % 4 {
        0 => positive(u)?,
        1 => 1e-3,
        _ => 1.0 / 60.0,
    };
    let tolerance = match u.arbitrary::<u8>()? % 4 {
        0 => positive(u)?,
        1 => 1e-9,
        _ => 1e-4,
    };
    let (substeps, newton) = (u.int_in_range(0..=4)?, u.int_in_range(0..=3)?);
    Ok(Settings { integrator, step, substeps, tolerance, newton })
}
