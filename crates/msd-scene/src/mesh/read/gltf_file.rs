//! glTF files, text or binary: their structure by `gltf`, their numbers here.

use crate::mesh::error::{MeshError, Row, malformed, one_line};
use crate::mesh::raw::{CornerUvs, LONGEST, Raw, check_count, out_of_domain};
use glam::{DMat4, DVec3};
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::Source;
use gltf::mesh::{Mode, Primitive, Semantic};
use std::borrow::Cow;

/// Finds the bytes of a buffer that lies in a file of its own, by its address.
pub(crate) type Loader<'a> = dyn Fn(&str) -> Result<Vec<u8>, MeshError> + 'a;

/// Reads the triangles of all meshes in the scene of a glTF file, each where its nodes put it.
///
/// # Errors
/// A file that is not valid, a buffer that is too short, or one that `load` does not find.
pub(crate) fn parse(bytes: &[u8], file: &str, load: &Loader) -> Result<Raw, MeshError> {
    let (document, blob) = read_structure(bytes, file)?;
    let (mut buffers, mut total) = (Vec::new(), 0);
    for buffer in document.buffers() {
        let data = match buffer.source() {
            Source::Bin => Cow::Borrowed(blob.as_deref().unwrap_or_default()),
            Source::Uri(uri) => Cow::Owned(match uri.strip_prefix("data:") {
                Some(data) => decode_data(data)
                    .ok_or_else(|| malformed(file, "a buffer's data is not valid base64"))?,
                None => load(uri)?,
            }),
        };
        // Many buffers may name the same file.
        total += data.len() as u64;
        if LONGEST < total {
            let (what, file) = ("the length of all buffers in bytes", file.into());
            let (count, limit) = (total.into(), LONGEST.into());
            return Err(MeshError::TooLarge { file, what, count, limit });
        }
        if data.len() < buffer.length() {
            return Err(MeshError::Truncated {
                file: file.into(),
                what: format!("buffer {}", buffer.index()),
                needed: buffer.length() as u128,
                present: data.len(),
            });
        }
        buffers.push(data);
    }
    let mut reader = Reading { file, buffers, raw: Raw::default() };
    reader.add_scene(&document)?;
    Ok(reader.raw)
}

/// Extensions by which the numbers of meshes are compressed.
const COMPRESSED: [&str; 3] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Beginnings of the names of extensions that are read, or that leave shapes alone.
const HARMLESS: [&str; 4] =
    ["KHR_mesh_quantization", "KHR_materials_", "KHR_lights_", "KHR_texture_transform"];

/// Refuses files of another version: their structure is another, and the reader would name the
/// first missing field.
fn check_version(bytes: &[u8], file: &str) -> Result<(), MeshError> {
    #[derive(serde::Deserialize)]
    struct Head {
        #[serde(default)]
        asset: serde_json::Value,
        #[serde(default)]
        meshes: serde_json::Value,
    }
    let version = match bytes.strip_prefix(b"glTF") {
        Some(rest) => rest.first().map(u8::to_string),
        None => serde_json::from_slice(bytes).ok().and_then(|Head { asset, meshes }| {
            let version = asset["version"].as_str().map(str::to_owned);
            // Meshes in a table, by name, are those of version 1.
            version.or_else(|| meshes.is_object().then(|| "1.0".into()))
        }),
    };
    let is_older = version.filter(|version| !version.starts_with('2'));
    is_older.map_or(Ok(()), |version| {
        let reason = format!(
            "it is glTF {}; it must be glTF 2.0: export it anew, or convert it",
            one_line(&version)
        );
        Err(malformed(file, reason))
    })
}

/// Refuses the extensions that a file cannot be read without, by name and with the way out.
fn check_extensions(required: &[String], file: &str) -> Result<(), MeshError> {
    let Some(name) = required.first() else { return Ok(()) };
    let compressed = required.iter().find(|name| COMPRESSED.contains(&name.as_str()));
    let reason = match compressed {
        Some(name) => format!(
            "its meshes are compressed ({name}), which msd does not read; export it without \
             compression"
        ),
        None => format!("it requires {name}, which msd does not read; export it without"),
    };
    Err(malformed(file, reason))
}

