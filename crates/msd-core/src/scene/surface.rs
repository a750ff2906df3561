//! Surfaces of bodies: the triangles that are drawn.

use alloc::vec::Vec;

/// One corner of a surface: a particle and where the texture puts it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Corner {
    /// The particle at the corner.
    pub particle: u32,
    /// Texture coordinates, each from 0 to 1.
    pub uv: [f32; 2],
}

/// The triangles of a body, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Surface {
    /// The corners; a particle may have several, with different texture coordinates.
    pub corners: Vec<Corner>,
    /// Three indices into `corners` per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Whether both sides are seen: true for a sheet, false for a solid.
    pub two_sided: bool,
}

impl Surface {
    /// The particles of a triangle, given by its corners; `None` if there is no such corner.
    pub fn particles_of(&self, triangle: [u32; 3]) -> Option<[u32; 3]> {
        let [a, b, c] = triangle.map(|corner| self.corners.get(corner as usize));
        Some([a?.particle, b?.particle, c?.particle])
    }

    /// The particles of each triangle, in order; of those whose corners there are.
    pub fn particles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.triangles.iter().filter_map(|&triangle| self.particles_of(triangle))
    }

    /// The edges that belong to one triangle only, between particles that meet a condition: the
    /// lower one first, in order.
    pub fn rim(&self, meets: impl Fn(u32) -> bool) -> Vec<[u32; 2]> {
        let sides = self.particles().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
        let found = sides.filter(|side| side.iter().all(|&end| meets(end)));
        let mut edges: Vec<_> = found.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.sort_unstable();
        let once = edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1);
        once.map(|same| same[0]).collect()
    }
}
