//! Bodies from meshes: particles and springs of a shell or of a filled solid.

mod lattice;
mod pieces;
mod brace;
mod shares;
mod shell;
mod texture;

use crate::mesh::clean::interior::Interior;
use crate::mesh::clean::topology::{edges, sides};
use crate::mesh::clean::winding::{Winding, holes};
use crate::mesh::error::MeshError;
use crate::mesh::fill::brace::{Braces, Frame, MOST_ROUND};
use crate::mesh::fill::lattice::{check_spacing, fill};
use crate::mesh::fill::pieces::pieces;
use crate::mesh::fill::shell::{of_sheet, shell_springs};
use crate::mesh::fill::texture::surface;
use crate::mesh::import::Mesh;
use crate::mesh::subdivide::subdivided;
use glam::DVec3;
use msd_core::substance::SOLID_POISSON;
use msd_core::{Elasticity, Part, Particle, Spring, Substance};
use std::borrow::Cow;

/// Seam springs from a particle on an open edge to the piece beside it.
const SEAMS: usize = 3;

/// The most of its surface over which a mesh may leave its inside undecided.
const MOST_UNDECIDED: f64 = 0.1;

/// The longest edges of the surface of a material, root mean square, in spacings. A coarser one is
/// cut up, as too few springs from the lattice would reach its corners.
const LONGEST_EDGE: f64 = 1.1;

/// The inside of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Filling {
    /// A solid if the mesh is closed, else a shell.
    #[default]
    Auto,
    /// An interior lattice. Holes are taken for closed; a mesh that leaves its inside undecided
    /// over more than a tenth of its surface is refused.
    Solid,
    /// Nothing.
    Shell,
}

/// Options of the body that is built from a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshOptions {
    /// The inside. Default [`Filling::Auto`].
    pub filling: Filling,
    /// Longest side of the bounding box, metres; positive. Default 1; `None` takes the units of
    /// the file as metres.
    pub size: Option<f64>,
    /// Spacing of the interior lattice, metres; positive. By default 1.2 times the mean length of
    /// the surface edges, but between 1/48 and 1/6 of the longest side.
    pub spacing: Option<f64>,
    /// Mass of the whole body, kilograms; positive. Default 1. Every particle has the same share:
    /// the lightest particle limits the step, so the best conditioned body has none.
    pub mass: f64,
    /// Stiffness of each spring, newtons per metre; not negative. Default 200: enough for a solid
    /// of 1 m and 1 kg to fall 1 m and keep its shape. All springs share it whatever their length:
    /// a uniform column runs fastest. A finer mesh of the same stiffness is a softer body.
    pub stiffness: f64,
    /// Damping of each spring, newton seconds per metre; not negative. Default 0.04.
    pub damping: f64,
    /// Stiffness and damping of the bending springs of a shell as a fraction of those of the
    /// others; not negative. Default 1, which keeps the columns uniform.
    pub bending: f64,
    /// Its substance, instead of mass, stiffness, damping and bending. Particles and springs are
    /// then those of the volume that they stand for; in a shell, which is of a uniform sheet, those
    /// of the area. Poisson's ratio is that of springs, 1/4 or 1/3. Default `None`.
    pub substance: Option<Substance>,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            filling: Filling::Auto,
            size: Some(1.0),
            spacing: None,
            mass: 1.0,
            stiffness: 200.0,
            damping: 0.04,
            bending: 1.0,
            substance: None,
        }
    }
}

impl MeshOptions {
    /// The defaults for a mesh that is filled so. A shell of an open mesh gets five times the
    /// stiffness and damping, since it has no inside to hold it up.
    pub fn for_mesh(mesh: &Mesh, filling: Filling) -> Self {
        let default = Self { filling, ..Self::default() };
        if mesh.is_closed() || filling == Filling::Solid {
            return default;
        }
        Self { stiffness: 5.0 * default.stiffness, damping: 5.0 * default.damping, ..default }
    }
}

