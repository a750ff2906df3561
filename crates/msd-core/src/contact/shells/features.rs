//! Features of shells: their vertices, edges and faces, and how these are connected.

use crate::columns::extent::Records;
use crate::columns::slots::Slots;
use crate::columns::{Aligned, LANES, single, vector};
use crate::number::Real;
use crate::obstacles::Obstacles;
use crate::scene::shell::{Between, Shell, any_meet, do_meet};
use alloc::collections::BTreeMap;
use alloc::vec::Vec;
use core::ops::Range;
use fearless_simd::Level;

/// No face.
pub(super) const NONE: u32 = u32::MAX;

/// A particle of a shell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// Where its numbers are in a column of vectors.
    pub(super) at: u32,
    pub(super) shell: u32,
    particle: u32,
}

/// An edge, by its vertices, the lower first, and the faces beside it. A point is an edge from a
/// vertex to itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) ends: [u32; 2],
    pub(super) faces: [u32; 2],
}

impl Edge {
    pub(super) fn is_point(&self) -> bool {
        self.ends[0] == self.ends[1]
    }
}

/// A triangle, by its vertices and the edges from each to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShellFace {
    pub(super) corners: [u32; 3],
    pub(super) edges: [u32; 3],
}

/// The shells of a model and their features. A feature keeps its number as others are added.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shells {
    rows: Vec<Shell>,
    /// The thickness of each, metres, and the root of its friction.
    laws: Vec<[f64; 2]>,
    /// Rules of contact between two of them, which replace those of both, in the order of the two.
    between: Vec<([usize; 2], Between)>,
    /// The vertices of which no feature meets one of the other, in order, both ways.
    exempt: Vec<[u32; 2]>,
    /// The largest coefficient of restitution.
    pub(super) most_restitution: f64,
    do_meet: bool,
    pub(super) vertices: Vec<Vertex>,
    pub(super) edges: Vec<Edge>,
    pub(super) faces: Vec<ShellFace>,
    /// The vertices that edges join to each.
    joined: ByVertex,
    faces_at: ByVertex,
    /// Where vertices are in columns of vectors.
    pub(super) records: Records,
}

/// Numbers of each vertex.
#[derive(Clone, Debug, Default)]
struct ByVertex {
    /// One vertex after the other.
    numbers: Vec<u32>,
    /// Where those of each start, and the last ones end.
    starts: Vec<u32>,
}

impl ByVertex {
    /// Those of so many vertices, from pairs of a vertex and a number.
    fn new(count: usize, pairs: impl Iterator<Item = [u32; 2]>) -> Self {
        let mut pairs: Vec<_> = pairs.collect();
        pairs.sort_unstable();
        let start = |vertex: u32| pairs.partition_point(|pair| pair[0] < vertex) as u32;
        let starts = (0..=count as u32).map(start).collect();
        ByVertex { numbers: pairs.into_iter().map(|pair| pair[1]).collect(), starts }
    }

    fn of(&self, vertex: u32) -> &[u32] {
        let [start, end] = [0, 1].map(|by| self.starts[vertex as usize + by] as usize);
        &self.numbers[start..end]
    }
}

impl Shells {
    /// The features of some rows.
    pub(crate) fn new(rows: Vec<Shell>, slots: &Slots) -> Self {
        let mut shells = Shells::default();
        let (mut numbers, mut edges) = (BTreeMap::new(), BTreeMap::new());
        for (number, row) in rows.iter().enumerate() {
            for particle in row.particles() {
                numbers.entry(particle).or_insert_with(|| {
                    let (at, shell) = (slots.at(particle) as u32, number as u32);
                    shells.vertices.push(Vertex { at, shell, particle: particle as u32 });
                    shells.vertices.len() as u32 - 1
                });
            }
            for corners in &row.triangles {
                let corners = corners.map(|corner| numbers[&corner]);
                let face = shells.faces.len() as u32;
                let sides = [0, 1, 2].map(|at| [corners[at], corners[(at + 1) % 3]]);
                let edges = sides.map(|side| {
                    let edge = shells.edge(side, &mut edges);
                    let faces = &mut shells.edges[edge as usize].faces;
                    if let Some(free) = faces.iter_mut().find(|face| **face == NONE) {
                        *free = face;
                    }
                    edge
                });
                shells.faces.push(ShellFace { corners, edges });
            }
            for ends in &row.edges {
                shells.edge(ends.map(|end| numbers[&end]), &mut edges);
            }
            for point in &row.points {
                shells.edge([numbers[point]; 2], &mut edges);
            }
        }
        let law = |row: &Shell| [row.thickness, Real::sqrt(row.friction)];
        let between = |(last, row): (usize, &Shell)| {
            let each = row.between.iter();
            each.map(move |&between| ([between.shell, last], between)).collect::<Vec<_>>()
        };
        shells.between = rows.iter().enumerate().flat_map(between).collect();
        shells.between.sort_unstable_by_key(|&(pair, _)| pair);
        let of_pairs = shells.between.iter().filter_map(|(_, between)| between.restitution);
        let restitutions = rows.iter().map(|row| row.restitution).chain(of_pairs);
        shells.most_restitution = restitutions.fold(0.0, f64::max);
        shells.do_meet = any_meet(&rows);
        let exempt = rows.iter().flat_map(|row| &row.exempt);
        let known = exempt.filter_map(|[a, b]| Some([*numbers.get(a)?, *numbers.get(b)?]));
        shells.exempt = known.flat_map(|[a, b]| [[a, b], [b, a]]).collect();
        shells.exempt.sort_unstable();
        shells.laws = rows.iter().map(law).collect();
        shells.rows = rows;
        shells.records = Records::new(shells.vertices.iter().map(|vertex| vertex.at));
        shells.join();
        shells
    }

