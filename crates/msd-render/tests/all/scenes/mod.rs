//! Scenes that the tests draw, built by hand so that they need only the description of the core,
//! and the device that draws them.

use glam::DVec3;
use msd_core::{
    Corner, Friction, Part, Particle, Pin, Plane, Real, Scene, Settings, Simulation, Snapshot,
    Spring, Surface, Vector,
};
use msd_render::Gpu;

/// An unchanged scene: planes do not move it.
pub struct Still<R: Real> {
    simulation: Simulation<R>,
    pub positions: Vec<R::Vec3>,
}

impl<R: Real> Still<R> {
    pub fn new(scene: &Scene) -> Self {
        let simulation = Simulation::new(scene, Settings::default()).unwrap();
        let position = |particle: &Particle| R::Vec3::of(particle.position);
        Still { simulation, positions: scene.particles.iter().map(position).collect() }
    }

    pub fn snapshot(&self) -> Snapshot<'_, R> {
        self.simulation.snapshot().with_positions(&self.positions)
    }
}

/// A particle at rest of 1 kg.
pub fn particle(x: f64, y: f64, z: f64) -> Particle {
    Particle { position: DVec3::new(x, y, z), velocity: DVec3::ZERO, mass: 1.0 }
}

/// A spring of a rest length.
pub fn spring(a: usize, b: usize, rest_length: f64) -> Spring {
    Spring { ends: [a, b], rest_length, stiffness: 1000.0, damping: 1.0 }
}

/// A horizontal plane at a height.
pub fn floor(height: f64) -> Plane {
    plane(DVec3::Y, height)
}

/// A plane.
pub fn plane(normal: DVec3, offset: f64) -> Plane {
    Plane { normal, offset, restitution: 0.0, friction: Friction::Coulomb(0.5) }
}

/// A surface whose corner `i` is particle `i`.
pub fn surface(uvs: &[[f32; 2]], triangles: Vec<[u32; 3]>, two_sided: bool) -> Surface {
    let corner = |(particle, &uv): (usize, &[f32; 2])| Corner { particle: particle as u32, uv };
    Surface { corners: uvs.iter().enumerate().map(corner).collect(), triangles, two_sided }
}

/// A horizontal square sheet of `n` by `n` particles around the origin, at y = 0.
pub fn sheet(n: usize, side: f64) -> Part {
    let mut part = Part::default();
    let mut uvs = Vec::new();
    let step = side / (n - 1) as f64;
    for row in 0..n {
        for column in 0..n {
            let at = |index: usize| index as f64 * step - 0.5 * side;
            part.particles.push(particle(at(column), 0.0, at(row)));
            uvs.push([column as f32, row as f32].map(|index| index / (n - 1) as f32));
        }
    }
    let mut triangles = Vec::new();
    for row in 0..n {
        for column in 0..n {
            let here = row * n + column;
            if column + 1 < n {
                part.springs.push(spring(here, here + 1, step));
            }
            if row + 1 < n {
                part.springs.push(spring(here, here + n, step));
            }
            if row + 1 < n && column + 1 < n {
                let corners = [here, here + n, here + 1, here + n + 1].map(|index| index as u32);
                let [a, b, c, d] = corners;
                triangles.extend([[a, b, c], [c, b, d]]);
            }
        }
    }
    part.surface = surface(&uvs, triangles, true);
    part
}

/// A solid block of `n` particles a side with 1 m spacing and six textured sides.
pub fn block(n: usize) -> Part {
    let mut part = Part::default();
    let half = 0.5 * (n - 1) as f64;
    let index = |[x, y, z]: [usize; 3]| (z * n + y) * n + x;
    for cell in 0..n * n * n {
        let at = |index: usize| index as f64 - half;
        part.particles.push(particle(at(cell % n), at(cell / n % n), at(cell / n / n)));
    }
    for cell in 0..n * n * n {
        let place = [cell % n, cell / n % n, cell / n / n];
        for axis in 0..3 {
            if place[axis] + 1 < n {
                let mut next = place;
                next[axis] += 1;
                part.springs.push(spring(cell, index(next), 1.0));
            }
        }
    }
    for side in 0..6 {
        add_side(&mut part.surface, n, side, &index);
    }
    part
}

fn add_side(surface: &mut Surface, n: usize, side: usize, index: &impl Fn([usize; 3]) -> usize) {
    let (axis, level) = (side / 2, side % 2 * (n - 1));
    let first = surface.corners.len() as u32;
    for row in 0..n {
        for column in 0..n {
            let mut place = [0; 3];
            place[axis] = level;
            place[(axis + 1) % 3] = column;
            place[(axis + 2) % 3] = row;
            let uv = [column as f32, row as f32].map(|index| index / (n - 1) as f32);
            surface.corners.push(Corner { particle: index(place) as u32, uv });
        }
    }
    for row in 0..n - 1 {
        for column in 0..n - 1 {
            let a = first + (row * n + column) as u32;
            let [b, c, d] = [a + 1, a + n as u32, a + n as u32 + 1];
            // The axes turn cyclically, so the upper side has u x v along the outward axis.
            let outward = [[a, b, d], [a, d, c]];
            let inward = [[a, d, b], [a, c, d]];
            surface.triangles.extend(if level == 0 { inward } else { outward });
        }
    }
}

/// A rope of `n` particles along x with a sag, its first particle pinned by the caller.
pub fn rope(n: usize, spacing: f64) -> Part {
    let mut part = Part::default();
    for index in 0..n {
        let t = index as f64 / (n - 1) as f64;
        let x = (index as f64 - 0.5 * (n - 1) as f64) * spacing;
        part.particles.push(particle(x, -4.0 * (t - t * t) * spacing * n as f64 * 0.2, 0.0));
        if 0 < index {
            part.springs.push(spring(index - 1, index, spacing));
        }
    }
    part
}

/// A pin that holds a particle still.
pub fn pin(particle: usize) -> Pin {
    Pin { particle, velocity: DVec3::ZERO }
}

/// A scene with one body.
pub fn scene_of(part: Part, planes: &[Plane]) -> Scene {
    let mut scene = Scene { planes: planes.to_vec(), ..Scene::default() };
    scene.add("body", part);
    scene
}

/// A device, or nothing and a loud line; nothing will not do where CI has installed a driver.
pub fn gpu() -> Option<Gpu> {
    match pollster::block_on(Gpu::headless()) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "no adapter: {error}");
            eprintln!("SKIPPED: no adapter: {error}");
            None
        }
    }
}
