//! The solids of a picture as triangles.

use crate::math::is_drawable;
use crate::picture::colour::bytes;
use crate::picture::geometry::{Geometry, SurfaceVertex};
use crate::picture::section::{cut, section};
use crate::viewing::view::View;
use glam::{DVec3, Vec3};
use msd_core::obstacles::Placed;
use msd_core::{DistanceGrid, Real, Shape, Snapshot};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Colour of a solid: stone, unlike any body.
const STONE: [f32; 3] = [0.68, 0.675, 0.66];
/// Steps around an axis, and of a half circle along it.
const AROUND: u32 = 48;
const HALF: u32 = 24;
/// Its roughness; it has neither pattern nor another side.
const DULL: [u8; 4] = [215, 0, 0, 0];

/// Adds every solid, in its place at the time of the snapshot, as far as there is room.
///
/// It is drawn smaller by the radius of a particle: triangles between particles that lie on it
/// would cut through its surface. A solid that hides the bodies is cut open.
pub(crate) fn add_solids<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    (view, limit): (&View, u64),
) {
    let look = (view.camera.eye(), view.camera.forward());
    let hidden = section(geometry, (snapshot.solids, snapshot.time), look);
    for (number, solid) in snapshot.solids.iter().enumerate() {
        let most = limit as usize / size_of::<SurfaceVertex>();
        if most < geometry.vertices.len() + most_vertices(&solid.shape) {
            log::warn!("some solids do not fit into a buffer: left out");
            return;
        }
        let placed = Placed::new(solid, snapshot.time);
        if !is_drawable(placed.middle.as_vec3()) {
            continue;
        }
        let inset = f64::from(geometry.particle_radius);
        let first = geometry.triangles.len();
        add(geometry, &placed, &solid.shape, inset);
        if let Some((hides, section)) = &hidden
            && hides[number]
        {
            cut(geometry, first, section);
        }
    }
}

/// More vertices than a solid has.
fn most_vertices(shape: &Shape) -> usize {
    match shape {
        Shape::Mesh(grid) => 3 * grid.triangles.len(),
        Shape::HalfSpace => 0,
        _ => 8192,
    }
}

/// Adds the surface that is so far inside that of a shape.
fn add(geometry: &mut Geometry, placed: &Placed<'_>, shape: &Shape, inset: f64) {
    let less = |length: f64, by: f64| (length - by).max(0.0);
    let mut revolve = |line: Vec<Point>| revolve(geometry, placed, &line);
    match *shape {
        Shape::Sphere { radius } => {
            revolve(arc([0.0, 0.0], less(radius, inset), [-FRAC_PI_2, FRAC_PI_2]));
        }
        Shape::Capsule { radius, length } => {
            let radius = less(radius, inset);
            let mut line = arc([0.0, -0.5 * length], radius, [-FRAC_PI_2, 0.0]);
            line.extend(arc([0.0, 0.5 * length], radius, [0.0, FRAC_PI_2]));
            revolve(line);
        }
        Shape::Cylinder { radius, length } => {
            let (radius, half) = (less(radius, inset), less(0.5 * length, inset));
            revolve(vec![[0.0, -half, 0.0, -1.0], [radius, -half, 0.0, -1.0]]);
            revolve(vec![[radius, -half, 1.0, 0.0], [radius, half, 1.0, 0.0]]);
            revolve(vec![[radius, half, 0.0, 1.0], [0.0, half, 0.0, 1.0]]);
        }
        Shape::Torus { radius, tube } => revolve(arc([radius, 0.0], less(tube, inset), [-PI, PI])),
        Shape::Box { size } => {
            add_box(geometry, placed, (size * 0.5 - inset).max(DVec3::ZERO));
        }
        Shape::Mesh(ref grid) => add_mesh(geometry, placed, grid, inset),
        // Drawn as planes are.
        Shape::HalfSpace => {}
    }
}

/// The cosine of the greatest angle of a smooth surface: between a face and the mean of those at a
/// corner.
const SMOOTH: f64 = 0.8;

/// Adds the triangles of a mesh, each with corners of its own, so that edges stay sharp.
fn add_mesh(geometry: &mut Geometry, placed: &Placed<'_>, grid: &DistanceGrid, inset: f64) {
    let mut means = vec![DVec3::ZERO; grid.corners.len()];
    let place = |corner: u32| grid.corners[corner as usize];
    let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
    for triangle in &grid.triangles {
        let area = area(triangle.map(place));
        triangle.iter().for_each(|&corner| means[corner as usize] += area);
    }
    means.iter_mut().for_each(|mean| *mean = mean.normalize_or_zero());
    for triangle in &grid.triangles {
        let face = area(triangle.map(place)).normalize_or_zero();
        let first = geometry.vertices.len() as u32;
        for &corner in triangle {
            let mean = means[corner as usize];
            let normal = if SMOOTH < mean.dot(face) { mean } else { face };
            push(geometry, placed, place(corner) - mean * inset, normal);
        }
        geometry.triangles.push([first, first + 1, first + 2]);
    }
}

