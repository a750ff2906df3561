//! glTF 2.0 in one file (GLB): bodies as meshes, and their motion as morph targets, one a moment.

use super::Follow;
use super::skin::{Form, Skin, positions};
use crate::runner::Runner;
use msd_core::glam::DVec3;
use msd_scene::{FileError, Output, Spool};
use serde_json::{Value, json};
use std::io::{self, Write};

/// The most moments: weights grow with their square, and programs keep every target in memory.
pub const MOST_MOMENTS: u64 = 1000;

/// Kinds of numbers and primitives of glTF.
const FLOAT: u32 = 5126;
const UNSIGNED: u32 = 5125;
const POINTS: u32 = 0;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// A file that is being written.
#[derive(Debug)]
pub struct Glb {
    output: Output,
    spool: Spool,
    parts: Vec<Drawn>,
    times: Vec<f64>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

/// A part with its vertices.
#[derive(Debug)]
struct Drawn {
    name: String,
    /// The particle of each vertex.
    particles: Vec<u32>,
    /// Where each vertex was at first, metres, and its normal; none but of a surface.
    start: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// Three vertices of each triangle of a surface.
    triangles: Vec<[u32; 3]>,
    primitive: Value,
    targets: Vec<Value>,
    is_two_sided: bool,
}

impl Glb {
    /// Begins one with the vertices where they are now.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn new(output: Output, spool: Spool, (skin, runner): (&Skin, &Runner)) -> io::Result<Self> {
        let (parts, times, views, accessors) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut glb = Glb { output, spool, parts, times, views, accessors };
        let all = positions(runner);
        for part in &skin.parts {
            let particles = part.form.particles();
            let place = |particle: &u32| all[*particle as usize].map(|x| x as f32);
            let start: Vec<[f32; 3]> = particles.iter().map(place).collect();
            let position = glb.add_vectors(&start)?;
            let mut attributes = json!({ "POSITION": position });
            let (mut triangles, mut normals) = (Vec::new(), Vec::new());
            let (mode, indices) = match &part.form {
                Form::Surface(surface) => {
                    triangles = surface.triangles.clone();
                    normals = normals_of(&start, &triangles);
                    let normals = glb.add_floats(normals.as_flattened(), "VEC3", 3)?;
                    attributes["NORMAL"] = normals.into();
                    // The origin of glTF's textures is the upper left corner.
                    let uv =
                        surface.corners.iter().map(|corner| [corner.uv[0], 1.0 - corner.uv[1]]);
                    let uv: Vec<f32> = uv.flatten().collect();
                    attributes["TEXCOORD_0"] = glb.add_floats(&uv, "VEC2", 2)?.into();
                    (TRIANGLES, surface.triangles.concat())
                }
                Form::Lines(lines) => {
                    let place = |end: &u32| particles.partition_point(|row| row < end) as u32;
                    (LINES, lines.iter().flatten().map(place).collect())
                }
                Form::Points(_) => (POINTS, (0..particles.len() as u32).collect()),
            };
            let indices = glb.add_indices(&indices)?;
            let is_two_sided = matches!(&part.form, Form::Surface(surface) if surface.two_sided);
            glb.parts.push(Drawn {
                name: part.name.clone(),
                particles,
                start,
                normals,
                triangles,
                primitive: json!({ "attributes": attributes, "indices": indices, "mode": mode }),
                targets: Vec::new(),
                is_two_sided,
            });
        }
        Ok(glb)
    }

    fn add_view(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let view = json!({
            "buffer": 0, "byteOffset": self.spool.length(), "byteLength": bytes.len()
        });
        self.spool.write_all(bytes)?;
        self.views.push(view);
        Ok(self.views.len() - 1)
    }