    /// Takes out the faces and edges of removed particles; the features left are numbered anew.
    pub(crate) fn remove(&mut self, is_removed: &dyn Fn(u32) -> bool, slots: &Slots) {
        if !self.vertices.iter().any(|vertex| is_removed(vertex.particle)) {
            return;
        }
        let mut rows = core::mem::take(&mut self.rows);
        for row in &mut rows {
            row.triangles.retain(|corners| !corners.iter().any(|&at| is_removed(at as u32)));
            row.edges.retain(|ends| !ends.iter().any(|&at| is_removed(at as u32)));
            row.points.retain(|&at| !is_removed(at as u32));
        }
        *self = Shells::new(rows, slots);
    }

    fn edge(&mut self, [a, b]: [u32; 2], known: &mut BTreeMap<[u32; 2], u32>) -> u32 {
        let ends = [a.min(b), a.max(b)];
        *known.entry(ends).or_insert_with(|| {
            self.edges.push(Edge { ends, faces: [NONE; 2] });
            self.edges.len() as u32 - 1
        })
    }

    fn join(&mut self) {
        let between = self.edges.iter().filter(|edge| !edge.is_point());
        let ends = between.flat_map(|edge| [edge.ends, [edge.ends[1], edge.ends[0]]]);
        self.joined = ByVertex::new(self.vertices.len(), ends);
        let faces = (0..).zip(&self.faces);
        let corners = faces.flat_map(|(face, row)| row.corners.map(|corner| [corner, face]));
        self.faces_at = ByVertex::new(self.vertices.len(), corners);
    }

    /// Whether any meets another or itself.
    pub(crate) fn do_meet(&self) -> bool {
        self.do_meet
    }

    /// The shells of particles.
    pub(super) fn by_particle(&self) -> BTreeMap<usize, usize> {
        let each = self.vertices.iter();
        each.map(|vertex| (vertex.particle as usize, vertex.shell as usize)).collect()
    }

    /// Whether two shells stop each other.
    pub(super) fn do_shells_meet(&self, pair: [usize; 2]) -> bool {
        do_meet(&self.rows, pair)
    }

    /// The rows as written.
    pub(crate) fn rows(&self) -> &[Shell] {
        &self.rows
    }

    /// The vertices that edges join to one.
    pub(super) fn joined_to(&self, vertex: u32) -> &[u32] {
        self.joined.of(vertex)
    }

    /// The faces at a vertex.
    pub(super) fn faces_at(&self, vertex: u32) -> &[u32] {
        self.faces_at.of(vertex)
    }

    pub(super) fn shell_of(&self, vertex: u32) -> usize {
        self.vertices[vertex as usize].shell as usize
    }

    /// The vertices of a shell, which are numbered one shell after the other.
    pub(super) fn vertices_of(&self, shell: usize) -> Range<u32> {
        let start = |shell| self.vertices.partition_point(|vertex| vertex.shell < shell) as u32;
        start(shell as u32)..start(shell as u32 + 1)
    }

    /// The faces of a shell, numbered so, too.
    pub(super) fn faces_of(&self, shell: usize) -> Range<u32> {
        let is_before = |face: &ShellFace, shell| self.shell_of(face.corners[0]) < shell;
        let start = |shell| self.faces.partition_point(|face| is_before(face, shell)) as u32;
        start(shell)..start(shell + 1)
    }

    /// Whether the faces of a shell close it, each with its corners around its way out.
    pub(super) fn is_closed(&self, shell: usize) -> bool {
        let faces = self.faces_of(shell);
        let corners = |face: u32| self.faces[face as usize].corners;
        let is_beside = |face: u32, edge: u32| {
            let other = self.edges[edge as usize].faces.into_iter().find(|&other| other != face);
            other.filter(|&other| other != NONE)
        };
        !faces.is_empty()
            && faces.into_iter().all(|face| {
                let sides = (0..3).zip(self.faces[face as usize].edges);
                sides.into_iter().all(|(at, edge)| {
                    let [from, to] = [corners(face)[at], corners(face)[(at + 1) % 3]];
                    is_beside(face, edge).is_some_and(|other| {
                        let [a, b, c] = corners(other);
                        [[b, a], [c, b], [a, c]].contains(&[from, to])
                    })
                })
            })
    }

