//! Workloads on which the speed of engines is compared: a cloth that swings, a block that drops and
//! an unstructured block.
//!
//! The numbers are part of the comparison: who changes one measures something else. All start at
//! rest and are stepped by [`settings`] under the default gravity, 9.82 m/s² down.

use crate::error::{FileError, Place};
use crate::file::{Budget, count_lattice};
use crate::nearby::join_nearest;
use glam::{DMat3, DVec3};
use msd_core::{
    Error, Friction, Integrator, Lattice, Material, Neighbours, Particle, Pin, Plane, Scene,
    Settings, Shape, Shell, Solid, Spring, shape,
};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// Mass of every particle, kilograms.
const MASS: f64 = 1.0;
/// Distance of neighbours along an axis, metres.
const SPACING: f64 = 1.0;
/// Height above the plane at which the lowest particles of the block start, metres.
const DROP: f64 = 1.0;
/// Springs of a particle of the unstructured block at least.
const NEAREST: usize = 14;

/// The settings of the work unless a user chooses otherwise: frames of 1/60 s in 12 substeps of
/// symplectic Euler.
pub fn settings() -> Settings {
    let integrator = Integrator::SymplecticEuler;
    Settings { integrator, step: 1.0 / 60.0, substeps: 12, ..Settings::default() }
}

/// Makes a flat cloth of `side` x `side` particles, pinned at (0, 0) and (`side` − 1, 0).
///
/// Particle (i, j) has the number i `side` + j and starts at x = i, y = 0, z = j, metres. Unit
/// masses, 8 neighbours 1 m apart, stiffness 1e4 N/m, damping 20 N s/m; (`side` − 1) (4 `side` − 2)
/// springs.
///
/// # Errors
/// A side below 2, [`FileError::TooLarge`].
pub fn cloth(side: usize) -> Result<Scene, FileError> {
    let material = Material { mass: MASS, stiffness: 1e4, damping: 20.0 };
    let (mut scene, lattice) = lattice("cloth", side, ([1, side, side], material), 0.0)?;
    let corners = [[0, 0, 0], [0, side - 1, 0]];
    let pin = |at| Pin { particle: lattice.particle(at), velocity: DVec3::ZERO };
    scene.pins.extend(corners.map(pin));
    Ok(scene)
}

/// Makes a block of `side` x `side` x `side` particles that drops from 1 m on the plane y = 0,
/// which neither returns speed nor rubs.
///
/// Particle (i, j, k) has the number (i `side` + j) `side` + k and starts at x = j, y = 1 + i,
/// z = k, metres. Unit masses, 26 neighbours 1 m apart, stiffness 2200 N/m, damping 1 N s/m;
/// (`side` − 1) (13 `side`² − 14 `side` + 4) springs.
///
/// # Errors
/// A side below 2, [`FileError::TooLarge`].
pub fn block(side: usize) -> Result<Scene, FileError> {
    let material = Material { mass: MASS, stiffness: 2200.0, damping: 1.0 };
    let (mut scene, _) = lattice("block", side, ([side; 3], material), DROP)?;
    scene.planes.push(ground());
    Ok(scene)
}

/// Makes an unstructured block of `count` particles at random places in a cube, which drops from 1
/// m on the plane of [`block`].
///
/// Unit masses, on average one in a cubic metre, in no order. Each is joined to its 14 nearest, or
/// to all others if there are fewer, no two of them twice: about 8 springs per particle. As long at
/// rest as the ends are apart, stiffness 2200 N/m, damping 1 N s/m. The same bits on every machine.
///
/// # Errors
/// More than memory holds, [`FileError::TooLarge`].
pub fn irregular(count: usize) -> Result<Scene, FileError> {
    check_memory("irregular", [count as u128, count as u128 * NEAREST as u128])?;
    let side = libm::cbrt(count as f64);
    let mut random = Pcg32::new(1, 1);
    let mut unit = || f64::from(random.next_u32()) / (1u64 << 32) as f64;
    let mut point = || DVec3::new(unit(), unit(), unit()) * side;
    let points: Vec<DVec3> = (0..count).map(|_| point()).collect();
    let particle = |&point: &DVec3| Particle {
        position: point + DROP * DVec3::Y,
        velocity: DVec3::ZERO,
        mass: MASS,
    };
    let particles: Vec<Particle> = points.iter().map(particle).collect();
    let spring = |pair: [u32; 2]| {
        let ends = pair.map(|end| end as usize);
        let [a, b] = ends.map(|end| particles[end].position);
        Spring { ends, rest_length: a.distance(b), stiffness: 2200.0, damping: 1.0 }
    };
    let springs = join_nearest(&points, NEAREST).into_iter().map(spring).collect();
    Ok(Scene { particles, springs, planes: vec![ground()], ..Scene::default() })
}

