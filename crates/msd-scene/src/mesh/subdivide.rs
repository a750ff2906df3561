//! Meshes at half their spacing: every triangle cut into four at the middles of its edges.

use crate::mesh::clean::topology::{edges, sides};
use crate::mesh::import::{Mesh, MeshReport};
use crate::mesh::raw::Group;

/// The edges of a mesh by their two vertices, the lower first, in the order in which their middles
/// become vertices.
pub(crate) fn edge_ends(mesh: &Mesh) -> Vec<[u32; 2]> {
    edges(&sides(&mesh.triangles)).map(|edge| edge[0].ends).collect()
}

/// The same surface of four times as many triangles: first the vertices that it had, then the
/// middles of its edges.
pub(crate) fn subdivided(mesh: &Mesh) -> Mesh {
    let ends = edge_ends(mesh);
    let first = mesh.positions.len() as u32;
    let middle = |a: u32, b: u32| {
        let pair = [a.min(b), a.max(b)];
        first + ends.partition_point(|&edge| edge < pair) as u32
    };
    let cut = |&[a, b, c]: &[u32; 3]| {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().flat_map(cut).collect();
    let at = |vertex: u32| mesh.positions[vertex as usize];
    let middles = ends.iter().map(|&[a, b]| 0.5 * (at(a) + at(b)));
    let positions: Vec<_> = mesh.positions.iter().copied().chain(middles).collect();
    let report = MeshReport {
        vertices: positions.len(),
        triangles: triangles.len(),
        open_edges: 2 * mesh.report.open_edges,
        non_manifold_edges: 2 * mesh.report.non_manifold_edges,
        ..mesh.report
    };
    let uvs = mesh.uvs.as_ref().map(|uvs| uvs.iter().flat_map(cut_texture).collect());
    let cut_group = |Group { name, triangles }: &Group| Group {
        name: name.clone(),
        triangles: 4 * triangles.start..4 * triangles.end,
    };
    let groups = mesh.groups.iter().map(cut_group).collect();
    Mesh { name: mesh.name.clone(), positions, uvs, triangles, groups, report }
}

fn cut_texture(&[a, b, c]: &[[f32; 2]; 3]) -> [[[f32; 2]; 3]; 4] {
    let middle = |a: [f32; 2], b: [f32; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}
