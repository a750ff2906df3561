//! Triangles of a picture: surfaces with smooth normals, and their edges.

use crate::math::direction_or;
use crate::picture::colour::{back_colour, body_colour, bytes, lighter, mix};
use crate::picture::geometry::{Geometry, Line, SurfaceVertex};
use crate::viewing::view::View;
use glam::Vec3;
use msd_core::{Body, Pattern, Real, Snapshot};

/// Colour of edges on a surface.
const EDGE: [f32; 3] = [0.07, 0.10, 0.16];
/// Colours of surfaces below springs whose colours stand for a quantity. These stand for nothing,
/// and differ from all of a scale with grey in its middle, and of one that begins dark.
const BELOW: [[f32; 3]; 2] = [[0.24, 0.25, 0.28], [0.90, 0.90, 0.88]];
/// Edges win against the surface they lie on: 0.2 % of the distance is more than its rounding.
const EDGE_BIAS: f32 = 0.002;

/// Adds the surface of every body, without triangles that touch a broken position or lie along a
/// spring that was cut.
pub(crate) fn add_surfaces<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    limit: u64,
) {
    let most_vertices = limit as usize / size_of::<SurfaceVertex>();
    let most_triangles = limit as usize / size_of::<[u32; 3]>();
    let mut normals = Normals::default();
    normals.particles.resize(geometry.positions.len(), Vec3::ZERO);
    normals.bends.resize(geometry.positions.len(), [0.0; 2]);
    let mut sizes = std::mem::take(&mut geometry.sizes);
    let cuts = cut_pairs(snapshot);
    for (index, body) in snapshot.bodies.iter().enumerate() {
        let vertices = geometry.vertices.len() + body.surface.corners.len();
        let triangles = geometry.triangles.len() + body.surface.triangles.len();
        if most_vertices < vertices || most_triangles < triangles {
            log::warn!("surface of body {} does not fit into a buffer: left out", body.name);
            continue;
        }
        let first = geometry.triangles.len();
        add_triangles(geometry, body, &cuts, &mut normals);
        normals.add_bends(geometry, first, body);
        if first < geometry.triangles.len() {
            let repeats = sizes.repeats((index, body), snapshot);
            add_vertices(geometry, (index, body), repeats, &mut normals);
        }
    }
    geometry.sizes = sizes;
}

/// Twice the area vectors of triangles, summed: large triangles count more, degenerate ones not at
/// all.
#[derive(Default)]
struct Normals {
    /// Those of the triangles at a particle.
    particles: Vec<Vec3>,
    /// Those at a corner of a body: of a block these are of one of its sides.
    corners: Vec<Vec3>,
    /// Over the neighbours of a particle with normal n, at d from it: Σ n·d and Σ |d|², whose ratio
    /// is half the mean curvature there.
    bends: Vec<[f32; 2]>,
}

/// The cosines of the angle between the two, from which on a corner belongs to an edge and up to
/// which it does not: at an edge of a block it is 45°.
const EDGE_ANGLES: [f32; 2] = [0.82, 0.93];

impl Normals {
    /// The normal at a corner: that of all that meets there, unless it is an edge.
    fn at(&self, corner: usize, particle: u32) -> Vec3 {
        let all = self.particles.get(particle as usize).copied().unwrap_or_default();
        let all = direction_or(all, Vec3::Y);
        let own = direction_or(self.corners[corner], all);
        let [edge, smooth] = EDGE_ANGLES;
        let share = ((own.dot(all) - edge) / (smooth - edge)).clamp(0.0, 1.0);
        direction_or(own + (all - own) * share, Vec3::Y)
    }

    /// Adds how a body bends, whose triangles are those from `first` on, and gives the normals of
    /// its particles length one.
    fn add_bends(&mut self, geometry: &Geometry, first: usize, body: &Body) {
        let corners = &body.surface.corners;
        for corner in corners {
            if let Some(normal) = self.particles.get_mut(corner.particle as usize) {
                *normal = direction_or(*normal, Vec3::ZERO);
            }
        }
        let before = geometry.vertices.len() as u32;
        for triangle in &geometry.triangles[first..] {
            let [a, b, c] =
                triangle.map(|corner| corners[(corner - before) as usize].particle as usize);
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let along = geometry.positions[to] - geometry.positions[from];
                for (end, along) in [(from, along), (to, -along)] {
                    self.bends[end][0] += self.particles[end].dot(along);
                    self.bends[end][1] += along.length_squared();
                }
            }
        }
    }

    /// Concavity of a body of a size at a particle: from -1, an edge, over 0, flat, to 1, a valley
    /// with a mean curvature of 25 over the size.
    fn hollow(&self, particle: u32, size: f32) -> f32 {
        let [height, square] = self.bends.get(particle as usize).copied().unwrap_or_default();
        let curvature = 2.0 * height / square.max(f32::MIN_POSITIVE);
        (curvature * size / 25.0).clamp(-1.0, 1.0)
    }
}

