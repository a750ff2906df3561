//! Clusters: a few vertices that edges join, with the features that begin at them.

use super::features::{NONE, Shells};
use alloc::vec::Vec;
use core::ops::Range;

/// The most vertices of a cluster: few enough that they move alike, and enough that looking at
/// clusters costs less than looking at features.
const MOST: usize = 16;

/// A feature of a cluster, and which of the corners of the cluster it has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Feature<const N: usize> {
    pub(super) number: u32,
    pub(super) corners: [u32; N],
}

/// A few vertices of a shell. A face and an edge belong to the cluster of their first vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Cluster {
    pub(super) vertices: Vec<Feature<1>>,
    pub(super) faces: Vec<Feature<3>>,
    pub(super) edges: Vec<Feature<2>>,
    /// Those of its edges that have no face beside them.
    pub(super) bare: Vec<Feature<2>>,
    /// Where the vertices of its features are among those of all clusters, in order.
    pub(super) corners: Range<usize>,
    /// Those and the ones that edges join to them, in order.
    pub(super) around: Vec<u32>,
}

/// The clusters of some shells.
#[derive(Clone, Debug, Default)]
pub(super) struct Clusters {
    pub(super) rows: Vec<Cluster>,
    /// The cluster of each vertex.
    pub(super) of_vertex: Vec<u32>,
    /// The vertices of the features of each cluster, one cluster after the other.
    pub(super) corners: Vec<u32>,
}

impl Clusters {
    pub(super) fn new(shells: &Shells) -> Self {
        let (groups, of_vertex) = group(shells);
        let mut features: Vec<[Vec<u32>; 2]> = alloc::vec![Default::default(); groups.len()];
        for (number, face) in (0..).zip(&shells.faces) {
            features[of_vertex[face.corners[0] as usize] as usize][0].push(number);
        }
        for (number, edge) in (0..).zip(&shells.edges) {
            features[of_vertex[edge.ends[0] as usize] as usize][1].push(number);
        }
        let mut clusters = Clusters { rows: Vec::new(), of_vertex, corners: Vec::new() };
        for (vertices, [faces, edges]) in groups.iter().zip(&features) {
            clusters.add(shells, vertices, (faces, edges));
        }
        clusters
    }

    /// Adds the cluster of some vertices, faces and edges.
    fn add(&mut self, shells: &Shells, vertices: &[u32], (faces, edges): (&[u32], &[u32])) {
        let of_face = |face: u32| shells.faces[face as usize].corners;
        let of_edge = |edge: u32| shells.edges[edge as usize].ends;
        let corners = vertices.iter().copied();
        let corners = corners.chain(faces.iter().flat_map(|&face| of_face(face)));
        let corners = in_order(corners.chain(edges.iter().flat_map(|&edge| of_edge(edge))));
        let joined = corners.iter().flat_map(|&vertex| shells.joined_to(vertex));
        let around = in_order(corners.iter().chain(joined).copied());
        let is_line = |&&edge: &&u32| !shells.edges[edge as usize].is_point();
        let is_bare = |&&edge: &&u32| shells.edges[edge as usize].faces == [NONE; 2];
        let first = self.corners.len();
        self.rows.push(Cluster {
            vertices: features(&corners, vertices.iter(), |vertex| [vertex]),
            faces: features(&corners, faces.iter(), of_face),
            edges: features(&corners, edges.iter().filter(is_line), of_edge),
            bare: features(&corners, edges.iter().filter(is_bare), of_edge),
            corners: first..first + corners.len(),
            around,
        });
        self.corners.extend(corners);
    }
}

/// Features with their vertices as places among the corners of a cluster.
fn features<'a, const N: usize>(
    corners: &[u32],
    numbers: impl Iterator<Item = &'a u32>,
    vertices: impl Fn(u32) -> [u32; N],
) -> Vec<Feature<N>> {
    let place = |vertex: u32| corners.partition_point(|&corner| corner < vertex) as u32;
    numbers.map(|&number| Feature { number, corners: vertices(number).map(place) }).collect()
}

/// Groups the vertices of shells, each group breadth first from its lowest vertex; returns also the
/// group of each vertex.
fn group(shells: &Shells) -> (Vec<Vec<u32>>, Vec<u32>) {
    let mut groups: Vec<Vec<u32>> = Vec::new();
    let mut of_vertex = alloc::vec![NONE; shells.vertices.len()];
    for seed in 0..shells.vertices.len() as u32 {
        if of_vertex[seed as usize] != NONE {
            continue;
        }
        let number = groups.len() as u32;
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
        groups.push(vertices);
    }
    (groups, of_vertex)
}

fn in_order(vertices: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut vertices: Vec<u32> = vertices.collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}
