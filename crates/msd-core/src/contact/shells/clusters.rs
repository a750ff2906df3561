//! Clusters: a few vertices that edges join, with the features that begin at them.

use super::features::{Edge, NONE, Shells};
use alloc::vec::Vec;

/// The most vertices of a cluster: few enough that they move alike, and enough that looking at
/// clusters costs less than looking at features.
const MOST: usize = 16;

/// A few vertices of a shell. A face and an edge belong to the cluster of their first vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Cluster {
    pub(super) vertices: Vec<u32>,
    pub(super) faces: Vec<u32>,
    pub(super) edges: Vec<u32>,
    /// Those of its edges that have no face beside them.
    pub(super) bare: Vec<u32>,
    /// The vertices of its features, in order.
    pub(super) corners: Vec<u32>,
    /// Those and the ones that edges join to them, in order.
    pub(super) around: Vec<u32>,
}

/// The clusters of some shells, and that of each vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Clusters {
    pub(super) rows: Vec<Cluster>,
    pub(super) of_vertex: Vec<u32>,
}

impl Clusters {
    pub(super) fn new(shells: &Shells) -> Self {
        let (rows, of_vertex) = group(shells);
        Clusters { rows, of_vertex }
    }
}

/// Groups the vertices of shells, each group breadth first from its lowest vertex; returns also the
/// cluster of each vertex.
fn group(shells: &Shells) -> (Vec<Cluster>, Vec<u32>) {
    let mut clusters: Vec<Cluster> = Vec::new();
    let mut of_vertex = alloc::vec![NONE; shells.vertices.len()];
    for seed in 0..shells.vertices.len() as u32 {
        if of_vertex[seed as usize] != NONE {
            continue;
        }
        let number = clusters.len() as u32;
        let mut vertices = alloc::vec![seed];
        of_vertex[seed as usize] = number;
        let mut next = 0;
        while let Some(&vertex) = vertices.get(next) {
            next += 1;
            for &other in shells.joined_to(vertex) {
                let is_free = of_vertex[other as usize] == NONE;
                let is_own = shells.shell_of(other) == shells.shell_of(seed);
                if is_free && is_own && vertices.len() < MOST {
                    of_vertex[other as usize] = number;
                    vertices.push(other);
                }
            }
        }
        clusters.push(Cluster { vertices, ..Cluster::default() });
    }
    for (number, face) in (0..).zip(&shells.faces) {
        clusters[of_vertex[face.corners[0] as usize] as usize].faces.push(number);
    }
    for (number, edge) in (0..).zip(&shells.edges) {
        let cluster = &mut clusters[of_vertex[edge.ends[0] as usize] as usize];
        if !edge.is_point() {
            cluster.edges.push(number);
        }
        if edge.faces == [NONE; 2] {
            cluster.bare.push(number);
        }
    }
    for cluster in &mut clusters {
        cluster.set_corners(shells);
    }
    (clusters, of_vertex)
}

impl Cluster {
    fn set_corners(&mut self, shells: &Shells) {
        let of_faces = self.faces.iter().flat_map(|&face| shells.faces[face as usize].corners);
        let of_edge = |&edge: &u32| -> [u32; 2] {
            let Edge { ends, .. } = shells.edges[edge as usize];
            ends
        };
        let of_edges = self.edges.iter().flat_map(of_edge);
        self.corners = in_order(self.vertices.iter().copied().chain(of_faces).chain(of_edges));
        let joined = self.corners.iter().flat_map(|&vertex| shells.joined_to(vertex));
        self.around = in_order(self.corners.iter().chain(joined).copied());
    }
}

fn in_order(vertices: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut vertices: Vec<u32> = vertices.collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}