/// The composition of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyReport {
    /// Whether it has an interior lattice.
    pub solid: bool,
    /// Particles on the surface: the first of the part, in the order of the mesh.
    pub surface_particles: usize,
    /// Particles of the interior lattice: the rest.
    pub interior_particles: usize,
    /// Springs along surface edges.
    pub edge_springs: usize,
    /// Springs from lattice point to lattice point; none in a shell.
    pub lattice_springs: usize,
    /// Springs from the surface inward, or across thin parts; none in a shell.
    pub brace_springs: usize,
    /// Springs across surface edges, against bending; none in a solid, nor in a shell of a
    /// material.
    pub bending_springs: usize,
    /// Pairs of triangles that resist bending in a shell of a material.
    pub hinges: usize,
    /// Springs between the open edges of a piece and the next piece; none in a solid.
    pub seam_springs: usize,
    /// Particles of a solid with fewer than four springs, or held in some direction by less than a
    /// quarter of one spring: those of a flat body, or of one too small for its lattice. 0 in a
    /// shell.
    pub loose_particles: usize,
    /// Loops of open edges that were taken for closed, to make a solid of an open mesh.
    pub holes: usize,
    /// Enclosed volume, cubic metres; 0 for the shell of an open mesh.
    pub volume: f64,
    /// Spacing of the interior lattice, metres; 0 for a shell.
    pub spacing: f64,
    /// Of a solid of a material: the root mean square of the forces that are left over in a uniform
    /// strain, as a part of those on the surface. 0 would be exact, and is that of other bodies.
    pub unbalanced: f64,
}

impl core::fmt::Display for BodyReport {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let kind = if self.solid { "solid" } else { "shell" };
        let closed = match self.holes {
            0 => String::new(),
            1 => ", one hole taken for closed".into(),
            holes => format!(", {holes} holes taken for closed"),
        };
        write!(
            f,
            "{kind}{}: {} surface and {} interior particles; {} edge, {} lattice, {} brace, {} \
             bending and {} seam springs; {} loose particles",
            closed,
            self.surface_particles,
            self.interior_particles,
            self.edge_springs,
            self.lattice_springs,
            self.brace_springs,
            self.bending_springs,
            self.seam_springs,
            self.loose_particles
        )?;
        if 0 < self.hinges {
            write!(f, "; {} hinges", self.hinges)?;
        }
        if 0.0 < self.unbalanced {
            let percent = 100.0 * self.unbalanced;
            write!(f, "; in a uniform strain its forces balance within {percent:.1} %")?;
        }
        Ok(())
    }
}

/// Builds a body from a mesh, the centre of its bounding box at the origin.
///
/// Every vertex becomes a particle, every edge a spring. A solid gets a cubic lattice inside with
/// springs to 26 neighbours, and braces from each surface particle to the nearest lattice points
/// or, in thin parts, across. A shell gets a bending spring across each edge that two faces share,
/// and seams. Its pieces, like the spout of a teapot, are joined where the open edge of one comes
/// within a mean edge length of another. Each spring starts at its rest length.
///
/// A solid of a substance has a surface as fine as its lattice, cut up where the mesh is coarser,
/// and more braces, to whatever is near. Its mass is that of the volume which the mesh encloses. A
/// shell of a substance has the mass of its area, and hinges instead of bending springs.
///
/// # Errors
/// An option outside its domain; a solid of a mesh that leaves its inside undecided; a substance of
/// other dimensions than the body; a lattice too fine.
///
/// # Panics
/// If a triangle names no vertex, or there are texture coordinates of fewer triangles: no [`Mesh`]
/// that was read or parsed is so.
pub fn body(mesh: &Mesh, options: &MeshOptions) -> Result<(Part, BodyReport), MeshError> {
    let solid = check(mesh, options)?;
    let options = &with_spacing(mesh, options);
    let mesh = &*as_fine(mesh, options)?;
    let mut points = place(&mesh.positions, options.size);
    let mut report = BodyReport { solid, surface_particles: points.len(), ..Default::default() };
    if solid || mesh.is_closed() {
        (report.holes, report.volume) = holes(&points, &mesh.triangles);
    }
    let ends = if solid {
        solid_springs(mesh, options, &mut points, &mut report)?
    } else {
        shell_springs(mesh, &points, options.substance.is_none(), &mut report)
    };
    let surface =
        surface(&points[..report.surface_particles], &mesh.triangles, mesh.uvs.as_deref(), !solid);
    let ((masses, constants), bends) = match &options.substance {
        Some(substance) if solid => {
            (shared(substance, (&points, &ends, &mesh.triangles), &mut report)?, Vec::new())
        }
        Some(substance) => of_sheet(substance, &points, (mesh, &ends), &mut report)?,
        None => (alike(options, (points.len(), ends.len()), &report), Vec::new()),
    };
    let particle = |(&position, mass)| Particle { position, velocity: DVec3::ZERO, mass };
    let spring = |(&ends, [stiffness, damping]): (&[usize; 2], [f64; 2])| {
        let rest_length = points[ends[0]].distance(points[ends[1]]);
        Spring { ends, rest_length, stiffness, damping }
    };
    let springs = ends.iter().zip(constants).map(spring).collect();
    let particles = points.iter().zip(masses).map(particle).collect();
    Ok((Part { particles, springs, bends, surface, ..Part::default() }, report))
}