/// Makes three cloths of `side` x `side` particles, one above the other, about to fall on a ball.
/// With 13 it is the scene on which other engines are timed.
///
/// # Errors
/// A side below 2, [`FileError::TooLarge`].
pub fn drape(side: usize) -> Result<Scene, FileError> {
    let refused = |error| FileError::Core { file: "drape".into(), source: Box::new(error) };
    let size = [side, side, 1];
    check_side("drape", side)?;
    check_memory("drape", count_lattice(size, Neighbours::All).map(|count| 3 * count))?;
    let material = Material { mass: 0.01, stiffness: 30.0, damping: 0.01 };
    let mut scene = Scene::default();
    for layer in 0..3 {
        let mut part = shape::cloth([side; 2], 0.08, material).map_err(refused)?;
        let middle = -0.04 * (side - 1) as f64 * DVec3::new(1.0, 0.0, 1.0);
        let above = DVec3::Y * (0.35 + 0.1 * f64::from(layer));
        part.place(DMat3::from_rotation_x(core::f64::consts::FRAC_PI_2), middle + above);
        scene.add("cloth", part);
    }
    let friction = Friction::Coulomb(0.3);
    scene.planes.push(Plane { normal: DVec3::Y, offset: -0.6, restitution: 0.0, friction });
    scene.solids.push(Solid { friction, ..Solid::new(Shape::Sphere { radius: 0.3 }) });
    scene.shells = shells(&scene, 0.008, 0.3);
    Ok(scene)
}

/// The surface of each body of a scene as a shell that meets itself and the others.
pub fn shells(scene: &Scene, thickness: f64, friction: f64) -> Vec<Shell> {
    let shell = |body| Shell { friction, itself: true, ..Shell::of(body, thickness) };
    scene.bodies.iter().map(shell).collect()
}

fn check_side(name: &str, side: usize) -> Result<(), FileError> {
    if 2 <= side {
        return Ok(());
    }
    let (value, expected) = (side as f64, "at least 2");
    let error = Error::OutOfDomain { quantity: "side", item: "body", row: 0, value, expected };
    Err(FileError::Core { file: name.into(), source: Box::new(error) })
}

/// Refuses particles and springs that take more memory than a scene may.
fn check_memory(name: &str, counts: [u128; 2]) -> Result<(), FileError> {
    let asks = || (Place { file: name.into(), position: None }, "its size".into());
    Budget::default().take_for(asks, counts)
}

/// The plane y = 0, which neither returns speed nor rubs.
fn ground() -> Plane {
    Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction: Friction::Coulomb(0.0) }
}

/// A lattice whose first particle is at x = 0, y = `height`, z = 0.
fn lattice(
    name: &str,
    side: usize,
    (size, material): ([usize; 3], Material),
    height: f64,
) -> Result<(Scene, Lattice), FileError> {
    let refused = |error| FileError::Core { file: name.into(), source: Box::new(error) };
    check_side(name, side)?;
    check_memory(name, count_lattice(size, Neighbours::All))?;
    let lattice = Lattice::new(size, Neighbours::All).map_err(refused)?;
    let part = shape::lattice(size, Neighbours::All, SPACING, material).map_err(refused)?;
    let mut scene = Scene::of(name, part);
    let start = DVec3::new(0.0, height, 0.0) - scene.particles[0].position;
    scene.particles.iter_mut().for_each(|particle| particle.position += start);
    Ok((scene, lattice))
}
