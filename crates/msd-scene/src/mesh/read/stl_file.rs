//! STL files: texts by `stl_io`, binary ones by hand, as `stl_io` takes any file that begins with
//! "solid" for a text.

use crate::mesh::error::{MeshError, Row, malformed, malformed_row};
use crate::mesh::raw::{Raw, check_count, without_mark};
use glam::DVec3;
use std::io::Cursor;

const HEADER: usize = 84;
const FACET: usize = 50;

/// Reads the facets of an STL file; every facet brings three vertices of its own.
pub(crate) fn parse(bytes: &[u8], file: &str) -> Result<Raw, MeshError> {
    if is_binary(bytes) {
        check_length(bytes, file)?;
        Ok(read_binary(bytes))
    } else {
        read_text(plain_text(without_mark(bytes), file)?.as_bytes(), file)
    }
}

/// Whether a file is binary. Some binary headers start with "solid" too, and some files go on after
/// the last facet. But no text has a zero, and the number of facets has one: its highest byte.
fn is_binary(bytes: &[u8]) -> bool {
    let word = without_mark(bytes).trim_ascii_start().get(..5);
    let starts_as_text = word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    !starts_as_text || bytes.get(..HEADER).is_some_and(|header| header.contains(&0))
}

/// The length that a binary header announces, bytes.
fn announced(bytes: &[u8]) -> Option<u128> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]);
    Some(HEADER as u128 + FACET as u128 * u128::from(count))
}

fn check_length(bytes: &[u8], file: &str) -> Result<(), MeshError> {
    let Some(needed) = announced(bytes) else {
        let reason = format!("an STL file has at least {HEADER} bytes; this has {}", bytes.len());
        return Err(malformed(file, reason));
    };
    if bytes.len() as u128 >= needed {
        // Each facet has three vertices of its own.
        let vertices = 3 * (needed - HEADER as u128) / FACET as u128;
        return check_count(file, "the number of vertices", vertices);
    }
    if bytes.iter().take(HEADER).all(|&byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace())
    {
        let reason = "it is text that does not begin with 'solid', as an STL file does";
        return Err(malformed(file, reason));
    }
    Err(MeshError::Truncated {
        file: file.into(),
        what: "facets".into(),
        needed: needed - HEADER as u128,
        present: bytes.len() - HEADER,
    })
}

/// The facets of all solids as one solid, in lower case: `stl_io` reads the first solid only, and
/// only if it has a name.
fn plain_text(bytes: &[u8], file: &str) -> Result<String, MeshError> {
    let text = String::from_utf8_lossy(bytes).to_ascii_lowercase();
    let first_word = |line: &str| line.split_whitespace().next().map(str::to_owned);
    let last = text.lines().rev().find_map(first_word);
    if last.as_deref() != Some("endsolid") {
        return Err(malformed(file, "the text ends without 'endsolid'; the file is cut short"));
    }
    let mut plain = String::from("solid mesh\n");
    for line in text.lines() {
        if !matches!(first_word(line).as_deref(), Some("solid" | "endsolid")) {
            plain.push_str(line);
            plain.push('\n');
        }
    }
    plain.push_str("endsolid\n");
    Ok(plain)
}

fn read_binary(bytes: &[u8]) -> Raw {
    let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let count = announced(bytes).map_or(0, |end| (end as usize - HEADER) / FACET);
    let mut raw = Raw::default();
    for facet in bytes[HEADER..].chunks_exact(FACET).take(count) {
        // After the normal, which is that of the corners.
        let corners = facet[12..48].chunks_exact(12);
        raw.add_facet(corners.map(|at| [0, 4, 8].map(|i| number(&at[i..i + 4]))));
    }
    // Some programs add less than a facet.
    let left_over = bytes.len() - HEADER - count * FACET;
    raw.left_over = if FACET <= left_over { left_over } else { 0 };
    raw
}

fn read_text(bytes: &[u8], file: &str) -> Result<Raw, MeshError> {
    let mut cursor = Cursor::new(bytes);
    let facets = stl_io::create_stl_reader(&mut cursor)
        .map_err(|error| malformed(file, error.to_string()))?;
    let mut raw = Raw::default();
    for (row, facet) in facets.enumerate() {
        let row = Row { item: "facet", row };
        let facet = facet.map_err(|error| {
            let message = error.to_string();
            let is_endless = message.contains("finite");
            let reason = if is_endless { "a coordinate is not finite" } else { message.as_str() };
            malformed_row(file, row, reason)
        })?;
        raw.add_facet(facet.vertices.iter().map(|vertex| vertex.0));
    }
    Ok(raw)
}

impl Raw {
    /// Appends a triangle with three vertices of its own.
    fn add_facet(&mut self, corners: impl Iterator<Item = [f32; 3]>) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners.map(|corner| DVec3::from_array(corner.map(f64::from))));
        self.triangles.push([first, first + 1, first + 2]);
        self.vertices_read = self.positions.len();
    }
}