/// The valid structure of a file, and the binary chunk that comes with it.
fn read_structure(
    bytes: &[u8],
    file: &str,
) -> Result<(gltf::Document, Option<Vec<u8>>), MeshError> {
    // `gltf` subtracts the length of the header from this one without a check.
    let total = bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if bytes.starts_with(b"glTF") && total.is_none_or(|total| total < 12) {
        return Err(malformed(file, "the binary header is cut short"));
    }
    check_version(bytes, file)?;
    let invalid = |error: gltf::Error| malformed(file, error.to_string());
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice_without_validation(bytes).map_err(invalid)?;
    let mut root = document.into_json();
    root.extensions_required.retain(|name| !HARMLESS.iter().any(|start| name.starts_with(start)));
    // First: later checks would say that the numbers are missing, not why.
    check_extensions(&root.extensions_required, file)?;
    // `gltf` looks at the accessor of the positions before it checks that there is one.
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    for accessor in primitives.flat_map(|primitive| primitive.attributes.values()) {
        if root.accessors.len() <= accessor.value() {
            let count = root.accessors.len();
            let reason = format!("accessor {accessor} is used, but there are only {count}");
            return Err(malformed(file, reason));
        }
    }
    let document = gltf::Document::from_json(root).map_err(invalid)?;
    Ok((document, blob))
}

struct Reading<'a> {
    file: &'a str,
    buffers: Vec<Cow<'a, [u8]>>,
    raw: Raw,
}

impl Reading<'_> {
    /// Walks the nodes of the default scene, or the first; without one, every mesh untransformed.
    fn add_scene(&mut self, document: &gltf::Document) -> Result<(), MeshError> {
        let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
            return document
                .meshes()
                .flat_map(|mesh| mesh.primitives().collect::<Vec<_>>())
                .try_for_each(|primitive| self.add_primitive(&primitive, DMat4::IDENTITY));
        };
        let mut visited = vec![false; document.nodes().count()];
        let mut waiting: Vec<_> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
        waiting.reverse();
        while let Some((node, parent)) = waiting.pop() {
            // The format asks for a tree; a loop would never end.
            if std::mem::replace(&mut visited[node.index()], true) {
                let reason = format!("node {} has more than one parent", node.index());
                return Err(malformed(self.file, reason));
            }
            let columns = node.transform().matrix().map(|column| column.map(f64::from));
            let transform = parent * DMat4::from_cols_array_2d(&columns);
            let first = self.raw.triangles.len();
            self.raw.starts.push(first);
            for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives()) {
                self.add_primitive(&primitive, transform)?;
            }
            node.name().into_iter().for_each(|name| self.raw.name(name, first));
            let children: Vec<_> = node.children().map(|child| (child, transform)).collect();
            waiting.extend(children.into_iter().rev());
        }
        Ok(())
    }

    fn add_primitive(&mut self, primitive: &Primitive, to: DMat4) -> Result<(), MeshError> {
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(()) };
        let first = self.raw.positions.len();
        let vertices = self.vectors(&positions, Dimensions::Vec3)?;
        // Many nodes can place the same few bytes, so the length of the file does not bound the
        // count.
        let count = first as u128 + vertices.len() as u128;
        check_count(self.file, "the number of vertices", count)?;
        let points = vertices.iter().copied().map(DVec3::from_array);
        self.raw.positions.extend(points.map(|point| to.transform_point3(point)));
        self.raw.vertices_read = self.raw.positions.len();
        let uvs = match primitive.get(&Semantic::TexCoords(0)) {
            Some(uvs) if uvs.count() == vertices.len() => self.vectors(&uvs, Dimensions::Vec2)?,
            _ => Vec::new(),
        };
        let corners = match primitive.indices() {
            Some(indices) => {
                let numbers = self.vectors(&indices, Dimensions::Scalar)?;
                numbers.iter().map(|number| number[0] as i64).collect()
            }
            None => (0..vertices.len() as i64).collect::<Vec<_>>(),
        };
        // A mirror image turns the faces over.
        let mirrored = to.determinant() < 0.0;
        let start = self.raw.triangles.len();
        for (row, mut corners) in triangles(mode, &corners).enumerate() {
            if mirrored {
                corners.swap(1, 2);
            }
            self.add_triangle((row, first), corners, (vertices.len(), &uvs))?;
        }
        let material = primitive.material();
        material.name().into_iter().for_each(|name| self.raw.name(name, start));
        let triangles = self.raw.triangles.len() as u128;
        check_count(self.file, "the number of triangles", triangles)
    }

    fn add_triangle(
        &mut self,
        (row, first): (usize, usize),
        corners: [i64; 3],
        (count, uvs): (usize, &[[f64; 3]]),
    ) -> Result<(), MeshError> {
        let mut triangle = [0; 3];
        let mut corner_uvs: CornerUvs = [[0.0; 2]; 3];
        for (i, corner) in corners.into_iter().enumerate() {
            let index = usize::try_from(corner).ok().filter(|&index| index < count);
            let index = index.ok_or_else(|| {
                let at = (self.file, Row { item: "face", row });
                let expected = format!("from 0 to less than {count}");
                out_of_domain(at, "a vertex index", corner.to_string(), expected)
            })?;
            triangle[i] = (first + index) as u32;
            if let Some(uv) = uvs.get(index) {
                // glTF counts v from the top; the other formats, and we, from the bottom.
                corner_uvs[i] = [uv[0] as f32, 1.0 - uv[1] as f32];
            }
        }
        self.raw.triangles.push(triangle);
        if uvs.len() == count {
            self.raw.uvs.push(corner_uvs);
        }
        Ok(())
    }

    /// The items of an accessor as one to three numbers each. Read here because `gltf` multiplies
    /// and adds the offsets of a file without a check.
    fn vectors(&self, accessor: &Accessor, shape: Dimensions) -> Result<Vec<[f64; 3]>, MeshError> {
        let index = accessor.index();
        let fail = |reason: &str| malformed(self.file, format!("accessor {index}: {reason}"));
        if accessor.sparse().is_some() {
            return Err(fail("sparse accessors are not read"));
        }
        if accessor.dimensions() != shape {
            return Err(fail(&format!("it must be of type {shape:?}")));
        }
        let Some(view) = accessor.view() else { return Err(fail("it has no buffer view")) };
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        let data = self.buffers.get(view.buffer().index());
        let end = view.offset().checked_add(view.length());
        let bytes = data.zip(end).and_then(|(data, end)| data.get(view.offset()..end));
        let bytes = bytes.and_then(|bytes| bytes.get(accessor.offset()..));
        let Some(bytes) = bytes else { return Err(fail("it reaches beyond its buffer")) };
        let count = accessor.count();
        let needed = (count as u128).saturating_sub(1) * stride as u128 + size as u128;
        if stride < size || (0 < count && (bytes.len() as u128) < needed) {
            return Err(fail("it reaches beyond its buffer view"));
        }
        // A byte takes many times that in memory.
        let (what, count) = match shape {
            Dimensions::Scalar => ("the number of triangles", count / 3),
            _ => ("the number of vertices", count),
        };
        check_count(self.file, what, count as u128)?;
        let kind = accessor.data_type();
        let scale = if accessor.normalized() { normalisation(kind) } else { 1.0 };
        let item = |start: usize| {
            let parts = bytes[start..start + size].chunks_exact(kind.size());
            let mut numbers = [0.0; 3];
            for (slot, part) in numbers.iter_mut().zip(parts) {
                // The lowest integer is one beyond −1.
                let value = scale * number(kind, part);
                *slot = if accessor.normalized() { value.max(-1.0) } else { value };
            }
            numbers
        };
        Ok((0..accessor.count()).map(|row| item(row * stride)).collect())
    }
}