/// The masses of particles, and stiffness and damping of springs.
type Constants = (Vec<f64>, Vec<[f64; 2]>);

/// Masses and springs that are alike but for those that resist bending.
fn alike(
    options: &MeshOptions,
    (particles, springs): (usize, usize),
    report: &BodyReport,
) -> Constants {
    let bending = report.edge_springs..report.edge_springs + report.bending_springs;
    let spring = |row: usize| {
        let fraction = if bending.contains(&row) { options.bending } else { 1.0 };
        [fraction * options.stiffness, fraction * options.damping]
    };
    (vec![options.mass / particles as f64; particles], (0..springs).map(spring).collect())
}

/// Masses and springs by the volume that each stands for.
///
/// # Errors
/// A substance that is not a solid of springs alone, or a number outside its domain.
fn shared(
    substance: &Substance,
    (points, springs, triangles): (&[DVec3], &[[usize; 2]], &[[u32; 3]]),
    report: &mut BodyReport,
) -> Result<Constants, MeshError> {
    let young = young(substance)?;
    let (first, count) = (report.edge_springs, report.lattice_springs);
    let squared = |[a, b]: [usize; 2]| points[a].distance_squared(points[b]);
    // Diagonals of faces are as long as the root of 2, those of cells as the root of 3.
    let cell = report.spacing * report.spacing * report.spacing;
    let far = 2.5 * report.spacing * report.spacing;
    let in_lattice =
        |&ends: &[usize; 2]| cell * if squared(ends) < far { 8.0 / 90.0 } else { 0.05 };
    let lattice: Vec<f64> = springs[first..first + count].iter().map(in_lattice).collect();
    let areas = shares::areas(points, triangles);
    let whole = (&lattice[..], report.volume.abs());
    let shares = shares::share(points, springs, &areas, whole, first);
    report.unbalanced = shares.unbalanced;
    let masses = shares::of_particles(points.len(), springs, &shares.volumes);
    let spring = |(&ends, volume): (&[usize; 2], &f64)| {
        let stiffness = 6.0 * young * volume / squared(ends);
        [stiffness, stiffness * substance.relaxation_time]
    };
    let constants = springs.iter().zip(&shares.volumes).map(spring).collect();
    Ok((masses.into_iter().map(|volume| substance.density * volume).collect(), constants))
}

/// Young's modulus of a substance that may fill a mesh, pascals.
///
/// # Errors
/// See [`shared`].
fn young(substance: &Substance) -> Result<f64, MeshError> {
    let Substance { elasticity, density, relaxation_time } = *substance;
    let option = |quantity, value, expected| Err(MeshError::Option { quantity, value, expected });
    let Elasticity::Solid { young, poisson } = elasticity else {
        let dimensions = if matches!(elasticity, Elasticity::Sheet { .. }) { 2.0 } else { 1.0 };
        let expected = "3, those of a solid, in one";
        return option("number of dimensions of the substance", dimensions, expected);
    };
    let positive = "positive and finite";
    for (quantity, value) in [("Young's modulus", young), ("density", density)] {
        if !(0.0 < value && value.is_finite()) {
            return option(quantity, value, positive);
        }
    }
    if !(0.0 <= relaxation_time && relaxation_time.is_finite()) {
        return option("relaxation time", relaxation_time, "finite and not negative");
    }
    if poisson != SOLID_POISSON {
        return option("Poisson's ratio", poisson, "0.25, that of springs");
    }
    Ok(young)
}

