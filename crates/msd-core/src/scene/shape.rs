//! Ropes, cloths and blocks, all of them lattices.

use crate::error::Error;
use crate::scene::check::{check, is_finite};
use crate::scene::lattice::{Lattice, Neighbours};
use crate::scene::part::{Material, Part};
use crate::scene::substance::{Cell, Substance};
use crate::scene::surface::Surface;
use crate::scene::{Particle, Scene, Spring};
use alloc::vec::Vec;
use glam::DVec3;

/// Makes a straight rope of `count` particles along x, centred at the origin.
///
/// # Errors
/// See [`lattice`].
pub fn rope(count: usize, spacing: f64, material: Material) -> Result<Part, Error> {
    lattice([1, count, 1], Neighbours::All, spacing, material)
}

/// Makes an upright cloth of `rows` x `columns` particles in the plane z = 0.
///
/// # Errors
/// See [`lattice`].
pub fn cloth(size: [usize; 2], spacing: f64, material: Material) -> Result<Part, Error> {
    lattice([size[0], size[1], 1], Neighbours::All, spacing, material)
}

/// Makes a block of rows x columns x stacks particles, each joined to its 26 neighbours.
///
/// # Errors
/// See [`lattice`].
pub fn block(size: [usize; 3], spacing: f64, material: Material) -> Result<Part, Error> {
    lattice(size, Neighbours::All, spacing, material)
}

/// Makes a body of `size` = (rows, columns, stacks) particles at rest, `spacing` metres apart,
/// centred at the origin: rows along y, columns along x, stacks along z.
///
/// # Errors
/// A size of 0, a spacing that is not positive and finite, or more rows than fit.
pub fn lattice(
    size: [usize; 3],
    neighbours: Neighbours,
    spacing: f64,
    material: Material,
) -> Result<Part, Error> {
    let lattice = Lattice::new(size, neighbours)?;
    check_spacing(spacing)?;
    let alike = [material.stiffness, material.damping];
    Ok(part(&lattice, spacing, |_| material.mass, |_| alike))
}

/// Makes a body of `size` = (rows, columns, stacks) particles, as [`lattice`] does, of springs and
/// masses by which it behaves like a substance: a block of a solid, a cloth of a sheet, a rope.
///
/// Any uniform strain of it has exactly the stress of the substance, at faces and edges too. (Shear
/// adds loads at the eight corners of a block, which balance one another.) A sheet and a rope
/// resist bending too. One whose first two particles, or rows of them, are pinned is clamped in the
/// middle between these.
///
/// # Errors
/// See [`lattice`]; a number of the substance outside its domain, or a size with more or fewer
/// dimensions than it.
pub fn body(size: [usize; 3], spacing: f64, substance: &Substance) -> Result<Part, Error> {
    let lattice = Lattice::new(size, Neighbours::All)?;
    check_spacing(spacing)?;
    let cell = Cell::new(substance, size, spacing)?;
    let mass = |place| cell.mass_at(&lattice, place);
    let part = part(&lattice, spacing, mass, |index| cell.spring(&lattice, index));
    Ok(Part { bends: cell.bends(&lattice), volumes: cell.volumes(&lattice), ..part })
}

fn check_spacing(spacing: f64) -> Result<(), Error> {
    let usable = 0.0 < spacing && is_finite::<f32>(spacing);
    check(usable, "spacing", ("body", 0), spacing, "positive and finite")
}

/// The rows of a lattice from the mass of the particle at a place, and stiffness and damping of a
/// spring.
fn part(
    lattice: &Lattice,
    spacing: f64,
    mass: impl Fn([usize; 3]) -> f64,
    constants: impl Fn(usize) -> [f64; 2],
) -> Part {
    let middle = lattice.size().map(|length| 0.5 * (length - 1) as f64);
    let particle = |index: usize| {
        let at = lattice.place(index);
        let [y, x, z] = [0, 1, 2].map(|axis| (at[axis] as f64 - middle[axis]) * spacing);
        let position = DVec3::new(x, y, z);
        Particle { position, velocity: DVec3::ZERO, mass: mass(at) }
    };
    let spring = |index: usize| {
        let [stiffness, damping] = constants(index);
        let rest_length = spacing * Lattice::family_length(lattice.family_of(index));
        Spring { ends: lattice.spring(index), rest_length, stiffness, damping }
    };
    let corners = (0..lattice.corner_count()).filter_map(|index| lattice.corner(index));
    let triangles = (0..lattice.triangle_count()).filter_map(|index| lattice.triangle(index));
    Part {
        particles: (0..lattice.particle_count()).map(particle).collect(),
        springs: (0..lattice.spring_count()).map(spring).collect(),
        bends: Vec::new(),
        volumes: Vec::new(),
        surface: Surface {
            corners: corners.collect(),
            triangles: triangles.collect(),
            two_sided: lattice.is_sheet(),
        },
    }
}

impl Scene {
    /// A scene of one part in the default world.
    pub fn of(name: &str, part: Part) -> Self {
        let mut scene = Scene::default();
        scene.add(name, part);
        scene
    }
}
