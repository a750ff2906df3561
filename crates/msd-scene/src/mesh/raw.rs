//! Raw triangles: the content of a file before it is cleaned.

use crate::mesh::error::{MeshError, Row, one_line};
use crate::mesh::polygon::{MOST_CORNERS, cut};
use glam::DVec3;
use msd_core::MAX_PARTICLES;
use std::ops::Range;

/// The longest file that is read, bytes.
pub(crate) const LONGEST: u64 = 1 << 30;

/// A bound, not `is_finite`: the square of a length overflows long before a coordinate does.
pub(crate) const EXTENT: f64 = 1e9;

/// Texture coordinates of the three corners of a triangle.
pub(crate) type CornerUvs = [[f32; 2]; 3];

/// Triangles that a file names together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The name of an object, a group, a node or a material.
    pub name: String,
    /// Its triangles; there may be several such runs of one name.
    pub triangles: Range<usize>,
}

/// Triangles as read; every corner is an index into `positions`.
#[derive(Debug, Default)]
pub(crate) struct Raw {
    /// Positions in file units.
    pub(crate) positions: Vec<DVec3>,
    /// Corners.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Texture coordinates; used only if there are as many as triangles.
    pub(crate) uvs: Vec<CornerUvs>,
    /// The first triangle of each object or group that the file names.
    pub(crate) starts: Vec<usize>,
    /// The names in the file, each with its triangles.
    pub(crate) groups: Vec<Group>,
    /// Vertices in the file, used or not.
    pub(crate) vertices_read: usize,
    /// Polygons that cross themselves.
    pub(crate) crossed: usize,
    /// Bytes that may hold facets which the header of the file does not announce.
    pub(crate) left_over: usize,
}

impl Raw {
    /// Gives the triangles from `first` on a name.
    pub(crate) fn name(&mut self, name: &str, first: usize) {
        let triangles = first..self.triangles.len();
        if !triangles.is_empty() {
            self.groups.push(Group { name: name.into(), triangles });
        }
    }

    /// Cuts a polygon into triangles and appends them.
    ///
    /// # Errors
    /// Fewer than three corners, or a corner that names no vertex; too many of one that is concave.
    pub(crate) fn add_polygon(
        &mut self,
        (file, row): (&str, Row),
        corners: &[i64],
        uvs: Option<&[[f32; 2]]>,
    ) -> Result<(), MeshError> {
        if corners.len() < 3 {
            return Err(out_of_domain(
                (file, row),
                "the number of corners",
                corners.len().to_string(),
                "at least 3",
            ));
        }
        let count = self.positions.len();
        let mut indices = Vec::with_capacity(corners.len());
        for &corner in corners {
            let index = u32::try_from(corner).ok().filter(|&index| (index as usize) < count);
            indices.push(index.ok_or_else(|| {
                let expected = format!("from 0 to less than {count}");
                out_of_domain((file, row), "a vertex index", corner.to_string(), expected)
            })?);
        }
        let points: Vec<DVec3> = indices.iter().map(|&i| self.positions[i as usize]).collect();
        let Some(cut) = cut(&points) else {
            let expected = format!("at most {MOST_CORNERS} where the face is concave: cut it up");
            let (quantity, value) = ("the number of corners", corners.len().to_string());
            return Err(out_of_domain((file, row), quantity, value, expected));
        };
        self.crossed += usize::from(cut.crossed);
        self.triangles.extend(cut.triangles.iter().map(|t| t.map(|corner| indices[corner])));
        if let Some(uvs) = uvs {
            self.uvs.extend(cut.triangles.iter().map(|t| t.map(|corner| uvs[corner])));
        }
        Ok(())
    }

    /// Checks that every coordinate is a usable number and that the mesh is not too large.
    ///
    /// # Errors
    /// The first vertex with a coordinate that is not finite or beyond [`EXTENT`].
    pub(crate) fn check(&self, file: &str) -> Result<(), MeshError> {
        check_count(file, "the number of vertices", self.positions.len() as u128)?;
        check_count(file, "the number of triangles", self.triangles.len() as u128)?;
        for (row, position) in self.positions.iter().enumerate() {
            for (quantity, value) in ["x", "y", "z"].into_iter().zip(position.to_array()) {
                check_coordinate((file, Row { item: "vertex", row }), quantity, value)?;
            }
        }
        Ok(())
    }
}

/// A text without the byte order mark that some editors put first.
pub(crate) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes)
}

/// Checks one coordinate.
pub(crate) fn check_coordinate(
    at: (&str, Row),
    quantity: &'static str,
    value: f64,
) -> Result<(), MeshError> {
    // Written so that a NaN fails.
    if value.abs() <= EXTENT {
        return Ok(());
    }
    Err(out_of_domain(at, quantity, value.to_string(), format!("finite and within ±{EXTENT:e}")))
}

/// Checks that a count fits into a scene.
pub(crate) fn check_count(file: &str, what: &'static str, count: u128) -> Result<(), MeshError> {
    // A closed mesh has about twice as many triangles as vertices; one limit serves both.
    let limit = 2 * MAX_PARTICLES as u128;
    if count <= limit {
        return Ok(());
    }
    Err(MeshError::TooLarge { file: file.into(), what, count, limit })
}

/// A value outside its domain, with its place.
pub(crate) fn out_of_domain(
    (file, row): (&str, Row),
    quantity: &'static str,
    value: String,
    expected: impl Into<String>,
) -> MeshError {
    let (value, expected) = (one_line(&value), expected.into());
    MeshError::OutOfDomain { file: file.into(), row, quantity, value, expected }
}
