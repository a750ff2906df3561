//! Looks of bodies and solids in glTF: materials, colours of vertices, and solids as meshes.

use msd_core::glam::DVec3;
use msd_core::{Body, Look, Pattern, Real, Shape, Shell, Snapshot, Surface, Vector};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Colour of a solid, sRGB, and its roughness.
const STONE: ([f32; 3], f32) = ([0.68, 0.675, 0.66], 0.85);
/// Colours of a floor and of other planes, in proportion to light: those of pictures.
const FLOOR: [f32; 3] = [0.58, 0.575, 0.56];
const WALL: [f32; 3] = [0.72, 0.71, 0.69];
/// A plane whose normal has this part upwards is a floor.
const LEVEL: f64 = 0.95;
/// Brightness of the second colour of a pattern, relative to the first.
const DARKER: f32 = 0.72;
/// The radius of a rope that does not touch, as a part of its spacing.
const THIN: f64 = 0.15;
/// Steps around an axis, and of a half circle along it.
const AROUND: u32 = 32;
const HALF: u32 = 12;

/// A component of a colour as glTF has it: in proportion to light.
fn linear(part: f32) -> f32 {
    if part <= 0.04045 { part / 12.92 } else { libm::powf((part + 0.055) / 1.055, 2.4) }
}

fn material(name: &str, colour: [f32; 3], look: &Look, is_two_sided: bool) -> Value {
    let [red, green, blue] = colour.map(linear);
    let mut material = json!({
        "name": name,
        "doubleSided": is_two_sided,
        "pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, 1.0 - look.translucency],
            "metallicFactor": if look.metal { 1.0 } else { 0.0 },
            "roughnessFactor": look.roughness,
        },
    });
    if 0.0 < look.translucency {
        material["alphaMode"] = "BLEND".into();
    }
    material
}

/// The colour of a body, sRGB: its own, or one by its kind and its place among the bodies.
pub fn colour(number: usize, body: &Body) -> [f32; 3] {
    body.look.colour_at(number, &body.surface)
}

/// The material of a body. One with another colour on its back is for its front alone.
pub fn of_body(number: usize, body: &Body) -> Value {
    let is_two_sided = body.surface.two_sided && body.look.back.is_none();
    material(&body.name, colour(number, body), &body.look, is_two_sided)
}

/// The material of the other side of a sheet, if that has a colour of its own.
pub fn of_back(body: &Body) -> Option<Value> {
    let back = body.look.back.filter(|_| body.surface.two_sided)?;
    Some(material(&format!("{}, back", body.name), back, &body.look, false))
}

/// The material of solids, and of particles and springs that belong to no body.
pub fn stone() -> Value {
    let look = Look { roughness: STONE.1, ..Look::default() };
    material("stone", STONE.0, &look, false)
}

/// The material of a plane with this normal. It is seen from its front alone, as a wall from behind
/// would hide the scene.
pub fn of_plane(normal: DVec3) -> Value {
    let (name, [red, green, blue]) =
        if LEVEL < normal.y { ("floor", FLOOR) } else { ("wall", WALL) };
    json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        },
    })
}

/// The colours of the corners of a surface with a pattern, factors of that of its body; nothing
/// without a pattern. Between corners they are mixed, so a pattern finer than triangles is lost.
pub fn pattern(look: &Look, surface: &Surface) -> Option<Vec<f32>> {
    // Where no count is given, eight times along the surface.
    let odd = |part: f32| (part * 8.0).floor().rem_euclid(2.0) == 1.0;
    let is_dark = |[u, v]: [f32; 2]| match look.pattern {
        Pattern::None => false,
        Pattern::Checks | Pattern::Weave => odd(u) != odd(v),
        Pattern::Stripes => odd(u),
        Pattern::Grain => odd(v),
    };
    let shade = |uv| if is_dark(uv) { DARKER } else { 1.0 };
    let shades = || surface.corners.iter().flat_map(|corner| [shade(corner.uv); 3]);
    (look.pattern != Pattern::None).then(|| shades().collect())
}

/// The lines of particles that the springs of a body are; nothing where they are another net.
pub fn ropes(lines: &[[u32; 2]]) -> Option<Vec<Vec<u32>>> {
    let mut starts: Vec<u32> = lines.iter().map(|[a, b]| *a.min(b)).collect();
    let is_along = lines.iter().all(|[a, b]| a.abs_diff(*b) == 1);
    starts.sort_unstable();
    starts.dedup();
    let mut ropes: Vec<Vec<u32>> = Vec::new();
    for start in starts {
        match ropes.last_mut().filter(|rope| rope.last() == Some(&start)) {
            Some(rope) => rope.push(start + 1),
            None => ropes.push(vec![start, start + 1]),
        }
    }
    is_along.then_some(ropes)
}

/// The radius of a rope, metres: its thickness where it meets others, or a part of its spacing.
pub fn radius<R: Real>(snapshot: &Snapshot<'_, R>, rope: &[u32]) -> f64 {
    let is_of = |shell: &&Shell| shell.particles().any(|particle| particle == rope[0] as usize);
    let shell = snapshot.shells.iter().find(is_of);
    let place = |row: &u32| snapshot.position(*row as usize).to_f64();
    let lengths = rope.windows(2).map(|pair| (place(&pair[1]) - place(&pair[0])).length());
    let spacing = lengths.sum::<f64>() / (rope.len() - 1) as f64;
    shell.map_or(THIN * spacing, |shell| shell.thickness)
}

