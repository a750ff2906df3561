//! The topology of triangles: which meet at which edges, which belong together, and which way they
//! face.

use crate::mesh::clean::inside::Inside;
use glam::DVec3;

/// One side of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Side {
    /// The two vertices, the lower first.
    pub(crate) ends: [u32; 2],
    /// The face.
    pub(crate) face: u32,
    /// Whether the face runs from the lower to the higher vertex.
    forward: bool,
    /// The third vertex of the face.
    pub(crate) opposite: u32,
}

impl Side {
    /// The two vertices in the direction of the face.
    pub(crate) fn along(&self) -> [u32; 2] {
        let [low, high] = self.ends;
        if self.forward { [low, high] } else { [high, low] }
    }
}

/// The sides of all faces, sorted: those of one edge stand together.
pub(crate) fn sides(triangles: &[[u32; 3]]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (face, corners) in triangles.iter().enumerate() {
        for i in 0..3 {
            let (a, b, opposite) = (corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]);
            let ends = [a.min(b), a.max(b)];
            sides.push(Side { ends, face: face as u32, forward: a < b, opposite });
        }
    }
    sides.sort_unstable();
    sides
}

/// The edges: runs of sides with the same ends.
pub(crate) fn edges(sides: &[Side]) -> impl Iterator<Item = &[Side]> {
    sides.chunk_by(|a, b| a.ends == b.ends)
}

/// Sets that grow together, by union and find.
pub(crate) struct Sets(Vec<u32>);

impl Sets {
    /// As many sets as members.
    pub(crate) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The lowest member of the set of `member`.
    pub(crate) fn find(&mut self, member: usize) -> usize {
        let mut member = member as u32;
        while self.0[member as usize] != member {
            let parent = self.0[member as usize];
            self.0[member as usize] = self.0[parent as usize];
            member = parent;
        }
        member as usize
    }

    /// Makes one set of two.
    pub(crate) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}

/// The component of each vertex, numbered from 0 in order of their first vertex, and their number.
pub(crate) fn components(count: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let mut sets = Sets::new(count);
    for &[a, b, c] in triangles {
        sets.join(a as usize, b as usize);
        sets.join(b as usize, c as usize);
    }
    let mut numbers = vec![0; count];
    let mut found = 0;
    for vertex in 0..count {
        let first = sets.find(vertex);
        if first == vertex {
            numbers[vertex] = found;
            found += 1;
        } else {
            numbers[vertex] = numbers[first];
        }
    }
    (numbers, found as usize)
}

/// Six times the volume between a triangle and a point, positive if it faces away from the point.
pub(crate) fn volume6(positions: &[DVec3], triangle: [u32; 3], from: DVec3) -> f64 {
    let [a, b, c] = triangle.map(|corner| positions[corner as usize] - from);
    a.dot(b.cross(c))
}

/// Turns faces so that neighbours agree and closed pieces face outward; returns which were turned.
///
/// A piece is a set of faces that hang together by edges with two faces. An open piece keeps the
/// direction of most of its faces. A closed piece with negative volume is turned, unless it bounds
/// a void in another.
pub(crate) fn orient(positions: &[DVec3], triangles: &mut [[u32; 3]]) -> Vec<bool> {
    let sides = sides(triangles);
    let (pieces, mut turned) = agree(triangles.len(), &sides);
    let count = pieces.iter().map(|&piece| piece as usize + 1).max().unwrap_or(0);
    let mut closed = vec![true; count];
    for side in edges(&sides).filter(|edge| edge.len() != 2).flatten() {
        closed[pieces[side.face as usize] as usize] = false;
    }
    let mut balance = vec![0i64; count];
    for (&piece, &turn) in pieces.iter().zip(&turned) {
        balance[piece as usize] += if turn { -1 } else { 1 };
    }
    let minority: Vec<bool> = balance.iter().map(|&balance| balance < 0).collect();
    for (&piece, turn) in pieces.iter().zip(&mut turned) {
        *turn ^= minority[piece as usize];
    }
    for (triangle, _) in triangles.iter_mut().zip(&turned).filter(|(_, turn)| **turn) {
        triangle.swap(1, 2);
    }
    let invert = inside_out(positions, triangles, &pieces, &closed);
    for (face, triangle) in triangles.iter_mut().enumerate() {
        if invert[pieces[face] as usize] {
            triangle.swap(1, 2);
            turned[face] = !turned[face];
        }
    }
    turned
}

/// The closed pieces that are inside out.
fn inside_out(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    pieces: &[u32],
    closed: &[bool],
) -> Vec<bool> {
    let from = positions.first().copied().unwrap_or_default();
    let mut volumes = vec![0.0; closed.len()];
    for (&triangle, &piece) in triangles.iter().zip(pieces) {
        if closed[piece as usize] {
            volumes[piece as usize] += volume6(positions, triangle, from);
        }
    }
    // If the sum is negative then all were written inside out, voids included.
    let sign = if volumes.iter().sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
    let outer: Vec<bool> = volumes.iter().map(|&volume| 0.0 < sign * volume).collect();
    let inner: Vec<bool> = volumes.iter().map(|&volume| sign * volume < 0.0).collect();
    let void = voids(positions, triangles, pieces, (&outer, &inner));
    let right = |piece: usize| outer[piece] || void[piece];
    (0..closed.len()).map(|piece| closed[piece] && right(piece) == (sign < 0.0)).collect()
}

/// Spreads the direction of the first face of each piece: the piece of each face, and whether it
/// must be turned to agree.
fn agree(count: usize, sides: &[Side]) -> (Vec<u32>, Vec<bool>) {
    let mut neighbours = vec![[(u32::MAX, false); 3]; count];
    let mut filled = vec![0u8; count];
    for edge in edges(sides) {
        // Where more than two faces meet, the continuation of a face is ambiguous.
        let &[a, b] = edge else { continue };
        for (from, to) in [(a, b), (b, a)] {
            let face = from.face as usize;
            neighbours[face][filled[face] as usize] = (to.face, a.forward == b.forward);
            filled[face] += 1;
        }
    }
    let mut pieces = vec![u32::MAX; count];
    let mut turned = vec![false; count];
    let mut piece = 0;
    let mut waiting = Vec::new();
    for first in 0..count {
        if pieces[first] != u32::MAX {
            continue;
        }
        pieces[first] = piece;
        waiting.push(first);
        while let Some(face) = waiting.pop() {
            for &(next, differs) in &neighbours[face][..filled[face] as usize] {
                let next = next as usize;
                if pieces[next] == u32::MAX {
                    pieces[next] = piece;
                    turned[next] = turned[face] ^ differs;
                    waiting.push(next);
                }
            }
        }
        piece += 1;
    }
    (pieces, turned)
}

/// The `inner` pieces that have their first corner inside one of the `outer` ones.
fn voids(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    pieces: &[u32],
    (outer, inner): (&[bool], &[bool]),
) -> Vec<bool> {
    let mut void = vec![false; outer.len()];
    if !inner.contains(&true) || !outer.contains(&true) {
        return void;
    }
    let faces = || triangles.iter().zip(pieces);
    let around: Vec<[u32; 3]> =
        faces().filter(|&(_, &piece)| outer[piece as usize]).map(|(&face, _)| face).collect();
    let inside = Inside::new(positions, &around);
    let mut seen = vec![false; outer.len()];
    for (face, &piece) in faces() {
        let piece = piece as usize;
        if inner[piece] && !seen[piece] {
            seen[piece] = true;
            void[piece] = inside.contains(positions[face[0] as usize]);
        }
    }
    void
}