    /// The first particle of a shell that has a feature.
    pub(super) fn first_particle(&self, shell: usize) -> usize {
        self.rows[shell].particles().next().unwrap_or(0)
    }

    /// Whether any vertex of a feature is exempt from meeting one of another.
    pub(super) fn exempts(&self, own: &[u32], other: &[u32]) -> bool {
        let is_exempt = |a: u32, b: u32| self.exempt.binary_search(&[a, b]).is_ok();
        !self.exempt.is_empty() && own.iter().any(|&a| other.iter().any(|&b| is_exempt(a, b)))
    }

    /// The particles of two vertices, if they are of one shell.
    pub(super) fn of_one_shell(&self, vertices: [u32; 2]) -> Option<[usize; 2]> {
        let [a, b] = vertices.map(|vertex| self.vertices[vertex as usize]);
        (a.shell == b.shell).then_some([a.particle as usize, b.particle as usize])
    }

    /// The distance at which the shells of two vertices stop each other, metres.
    pub(super) fn stop_of<R: Real>(&self, a: u32, b: u32) -> R {
        let [a, b] = [a, b].map(|vertex| self.laws[self.shell_of(vertex)][0]);
        R::of(a) + R::of(b)
    }

    /// The distance that a vertex keeps from obstacles, metres.
    pub(super) fn radius_of<R: Real>(&self, vertex: u32) -> R {
        let row = &self.rows[self.shell_of(vertex)];
        if row.obstacles { R::of(row.thickness) } else { R::ZERO }
    }

    /// Coulomb's factor and the coefficient of restitution of the shells of two vertices: those of
    /// [`law_between`](crate::scene::law_between), by roots that are known.
    pub(super) fn law_of<R: Real>(&self, a: u32, b: u32) -> [R; 2] {
        let [a, b] = [a, b].map(|vertex| self.shell_of(vertex));
        let pair = [a.min(b), a.max(b)];
        let found = self.between.binary_search_by_key(&pair, |&(pair, _)| pair);
        let said = found.map_or(Between::default(), |at| self.between[at].1);
        let restitution = || self.rows[a].restitution.max(self.rows[b].restitution);
        [
            R::of(said.friction.unwrap_or(self.laws[a][1] * self.laws[b][1])),
            R::of(said.restitution.unwrap_or_else(restitution)),
        ]
    }

    /// The thicknesses that count against obstacles, metres, a number for each slot, and the
    /// largest; none where no shell's does.
    pub(crate) fn radii_at_obstacles<R: Real>(&self, slots: &Slots) -> (Aligned<R>, R) {
        if !self.rows.iter().any(|row| row.obstacles) {
            return (Aligned::default(), R::ZERO);
        }
        let mut radii = Aligned::new(slots.record_count() * LANES, 28);
        let mut largest = R::ZERO;
        for row in self.rows.iter().filter(|row| row.obstacles) {
            let radius = R::of(row.thickness);
            row.particles().for_each(|particle| radii[single(slots.at(particle))] = radius);
            largest = largest.max(radius);
        }
        (radii, largest)
    }

    /// The largest distance at which two shells stop each other, metres.
    pub(crate) fn reach(&self) -> f64 {
        2.0 * self.rows.iter().map(|row| row.thickness).fold(0.0, f64::max)
    }

    /// Where a vertex is, metres.
    #[inline(always)]
    pub(super) fn point<R: Real>(&self, positions: &[R], vertex: u32) -> R::Vec3 {
        vector::<R>(positions, self.vertices[vertex as usize].at as usize)
    }
}

/// A state in columns, and the other inputs of its rows.
pub(crate) struct At<'a, R: Real> {
    pub(crate) level: Level,
    pub(crate) shells: &'a Shells,
    pub(crate) obstacles: &'a Obstacles<R>,
    pub(crate) inverse_masses: &'a [R],
    /// Simulated time, seconds.
    pub(crate) time: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::slots::Block;
    use crate::scene::law_between;
    use alloc::vec;

    #[test]
    fn two_vertices_meet_by_the_law_of_their_shells() {
        let shell = |row: usize, friction, restitution| Shell {
            points: vec![row],
            thickness: 0.01,
            friction,
            restitution,
            ..Shell::default()
        };
        let mut rows = vec![shell(0, 0.3, 0.1), shell(1, 0.7, 0.0), shell(2, 0.9, 0.4)];
        rows[2].between = vec![Between { shell: 0, friction: Some(0.2), restitution: None }];
        let block = Block { particles: 0..3, blank: 0, len: 1, order: None };
        let shells = Shells::new(rows.clone(), &Slots::new(vec![block]));
        for pair in [[0, 1], [1, 0], [0, 2], [2, 1]] {
            let known = shells.law_of::<f64>(pair[0] as u32, pair[1] as u32);
            for (known, right) in known.into_iter().zip(law_between(&rows, pair)) {
                // Two roots and their product are rounded.
                assert!((known - right).abs() <= 4.0 * f64::EPSILON, "{pair:?}: {known}, {right}");
            }
        }
    }
}
