//! Where on a texture do the triangles of a body lie?

use super::raw::CornerUvs;
use glam::{DVec2, DVec3};
use msd_core::{Corner, Surface};
use std::collections::BTreeMap;

/// The surface of a body whose particles are the vertices of a mesh.
///
/// Without texture coordinates each triangle is projected along the axis that it faces most, onto
/// the longest side of the bounding box: no pattern is stretched by more than √3.
pub(crate) fn surface(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    uvs: Option<&[CornerUvs]>,
    two_sided: bool,
) -> Surface {
    let low = positions.iter().copied().fold(DVec3::MAX, DVec3::min);
    let high = positions.iter().copied().fold(DVec3::MIN, DVec3::max);
    let side = (high - low).max_element();
    let mut surface = Surface { two_sided, ..Surface::default() };
    let mut numbers = BTreeMap::new();
    for (face, &corners) in triangles.iter().enumerate() {
        let uvs = match uvs {
            Some(uvs) => uvs[face],
            None => {
                let places = corners.map(|corner| positions[corner as usize]);
                project(places.map(|place| (place - low) / side))
            }
        };
        let mut triangle = [0; 3];
        for (slot, (particle, uv)) in triangle.iter_mut().zip(corners.into_iter().zip(uvs)) {
            let key = (particle, uv.map(f32::to_bits));
            *slot = *numbers.entry(key).or_insert_with(|| {
                surface.corners.push(Corner { particle, uv });
                surface.corners.len() as u32 - 1
            });
        }
        surface.triangles.push(triangle);
    }
    surface
}

fn project(corners: [DVec3; 3]) -> CornerUvs {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).abs();
    let flat = |corner: DVec3| match normal {
        n if n.y <= n.z && n.x <= n.z => DVec2::new(corner.x, corner.y),
        n if n.y <= n.x => DVec2::new(corner.z, corner.y),
        _ => DVec2::new(corner.x, corner.z),
    };
    corners.map(|corner| flat(corner).as_vec2().to_array())
}
