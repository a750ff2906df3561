//! Texture coordinates of the triangles of a body.

use crate::mesh::raw::CornerUvs;
use glam::{DVec2, DVec3};
use msd_core::{Corner, Surface};
use std::collections::BTreeMap;

/// The surface of a body whose particles are the vertices of a mesh.
///
/// Without texture coordinates everything is projected along the shortest side of the bounding box:
/// a pattern is stretched where the surface turns away, but nowhere torn.
pub(crate) fn surface(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    uvs: Option<&[CornerUvs]>,
    two_sided: bool,
) -> Surface {
    let low = positions.iter().copied().fold(DVec3::MAX, DVec3::min);
    let high = positions.iter().copied().fold(DVec3::MIN, DVec3::max);
    let (side, flatten) = ((high - low).max_element(), flatten(high - low));
    let mut surface = Surface { two_sided, ..Surface::default() };
    let mut numbers = BTreeMap::new();
    for (face, &corners) in triangles.iter().enumerate() {
        let uvs = match uvs {
            Some(uvs) => uvs[face],
            None => {
                let place = |corner: u32| (positions[corner as usize] - low) / side;
                corners.map(|corner| flatten(place(corner)).as_vec2().to_array())
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

/// The projection along the shortest side of a box.
fn flatten(size: DVec3) -> fn(DVec3) -> DVec2 {
    match size {
        n if n.z <= n.x && n.z <= n.y => |place| DVec2::new(place.x, place.y),
        n if n.x <= n.y => |place| DVec2::new(place.z, place.y),
        _ => |place| DVec2::new(place.x, place.z),
    }
}
