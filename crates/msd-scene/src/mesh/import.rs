//! Import of mesh files: format, bytes, clean triangles.

use crate::mesh::clean::overlap::overlapping;
use crate::mesh::clean::topology::{components, edges, sides};
use crate::mesh::clean::weld::clean;
use crate::mesh::error::{MeshError, malformed};
use crate::mesh::foreign::foreign;
use crate::mesh::raw::{Group, LONGEST, without_mark};
use crate::mesh::read::{gltf_file, obj_file, ply_file, stl_file};
use crate::shown::shown_path;
use glam::DVec3;
use std::path::{Component, Path};

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ; faces, and the names of objects, groups and materials.
    Obj,
    /// STL, text or binary.
    Stl,
    /// PLY, text or binary.
    Ply,
    /// glTF 2.0, text (`.gltf`) or binary (`.glb`).
    Gltf,
}

impl Format {
    /// The format that the ending of a file name stands for, in upper or lower case.
    ///
    /// ```
    /// use msd_scene::mesh::Format;
    /// assert_eq!(Format::from_extension("GLB"), Some(Format::Gltf));
    /// assert_eq!(Format::from_extension("toml"), None);
    /// ```
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "obj" => Some(Self::Obj),
            "stl" => Some(Self::Stl),
            "ply" => Some(Self::Ply),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }

    /// The ending of its files; that of text where there are two.
    fn ending(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Stl => "stl",
            Self::Ply => "ply",
            Self::Gltf => "gltf",
        }
    }
}

/// Clean triangles: no two vertices at one place, no face without area or there twice.
///
/// Faces are counter-clockwise seen from outside; vertices stand in order of their first use.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Name of the file without its folder, for messages.
    pub name: String,
    /// Vertices, in the units of the file.
    pub positions: Vec<DVec3>,
    /// Texture coordinates of the corners of each triangle, from 0 to 1, v upward; `None` if the
    /// file gives none. Coordinates outside that range are scaled down into it.
    pub uvs: Option<Vec<[[f32; 2]; 3]>>,
    /// Three vertices per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The names in the file, each with its triangles.
    pub groups: Vec<Group>,
    /// Counts of the read and the cleaning.
    pub report: MeshReport,
}

impl Mesh {
    /// Whether every edge has two faces, so that there is an inside.
    pub fn is_closed(&self) -> bool {
        self.report.open_edges == 0 && self.report.non_manifold_edges == 0
    }
}

/// Counts of the read and the cleaning. `vertices_read` = vertices left + `welded` + `unused`,
/// unless closed parts that touch share vertices in the file: those are left once for each part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshReport {
    /// Vertices in the file.
    pub vertices_read: usize,
    /// Vertices merged into another within 10⁻⁶ of the diagonal of the bounding box.
    pub welded: usize,
    /// Vertices left out because no face uses them.
    pub unused: usize,
    /// Triangles in the file, polygons cut up.
    pub triangles_read: usize,
    /// Polygons that cross themselves, for which a fan around the first corner stands.
    pub crossed: usize,
    /// Triangles dropped because they have no area once welded.
    pub degenerate: usize,
    /// Triangles dropped because another has the same three corners.
    pub duplicate: usize,
    /// Triangles turned over, to face outward or to agree with their neighbours.
    pub turned: usize,
    /// Closed parts that touch another one, which are bodies of their own.
    pub touching: usize,
    /// Closed parts that go through another one, or are inside it and no void; not counted in
    /// meshes of more than 20 000 triangles.
    pub overlapping: usize,
    /// Bytes of a binary STL file after the facets that its header announces, which are not read.
    pub left_over: usize,
    /// Vertices left.
    pub vertices: usize,
    /// Triangles left.
    pub triangles: usize,
    /// Edges with a single face.
    pub open_edges: usize,
    /// Edges with more than two faces.
    pub non_manifold_edges: usize,
    /// Pieces that share no vertex.
    pub components: usize,
}

impl core::fmt::Display for MeshReport {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let closed = if self.open_edges + self.non_manifold_edges == 0 { "closed" } else { "open" };
        writeln!(
            f,
            "read {} vertices ({} welded, {} unused) and {} triangles ({} degenerate and {} \
             duplicate dropped, {} turned)",
            self.vertices_read,
            self.welded,
            self.unused,
            self.triangles_read,
            self.degenerate,
            self.duplicate,
            self.turned
        )?;
        if 0 < self.crossed {
            writeln!(f, "{} faces cross themselves: what they cover is a guess", self.crossed)?;
        }
        if 0 < self.touching {
            writeln!(
                f,
                "{} closed parts touch another one; each is a body of its own, not joined to it",
                self.touching
            )?;
        }
        if 0 < self.overlapping {
            writeln!(
                f,
                "{} closed parts overlap another one; what they share counts twice in the volume, \
                 and in a mass by density",
                self.overlapping
            )?;
        }
        if 0 < self.left_over {
            let (facets, bytes) = (self.triangles_read, self.left_over);
            writeln!(
                f,
                "its header announces {facets} facets; {bytes} bytes after them are not read"
            )?;
        }
        write!(
            f,
            "{} vertices, {} triangles, {} components, {closed}: {} open edges, {} edges with \
             more than two faces",
            self.vertices,
            self.triangles,
            self.components,
            self.open_edges,
            self.non_manifold_edges
        )
    }
}

