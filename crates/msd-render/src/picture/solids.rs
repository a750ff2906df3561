//! The solids of a picture as triangles.

use crate::math::is_drawable;
use crate::picture::colour::bytes;
use crate::picture::geometry::{Geometry, SurfaceVertex};
use glam::{DVec3, Vec3};
use msd_core::obstacles::Placed;
use msd_core::{Real, Shape, Snapshot};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Colour of a solid: stone, unlike any body.
const STONE: [f32; 3] = [0.46, 0.47, 0.49];
/// Steps around an axis, and of a half circle along it.
const AROUND: u32 = 48;
const HALF: u32 = 24;
/// A place on the chequerboard of bodies, away from its lines: solids are of one colour.
const PLAIN: [f32; 2] = [0.03125, 0.03125];

/// Adds every solid, where it is at the time of the snapshot, as far as there is room.
///
/// It is drawn smaller by the radius of a particle: triangles between particles that lie on it
/// would cut through its surface.
pub(crate) fn add_solids<R: Real>(geometry: &mut Geometry, snapshot: &Snapshot<'_, R>, limit: u64) {
    for solid in snapshot.solids {
        let most = limit as usize / size_of::<SurfaceVertex>();
        if most < geometry.vertices.len() + MOST_VERTICES {
            log::warn!("some solids do not fit into a buffer: left out");
            return;
        }
        let placed = Placed::new(solid, snapshot.time);
        if !is_drawable(placed.middle.as_vec3()) {
            continue;
        }
        let inset = f64::from(geometry.particle_radius);
        add(geometry, &placed, shrunk(solid.shape, inset));
    }
}

/// A shape whose surface is so far inside that of another.
fn shrunk(shape: Shape, inset: f64) -> Shape {
    let less = |length: f64, by: f64| (length - by).max(0.0);
    match shape {
        Shape::Sphere { radius } => Shape::Sphere { radius: less(radius, inset) },
        Shape::Capsule { radius, length } => Shape::Capsule { radius: less(radius, inset), length },
        Shape::Box { size } => Shape::Box { size: (size - 2.0 * inset).max(DVec3::ZERO) },
        Shape::Cylinder { radius, length } => {
            Shape::Cylinder { radius: less(radius, inset), length: less(length, 2.0 * inset) }
        }
        Shape::Torus { radius, tube } => Shape::Torus { radius, tube: less(tube, inset) },
    }
}

fn add(geometry: &mut Geometry, placed: &Placed, shape: Shape) {
    match shape {
        Shape::Box { size } => add_box(geometry, placed, size * 0.5),
        _ => profiles(shape).iter().for_each(|line| revolve(geometry, placed, line)),
    }
}

/// More vertices than a solid has.
const MOST_VERTICES: usize = 8192;

/// A point of a line that is turned about y: distance from the axis and height, and the normal in
/// the same way.
type Point = [f64; 4];

/// The lines whose turns about y make a shape: one for each smooth piece.
fn profiles(shape: Shape) -> Vec<Vec<Point>> {
    match shape {
        Shape::Sphere { radius } => vec![arc([0.0, 0.0], radius, [-FRAC_PI_2, FRAC_PI_2])],
        Shape::Capsule { radius, length } => {
            let mut line = arc([0.0, -0.5 * length], radius, [-FRAC_PI_2, 0.0]);
            line.extend(arc([0.0, 0.5 * length], radius, [0.0, FRAC_PI_2]));
            vec![line]
        }
        Shape::Cylinder { radius, length } => {
            let half = 0.5 * length;
            vec![
                vec![[0.0, -half, 0.0, -1.0], [radius, -half, 0.0, -1.0]],
                vec![[radius, -half, 1.0, 0.0], [radius, half, 1.0, 0.0]],
                vec![[radius, half, 0.0, 1.0], [0.0, half, 0.0, 1.0]],
            ]
        }
        Shape::Torus { radius, tube } => vec![arc([radius, 0.0], tube, [-PI, PI])],
        Shape::Box { .. } => Vec::new(),
    }
}

fn arc(middle: [f64; 2], radius: f64, [from, to]: [f64; 2]) -> Vec<Point> {
    let point = |part: u32| {
        let (sine, cosine) = (from + (to - from) * f64::from(part) / f64::from(HALF)).sin_cos();
        [middle[0] + radius * cosine, middle[1] + radius * sine, cosine, sine]
    };
    (0..=HALF).map(point).collect()
}

/// Adds the surface that a line turned about the axis of a solid leaves.
fn revolve(geometry: &mut Geometry, placed: &Placed, line: &[Point]) {
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

fn add_box(geometry: &mut Geometry, placed: &Placed, half: DVec3) {
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

fn push(geometry: &mut Geometry, placed: &Placed, place: DVec3, normal: DVec3) {
    geometry.vertices.push(SurfaceVertex {
        position: (placed.middle + placed.axes * place).as_vec3(),
        normal: (placed.axes * normal).as_vec3().normalize_or(Vec3::Y),
        uv: PLAIN,
        colour: bytes(STONE, 1.0),
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::Solid;

    /// The triangles of a solid lie on its surface and face out of it.
    #[test]
    fn triangles_lie_on_the_surface_and_face_out() {
        for shape in [
            Shape::Sphere { radius: 0.7 },
            Shape::Capsule { radius: 0.4, length: 1.1 },
            Shape::Box { size: DVec3::new(0.8, 1.2, 0.5) },
            Shape::Cylinder { radius: 0.6, length: 0.9 },
            Shape::Torus { radius: 0.8, tube: 0.25 },
        ] {
            let mut geometry = Geometry::default();
            add(&mut geometry, &Placed::new(&Solid::new(shape), 0.0), shape);
            assert!(geometry.vertices.len() < MOST_VERTICES);
            for vertex in &geometry.vertices {
                assert!(shape.gap(vertex.position.as_dvec3()).abs() < 1e-6, "{shape:?}");
            }
            for corners in &geometry.triangles {
                let [a, b, c] = corners.map(|corner| geometry.vertices[corner as usize]);
                let area = (b.position - a.position).cross(c.position - a.position);
                // At the poles of what is turned, triangles have no area.
                let faces_out = 0.0 <= area.dot(a.normal + b.normal + c.normal);
                assert!(faces_out, "{shape:?}: {corners:?}");
            }
        }
    }
}