/// Adds the triangles of a body, and their area vectors to the normals.
fn add_triangles(geometry: &mut Geometry, body: &Body, cuts: &[[u32; 2]], normals: &mut Normals) {
    let first = geometry.vertices.len() as u32;
    normals.corners.clear();
    normals.corners.resize(body.surface.corners.len(), Vec3::ZERO);
    for triangle in &body.surface.triangles {
        let Some(particles) = body.surface.particles_of(*triangle) else { continue };
        if sides(particles).iter().any(|side| is_cut(cuts, *side)) {
            continue;
        }
        let [Some(a), Some(b), Some(c)] = particles.map(|p| geometry.drawable(p)) else { continue };
        let area = (b - a).cross(c - a);
        for (particle, corner) in particles.into_iter().zip(*triangle) {
            normals.particles[particle as usize] += area;
            normals.corners[corner as usize] += area;
        }
        geometry.triangles.push(triangle.map(|corner| corner + first));
    }
}

/// Adds the corners of a body as vertices and clears the normals it used.
fn add_vertices(
    geometry: &mut Geometry,
    (index, body): (usize, &Body),
    repeats: &[[f32; 2]],
    normals: &mut Normals,
) {
    let look = &body.look;
    let of_springs = geometry.scale.filter(|scale| scale.quantity.is_of_springs());
    let (own, back) = match of_springs {
        Some(scale) => {
            let below = BELOW[usize::from(!scale.quantity.is_signed())];
            (below, lighter(below))
        }
        None => (body_colour(index, body), back_colour(index, body)),
    };
    let metal = if look.metal { 1.0 } else { 0.0 };
    // Six times the area: each triangle has twice its own at three corners.
    let size = (normals.corners.iter().map(|area| area.length()).sum::<f32>() / 6.0).sqrt();
    for (number, corner) in body.surface.corners.iter().enumerate() {
        let shade = geometry.shade(corner.particle);
        let is_sheet = if body.surface.two_sided && shade.is_none() { 1.0 } else { 0.0 };
        let repeats = repeats.get(number).copied().unwrap_or([1.0; 2]);
        let [red, green, blue, _] = bytes(back, 1.0);
        geometry.vertices.push(SurfaceVertex {
            position: geometry.drawable(corner.particle).unwrap_or_default(),
            normal: normals.at(number, corner.particle),
            uv: [0, 1].map(|axis| corner.uv[axis] * repeats[axis]),
            colour: bytes(shade.unwrap_or(own), 0.5 + 0.5 * normals.hollow(corner.particle, size)),
            back: [red, green, blue, number_of(look.pattern)],
            finish: bytes([look.roughness, metal, look.translucency], is_sheet),
        });
    }
    for corner in &body.surface.corners {
        let particle = corner.particle as usize;
        if particle < normals.particles.len() {
            normals.particles[particle] = Vec3::ZERO;
            normals.bends[particle] = [0.0; 2];
        }
    }
}

/// The number by which `surface.wgsl` knows a pattern.
fn number_of(pattern: Pattern) -> u8 {
    match pattern {
        Pattern::None => 0,
        Pattern::Checks => 1,
        Pattern::Stripes => 2,
        Pattern::Weave => 3,
        Pattern::Grain => 4,
    }
}

/// The sides of a triangle as pairs of particles, the lower number first.
fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)])
}

/// The pairs of particles whose spring was cut, the lower number first, in order.
fn cut_pairs<R: Real>(snapshot: &Snapshot<'_, R>) -> Vec<[u32; 2]> {
    let springs = snapshot.ends.iter().enumerate();
    let cut = springs.filter(|&(spring, _)| snapshot.is_cut(spring));
    let mut pairs: Vec<_> = cut.map(|(_, &[a, b])| [a.min(b), a.max(b)]).collect();
    pairs.sort_unstable();
    pairs
}

fn is_cut(cuts: &[[u32; 2]], pair: [u32; 2]) -> bool {
    cuts.binary_search(&pair).is_ok()
}

