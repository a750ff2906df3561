//! Solids that hide all bodies are cut: their nearer parts are left out.

use crate::picture::geometry::{Geometry, SurfaceVertex};
use glam::Vec3;
use msd_core::obstacles::Placed;
use msd_core::{Shape, Solid};

/// Number of particles whose visibility is checked.
const SAMPLES: usize = 64;
/// The part of them that is hidden where all bodies are: a corner that shows is not a view of them.
const HIDDEN: f32 = 0.9;
/// The most steps along a ray to a particle.
const STEPS: usize = 64;
/// Largest distance that counts as a hit, as a part of the way.
const HIT: f64 = 1e-4;

/// A plane across the view: everything before it is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Section {
    /// The direction of view, length one.
    pub forward: Vec3,
    /// Position of the plane along it, metres from the origin.
    pub depth: f32,
}

/// The solids to cut, and where: those that hide particles if nearly all are hidden.
pub(crate) fn section(
    geometry: &Geometry,
    (solids, time): (&[Solid], f64),
    (eye, forward): (Vec3, Vec3),
) -> Option<(Vec<bool>, Section)> {
    let mut hides = vec![false; solids.len()];
    let (mut count, mut hidden, mut depth) = (0.0, 0.0, 0.0);
    let stride = geometry.positions.len().div_ceil(SAMPLES).max(1);
    let placed: Vec<Placed<'_>> = solids.iter().map(|solid| Placed::new(solid, time)).collect();
    for particle in (0..geometry.positions.len()).step_by(stride) {
        let Some(point) = geometry.drawable(particle as u32) else { continue };
        // A particle on a solid is not hidden by its own contact.
        let margin = 2.0 * geometry.particle_radius;
        let mut is_hidden = false;
        for ((solid, placed), hides) in solids.iter().zip(&placed).zip(&mut hides) {
            let is_before = is_between(&solid.shape, placed, [eye, point], margin);
            *hides |= is_before;
            is_hidden |= is_before;
        }
        count += 1.0;
        hidden += f32::from(is_hidden);
        depth += forward.dot(point);
    }
    let section = Section { forward, depth: depth / count };
    (0.0 < hidden && HIDDEN * count <= hidden).then_some((hides, section))
}

/// Returns whether a solid is met on the way from the eye to a point, up to a margin before it.
fn is_between(shape: &Shape, placed: &Placed<'_>, [eye, point]: [Vec3; 2], margin: f32) -> bool {
    if *shape == Shape::HalfSpace {
        return false;
    }
    let way = (point - eye).as_dvec3();
    let length = way.length();
    let (mut gone, end) = (0.0, length - f64::from(margin));
    for _ in 0..STEPS {
        // False for a NaN too.
        let is_on_the_way = gone < end;
        if !is_on_the_way {
            return false;
        }
        let at = eye.as_dvec3() + way * (gone / length);
        let gap = shape.gap(placed.axes.transpose() * (at - placed.middle));
        if gap <= HIT * length {
            return true;
        }
        gone += gap;
    }
    false
}

/// Cuts the triangles from one on at a section.
pub(crate) fn cut(geometry: &mut Geometry, first: usize, section: &Section) {
    let triangles = geometry.triangles.split_off(first);
    for corners in triangles {
        let behind = |corner: u32| {
            let vertex = geometry.vertices[corner as usize];
            section.forward.dot(vertex.position) - section.depth
        };
        let depths = corners.map(behind);
        let mut kept: Vec<u32> = Vec::with_capacity(4);
        for side in 0..3 {
            let (here, next) = (side, (side + 1) % 3);
            if 0.0 <= depths[here] {
                kept.push(corners[here]);
            }
            if (0.0 <= depths[here]) != (0.0 <= depths[next]) {
                let part = depths[here] / (depths[here] - depths[next]);
                let [a, b] = [here, next].map(|end| geometry.vertices[corners[end] as usize]);
                kept.push(geometry.vertices.len() as u32);
                geometry.vertices.push(SurfaceVertex {
                    position: a.position.lerp(b.position, part),
                    normal: a.normal.lerp(b.normal, part).normalize_or(a.normal),
                    ..a
                });
            }
        }
        for corner in 2..kept.len() {
            geometry.triangles.push([kept[0], kept[corner - 1], kept[corner]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use glam::DVec3;

    fn corner(x: f32, z: f32) -> SurfaceVertex {
        SurfaceVertex { position: Vec3::new(x, 0.0, z), normal: Vec3::Y, ..SurfaceVertex::zeroed() }
    }

    #[test]
    fn what_is_left_of_a_square_has_the_area_behind_the_section() {
        let mut geometry = Geometry::default();
        geometry
            .vertices
            .extend([(0., 0.), (2., 0.), (2., 2.), (0., 2.)].map(|(x, z)| corner(x, z)));
        geometry.triangles.extend([[0, 1, 2], [0, 2, 3]]);
        let section = Section { forward: Vec3::X, depth: 0.5 };
        cut(&mut geometry, 0, &section);
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| geometry.vertices[corner as usize].position);
            0.5 * (b - a).cross(c - a).length()
        };
        let left: f32 = geometry.triangles.iter().map(area).sum();
        // Exact: all coordinates are halves.
        assert_eq!(left, 3.0);
        let all = geometry.triangles.as_flattened().iter();
        assert!(all.into_iter().all(|&c| 0.5 <= geometry.vertices[c as usize].position.x));
    }

    #[test]
    fn a_ball_behind_a_wall_is_hidden_and_one_beside_it_is_not() {
        let mut geometry = Geometry::default();
        geometry.positions.extend((0..100).map(|at| Vec3::new(0.0, 0.01 * at as f32, 0.0)));
        let size = DVec3::new(3.0, 3.0, 0.1);
        let mut wall = Solid::new(Shape::Box { size });
        wall.position = DVec3::Z;
        let look = (Vec3::new(0.0, 0.5, 5.0), Vec3::NEG_Z);
        let other = Solid::new(Shape::Sphere { radius: 0.1 });
        let solids = [Solid { position: DVec3::X * 5.0, ..other }, wall];
        let (hides, section) = section(&geometry, (&solids, 0.0), look).expect("hidden");
        assert_eq!((hides, section.depth), (vec![false, true], 0.0));
        let beside = [Solid { position: DVec3::new(4.0, 0.0, 1.0), ..solids[1].clone() }];
        assert_eq!(super::section(&geometry, (&beside, 0.0), look), None);
        // Behind them a wall hides nothing.
        let behind = [Solid { position: DVec3::NEG_Z, ..solids[1].clone() }];
        assert_eq!(super::section(&geometry, (&behind, 0.0), look), None);
    }
}
