//! glTF 2.0 in one file (GLB): bodies as meshes, and their motion as morph targets, one a moment.

use super::Follow;
use super::glb_look::{self, Mesh};
use super::skin::{Form, Skin};
use crate::on;
use crate::runner::Runner;
use msd_core::glam::{DQuat, DVec3, Quat};
use msd_core::obstacles::Placed;
use msd_core::{Body, Real, Shape, Simulation, Surface, Vector};
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
    solids: Vec<Scenery>,
    planes: Vec<Flat>,
    /// The box around all particles at all moments, metres.
    bounds: [DVec3; 2],
    materials: Vec<Value>,
    times: Vec<f64>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

/// A part with its vertices.
#[derive(Debug)]
struct Drawn {
    name: String,
    cover: Cover,
    /// Initial positions of the vertices, metres, and their normals; empty but for triangles.
    start: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    primitives: Vec<Value>,
    targets: Vec<Value>,
}

/// The way in which vertices follow particles.
#[derive(Debug)]
enum Cover {
    /// Each is at one; three of each triangle, if there are any.
    Surface { particles: Vec<u32>, triangles: Vec<[u32; 3]> },
    /// Rings around a line of them.
    Tube { particles: Vec<u32>, radius: f64 },
}

impl Cover {
    /// Positions of the vertices, metres, and their normals; empty but for triangles.
    fn vertices(&self, all: &[DVec3]) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
        if let Some(mesh) = self.tube(all) {
            return (mesh.places, mesh.normals);
        }
        let Cover::Surface { particles, triangles } = self else { return Default::default() };
        let place = |particle: &u32| all[*particle as usize].as_vec3().to_array();
        let places: Vec<[f32; 3]> = particles.iter().map(place).collect();
        let normals = normals_of(&places, triangles);
        (places, normals)
    }

    fn tube(&self, all: &[DVec3]) -> Option<Mesh> {
        let Cover::Tube { particles, radius } = self else { return None };
        let points: Vec<DVec3> = particles.iter().map(|&row| all[row as usize]).collect();
        Some(Mesh::tube(&points, *radius, AROUND))
    }
}

/// A solid, and its places and turns at the moments.
#[derive(Debug)]
struct Scenery {
    number: usize,
    name: String,
    primitive: Value,
    ways: Vec<([f32; 3], [f32; 4])>,
    /// Whether it is a square, as large as the run needs.
    is_flat: bool,
}

/// A plane: its points have `normal` · point = `offset`, metres.
#[derive(Debug)]
struct Flat {
    normal: DVec3,
    offset: f64,
    primitive: Value,
}

impl Flat {
    /// Its node: a square about the point that is nearest to `middle`, metres.
    fn node(&self, name: &str, mesh: usize, (middle, reach): (DVec3, f64)) -> Value {
        let place = middle - (self.normal.dot(middle) - self.offset) * self.normal;
        json!({
            "name": name,
            "mesh": mesh,
            "translation": place.as_vec3().to_array(),
            "rotation": DQuat::from_rotation_arc(DVec3::Y, self.normal).as_quat().to_array(),
            "scale": [reach, 1.0, reach],
        })
    }
}

/// A plane reaches so many times as far as the particles do from their middle.
const REACH: f64 = 2.0;
/// And at least so far, metres.
const LEAST: f64 = 0.1;

/// Corners around a rope.
const AROUND: u32 = 8;