/// Adds every edge of a surface triangle once: dark on surfaces, in the body's colour without.
pub(crate) fn add_wireframe<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    view: &View,
) {
    let cuts = cut_pairs(snapshot);
    for (index, body) in snapshot.bodies.iter().enumerate() {
        let opacity = if view.style.surfaces { 0.6 } else { 1.0 };
        let own = mix(body_colour(index, body), EDGE, 0.25);
        let colour = bytes(if view.style.surfaces { EDGE } else { own }, opacity);
        for [a, b] in edges(body).into_iter().filter(|edge| !is_cut(&cuts, *edge)) {
            let (Some(a), Some(b)) = (geometry.drawable(a), geometry.drawable(b)) else { continue };
            let width = view.style.line_pixels();
            geometry.lines.push(Line { a, width, b, bias: EDGE_BIAS, colour, radius: 0.0 });
        }
    }
}

/// The edges of a surface as pairs of particles, each once whatever its direction.
fn edges(body: &Body) -> Vec<[u32; 2]> {
    let mut edges: Vec<_> = body.surface.particles().flat_map(sides).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::{Interaction, Material, Scene, Settings, Simulation, Vector, shape};

    #[test]
    fn a_surface_opens_along_springs_that_were_cut_and_nowhere_else() {
        let part = shape::cloth([3, 3], 1.0, Material::default()).expect("a valid size");
        let scene = Scene::of("cloth", part);
        let mut cloth = Simulation::<f32>::new(&scene, Settings::default()).expect("a valid scene");
        let drawn = |cloth: &Simulation<f32>| {
            let mut geometry = Geometry::default();
            let snapshot = cloth.snapshot();
            geometry.positions.extend(snapshot.positions().map(|position| position.to_f32()));
            add_surfaces(&mut geometry, &snapshot, u64::MAX);
            let corners = &snapshot.bodies[0].surface.corners;
            let particles = |corner: u32| corners[corner as usize].particle;
            let triangles = geometry.triangles.iter();
            triangles.map(|triangle| triangle.map(particles)).collect::<Vec<_>>()
        };
        let whole = drawn(&cloth);
        let spring = (0..scene.springs.len()).find(|&spring| {
            let [a, b] = scene.springs[spring].ends.map(|end| end as u32);
            whole.iter().filter(|triangle| triangle.contains(&a) && triangle.contains(&b)).count()
                == 2
        });
        let spring = spring.expect("an edge between two triangles");
        cloth.queue(Interaction::Cut { spring }).expect("a spring");
        cloth.apply_queued().expect("it can be cut");
        let [a, b] = scene.springs[spring].ends.map(|end| end as u32);
        let is_apart = |triangle: &&[u32; 3]| !(triangle.contains(&a) && triangle.contains(&b));
        let left: Vec<[u32; 3]> = whole.iter().filter(is_apart).copied().collect();
        assert_eq!((whole.len() - left.len(), drawn(&cloth)), (2, left));
    }

    /// A sheet of 8 m by 8 m around a cylinder, whose mean curvature is 1 / 2r: 0.08 times
    /// 25 / 8 m. Its area by the sums at corners is off by 3 %, less than a step of a byte.
    #[test]
    fn the_inside_of_a_bent_sheet_is_as_hollow_as_its_outside_is_not() {
        let radius = 2.0_f64;
        let part = shape::cloth([9, 9], 1.0, Material::default()).expect("a valid size");
        for turn in [1.0, -1.0] {
            let mut scene = Scene::of("cloth", part.clone());
            // Chords of 1 m, as long as the cells are high: n·d is |d|² / 2r around, 0 along.
            let angle = 2.0 * (0.5 / radius).asin();
            for particle in &mut scene.particles {
                let at = &mut particle.position;
                let (sin, cos) = (at.x * angle).sin_cos();
                (at.x, at.z) = (radius * sin, radius * turn * (1.0 - cos));
            }
            let cloth = Simulation::<f32>::new(&scene, Settings::default()).expect("a valid scene");
            let snapshot = cloth.snapshot();
            let mut geometry = Geometry::default();
            geometry.positions.extend(snapshot.positions().map(|position| position.to_f32()));
            add_surfaces(&mut geometry, &snapshot, u64::MAX);
            let middle = geometry.vertices.iter().find(|vertex| vertex.position.length() < 1e-3);
            let middle = middle.expect("a particle in the middle");
            // The axis is on the side that the middle bends to.
            let is_inside = 0.0 < f64::from(middle.normal.z) * turn;
            let [inside, outside] = [0.54, 0.46].map(|share: f32| (share * 255.0).round() as u8);
            assert_eq!(middle.colour[3], if is_inside { inside } else { outside });
        }
    }
}
