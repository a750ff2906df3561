//! The bodies that go through the hardships, and how they are maltreated.

use msd_core::glam::DVec3;
use msd_core::{Friction, Lattice, Material, Neighbours, Part, Pin, Plane, Scene, World, shape};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// Particles along an edge of the block.
const EDGE: usize = 4;
/// Between neighbours, metres.
const SPACING: f64 = 0.25;
/// Of 0.1 kg per particle, 1000 N/m and 3 Ns/m: every method is stable at 480 substeps per second.
pub const MATERIAL: Material = Material { mass: 0.1, stiffness: 1000.0, damping: 3.0 };

/// A block of 4 x 4 x 4 particles at rest about the origin, 0.75 m wide, in space without gravity.
pub fn block(material: Material) -> Scene {
    let world = World { gravity: DVec3::ZERO, ..World::default() };
    // The size fits: nothing is refused.
    let part = shape::block([EDGE; 3], SPACING, material).unwrap_or_default();
    Scene { world, ..Scene::of("block", part) }
}

/// The usual block with every position changed.
pub fn placed(place: impl Fn(DVec3) -> DVec3) -> Scene {
    placed_of(MATERIAL, place)
}

/// A block of a material with every position changed.
pub fn placed_of(material: Material, place: impl Fn(DVec3) -> DVec3) -> Scene {
    let mut scene = block(material);
    for particle in &mut scene.particles {
        particle.position = place(particle.position);
    }
    scene
}

/// The usual block with velocities by position.
pub fn moving(velocity: impl Fn(DVec3) -> DVec3) -> Scene {
    let mut scene = block(MATERIAL);
    for particle in &mut scene.particles {
        particle.velocity = velocity(particle.position);
    }
    scene
}

/// The scene in a world that reaches as far as a world may.
pub fn in_a_wide_world(mut scene: Scene) -> Scene {
    scene.world.extent = 1e12;
    scene
}

/// Every particle drawn by lot: in a box of `width` metres about the origin.
pub fn scattered(width: f64) -> Scene {
    let mut lot = lots();
    let mut scene = block(MATERIAL);
    for particle in &mut scene.particles {
        particle.position = vector(&mut lot) * width;
    }
    scene
}

/// Every particle thrown another way, at up to `speed` metres per second along each axis.
pub fn torn(speed: f64) -> Scene {
    let mut lot = lots();
    let mut scene = block(MATERIAL);
    for particle in &mut scene.particles {
        particle.velocity = vector(&mut lot) * (2.0 * speed);
    }
    scene
}

/// Any fixed seed and stream would do.
fn lots() -> Pcg32 {
    Pcg32::new(7, 0xa02b_dbf7_bb3c_0a7a)
}

/// Each component from -1/2 to 1/2.
fn vector(lot: &mut Pcg32) -> DVec3 {
    let mut draw = || f64::from(lot.next_u32()) / f64::from(u32::MAX) - 0.5;
    DVec3::new(draw(), draw(), draw())
}

/// Neighbours have masses that differ by a factor, the heavier ones as heavy as usual.
pub fn uneven(ratio: f64) -> Scene {
    let mut scene = placed(|x| x * 1.01);
    let Ok(lattice) = Lattice::new([EDGE; 3], Neighbours::All) else { return scene };
    for (row, particle) in scene.particles.iter_mut().enumerate() {
        if lattice.place(row).iter().sum::<usize>() % 2 == 1 {
            particle.mass /= ratio;
        }
    }
    scene
}

/// The usual block with springs of no length.
pub fn without_lengths() -> Scene {
    let mut scene = block(MATERIAL);
    scene.springs.iter_mut().for_each(|spring| spring.rest_length = 0.0);
    scene
}

/// A plane with its normal along y; the solid is below it, or above it where `up` is negative.
fn level(height: f64, up: f64, (restitution, friction): (f64, f64)) -> Plane {
    let normal = DVec3::new(0.0, up, 0.0);
    Plane { normal, offset: height * up, restitution, friction: Friction::Coulomb(friction) }
}

/// Lets the usual block fall on a floor a metre below it.
pub fn dropped((restitution, friction): (f64, f64), velocity: DVec3) -> Scene {
    let mut scene = moving(|_| velocity);
    scene.world = World::default();
    scene.planes.push(level(-1.375, 1.0, (restitution, friction)));
    scene
}

/// The block between a floor and a ceiling, half its height apart.
pub fn squeezed() -> Scene {
    let mut scene = block(MATERIAL);
    scene.world = World::default();
    scene.planes.extend([level(-0.1875, 1.0, (0.0, 0.5)), level(0.1875, -1.0, (0.0, 0.5))]);
    scene
}

/// The block on a floor, its upper side pinned and pressed down at 0.2 m/s, down to the floor and
/// through it.
pub fn crushed() -> Scene {
    let mut scene = block(MATERIAL);
    scene.planes.push(level(-0.375, 1.0, (0.0, 0.5)));
    let upper = |row: &usize| 0.37 < scene.particles[*row].position.y;
    let pin = |particle| Pin { particle, velocity: DVec3::new(0.0, -0.2, 0.0) };
    scene.pins = (0..scene.particles.len()).filter(upper).map(pin).collect();
    scene
}

/// The part alone, for a scene of one's own.
pub fn part() -> Part {
    shape::block([EDGE; 3], SPACING, MATERIAL).unwrap_or_default()
}
