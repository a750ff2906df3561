//! How is an OBJ file read? Row by row for the errors, then by `tobj`.

use super::error::{MeshError, Row, malformed, malformed_row};
use super::raw::{Raw, check_coordinate, check_count, out_of_domain};
use glam::DVec3;

/// Reads the vertices, texture coordinates and faces of an OBJ file.
///
/// `tobj` names no line in its errors, takes faces and lines of two corners in silence, makes
/// triangles of polylines, and overflows on huge indices. So the rows are checked here, and only
/// the checked ones are handed over.
pub(crate) fn parse(bytes: &[u8], file: &str) -> Result<Raw, MeshError> {
    let text = String::from_utf8_lossy(bytes);
    let rows = Rows::check(&text, file)?;
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let mut checked = rows.checked.as_bytes();
    let (models, _) = tobj::load_obj_buf(&mut checked, &options, no_materials)
        .map_err(|error| malformed(file, error.to_string()))?;
    let mut raw = Raw { vertices_read: rows.vertices, ..Raw::default() };
    for mesh in models.into_iter().map(|model| model.mesh) {
        let first = raw.positions.len() as u32;
        let positions = mesh.positions.chunks_exact(3);
        raw.positions.extend(positions.map(DVec3::from_slice));
        let corners = mesh.indices.chunks_exact(3);
        raw.triangles.extend(corners.map(|c| [c[0] + first, c[1] + first, c[2] + first]));
        let uv = |corner: &u32| {
            let start = 2 * *corner as usize;
            [mesh.texcoords[start] as f32, mesh.texcoords[start + 1] as f32]
        };
        let corners = mesh.texcoord_indices.chunks_exact(3);
        raw.uvs.extend(corners.map(|c| [uv(&c[0]), uv(&c[1]), uv(&c[2])]));
    }
    Ok(raw)
}

/// What a scan of the rows has found.
#[derive(Default)]
struct Rows {
    vertices: usize,
    texture_vertices: usize,
    /// Whether every face so far gives texture coordinates.
    textured: bool,
    faces: Vec<Vec<[usize; 2]>>,
    /// Rows of texture coordinates.
    texture_rows: String,
    /// The file again: vertices and faces only, every index from 1 and in range.
    checked: String,
}

impl Rows {
    fn check(text: &str, file: &str) -> Result<Self, MeshError> {
        let mut rows = Self { textured: true, ..Self::default() };
        let mut joined = String::new();
        for (line, row) in text.lines().zip(1..) {
            let at = (file, Row { item: "line", row });
            // A backslash at the end continues the row on the next line.
            if let Some(start) = line.trim_end().strip_suffix('\\') {
                joined.push_str(start);
                joined.push(' ');
                continue;
            }
            joined.push_str(line);
            let content = joined.split('#').next().unwrap_or_default();
            let mut words = content.split_whitespace();
            match words.next() {
                Some("v") => rows.add_vertex(at, words)?,
                Some("vt") => rows.add_texture_vertex(at, words)?,
                Some("f") => rows.add_face(at, words)?,
                // Groups, materials, normals, lines and points hold no body together.
                _ => {}
            }
            joined.clear();
            // A row of eight bytes takes many times that in memory.
            check_count(file, "the number of vertices", rows.vertices as u128)?;
            check_count(file, "the number of texture vertices", rows.texture_vertices as u128)?;
            check_count(file, "the number of faces", rows.faces.len() as u128)?;
        }
        rows.write_faces();
        Ok(rows)
    }

    fn add_vertex<'a>(
        &mut self,
        at: (&str, Row),
        words: impl Iterator<Item = &'a str>,
    ) -> Result<(), MeshError> {
        let words: Vec<&str> = words.collect();
        if words.len() < 3 {
            let count = words.len().to_string();
            return Err(out_of_domain(at, "the number of coordinates", count, "at least 3"));
        }
        let values = [number(at, words[0])?, number(at, words[1])?, number(at, words[2])?];
        // A fourth number alone is a weight; three more are a colour.
        let weight = if words.len() == 4 { number(at, words[3])? } else { 1.0 };
        for (quantity, value) in ["x", "y", "z"].into_iter().zip(values) {
            check_coordinate(at, quantity, value / weight)?;
        }
        let weight = if words.len() == 4 { words[3] } else { "" };
        let row = format!("v {} {} {} {weight}\n", words[0], words[1], words[2]);
        self.checked.push_str(&row);
        self.vertices += 1;
        Ok(())
    }

    fn add_texture_vertex<'a>(
        &mut self,
        at: (&str, Row),
        mut words: impl Iterator<Item = &'a str>,
    ) -> Result<(), MeshError> {
        // The second coordinate may be left out.
        let u = words.next().unwrap_or_default();
        let v = words.next().unwrap_or("0");
        number(at, u)?;
        number(at, v)?;
        self.texture_rows.push_str(&format!("vt {u} {v}\n"));
        self.texture_vertices += 1;
        Ok(())
    }

    fn add_face<'a>(
        &mut self,
        at: (&str, Row),
        words: impl Iterator<Item = &'a str>,
    ) -> Result<(), MeshError> {
        let mut corners = Vec::new();
        for word in words {
            let mut parts = word.split('/');
            let vertex = parts.next().unwrap_or_default();
            let vertex = index(at, "a vertex index", vertex, self.vertices)?;
            let texture = match parts.next() {
                None | Some("") => {
                    self.textured = false;
                    0
                }
                Some(text) => index(at, "a texture index", text, self.texture_vertices)?,
            };
            corners.push([vertex, texture]);
        }
        if corners.len() < 3 {
            let count = corners.len().to_string();
            return Err(out_of_domain(at, "the number of corners", count, "at least 3"));
        }
        self.faces.push(corners);
        Ok(())
    }

    /// Writes all faces with texture coordinates or none: `tobj` makes up what is missing.
    fn write_faces(&mut self) {
        if self.textured {
            self.checked.push_str(&self.texture_rows);
        }
        for corners in &self.faces {
            self.checked.push('f');
            for [vertex, texture] in corners {
                self.checked.push_str(&format!(" {vertex}"));
                if self.textured {
                    self.checked.push_str(&format!("/{texture}"));
                }
            }
            self.checked.push('\n');
        }
    }
}

fn number(at: (&str, Row), word: &str) -> Result<f64, MeshError> {
    word.parse().map_err(|_| malformed_row(at.0, at.1, format!("'{word}' is not a number")))
}

/// An index from 1; a negative one counts back from the last row so far.
fn index(
    at: (&str, Row),
    quantity: &'static str,
    word: &str,
    count: usize,
) -> Result<usize, MeshError> {
    let expected = || format!("from 1 to {count}, or from -{count} to -1");
    let value: i64 =
        word.parse().map_err(|_| out_of_domain(at, quantity, format!("'{word}'"), expected()))?;
    let back = usize::try_from(value.unsigned_abs()).unwrap_or(usize::MAX);
    if back == 0 || count < back {
        return Err(out_of_domain(at, quantity, word.into(), expected()));
    }
    Ok(if value < 0 { count + 1 - back } else { back })
}