/// A point of a line that is turned about y: distance from the axis and height, and the normal in
/// the same way.
type Point = [f64; 4];

fn arc(middle: [f64; 2], radius: f64, [from, to]: [f64; 2]) -> Vec<Point> {
    let point = |part: u32| {
        let (sine, cosine) = (from + (to - from) * f64::from(part) / f64::from(HALF)).sin_cos();
        [middle[0] + radius * cosine, middle[1] + radius * sine, cosine, sine]
    };
    (0..=HALF).map(point).collect()
}

/// Adds the surface that a line turned about the axis of a solid leaves.
fn revolve(geometry: &mut Geometry, placed: &Placed<'_>, line: &[Point]) {
    let first = geometry.vertices.len() as u32;
    let along = line.len() as u32;
    for turn in 0..=AROUND {
        let (sine, cosine) = (TAU * f64::from(turn % AROUND) / f64::from(AROUND)).sin_cos();
        for &[away, height, out, up] in line {
            let place = DVec3::new(away * cosine, height, away * sine);
            push(geometry, placed, place, DVec3::new(out * cosine, up, out * sine));
        }
    }
    for turn in 0..AROUND {
        for step in 0..along - 1 {
            let [a, b] = [turn, turn + 1].map(|turn| first + turn * along + step);
            geometry.triangles.push([a, a + 1, b]);
            geometry.triangles.push([b, a + 1, b + 1]);
        }
    }
}

fn add_box(geometry: &mut Geometry, placed: &Placed<'_>, half: DVec3) {
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = geometry.vertices.len() as u32;
            let [normal, u, v] = [0, 1, 2].map(|turn| DVec3::AXES[(axis + turn) % 3]);
            for [s, t] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
                push(
                    geometry,
                    placed,
                    half * (normal * side + u * (s * side) + v * t),
                    normal * side,
                );
            }
            geometry.triangles.push([first, first + 1, first + 2]);
            geometry.triangles.push([first + 2, first + 1, first + 3]);
        }
    }
}

fn push(geometry: &mut Geometry, placed: &Placed<'_>, place: DVec3, normal: DVec3) {
    geometry.vertices.push(SurfaceVertex {
        position: (placed.middle + placed.axes * place).as_vec3(),
        normal: (placed.axes * normal).as_vec3().normalize_or(Vec3::Y),
        uv: [0.0; 2],
        colour: bytes(STONE, 0.5),
        back: [0; 4],
        finish: DULL,
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::Solid;
    use std::sync::Arc;

    /// A tetrahedron in a grid of two points each way, between which all distances are zero.
    fn tetrahedron() -> DistanceGrid {
        let (low, cell, counts, distances) = (DVec3::ZERO, 1.0, [2; 3], vec![0.0; 8]);
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        DistanceGrid { low, cell, counts, distances, reach: 1.0, error: 0.0, corners, triangles }
    }

    /// The triangles of a solid lie on its surface and face out of it.
    #[test]
    fn triangles_lie_on_the_surface_and_face_out() {
        for shape in [
            Shape::Sphere { radius: 0.7 },
            Shape::Capsule { radius: 0.4, length: 1.1 },
            Shape::Box { size: DVec3::new(0.8, 1.2, 0.5) },
            Shape::Cylinder { radius: 0.6, length: 0.9 },
            Shape::Torus { radius: 0.8, tube: 0.25 },
            Shape::Mesh(Arc::new(tetrahedron())),
        ] {
            let mut geometry = Geometry::default();
            let solid = Solid::new(shape.clone());
            add(&mut geometry, &Placed::new(&solid, 0.0), &shape, 0.0);
            assert!(geometry.vertices.len() <= most_vertices(&shape));
            for vertex in &geometry.vertices {
                assert!(shape.gap(vertex.position.as_dvec3()).abs() < 1e-6, "{shape:?}");
            }
            for corners in &geometry.triangles {
                let [a, b, c] = corners.map(|corner| geometry.vertices[corner as usize]);
                let area = (b.position - a.position).cross(c.position - a.position);
                // At the poles of a surface of revolution, triangles have no area.
                let faces_out = 0.0 <= area.dot(a.normal + b.normal + c.normal);
                assert!(faces_out, "{shape:?}: {corners:?}");
            }
        }
    }
}