/// The mesh, its triangles cut up if it is to be of a material and coarser than the spacing given.
///
/// # Errors
/// A lattice too fine, or coarser than the body.
fn as_fine<'m>(mesh: &'m Mesh, options: &MeshOptions) -> Result<Cow<'m, Mesh>, MeshError> {
    let mut fine = Cow::Borrowed(mesh);
    let fills = options.substance.is_some() && is_solid(mesh, options.filling);
    if let (true, Some(spacing)) = (fills, options.spacing) {
        let points = place(&mesh.positions, options.size);
        let longest = 2.0 * points.iter().fold(0.0, |most: f64, p| most.max(p.abs().max_element()));
        if longest < spacing {
            let expected = "at most the longest side of the body";
            return Err(MeshError::Option { quantity: "spacing", value: spacing, expected });
        }
        check_spacing(&points, spacing, &mesh.name)?;
        let (edges, _) = edge_springs(mesh, &points);
        let squares = edges.iter().map(|&[a, b]| points[a].distance_squared(points[b]));
        let mut edge = (squares.sum::<f64>() / edges.len() as f64).sqrt();
        // Each cut halves the edges; those that it adds are as long.
        while LONGEST_EDGE * spacing < edge {
            fine = Cow::Owned(subdivided(&fine));
            edge *= 0.5;
        }
    }
    Ok(fine)
}

/// The options of a solid of a material with the spacing that they amount to: that of the mesh
/// before it is cut up.
fn with_spacing(mesh: &Mesh, options: &MeshOptions) -> MeshOptions {
    if options.substance.is_none() || !is_solid(mesh, options.filling) {
        return *options;
    }
    let points = place(&mesh.positions, options.size);
    let (_, mean) = edge_springs(mesh, &points);
    MeshOptions { spacing: Some(spacing(options, &points, mean)), ..*options }
}

/// Estimates, from above, the particles and springs of a body that is not built yet.
///
/// # Errors
/// See [`body`].
pub(crate) fn estimate(mesh: &Mesh, options: &MeshOptions) -> Result<[u128; 2], MeshError> {
    let solid = check(mesh, options)?;
    let options = &with_spacing(mesh, options);
    let mesh = &*as_fine(mesh, options)?;
    let points = place(&mesh.positions, options.size);
    let (edges, mean) = edge_springs(mesh, &points);
    let (surface, edges) = (points.len() as u128, edges.len() as u128);
    if !solid {
        // A bending spring across every edge, seams from every particle.
        return Ok([surface, 2 * edges + SEAMS as u128 * surface]);
    }
    let spacing = spacing(options, &points, mean);
    check_spacing(&points, spacing, &mesh.name)?;
    // A lattice point per cell of the volume, with 13 springs; braces from the surface.
    let braces = if options.substance.is_some() { MOST_ROUND as u128 } else { 4 };
    let cell = spacing * spacing * spacing;
    let (_, volume) = holes(&points, &mesh.triangles);
    let inside = (volume.abs() / cell).ceil() as u128;
    Ok([surface + inside, edges + 13 * inside + braces * surface])
}

/// Checks the options; returns whether the body is a solid.
fn check(mesh: &Mesh, options: &MeshOptions) -> Result<bool, MeshError> {
    check_options(options)?;
    let solid = is_solid(mesh, options.filling);
    if solid && !mesh.is_closed() {
        let undecided = Winding::new(&mesh.positions, &mesh.triangles).undecided();
        if MOST_UNDECIDED < undecided {
            return Err(MeshError::Undecided { file: mesh.name.clone(), undecided });
        }
    }
    Ok(solid)
}

/// Whether a mesh is to become a solid.
pub(crate) fn is_solid(mesh: &Mesh, filling: Filling) -> bool {
    match filling {
        Filling::Auto => mesh.is_closed(),
        Filling::Solid => true,
        Filling::Shell => false,
    }
}

/// The spacing of the lattice that fills a mesh of this size where none is given, metres.
pub(crate) fn own_spacing(mesh: &Mesh, size: f64) -> f64 {
    let points = place(&mesh.positions, Some(size));
    let (_, mean) = edge_springs(mesh, &points);
    spacing(&MeshOptions::default(), &points, mean)
}

