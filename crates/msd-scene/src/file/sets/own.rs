//! Sets that a body has of its own: by the sides of a lattice, by the names in a mesh file.

use crate::mesh::{Group, Mesh};
use msd_core::{Lattice, Surface};
use std::collections::BTreeMap;

/// The names of sets beside those of sides.
pub(crate) const SHAPES: [&str; 6] = ["all", "first", "last", "corners", "edges", "surface"];

/// Where the sets come from that a body has of its own.
pub(crate) enum OwnSets {
    /// The sides of a lattice.
    Lattice(Lattice),
    /// The names in the file of a mesh.
    Groups(Groups),
}

/// The particles of each name, counted in the body, ascending.
pub(crate) type Groups = BTreeMap<String, Vec<usize>>;

/// The particles of each name in the file of a mesh, by the surface of its body, whose first
/// particle is `first`. Each triangle of the mesh may be cut into as many as any other there.
pub(crate) fn groups(mesh: &Mesh, surface: &Surface, first: usize) -> Groups {
    let mut groups = Groups::new();
    if mesh.groups.is_empty() {
        return groups;
    }
    let all: Vec<[u32; 3]> = surface.particles().collect();
    let parts = all.len() / mesh.triangles.len().max(1);
    let own = mesh.groups.iter().filter(|group| !SHAPES.contains(&group.name.as_str()));
    for Group { name, triangles } in own {
        let triangles = &all[parts * triangles.start..parts * triangles.end];
        let particles = triangles.as_flattened().iter().map(|&particle| particle as usize - first);
        groups.entry(name.clone()).or_default().extend(particles);
    }
    for particles in groups.values_mut() {
        particles.sort_unstable();
        particles.dedup();
    }
    groups
}
