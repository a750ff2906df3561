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
