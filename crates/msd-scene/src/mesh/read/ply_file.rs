//! PLY files, text or binary, by `ply-rs-bw`, once their counts are known to fit.

use crate::mesh::error::{MeshError, Row, malformed, malformed_row};
use crate::mesh::raw::{Raw, check_count};
use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

/// Reads the elements `vertex` and `face` of a PLY file and skips all others.
pub(crate) fn parse(bytes: &[u8], file: &str) -> Result<Raw, MeshError> {
    let failed = |error: ParseError| match error.line() {
        Some(row) => malformed_row(file, Row { item: "line", row }, without_line(&error)),
        None => malformed(file, error.to_string()),
    };
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(failed)?;
    check_counts(&header, reader.get_ref().len(), file)?;
    check_elements(&header, file)?;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (name, element) in &header.elements {
        let r = &mut reader;
        match name.as_str() {
            "vertex" => {
                vertices = Parser::<Vertex>::new()
                    .read_payload_for_element(r, element, &header)
                    .map_err(failed)?;
            }
            "face" => {
                faces = Parser::<Face>::new()
                    .read_payload_for_element(r, element, &header)
                    .map_err(failed)?;
            }
            _ => {
                Parser::<Skipped>::new()
                    .read_payload_for_element(r, element, &header)
                    .map_err(failed)?;
            }
        }
    }
    let textured = header.elements.get("vertex").is_some_and(|element| {
        element.properties.keys().filter(|name| uv_axis(name).is_some()).count() == 2
    });
    assemble(&vertices, &faces, (file, textured))
}

/// The message of a parse error without its line, which is printed apart, and without the
/// expectations of the reader's grammar.
fn without_line(error: &ParseError) -> String {
    let message = error.to_string();
    let reason = match (message.strip_prefix("Line "), message.split_once(": ")) {
        (Some(_), Some((_, reason))) => reason,
        _ => &message,
    };
    if reason.contains("magic number") {
        return "it does not begin with 'ply', as a PLY file does".into();
    }
    let is_of_grammar = reason.contains("ParseError {") || reason.contains("error at ");
    match reason.split_once("String: '").and_then(|(_, rest)| rest.split_once('\'')) {
        Some((text, _)) if is_of_grammar => format!("'{}' cannot be read", text.trim()),
        _ => reason.to_owned(),
    }
}

/// Checks that vertices have coordinates, and that faces are polygons.
fn check_elements(header: &Header, file: &str) -> Result<(), MeshError> {
    let vertex = header.elements.get("vertex");
    let has = |name: &str| vertex.is_none_or(|vertex| vertex.properties.contains_key(name));
    if let Some(name) = ["x", "y", "z"].into_iter().find(|name| !has(name)) {
        return Err(malformed(file, format!("its vertices have no property {name}")));
    }
    if header.elements.contains_key("tristrips") && !header.elements.contains_key("face") {
        let reason = "its triangles are strips (element 'tristrips'), which msd does not read: \
                      write them as faces";
        return Err(malformed(file, reason));
    }
    Ok(())
}

fn assemble(
    vertices: &[Vertex],
    faces: &[Face],
    (file, textured): (&str, bool),
) -> Result<Raw, MeshError> {
    let mut raw = Raw { vertices_read: vertices.len(), ..Raw::default() };
    raw.positions = vertices.iter().map(|vertex| DVec3::from_array(vertex.position)).collect();
    for (row, face) in faces.iter().enumerate() {
        let row = Row { item: "face", row };
        let pairs = face.uvs.chunks_exact(2).map(|uv| [uv[0], uv[1]]);
        let mut uvs: Vec<[f32; 2]> = pairs.collect();
        if textured {
            let vertex = |&corner: &i64| vertices.get(usize::try_from(corner).ok()?);
            let corners = face.corners.iter();
            uvs = corners.map(|corner| vertex(corner).map_or([0.0; 2], |v| v.uv)).collect();
        }
        let uvs = (uvs.len() == face.corners.len()).then_some(&uvs[..]);
        raw.add_polygon((file, row), &face.corners, uvs)?;
    }
    Ok(raw)
}

/// Checks that the elements a header announces can be in the bytes that follow it. Some readers
/// make room for four billion elements, or count to four billion, on the word of a header.
fn check_counts(header: &Header, present: usize, file: &str) -> Result<(), MeshError> {
    let text = header.encoding == Encoding::Ascii;
    let mut needed = 0;
    for (name, element) in &header.elements {
        let size = smallest_size(element, text).max(1);
        // The last line of a text need not end.
        let last = u128::from(text && 0 < element.count);
        needed += element.count as u128 * size as u128 - last;
        if present as u128 + 1 < needed {
            let what = format!("elements '{name}' and before");
            return Err(MeshError::Truncated { file: file.into(), what, needed, present });
        }
        // A row of three bytes takes many times that in memory.
        match name.as_str() {
            "vertex" => check_count(file, "the number of vertices", element.count as u128)?,
            "face" => check_count(file, "the number of faces", element.count as u128)?,
            _ => (),
        }
    }
    Ok(())
}

/// The fewest bytes that an element can take; two per number in a text.
fn smallest_size(element: &ElementDef, text: bool) -> usize {
    let scalar = |scalar: &ScalarType| match scalar {
        _ if text => 2,
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let properties = element.properties.values();
    properties
        .map(|property| match &property.data_type {
            PropertyType::Scalar(kind) | PropertyType::List(kind, _) => scalar(kind),
        })
        .sum()
}

fn uv_axis(name: &str) -> Option<usize> {
    match name {
        "u" | "s" | "texture_u" => Some(0),
        "v" | "t" | "texture_v" => Some(1),
        _ => None,
    }
}

struct Vertex {
    position: [f64; 3],
    uv: [f32; 2],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        // The header was checked to have all three coordinates.
        Self { position: [f64::NAN; 3], uv: [0.0; 2] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(value) = scalar(&property) else { return PropertyAccessResult::Ignored };
        match (name, uv_axis(name)) {
            ("x", _) => self.position[0] = value,
            ("y", _) => self.position[1] = value,
            ("z", _) => self.position[2] = value,
            (_, Some(axis)) => self.uv[axis] = value as f32,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

struct Face {
    corners: Vec<i64>,
    uvs: Vec<f32>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self { corners: Vec::new(), uvs: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "vertex_indices" | "vertex_index" => match integers(property) {
                Some(corners) => self.corners = corners,
                None => return PropertyAccessResult::UnsupportedType,
            },
            "texcoord" => match property {
                Property::ListFloat(uvs) => self.uvs = uvs,
                _ => return PropertyAccessResult::Ignored,
            },
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

fn scalar(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(value) => value.into(),
        Property::UChar(value) => value.into(),
        Property::Short(value) => value.into(),
        Property::UShort(value) => value.into(),
        Property::Int(value) => value.into(),
        Property::UInt(value) => value.into(),
        Property::Float(value) => value.into(),
        Property::Double(value) => value,
        _ => return None,
    })
}

fn integers(property: Property) -> Option<Vec<i64>> {
    Some(match property {
        Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
        Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
        _ => return None,
    })
}