impl Glb {
    /// Begins one with the vertices where they are now.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn new(output: Output, spool: Spool, (skin, runner): (&Skin, &Runner)) -> io::Result<Self> {
        let mut glb = Glb {
            output,
            spool,
            parts: Vec::new(),
            solids: Vec::new(),
            planes: Vec::new(),
            bounds: [DVec3::INFINITY, DVec3::NEG_INFINITY],
            materials: Vec::new(),
            times: Vec::new(),
            views: Vec::new(),
            accessors: Vec::new(),
        };
        on!(runner, simulation => glb.add_parts(skin, simulation))?;
        on!(runner, simulation => glb.add_solids(simulation))?;
        on!(runner, simulation => glb.add_planes(simulation))?;
        Ok(glb)
    }

    fn add_parts<R: Real>(&mut self, skin: &Skin, simulation: &Simulation<R>) -> io::Result<()> {
        let (bodies, all) = (simulation.model().bodies(), places(simulation));
        for part in &skin.parts {
            let body = part.body.map(|number| (number, &bodies[number]));
            let material =
                body.map_or_else(glb_look::stone, |(number, body)| glb_look::of_body(number, body));
            let material = self.add_material(material);
            match &part.form {
                Form::Surface(surface) => {
                    self.add_surface(&part.name, surface, &all, (body, material))?;
                }
                Form::Lines(lines) => {
                    let ropes = body.and_then(|_| glb_look::ropes(lines));
                    for rope in ropes.iter().flatten() {
                        let radius = glb_look::radius(&simulation.snapshot(), rope);
                        self.add_tube(&part.name, (rope, radius), &all, material)?;
                    }
                    if ropes.is_none() {
                        let particles = part.form.particles();
                        let place = |end: &u32| particles.partition_point(|row| row < end) as u32;
                        let indices: Vec<u32> = lines.iter().flatten().map(place).collect();
                        self.add_plain(&part.name, particles, (&indices, LINES), (&all, material))?;
                    }
                }
                Form::Points(points) => {
                    let indices: Vec<u32> = (0..points.len() as u32).collect();
                    let particles = points.clone();
                    self.add_plain(&part.name, particles, (&indices, POINTS), (&all, material))?;
                }
            }
        }
        Ok(())
    }

    fn add_material(&mut self, material: Value) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    fn add_surface(
        &mut self,
        name: &str,
        surface: &Surface,
        all: &[DVec3],
        (body, material): (Option<(usize, &Body)>, usize),
    ) -> io::Result<()> {
        let particles = surface.corners.iter().map(|corner| corner.particle).collect();
        let cover = Cover::Surface { particles, triangles: surface.triangles.clone() };
        let (start, normals) = cover.vertices(all);
        // The origin of glTF's textures is the upper left corner.
        let uv = surface.corners.iter().map(|corner| [corner.uv[0], 1.0 - corner.uv[1]]);
        let uv: Vec<f32> = uv.flatten().collect();
        let mut attributes = json!({ "POSITION": self.add_vectors(&start)? });
        attributes["NORMAL"] = self.add_floats(normals.as_flattened(), "VEC3", 3)?.into();
        attributes["TEXCOORD_0"] = self.add_floats(&uv, "VEC2", 2)?.into();
        let shades = body.and_then(|(_, body)| glb_look::pattern(&body.look, surface));
        if let Some(shades) = shades {
            attributes["COLOR_0"] = self.add_floats(&shades, "VEC3", 3)?.into();
        }
        let primitive = |indices: usize, material: usize| {
            json!({
                "attributes": attributes, "indices": indices, "mode": TRIANGLES,
                "material": material,
            })
        };
        let indices = self.add_indices(surface.triangles.as_flattened())?;
        let mut primitives = vec![primitive(indices, material)];
        if let Some(back) = body.and_then(|(_, body)| glb_look::of_back(body)) {
            let turned: Vec<u32> =
                surface.triangles.iter().flat_map(|&[a, b, c]| [a, c, b]).collect();
            let (indices, back) = (self.add_indices(&turned)?, self.add_material(back));
            primitives.push(primitive(indices, back));
        }
        self.push_drawn(name, cover, (start, normals), primitives);
        Ok(())
    }

    fn add_tube(
        &mut self,
        name: &str,
        (rope, radius): (&[u32], f64),
        all: &[DVec3],
        material: usize,
    ) -> io::Result<()> {
        let cover = Cover::Tube { particles: rope.to_vec(), radius };
        let (start, normals) = cover.vertices(all);
        let attributes = json!({
            "POSITION": self.add_vectors(&start)?,
            "NORMAL": self.add_floats(normals.as_flattened(), "VEC3", 3)?,
        });
        let triangles = cover.tube(all).map(|mesh| mesh.triangles).unwrap_or_default();
        let indices = self.add_indices(triangles.as_flattened())?;
        let primitive = json!({
            "attributes": attributes, "indices": indices, "mode": TRIANGLES, "material": material,
        });
        self.push_drawn(name, cover, (start, normals), vec![primitive]);
        Ok(())
    }

    fn add_plain(
        &mut self,
        name: &str,
        particles: Vec<u32>,
        (indices, mode): (&[u32], u32),
        (all, material): (&[DVec3], usize),
    ) -> io::Result<()> {
        let cover = Cover::Surface { particles, triangles: Vec::new() };
        let (start, normals) = cover.vertices(all);
        let attributes = json!({ "POSITION": self.add_vectors(&start)? });
        let primitive = json!({
            "attributes": attributes, "indices": self.add_indices(indices)?, "mode": mode,
            "material": material,
        });
        self.push_drawn(name, cover, (start, normals), vec![primitive]);
        Ok(())
    }

    fn push_drawn(
        &mut self,
        name: &str,
        cover: Cover,
        (start, normals): (Vec<[f32; 3]>, Vec<[f32; 3]>),
        primitives: Vec<Value>,
    ) {
        let (name, targets) = (name.to_owned(), Vec::new());
        self.parts.push(Drawn { name, cover, start, normals, primitives, targets });
    }

    /// Adds solids, each as a node with a mesh about its middle.
    fn add_solids<R: Real>(&mut self, simulation: &Simulation<R>) -> io::Result<()> {
        let snapshot = simulation.snapshot();
        let stone = self.add_material(glb_look::stone());
        for (number, solid) in snapshot.solids.iter().enumerate() {
            let is_flat = solid.shape == Shape::HalfSpace;
            let material = match is_flat {
                true => {
                    let normal = Placed::new(solid, snapshot.time).axes.y_axis;
                    self.add_material(glb_look::of_plane(normal))
                }
                false => stone,
            };
            let primitive = self.add_mesh(&Mesh::of(&solid.shape), material)?;
            let name = format!("solid {number}");
            self.solids.push(Scenery { number, name, primitive, ways: Vec::new(), is_flat });
        }
        Ok(())
    }

    fn add_planes<R: Real>(&mut self, simulation: &Simulation<R>) -> io::Result<()> {
        for plane in simulation.snapshot().planes {
            let (normal, offset) = (plane.normal.to_f64(), plane.offset.to_f64());
            let material = self.add_material(glb_look::of_plane(normal));
            let primitive = self.add_mesh(&Mesh::square(), material)?;
            self.planes.push(Flat { normal, offset, primitive });
        }
        Ok(())
    }

    /// Adds a mesh that keeps its form, as a primitive.
    fn add_mesh(&mut self, mesh: &Mesh, material: usize) -> io::Result<Value> {
        let attributes = json!({
            "POSITION": self.add_vectors(&mesh.places)?,
            "NORMAL": self.add_floats(mesh.normals.as_flattened(), "VEC3", 3)?,
        });
        let indices = self.add_indices(mesh.triangles.as_flattened())?;
        Ok(json!({
            "attributes": attributes, "indices": indices, "mode": TRIANGLES, "material": material,
        }))
    }

    /// The middle of the particles at all moments, and how far a plane reaches around it, metres.
    fn middle_and_reach(&self) -> (DVec3, f64) {
        let [low, high] = self.bounds;
        if !low.cmple(high).all() {
            return (DVec3::ZERO, LEAST);
        }
        (0.5 * (low + high), (0.5 * REACH * (high - low).length()).max(LEAST))
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
        let sampler =
            |output: usize| json!({ "input": input, "output": output, "interpolation": "LINEAR" });
        let channel = |sampler: usize, node: usize, path: &str| {
            let target = json!({ "node": node, "path": path });
            json!({ "sampler": sampler, "target": target })
        };
        let mut samplers = vec![sampler(output)];
        let mut channels: Vec<Value> =
            (0..self.parts.len()).map(|node| channel(0, node, "weights")).collect();
        for row in 0..self.solids.len() {
            let ways = std::mem::take(&mut self.solids[row].ways);
            let node = self.parts.len() + row;
            if ways.iter().any(|way| way.0 != ways[0].0) {
                let places: Vec<f32> = ways.iter().flat_map(|way| way.0).collect();
                channels.push(channel(samplers.len(), node, "translation"));
                samplers.push(sampler(self.add_floats(&places, "VEC3", 3)?));
            }
            if ways.iter().any(|way| way.1 != ways[0].1) {
                let turns: Vec<f32> = ways.iter().flat_map(|way| way.1).collect();
                channels.push(channel(samplers.len(), node, "rotation"));
                samplers.push(sampler(self.add_floats(&turns, "VEC4", 4)?));
            }
            self.solids[row].ways = ways;
        }
        Ok(json!({ "name": "run", "samplers": samplers, "channels": channels }))
    }

    fn document(&mut self) -> io::Result<Value> {
        let is_moving = 1 < self.times.len() && !self.parts.is_empty();
        let animation = is_moving.then(|| self.animation()).transpose()?;
        let (mut meshes, mut nodes) = (Vec::new(), Vec::new());
        let (middle, reach) = self.middle_and_reach();
        for (row, part) in self.parts.iter().enumerate() {
            let mut primitives = part.primitives.clone();
            let mut mesh = json!({ "name": part.name });
            if !part.targets.is_empty() {
                for primitive in &mut primitives {
                    primitive["targets"] = json!(part.targets);
                }
                mesh["weights"] = json!(vec![0.0; part.targets.len()]);
            }
            mesh["primitives"] = json!(primitives);
            meshes.push(mesh);
            nodes.push(json!({ "name": part.name, "mesh": row }));
        }
        for solid in &self.solids {
            let mut node = json!({ "name": solid.name, "mesh": meshes.len() });
            if let Some((place, turn)) = solid.ways.first() {
                (node["translation"], node["rotation"]) = (json!(place), json!(turn));
                if solid.is_flat {
                    let side = DVec3::from(place.map(f64::from)).distance(middle) + reach;
                    node["scale"] = json!([side, 1.0, side]);
                }
            }
            nodes.push(node);
            meshes.push(json!({ "name": solid.name, "primitives": [solid.primitive] }));
        }
        for (row, plane) in self.planes.iter().enumerate() {
            let name = format!("plane {row}");
            nodes.push(plane.node(&name, meshes.len(), (middle, reach)));
            meshes.push(json!({ "name": name, "primitives": [plane.primitive] }));
        }
        let mut document = json!({
            "asset": { "version": "2.0", "generator": "msd" },
            "scene": 0,
            "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
            "nodes": nodes,
            "meshes": meshes,
            "materials": self.materials,
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
        on!(runner, simulation => {
            let snapshot = simulation.snapshot();
            for solid in &mut self.solids {
                let placed = Placed::new(&snapshot.solids[solid.number], snapshot.time);
                let mut turn = DQuat::from_mat3(&placed.axes).as_quat();
                // The shorter way from the turn before.
                let before = solid.ways.last().map_or(turn, |way| Quat::from_array(way.1));
                if turn.dot(before) < 0.0 {
                    turn = -turn;
                }
                solid.ways.push((placed.middle.as_vec3().to_array(), turn.to_array()));
            }
        });
        let all = on!(runner, simulation => places(simulation));
        for place in &all {
            self.bounds = [self.bounds[0].min(*place), self.bounds[1].max(*place)];
        }
        if is_first {
            return Ok(());
        }
        for row in 0..self.parts.len() {
            let part = &self.parts[row];
            let (now, normals) = part.cover.vertices(&all);
            let moved = differences(&now, &part.start);
            let turned = differences(&normals, &part.normals);
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

/// Positions of all particles, metres.
fn places<R: Real>(simulation: &Simulation<R>) -> Vec<DVec3> {
    simulation.positions().map(|position| position.to_f64()).collect()
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