/// Reads a mesh from a file, in the format given by the ending of its name.
///
/// A `.gltf` file may name buffers in files beside or below it.
///
/// # Errors
/// A file that cannot be read or is larger than 1 GiB, and all that [`parse`] refuses.
pub fn read(path: &Path) -> Result<Mesh, MeshError> {
    let name = shown_path(path);
    if path.is_dir() {
        let reason = "it is a folder; a mesh is a file".into();
        return Err(MeshError::Unreadable { file: name, reason });
    }
    let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
    let Some(format) = Format::from_extension(&extension) else {
        return Err(MeshError::UnknownFormat { file: name, extension });
    };
    let bytes = read_bytes(path, &name)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let load = |address: &str| {
        let relative = decode_percent(address);
        let relative = Path::new(&relative);
        // A mesh may not reach for files elsewhere on the machine.
        let below = relative.components().all(|part| matches!(part, Component::Normal(_)));
        if !below || address.contains(':') {
            let reason = format!("buffer '{address}' does not lie beside or below the file");
            return Err(malformed(&name, reason));
        }
        read_bytes(&folder.join(relative), &format!("{name}: buffer '{address}'"))
    };
    let mut mesh = parse_with(&bytes, format, &name, &load)?;
    mesh.name = shown_path(Path::new(path.file_name().unwrap_or(path.as_os_str())));
    Ok(mesh)
}

/// Parses a mesh from the bytes of one file; touches no other.
///
/// # Errors
/// The first thing that is wrong, with the file and, where it is known, the row: a number that is
/// not finite or beyond 10⁹, an index that names nothing, a face with fewer than three corners, a
/// file cut short, no face with an area, a glTF buffer in another file.
pub fn parse(bytes: &[u8], format: Format, name: &str) -> Result<Mesh, MeshError> {
    parse_with(bytes, format, name, &|address| {
        let reason =
            format!("buffer '{address}' lies in another file; read it by path, or as .glb");
        Err(malformed(name, reason))
    })
}

fn parse_with(
    bytes: &[u8],
    format: Format,
    name: &str,
    load: &gltf_file::Loader,
) -> Result<Mesh, MeshError> {
    let raw = match format {
        Format::Obj => obj_file::parse(without_mark(bytes), name),
        Format::Stl => stl_file::parse(bytes, name),
        Format::Ply => ply_file::parse(without_mark(bytes), name),
        Format::Gltf => gltf_file::parse(without_mark(bytes), name, load),
    };
    let cleaned = raw.and_then(|mut raw| Ok((clean(&mut raw, name)?, raw)));
    let (clean, raw) = cleaned.map_err(|error| match foreign(bytes, format.ending()) {
        Some(reason) => malformed(name, reason),
        None => error,
    })?;
    let sides = sides(&clean.triangles);
    let (parts, count) = components(clean.positions.len(), &clean.triangles);
    let report = MeshReport {
        vertices_read: raw.vertices_read,
        welded: clean.welded,
        unused: clean.unused,
        triangles_read: raw.triangles.len(),
        crossed: raw.crossed,
        degenerate: clean.degenerate,
        duplicate: clean.duplicate,
        turned: clean.turned,
        touching: clean.touching,
        overlapping: overlapping(&clean.positions, &clean.triangles, &parts),
        left_over: raw.left_over,
        vertices: clean.positions.len(),
        triangles: clean.triangles.len(),
        open_edges: edges(&sides).filter(|edge| edge.len() == 1).count(),
        non_manifold_edges: edges(&sides).filter(|edge| 2 < edge.len()).count(),
        components: count,
    };
    Ok(Mesh {
        name: name.into(),
        positions: clean.positions,
        uvs: clean.uvs,
        triangles: clean.triangles,
        groups: clean.groups,
        report,
    })
}

fn read_bytes(path: &Path, name: &str) -> Result<Vec<u8>, MeshError> {
    let unreadable = |reason: String| MeshError::Unreadable { file: name.into(), reason };
    let about = std::fs::metadata(path).map_err(|error| unreadable(error.to_string()))?;
    if !about.is_file() {
        return Err(unreadable("it is not a regular file".into()));
    }
    let (what, count, limit) = ("its length in bytes", about.len(), LONGEST);
    if limit < count {
        let (count, limit) = (count.into(), limit.into());
        return Err(MeshError::TooLarge { file: name.into(), what, count, limit });
    }
    std::fs::read(path).map_err(|error| unreadable(error.to_string()))
}

/// Turns the %20 of an address back into its character.
fn decode_percent(address: &str) -> String {
    let mut bytes = Vec::with_capacity(address.len());
    let mut rest = address.as_bytes();
    while let Some((&byte, tail)) = rest.split_first() {
        let code = tail.get(..2).and_then(|digits| std::str::from_utf8(digits).ok());
        let code = code.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        (rest, _) = match (byte, code) {
            (b'%', Some(code)) => (&tail[2..], bytes.push(code)),
            _ => (tail, bytes.push(byte)),
        };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