/// The triangles of a list, strip or fan.
fn triangles(mode: Mode, corners: &[i64]) -> impl Iterator<Item = [i64; 3]> + '_ {
    let count = match mode {
        Mode::Triangles => corners.len() / 3,
        _ => corners.len().saturating_sub(2),
    };
    (0..count).map(move |i| match mode {
        Mode::Triangles => [corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]],
        Mode::TriangleFan => [corners[0], corners[i + 1], corners[i + 2]],
        // Every second triangle of a strip runs the other way round.
        _ if i % 2 == 1 => [corners[i + 1], corners[i], corners[i + 2]],
        _ => [corners[i], corners[i + 1], corners[i + 2]],
    })
}

/// The number in the bytes of one component.
fn number(kind: DataType, bytes: &[u8]) -> f64 {
    match (kind, bytes) {
        (DataType::I8, &[a]) => f64::from(a as i8),
        (DataType::U8, &[a]) => f64::from(a),
        (DataType::I16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (DataType::U16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (DataType::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (DataType::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => f64::NAN,
    }
}

/// The factor of a normalised integer.
fn normalisation(kind: DataType) -> f64 {
    match kind {
        DataType::I8 => 1.0 / 127.0,
        DataType::U8 => 1.0 / 255.0,
        DataType::I16 => 1.0 / 32767.0,
        DataType::U16 => 1.0 / 65535.0,
        DataType::U32 | DataType::F32 => 1.0,
    }
}

/// The bytes of a data address without its `data:`; `None` unless it is base64.
fn decode_data(data: &str) -> Option<Vec<u8>> {
    let text = data.split_once(";base64,")?.1.trim_end_matches('=');
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0u32, 0);
    for byte in text.bytes() {
        let digit = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = (bits << 6 | u32::from(digit)) & 0xffff;
        count += 6;
        if 8 <= count {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}