/// Corners with their normals, and triangles, counter-clockwise seen from outside.
#[derive(Debug, Default)]
pub struct Mesh {
    /// Places, metres.
    pub places: Vec<[f32; 3]>,
    /// Normals, length one.
    pub normals: Vec<[f32; 3]>,
    /// Three corners each.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The surface of a solid, as seen from its middle; of a half space a square of it with sides
    /// of 2 m.
    pub fn of(shape: &Shape) -> Self {
        let mut mesh = Mesh::default();
        match *shape {
            Shape::Sphere { radius } => {
                mesh.revolve(&arc([0.0, 0.0], radius, -FRAC_PI_2, FRAC_PI_2))
            }
            Shape::Capsule { radius, length } => {
                let mut line = arc([0.0, -0.5 * length], radius, -FRAC_PI_2, 0.0);
                line.extend(arc([0.0, 0.5 * length], radius, 0.0, FRAC_PI_2));
                mesh.revolve(&line);
            }
            Shape::Cylinder { radius, length } => {
                let half = 0.5 * length;
                mesh.revolve(&[[0.0, -half, 0.0, -1.0], [radius, -half, 0.0, -1.0]]);
                mesh.revolve(&[[radius, -half, 1.0, 0.0], [radius, half, 1.0, 0.0]]);
                mesh.revolve(&[[radius, half, 0.0, 1.0], [0.0, half, 0.0, 1.0]]);
            }
            Shape::Torus { radius, tube } => mesh.revolve(&arc([radius, 0.0], tube, -PI, PI)),
            Shape::Box { size } => mesh.add_box(0.5 * size),
            Shape::Mesh(ref grid) => {
                for triangle in &grid.triangles {
                    let corners = triangle.map(|corner| grid.corners[corner as usize]);
                    let [a, b, c] = corners;
                    let normal = (b - a).cross(c - a).normalize_or(DVec3::Y);
                    let [a, b, c] = corners.map(|corner| mesh.push(corner, normal));
                    mesh.triangles.push([a, b, c]);
                }
            }
            Shape::HalfSpace => return Mesh::square(),
        }
        mesh
    }

    /// A square that faces up, with sides of 2 m about its middle.
    pub fn square() -> Self {
        let mut mesh = Mesh::default();
        for [x, z] in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
            mesh.push(DVec3::new(x, 0.0, z), DVec3::Y);
        }
        mesh.triangles.extend([[0, 1, 2], [2, 1, 3]]);
        mesh
    }

    /// A tube around a line of points, which it goes around with so many corners.
    pub fn tube(points: &[DVec3], radius: f64, around: u32) -> Self {
        let mut mesh = Mesh::default();
        let mut side = DVec3::ZERO;
        for (row, &point) in points.iter().enumerate() {
            let before = points[row.saturating_sub(1)];
            let after = points[(row + 1).min(points.len() - 1)];
            let along = (after - before).normalize_or(DVec3::Y);
            // The side of the ring before, turned as little as the line turns.
            let kept = side - along * side.dot(along);
            side = kept.try_normalize().unwrap_or_else(|| along.any_orthonormal_vector());
            let other = along.cross(side);
            for turn in 0..around {
                let (sine, cosine) = libm::sincos(TAU * f64::from(turn) / f64::from(around));
                let normal = side * cosine + other * sine;
                mesh.push(point + normal * radius, normal);
            }
        }
        for ring in 1..points.len() as u32 {
            for turn in 0..around {
                let at = |ring: u32, turn: u32| ring * around + turn % around;
                let [a, b] = [at(ring - 1, turn), at(ring - 1, turn + 1)];
                let [c, d] = [at(ring, turn), at(ring, turn + 1)];
                mesh.triangles.extend([[a, b, c], [c, b, d]]);
            }
        }
        mesh
    }

    fn push(&mut self, place: DVec3, normal: DVec3) -> u32 {
        self.places.push(place.as_vec3().to_array());
        self.normals.push(normal.as_vec3().to_array());
        self.places.len() as u32 - 1
    }

    /// Adds the surface of revolution of a line about y: each point of the line has a distance from
    /// the axis and a height, and its normal has the same two components.
    fn revolve(&mut self, line: &[[f64; 4]]) {
        let (first, along) = (self.places.len() as u32, line.len() as u32);
        for turn in 0..=AROUND {
            let (sine, cosine) = libm::sincos(TAU * f64::from(turn % AROUND) / f64::from(AROUND));
            for &[away, height, out, up] in line {
                let place = DVec3::new(away * cosine, height, away * sine);
                self.push(place, DVec3::new(out * cosine, up, out * sine));
            }
        }
        for turn in 0..AROUND {
            for step in 0..along - 1 {
                let [a, b] = [turn, turn + 1].map(|turn| first + turn * along + step);
                self.triangles.extend([[a, a + 1, b], [b, a + 1, b + 1]]);
            }
        }
    }

    fn add_box(&mut self, half: DVec3) {
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let [normal, u, v] = [0, 1, 2].map(|turn| DVec3::AXES[(axis + turn) % 3]);
                let corners = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
                let [a, b, c, d] = corners.map(|[s, t]| {
                    self.push(half * (normal * side + u * (s * side) + v * t), normal * side)
                });
                self.triangles.extend([[a, b, c], [c, b, d]]);
            }
        }
    }
}

fn arc(middle: [f64; 2], radius: f64, from: f64, to: f64) -> Vec<[f64; 4]> {
    let point = |part: u32| {
        let (sine, cosine) = libm::sincos(from + (to - from) * f64::from(part) / f64::from(HALF));
        [middle[0] + radius * cosine, middle[1] + radius * sine, cosine, sine]
    };
    (0..=HALF).map(point).collect()
}
