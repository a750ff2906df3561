//! STL files, text or binary, by `stl_io`, once their lengths are known to be true.

use crate::mesh::error::{MeshError, Row, malformed, malformed_row};
use crate::mesh::raw::{Raw, check_count};
use glam::DVec3;
use std::io::Cursor;

const HEADER: usize = 84;
const FACET: usize = 50;

/// Reads the facets of an STL file; every facet brings three vertices of its own.
pub(crate) fn parse(bytes: &[u8], file: &str) -> Result<Raw, MeshError> {
    if is_binary(bytes) {
        check_length(bytes, file)?;
        read_facets(bytes, file)
    } else {
        read_facets(plain_text(bytes, file)?.as_bytes(), file)
    }
}

/// Whether a file is binary: some binary headers start with "solid" too, so the length decides.
fn is_binary(bytes: &[u8]) -> bool {
    let starts_as_text =
        bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    !starts_as_text || announced(bytes).is_some_and(|length| length == bytes.len() as u128)
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

fn read_facets(bytes: &[u8], file: &str) -> Result<Raw, MeshError> {
    let mut cursor = Cursor::new(bytes);
    let facets = stl_io::create_stl_reader(&mut cursor)
        .map_err(|error| malformed(file, error.to_string()))?;
    let mut raw = Raw::default();
    for (row, facet) in facets.enumerate() {
        let row = Row { item: "facet", row };
        let facet = facet.map_err(|error| malformed_row(file, row, error.to_string()))?;
        let first = raw.positions.len() as u32;
        let vertices = facet.vertices.iter();
        raw.positions.extend(vertices.map(|vertex| DVec3::from_array(vertex.0.map(f64::from))));
        raw.triangles.push([first, first + 1, first + 2]);
    }
    raw.vertices_read = raw.positions.len();
    Ok(raw)
}
