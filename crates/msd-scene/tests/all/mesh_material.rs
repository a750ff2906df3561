//! Bodies from meshes that are made of a material: their mass, and their stretch.

use msd_core::glam::DVec3;
use msd_core::{Elasticity, Part, Substance};
use msd_scene::mesh::{self, Format, Mesh, MeshOptions};
use std::fmt::Write;

const YOUNG: f64 = 5e4;
const DENSITY: f64 = 800.0;

fn substance() -> Substance {
    let elasticity = Elasticity::Solid { young: YOUNG, poisson: 0.25 };
    Substance { elasticity, density: DENSITY, relaxation_time: 0.01 }
}

/// A box of the given sides of twelve triangles.
fn box_mesh([x, y, z]: [f64; 3]) -> Mesh {
    let mut text = String::new();
    for corner in 0..8 {
        let at = |bit: i32, side: f64| if corner >> bit & 1 == 1 { side } else { 0.0 };
        writeln!(text, "v {} {} {}", at(0, x), at(1, y), at(2, z)).unwrap();
    }
    for [a, b, c, d] in
        [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]]
    {
        writeln!(text, "f {a} {b} {c} {d}").unwrap();
    }
    mesh::parse(text.as_bytes(), Format::Obj, "box.obj").unwrap()
}

fn bunny() -> Mesh {
    mesh::parse(include_bytes!("../../meshes/bunny.obj"), Format::Obj, "bunny.obj").unwrap()
}

/// The area vector of each particle, a third of its triangles.
fn areas(part: &Part) -> Vec<DVec3> {
    let mut areas = vec![DVec3::ZERO; part.particles.len()];
    for (corners, area) in faces(part) {
        corners.into_iter().for_each(|corner| areas[corner] += area / 3.0);
    }
    areas
}

fn faces(part: &Part) -> impl Iterator<Item = ([usize; 3], DVec3)> {
    part.surface.triangles.iter().map(|triangle| {
        let corners =
            triangle.map(|corner| part.surface.corners[corner as usize].particle as usize);
        let [a, b, c] = corners.map(|corner| part.particles[corner].position);
        (corners, (b - a).cross(c - a) / 2.0)
    })
}

fn volume(part: &Part) -> f64 {
    let third = |([a, ..], area): ([usize; 3], DVec3)| part.particles[a].position.dot(area) / 3.0;
    faces(part).map(third).sum()
}

/// Solves K u = f for small displacements from rest, by conjugate gradients.
fn displacements(part: &Part, forces: &[DVec3]) -> Vec<DVec3> {
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    let rows = part.springs.iter().map(|spring| {
        let [a, b] = spring.ends.map(|end| part.particles[end].position);
        (spring.ends, (b - a).normalize(), spring.stiffness)
    });
    let rows: Vec<_> = rows.collect();
    let product = |u: &[DVec3]| {
        let mut product = vec![DVec3::ZERO; u.len()];
        for &([a, b], way, stiffness) in &rows {
            let pull = stiffness * way.dot(u[a] - u[b]) * way;
            product[a] += pull;
            product[b] -= pull;
        }
        product
    };
    let mut found = vec![DVec3::ZERO; forces.len()];
    let (mut left, mut search) = (forces.to_vec(), forces.to_vec());
    let start = dot(&left, &left);
    let mut square = start;
    while 1e-16 * start < square {
        let bent = product(&search);
        let length = square / dot(&search, &bent);
        found.iter_mut().zip(&search).for_each(|(found, way)| *found += length * *way);
        left.iter_mut().zip(&bent).for_each(|(left, bent)| *left -= length * *bent);
        let next = dot(&left, &left);
        let turn = next / square;
        search.iter_mut().zip(&left).for_each(|(way, left)| *way = *left + turn * *way);
        square = next;
    }
    found
}

/// Young's modulus and Poisson's ratio of a body that is pulled by a uniform stress along a
/// direction, from its mean strain (by the divergence theorem, from its surface).
fn pulled(part: &Part, along: DVec3) -> (f64, f64) {
    let forces: Vec<DVec3> = areas(part).iter().map(|area| along * along.dot(*area)).collect();
    let moved = displacements(part, &forces);
    let (mut stretch, mut growth) = (0.0, 0.0);
    for (corners, area) in faces(part) {
        let mean = corners.into_iter().map(|corner| moved[corner]).sum::<DVec3>() / 3.0;
        stretch += mean.dot(along) * area.dot(along);
        growth += mean.dot(area);
    }
    let (stretch, growth) = (stretch / volume(part), growth / volume(part));
    (1.0 / stretch, (stretch - growth) / (2.0 * stretch))
}

