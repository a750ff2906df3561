//! Bodies with shells: blocks, and cloths.

use msd_core::glam::{DVec3, dvec3};
use msd_core::{Particle, Scene, Shell, Spring};
use std::collections::BTreeMap;

/// Stiffness and weight of a body.
#[derive(Clone, Copy)]
pub struct Stuff {
    /// Young's modulus, pascals.
    pub young: f64,
    /// Density, kilograms per cubic metre.
    pub density: f64,
    /// Damping of a spring by its stiffness, seconds.
    pub damping: f64,
}

/// Adds a block of cubic cells and its surface, and returns its particles.
pub fn add_block(
    scene: &mut Scene,
    [nx, ny, nz]: [usize; 3],
    (spacing, corner): (f64, DVec3),
    stuff: Stuff,
    shell: Shell,
) -> std::ops::Range<usize> {
    let first = scene.particles.len();
    let id = |x: usize, y: usize, z: usize| first + (x * ny + y) * nz + z;
    for x in 0..nx {
        for y in 0..ny {
            for z in 0..nz {
                let position = corner + dvec3(x as f64, y as f64, z as f64) * spacing;
                scene.particles.push(Particle { position, velocity: DVec3::ZERO, mass: 0.0 });
            }
        }
    }
    let stiffness = 0.4 * stuff.young * spacing;
    let mut springs = BTreeMap::new();
    for x in 0..nx - 1 {
        for y in 0..ny - 1 {
            for z in 0..nz - 1 {
                let corner = |c: usize| id(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2 & 1));
                for a in 0..8usize {
                    scene.particles[corner(a)].mass += stuff.density * spacing.powi(3) / 8.0;
                    for b in a + 1..8 {
                        let part = match (a ^ b).count_ones() {
                            1 => 0.25,
                            2 => 0.5,
                            _ => continue,
                        };
                        *springs.entry([corner(a), corner(b)]).or_insert(0.0) += part * stiffness;
                    }
                }
            }
        }
    }
    add_springs(scene, springs, stuff.damping);
    let mut triangles = Vec::new();
    let mut side = |corners: [usize; 4], turned: bool| {
        let [a, b, c, d] = corners;
        let [b, d] = if turned { [b, d] } else { [d, b] };
        triangles.extend([[a, b, c], [a, c, d]]);
    };
    for x in 0..nx - 1 {
        for y in 0..ny - 1 {
            for (z, turned) in [(0, false), (nz - 1, true)] {
                side([id(x, y, z), id(x + 1, y, z), id(x + 1, y + 1, z), id(x, y + 1, z)], turned);
            }
        }
    }
    for x in 0..nx - 1 {
        for z in 0..nz - 1 {
            for (y, turned) in [(0, true), (ny - 1, false)] {
                side([id(x, y, z), id(x + 1, y, z), id(x + 1, y, z + 1), id(x, y, z + 1)], turned);
            }
        }
    }
    for y in 0..ny - 1 {
        for z in 0..nz - 1 {
            for (x, turned) in [(0, false), (nx - 1, true)] {
                side([id(x, y, z), id(x, y + 1, z), id(x, y + 1, z + 1), id(x, y, z + 1)], turned);
            }
        }
    }
    scene.shells.push(Shell { triangles, ..shell });
    first..scene.particles.len()
}

/// Adds a cloth of some particles along two directions, and returns its particles.
pub fn add_cloth(
    scene: &mut Scene,
    [nu, nv]: [usize; 2],
    [corner, along, across]: [DVec3; 3],
    (mass, stiffness): (f64, f64),
    shell: Shell,
) -> std::ops::Range<usize> {
    let first = scene.particles.len();
    let id = |u: usize, v: usize| first + u * nv + v;
    let (mut springs, mut triangles) = (BTreeMap::new(), Vec::new());
    for u in 0..nu {
        for v in 0..nv {
            let position = corner + along * u as f64 + across * v as f64;
            scene.particles.push(Particle { position, velocity: DVec3::ZERO, mass });
            let mut join = |to: [usize; 2], part: f64, from: [usize; 2]| {
                if to[0] < nu && to[1] < nv {
                    springs.insert([id(from[0], from[1]), id(to[0], to[1])], part * stiffness);
                }
            };
            join([u + 1, v], 1.0, [u, v]);
            join([u, v + 1], 1.0, [u, v]);
            join([u + 1, v + 1], 0.5, [u, v]);
            if u + 1 < nu {
                join([u, v + 1], 0.5, [u + 1, v]);
            }
            join([u + 2, v], 0.05, [u, v]);
            join([u, v + 2], 0.05, [u, v]);
            if u + 1 < nu && v + 1 < nv {
                let [a, b, c, d] = [id(u, v), id(u + 1, v), id(u + 1, v + 1), id(u, v + 1)];
                let halves =
                    if (u + v) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                triangles.extend(halves);
            }
        }
    }
    add_springs(scene, springs, 1e-3);
    scene.shells.push(Shell { triangles, ..shell });
    first..scene.particles.len()
}

fn add_springs(scene: &mut Scene, springs: BTreeMap<[usize; 2], f64>, damping: f64) {
    for (ends, stiffness) in springs {
        let [a, b] = ends.map(|end| scene.particles[end].position);
        let rest_length = (b - a).length();
        scene.springs.push(Spring { ends, rest_length, stiffness, damping: damping * stiffness });
    }
}
