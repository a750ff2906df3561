//! The inside of a mesh, closed or with holes.

use crate::mesh::clean::inside::Inside;
use crate::mesh::clean::winding::Winding;
use glam::DVec3;

/// The test whether a point is inside.
pub(crate) enum Interior<'a> {
    /// Rays, which are exact where a mesh is closed.
    Closed(Inside<'a>),
    /// Winding numbers.
    Holed(Winding),
}

impl<'a> Interior<'a> {
    /// Sorts the triangles by how they are asked.
    pub(crate) fn new(positions: &'a [DVec3], triangles: &'a [[u32; 3]], is_closed: bool) -> Self {
        match is_closed {
            true => Interior::Closed(Inside::new(positions, triangles)),
            false => Interior::Holed(Winding::new(positions, triangles)),
        }
    }

    /// Whether a point is inside.
    pub(crate) fn contains(&self, point: DVec3) -> bool {
        match self {
            Interior::Closed(inside) => inside.contains(point),
            Interior::Holed(winding) => winding.contains(point),
        }
    }
}