#[test]
fn a_mesh_of_a_material_weighs_its_volume_and_stretches_as_the_material_does() {
    let spaced = |size: f64, spacing: f64| MeshOptions {
        size: Some(size),
        spacing: Some(spacing),
        substance: Some(substance()),
        ..MeshOptions::default()
    };
    let own = MeshOptions { spacing: None, ..spaced(0.5, 1.0) };
    let long = box_mesh([3.0, 1.0, 1.0]);
    // A lattice that fits the box, one that does not, and the one that msd takes.
    for (mesh, options) in [
        (&long, spaced(0.3, 0.025)),
        (&long, spaced(0.3, 0.023)),
        (&box_mesh([1.0, 1.2, 0.8]), MeshOptions { size: None, ..own }),
        (&bunny(), own),
    ] {
        let (part, report) = mesh::body(mesh, &options).unwrap();
        let mass: f64 = part.particles.iter().map(|particle| particle.mass).sum();
        // Two sums of as many roundings as there are springs and faces.
        assert!((mass / (DENSITY * volume(&part)) - 1.0).abs() < 1e-12, "{mass}");
        assert!(part.particles.iter().all(|particle| 0.0 < particle.mass));
        let damped = |s: &msd_core::Spring| (s.damping - 0.01 * s.stiffness).abs() < 1e-15;
        assert!(part.springs.iter().all(damped));
        println!("{report}");
        assert!(report.unbalanced < 0.06 && report.loose_particles == 0, "{report}");
        for along in [DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE] {
            let (young, poisson) = pulled(&part, along.normalize());
            println!("{} {along}: E {:.4}, {poisson:.4}", mesh.name, young / YOUNG);
            // Unbalanced forces of springs move particles from a uniform strain, by that part of
            // it: so much is gained or lost at most.
            assert!((young / YOUNG - 1.0).abs() < report.unbalanced, "{along}: {young}");
            assert!((poisson - 0.25).abs() < report.unbalanced, "{along}: {poisson}");
        }
    }
}

#[test]
fn a_material_needs_a_solid_of_springs_alone() {
    let mesh = box_mesh([1.0; 3]);
    let options = |substance| MeshOptions { substance: Some(substance), ..MeshOptions::default() };
    let refused = |options| mesh::body(&mesh, &options).unwrap_err().to_string();
    let elasticity = Elasticity::Solid { young: YOUNG, poisson: 0.4 };
    let message = refused(options(Substance { elasticity, ..substance() }));
    assert!(message.contains("Poisson's ratio of the mesh body is 0.4; it must be 0.25"));
    let message = refused(options(Substance { density: 0.0, ..substance() }));
    assert!(message.contains("density of the mesh body is 0; it must be positive"), "{message}");
    let elasticity = Elasticity::sheet(YOUNG, 0.01);
    let message = refused(options(Substance { elasticity, ..substance() }));
    assert!(message.contains("dimensions of the substance of the mesh body is 2"), "{message}");
}

#[test]
fn a_finer_mesh_of_a_material_has_the_same_mass_and_nearly_the_same_modulus() {
    // The surface is cut up to the lattice: a box of twelve triangles is not coarser than that.
    let mesh = box_mesh([1.0; 3]);
    for spacing in [0.25, 0.125] {
        let options = MeshOptions {
            spacing: Some(spacing),
            substance: Some(substance()),
            ..MeshOptions::default()
        };
        let (part, report) = mesh::body(&mesh, &options).unwrap();
        let mean = part.surface.triangles.len() as f64;
        // Two triangles to a square of the spacing, within the factor of 4 of one cut.
        let even = 2.0 * 6.0 / (spacing * spacing);
        assert!(even / 4.0 <= mean && mean <= 4.0 * even, "{report}");
        let mass: f64 = part.particles.iter().map(|particle| particle.mass).sum();
        assert!((mass / DENSITY - 1.0).abs() < 1e-12);
    }
}