fn check_options(options: &MeshOptions) -> Result<(), MeshError> {
    let positive = |quantity, value: f64| {
        // A NaN fails both comparisons.
        let ok = 0.0 < value && value <= 1e9;
        let expected = "positive and at most 1e9";
        if ok { Ok(()) } else { Err(MeshError::Option { quantity, value, expected }) }
    };
    let not_negative = |quantity, value: f64| {
        let ok = 0.0 <= value && value.is_finite();
        let expected = "finite and not negative";
        if ok { Ok(()) } else { Err(MeshError::Option { quantity, value, expected }) }
    };
    positive("size", options.size.unwrap_or(1.0))?;
    positive("spacing", options.spacing.unwrap_or(1.0))?;
    positive("mass", options.mass)?;
    not_negative("stiffness", options.stiffness)?;
    not_negative("damping", options.damping)?;
    not_negative("bending fraction", options.bending)
}

/// Scales positions to the size asked for, centred on the origin.
pub(crate) fn place(positions: &[DVec3], size: Option<f64>) -> Vec<DVec3> {
    let low = positions.iter().copied().fold(DVec3::MAX, DVec3::min);
    let high = positions.iter().copied().fold(DVec3::MIN, DVec3::max);
    let scale = size.map_or(1.0, |size| size / (high - low).max_element());
    positions.iter().map(|&position| scale * (position - (low + high) / 2.0)).collect()
}

/// The surface edges as springs, and their mean length.
fn edge_springs(mesh: &Mesh, points: &[DVec3]) -> (Vec<[usize; 2]>, f64) {
    let sides = sides(&mesh.triangles);
    let springs: Vec<_> = edges(&sides).map(|edge| edge[0].ends.map(|end| end as usize)).collect();
    let length: f64 = springs.iter().map(|&[a, b]| points[a].distance(points[b])).sum();
    let mean = length / springs.len() as f64;
    (springs, mean)
}

/// Spacing of the lattice inside, by the mean length of the surface edges if it is not given.
fn spacing(options: &MeshOptions, points: &[DVec3], mean: f64) -> f64 {
    let extent = points.iter().fold(0.0, |extent: f64, p| extent.max(p.abs().max_element()));
    let automatic = (1.2 * mean).clamp(2.0 * extent / 48.0, 2.0 * extent / 6.0);
    options.spacing.unwrap_or(automatic)
}

fn solid_springs(
    mesh: &Mesh,
    options: &MeshOptions,
    points: &mut Vec<DVec3>,
    report: &mut BodyReport,
) -> Result<Vec<[usize; 2]>, MeshError> {
    let (mut springs, mean) = edge_springs(mesh, points);
    let vertices = points.clone();
    let spacing = spacing(options, points, mean);
    let inside = Interior::new(&vertices, &mesh.triangles, mesh.is_closed());
    let lattice = fill((&vertices, &mesh.triangles), &inside, spacing, &mesh.name)?;
    let first = vertices.len();
    points.extend(&lattice.points);
    report.spacing = spacing;
    report.interior_particles = lattice.points.len();
    report.edge_springs = springs.len();
    let pieces = pieces((&vertices, &mesh.triangles), &lattice.points, mesh.is_closed());
    let inner = lattice.springs.iter().map(|ends| ends.map(|end| first + end));
    springs.extend(inner.filter(|&[a, b]| pieces[a] == pieces[b]));
    report.lattice_springs = springs.len() - report.edge_springs;
    let frame = Frame {
        points,
        surface: first,
        normals: &normals(&vertices, &mesh.triangles),
        pieces: &pieces,
        inside: &inside,
        spacing,
        joined: springs.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect(),
    };
    let many = options.substance.is_some();
    let (braces, loose) = frame.brace(if many { Braces::AllRound } else { Braces::Inward });
    report.loose_particles = loose;
    report.brace_springs = braces.len();
    springs.extend(braces);
    Ok(springs)
}

/// Outward directions at the vertices, weighted by area.
fn normals(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; points.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        for &corner in corners {
            normals[corner as usize] += (b - a).cross(c - a);
        }
    }
    normals.into_iter().map(DVec3::normalize_or_zero).collect()
}