    fn add_accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn add_floats(&mut self, values: &[f32], kind: &str, width: usize) -> io::Result<usize> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.add_view(&bytes)?;
        let count = values.len() / width;
        Ok(self.add_accessor(json!({
            "bufferView": view, "componentType": FLOAT, "count": count, "type": kind
        })))
    }

    /// Adds vectors of vertices, with the box that they are in.
    fn add_vectors(&mut self, vectors: &[[f32; 3]]) -> io::Result<usize> {
        let accessor = self.add_floats(vectors.as_flattened(), "VEC3", 3)?;
        let bound = |pick: fn(f32, f32) -> f32| {
            let first = vectors.first().copied().unwrap_or_default();
            vectors.iter().fold(first, |bound, vector| {
                std::array::from_fn(|axis| pick(bound[axis], vector[axis]))
            })
        };
        self.accessors[accessor]["min"] = json!(bound(f32::min));
        self.accessors[accessor]["max"] = json!(bound(f32::max));
        Ok(accessor)
    }

    fn add_indices(&mut self, indices: &[u32]) -> io::Result<usize> {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        let view = self.add_view(&bytes)?;
        Ok(self.add_accessor(json!({
            "bufferView": view, "componentType": UNSIGNED, "count": indices.len(), "type": "SCALAR"
        })))
    }

    /// The animation: at each moment its target alone has weight; at the first none has.
    fn animation(&mut self) -> io::Result<Value> {
        let first = self.times.first().copied().unwrap_or(0.0);
        let times: Vec<f32> = self.times.iter().map(|time| (time - first) as f32).collect();
        let input = self.add_floats(&times, "SCALAR", 1)?;
        self.accessors[input]["min"] = json!([times.first()]);
        self.accessors[input]["max"] = json!([times.last()]);
        let targets = times.len() - 1;
        let mut weights = vec![0.0; times.len() * targets];
        (0..targets).for_each(|target| weights[(target + 1) * targets + target] = 1.0);
        let output = self.add_floats(&weights, "SCALAR", 1)?;
        let channel =
            |node: usize| json!({ "sampler": 0, "target": { "node": node, "path": "weights" } });
        let channels: Vec<Value> = (0..self.parts.len()).map(channel).collect();
        Ok(json!({
            "name": "run",
            "samplers": [{ "input": input, "output": output, "interpolation": "LINEAR" }],
            "channels": channels,
        }))
    }

    fn document(&mut self) -> io::Result<Value> {
        let is_moving = 1 < self.times.len() && !self.parts.is_empty();
        let animation = is_moving.then(|| self.animation()).transpose()?;
        let (mut meshes, mut nodes) = (Vec::new(), Vec::new());
        for (row, part) in self.parts.iter().enumerate() {
            let mut primitive = part.primitive.clone();
            primitive["material"] = usize::from(part.is_two_sided).into();
            let mut mesh = json!({ "name": part.name });
            if !part.targets.is_empty() {
                primitive["targets"] = json!(part.targets);
                mesh["weights"] = json!(vec![0.0; part.targets.len()]);
            }
            mesh["primitives"] = json!([primitive]);
            meshes.push(mesh);
            nodes.push(json!({ "name": part.name, "mesh": row }));
        }
        let material = |name: &str, is_two_sided: bool| {
            let rough = json!({ "metallicFactor": 0.0, "roughnessFactor": 0.7 });
            json!({ "name": name, "doubleSided": is_two_sided, "pbrMetallicRoughness": rough })
        };
        let mut document = json!({
            "asset": { "version": "2.0", "generator": "msd" },
            "scene": 0,
            "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
            "nodes": nodes,
            "meshes": meshes,
            "materials": [material("solid", false), material("sheet", true)],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.spool.length() }],
        });
        if let Some(animation) = animation {
            document["animations"] = json!([animation]);
        }
        Ok(document)
    }
}

impl Follow for Glb {
    fn add(&mut self, runner: &Runner) -> io::Result<()> {
        let is_first = self.times.is_empty();
        self.times.push(runner.time());
        if is_first {
            return Ok(());
        }
        let all = positions(runner);
        for row in 0..self.parts.len() {
            let part = &self.parts[row];
            let place = |particle: &u32| all[*particle as usize].map(|x| x as f32);
            let now: Vec<[f32; 3]> = part.particles.iter().map(place).collect();
            let moved = differences(&now, &part.start);
            let turned = differences(&normals_of(&now, &part.triangles), &part.normals);
            let mut target = json!({ "POSITION": self.add_vectors(&moved)? });
            if !turned.is_empty() {
                target["NORMAL"] = self.add_floats(turned.as_flattened(), "VEC3", 3)?.into();
            }
            self.parts[row].targets.push(target);
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), FileError> {
        let document = self.document();
        let Glb { mut output, spool, .. } = *self;
        let write = || -> io::Result<()> {
            let mut text = serde_json::to_vec(&document?)?;
            text.resize(text.len().next_multiple_of(4), b' ');
            let total = 12 + 8 + text.len() as u64 + 8 + spool.length();
            let length = |bytes: u64| u32::try_from(bytes).map(u32::to_le_bytes);
            let too_long = |_| io::Error::other("a GLB file holds at most 4 GB");
            let (total, binary) = (length(total), length(spool.length()));
            output.write_all(b"glTF\x02\0\0\0")?;
            output.write_all(&total.map_err(too_long)?)?;
            output.write_all(&(text.len() as u32).to_le_bytes())?;
            output.write_all(b"JSON")?;
            output.write_all(&text)?;
            // All is in numbers of four bytes, so its length is a multiple of four.
            output.write_all(&binary.map_err(too_long)?)?;
            output.write_all(b"BIN\0")?;
            spool.copy_to(&mut output)
        };
        let written = write();
        written.map_err(|error| output.refused(&error))?;
        output.finish()
    }
}

/// The first vectors less the second ones, as many as there are of both.
fn differences(now: &[[f32; 3]], start: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let pairs = now.iter().zip(start);
    pairs.map(|(now, start)| std::array::from_fn(|axis| now[axis] - start[axis])).collect()
}

/// The normal of each vertex, of length one: the mean of its triangles by their areas, or up where
/// they have none. Vertices of a block are those of one side, and its edges stay edges.
fn normals_of(places: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    if triangles.is_empty() {
        return Vec::new();
    }
    let place = |vertex: u32| DVec3::from(places[vertex as usize].map(f64::from));
    let mut sums = vec![DVec3::ZERO; places.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(place);
        let area = (b - a).cross(c - a);
        triangle.iter().for_each(|&vertex| sums[vertex as usize] += area);
    }
    sums.into_iter().map(|sum| sum.normalize_or(DVec3::Y).as_vec3().to_array()).collect()
}
