//! OBJ files, read row by row.

use crate::mesh::error::{MeshError, Row, malformed_row};
use crate::mesh::raw::{Raw, check_coordinate, check_count, out_of_domain};
use glam::DVec3;

/// Reads the vertices, texture coordinates and faces of an OBJ file.
///
/// By hand, as a reader from elsewhere (`tobj`) names no line in its errors, takes faces and lines
/// of two corners in silence, makes triangles of polylines, and overflows on huge indices.
pub(crate) fn parse(bytes: &[u8], file: &str) -> Result<Raw, MeshError> {
    let mut text = String::from_utf8_lossy(bytes);
    if !text.contains('\n') {
        // Lines that end as they did on the first Macintosh.
        text = text.replace('\r', "\n").into();
    }
    let mut rows = Rows::default();
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
            Some(kind @ ("o" | "g" | "usemtl")) => rows.name(kind, words),
            // Normals, lines and points hold no body together.
            _ => {}
        }
        joined.clear();
        // A row of eight bytes takes many times that in memory.
        check_count(file, "the number of vertices", rows.vertices.len() as u128)?;
        check_count(file, "the number of texture vertices", rows.texture_vertices.len() as u128)?;
        check_count(file, "the number of faces", rows.faces as u128)?;
    }
    Ok(rows.finish())
}

/// The results of the rows so far.
#[derive(Default)]
struct Rows {
    vertices: Vec<DVec3>,
    /// The number of each vertex among those that faces use, in order of their first use.
    numbers: Vec<Option<u32>>,
    texture_vertices: Vec<[f32; 2]>,
    faces: usize,
    /// Whether a face gives no texture coordinates.
    bare: bool,
    names: Names,
    raw: Raw,
}

/// The names of the faces that follow.
#[derive(Default)]
struct Names {
    object: Option<String>,
    groups: Vec<String>,
    material: Option<String>,
    /// The first triangle that has them.
    first: usize,
}

impl Rows {
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
        let values = values.map(|value| value / weight);
        for (quantity, value) in ["x", "y", "z"].into_iter().zip(values) {
            check_coordinate(at, quantity, value)?;
        }
        self.vertices.push(DVec3::from_array(values));
        self.numbers.push(None);
        Ok(())
    }

    fn add_texture_vertex<'a>(
        &mut self,
        at: (&str, Row),
        mut words: impl Iterator<Item = &'a str>,
    ) -> Result<(), MeshError> {
        // The second coordinate may be left out.
        let u = number(at, words.next().unwrap_or_default())?;
        let v = number(at, words.next().unwrap_or("0"))?;
        self.texture_vertices.push([u as f32, v as f32]);
        Ok(())
    }

    fn add_face<'a>(
        &mut self,
        at: (&str, Row),
        words: impl Iterator<Item = &'a str>,
    ) -> Result<(), MeshError> {
        let (mut corners, mut uvs) = (Vec::new(), Vec::new());
        for word in words {
            let mut parts = word.split('/');
            let vertex = parts.next().unwrap_or_default();
            let vertex = index(at, "a vertex index", vertex, self.vertices.len())?;
            corners.push(self.number(vertex - 1).into());
            let count = self.texture_vertices.len();
            match parts.next() {
                // Exporters leave out an empty map, but not the indices into it.
                None | Some("") => self.bare = true,
                Some(_) if count == 0 => self.bare = true,
                Some(text) => {
                    let texture = index(at, "a texture index", text, count)?;
                    uvs.push(self.texture_vertices[texture - 1]);
                }
            }
        }
        self.faces += 1;
        self.raw.add_polygon(at, &corners, (!self.bare).then_some(uvs.as_slice()))
    }

    /// Takes a row that names the faces after it.
    fn name<'a>(&mut self, kind: &str, words: impl Iterator<Item = &'a str>) {
        self.end_names();
        let words: Vec<String> = words.map(str::to_owned).collect();
        let whole = Some(words.join(" ")).filter(|name| !name.is_empty());
        match kind {
            "o" => self.names.object = whole,
            "usemtl" => self.names.material = whole,
            _ => self.names.groups = words,
        }
        if kind != "usemtl" {
            self.raw.starts.push(self.raw.triangles.len());
        }
    }

    /// Gives the faces since the last name theirs.
    fn end_names(&mut self) {
        let Names { object, groups, material, first } = &mut self.names;
        let names = object.iter().chain(&*groups).chain(&*material);
        names.for_each(|name| self.raw.name(name, *first));
        *first = self.raw.triangles.len();
    }

    /// The number of a vertex among those in use; from now on it is one of them.
    fn number(&mut self, vertex: usize) -> u32 {
        let positions = &mut self.raw.positions;
        *self.numbers[vertex].get_or_insert_with(|| {
            positions.push(self.vertices[vertex]);
            positions.len() as u32 - 1
        })
    }

    fn finish(mut self) -> Raw {
        self.end_names();
        // All faces have texture coordinates, or none has.
        if self.bare {
            self.raw.uvs.clear();
        }
        Raw { vertices_read: self.vertices.len(), ..self.raw }
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
