//! Shells: springs along the edges of a mesh, and those that keep it from bending.
//!
//! In a shell of a material a spring of length L along an edge stands for the triangles at it, of
//! areas A: k = E t Σ A/L² (Van Gelder, 1998). A particle has a third of the mass of each of its
//! triangles, and two triangles that share an edge resist bending by [`Bend::hinge`].

use super::{BodyReport, Constants, SEAMS, edge_springs};
use crate::mesh::clean::topology::{components, edges, sides};
use crate::mesh::error::MeshError;
use crate::mesh::import::Mesh;
use crate::nearby::Nearby;
use glam::DVec3;
use msd_core::substance::SHEET_POISSON;
use msd_core::{Bend, Bending, Elasticity, Substance};
use std::collections::BTreeSet;

/// The ends of the springs of a shell; `bends` says whether springs across edges resist bending.
pub(super) fn shell_springs(
    mesh: &Mesh,
    points: &[DVec3],
    bends: bool,
    report: &mut BodyReport,
) -> Vec<[usize; 2]> {
    let (mut springs, mean) = edge_springs(mesh, points);
    report.edge_springs = springs.len();
    let mut joined: BTreeSet<[usize; 2]> = springs.iter().copied().collect();
    let sides = sides(&mesh.triangles);
    for edge in edges(&sides).filter(|_| bends) {
        // Two of the faces at an edge with more than two still resist bending.
        let &[a, b, ..] = edge else { continue };
        let (a, b) = (a.opposite as usize, b.opposite as usize);
        let pair = [a.min(b), a.max(b)];
        if a != b && joined.insert(pair) {
            springs.push(pair);
        }
    }
    report.bending_springs = springs.len() - report.edge_springs;
    for pair in seams(mesh, points, mean) {
        if joined.insert(pair) {
            springs.push(pair);
            report.seam_springs += 1;
        }
    }
    springs
}

/// Pairs across the gaps between the pieces of a mesh, from each open edge.
fn seams(mesh: &Mesh, points: &[DVec3], reach: f64) -> Vec<[usize; 2]> {
    let (pieces, count) = components(points.len(), &mesh.triangles);
    if count < 2 {
        return Vec::new();
    }
    let sides = sides(&mesh.triangles);
    let open = edges(&sides).filter(|edge| edge.len() == 1);
    let border: BTreeSet<u32> = open.flat_map(|edge| edge[0].ends).collect();
    let nearby = Nearby::new(points, reach);
    let mut pairs = Vec::new();
    for from in border.into_iter().map(|vertex| vertex as usize) {
        let near = nearby.within(points[from], reach).into_iter();
        let across = near.filter(|&to| pieces[to] != pieces[from]).take(SEAMS);
        pairs.extend(across.map(|to| [from.min(to), from.max(to)]));
    }
    pairs
}

/// Masses, springs and bends of a shell of a sheet, by the areas that they stand for.
///
/// # Errors
/// A substance that is not a uniform sheet, or a number outside its domain.
pub(super) fn of_sheet(
    substance: &Substance,
    points: &[DVec3],
    (mesh, springs): (&Mesh, &[[usize; 2]]),
    report: &mut BodyReport,
) -> Result<(Constants, Vec<Bend>), MeshError> {
    let (modulus, bending) = uniform(substance)?;
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        0.5 * (b - a).cross(c - a).length()
    };
    let areas: Vec<f64> = mesh.triangles.iter().map(area).collect();
    let mut masses = vec![0.0; points.len()];
    for (corners, area) in mesh.triangles.iter().zip(&areas) {
        for &corner in corners {
            masses[corner as usize] += substance.density * area / 3.0;
        }
    }
    let sides = sides(&mesh.triangles);
    let edges: Vec<_> = edges(&sides).collect();
    let mut constants = Vec::with_capacity(springs.len());
    for (row, &[a, b]) in springs.iter().enumerate() {
        // The springs along edges come first, in their order; a seam is as stiff as an edge between
        // equilateral triangles.
        let share = edges.get(row).map_or(3.0f64.sqrt() / 2.0, |edge| {
            let both: f64 = edge.iter().map(|side| areas[side.face as usize]).sum();
            both / points[a].distance_squared(points[b])
        });
        let stiffness = modulus * share;
        constants.push([stiffness, stiffness * substance.relaxation_time]);
    }
    let hinges = edges.iter().flat_map(|edge| edge.windows(2)).filter_map(|pair| {
        let [a, b] = pair[0].along();
        let particles = [a, b, pair[0].opposite, pair[1].opposite].map(|vertex| vertex as usize);
        let hinge = Bend::hinge(particles, particles.map(|particle| points[particle]), bending)?;
        let damping = hinge.stiffness * substance.relaxation_time;
        (particles[2] != particles[3]).then_some(Bend { damping, ..hinge })
    });
    let hinges: Vec<Bend> = hinges.filter(|hinge| 0.0 < hinge.stiffness).collect();
    report.hinges = hinges.len();
    Ok(((masses, constants), hinges))
}

/// Young's modulus times thickness of a uniform sheet, newtons per metre, and its bending
/// stiffness, newton metres.
///
/// # Errors
/// See [`of_sheet`].
fn uniform(substance: &Substance) -> Result<(f64, f64), MeshError> {
    let Substance { elasticity, density, relaxation_time } = *substance;
    let option = |quantity, value, expected| Err(MeshError::Option { quantity, value, expected });
    let Elasticity::Sheet { warp, weft, shear, bending } = elasticity else {
        let dimensions = if matches!(elasticity, Elasticity::Solid { .. }) { 3.0 } else { 1.0 };
        let expected = "2, those of a sheet, in a shell";
        return option("number of dimensions of the substance", dimensions, expected);
    };
    let positive = "positive and finite";
    for (quantity, value) in [("modulus", warp), ("density", density)] {
        if !(0.0 < value && value.is_finite()) {
            return option(quantity, value, positive);
        }
    }
    if warp != weft {
        return option("modulus of the weft", weft, "that of the warp: a shell has no threads");
    }
    let exact = warp / (2.0 * (1.0 + SHEET_POISSON));
    if !shear.is_finite() || 1e-9 * exact < (shear - exact).abs() {
        return option("shear modulus", shear, "3/8 of the modulus: a shell has no threads");
    }
    let Bending { warp: stiffness, weft, bias } = bending;
    if !(0.0 <= stiffness && stiffness.is_finite()) || [weft, bias] != [stiffness; 2] {
        return option("bending stiffness", bias, "not negative, and one in all directions");
    }
    if !(0.0 <= relaxation_time && relaxation_time.is_finite()) {
        return option("relaxation time", relaxation_time, "finite and not negative");
    }
    Ok((warp, stiffness))
}
