//! Rows of the features that are nearest to each other.

use super::features::{NONE, Shells};
use super::row::{ContactRow, EDGE, EDGES, FACE, OBSTACLE, VERTEX, features, key};
use crate::columns::vector;
use crate::number::{Real, Vector};
use crate::obstacles::Obstacles;
use crate::triangle::{nearest, part_of_edge};
use alloc::vec::Vec;

/// A state in columns, and what the rows of it depend on.
pub(crate) struct At<'a, R: Real> {
    pub(crate) shells: &'a Shells,
    pub(crate) obstacles: &'a Obstacles<R>,
    pub(crate) inverse_masses: &'a [R],
    /// Simulated time, seconds.
    pub(crate) time: f64,
}

/// Rows as they are found.
pub(super) struct Finder<'a, R: Real> {
    pub(super) at: &'a At<'a, R>,
    pub(super) positions: &'a [R],
    /// How far beyond their reach features may be, metres.
    pub(super) margin: R,
    pub(super) rows: Vec<ContactRow<R>>,
    /// The vertices in them.
    pub(super) used: Vec<u32>,
}

impl<R: Real> Finder<'_, R> {
    fn point(&self, vertex: u32) -> R::Vec3 {
        self.at.shells.point(self.positions, vertex)
    }

    /// The square of the distance of a point from a face.
    fn square(&self, point: R::Vec3, face: u32) -> R {
        let corners = self.at.shells.faces[face as usize].corners;
        nearest::<R>(corners.map(|corner| self.point(corner) - point)).square
    }

    /// Adds the row of some features unless they are too far apart.
    fn add(&mut self, key: u64) {
        if let Some((row, vertices)) = self.row(key) {
            self.rows.push(row);
            self.used.extend(vertices.iter().take(row.count));
        }
    }

    /// The row of some features, and its vertices; none where they are too far apart, or nothing
    /// moves either.
    pub(super) fn row(&self, key: u64) -> Option<(ContactRow<R>, [u32; 4])> {
        let shells = self.at.shells;
        let Sides { vertices, weights, count } = self.sides(key);
        let (stop, friction) = shells.law_of::<R>(vertices[0], vertices[count - 1]);
        let at = vertices.map(|vertex| shells.vertices[vertex as usize].at);
        let mut row =
            ContactRow { key, at, weights, count, stop, friction, ..ContactRow::default() };
        let way = row.relative(self.positions);
        let square = way.dot(way);
        let most = stop + self.margin;
        if most * most <= square || square < R::SHORTEST_SQUARED {
            return None;
        }
        let distance = square.sqrt();
        row.normal = way * (R::ONE / distance);
        row.gap = distance - stop;
        row.mass = self.mass(&row)?;
        if R::ZERO < friction {
            self.turn(&mut row, distance);
        }
        Some((row, vertices))
    }

    /// The points of two features that are nearest to each other.
    fn sides(&self, key: u64) -> Sides<R> {
        let shells = self.at.shells;
        let [a, b] = features(key);
        match key >> 62 {
            FACE => {
                let corners = shells.faces[b as usize].corners;
                let here = self.point(a);
                let [u, v, w] = nearest::<R>(corners.map(|at| self.point(at) - here)).weights;
                Sides::new([a, corners[0], corners[1], corners[2]], [R::ONE, -u, -v, -w])
            }
            EDGE => {
                let [from, to] = shells.edges[b as usize].ends;
                let here = self.point(a);
                let part = part_of_edge::<R>(self.point(from) - here, self.point(to) - here);
                Sides::new([a, from, to], [R::ONE, part - R::ONE, -part])
            }
            VERTEX => Sides::new([a, b], [R::ONE, -R::ONE]),
            _ => {
                let [own, other] = [a, b].map(|edge| shells.edges[edge as usize].ends);
                let [s, t] = self.parts([own, other]).unwrap_or([R::HALF; 2]);
                let [s, t] = [s, t].map(|part| part.max(R::ZERO).min(R::ONE));
                let ends = [own[0], own[1], other[0], other[1]];
                Sides::new(ends, [R::ONE - s, s, t - R::ONE, -t])
            }
        }
    }

    /// Where the lines of two edges are nearest to each other, in parts of the edges; none where
    /// they are parallel.
    fn parts(&self, [own, other]: [[u32; 2]; 2]) -> Option<[R; 2]> {
        let [p, p_end] = own.map(|end| self.point(end));
        let [q, q_end] = other.map(|end| self.point(end));
        let (d, e, r) = (p_end - p, q_end - q, p - q);
        let [dd, ee, de, dr, er] = [d.dot(d), e.dot(e), d.dot(e), d.dot(r), e.dot(r)];
        let sine = dd * ee - de * de;
        let s = (de * er - dr * ee) / sine;
        (R::of(1e-6) * (dd * ee) <= sine).then(|| [s, (de * s + er) / ee])
    }

    /// The faces at some features.
    fn faces_of(&self, key: u64) -> impl Iterator<Item = u32> {
        let shells = self.at.shells;
        let [a, b] = features(key);
        let beside = |edge: u32| shells.edges[edge as usize].faces;
        let (few, [first, last]): (_, [&[u32]; 2]) = match key >> 62 {
            FACE => ([b, NONE, NONE, NONE], [&[]; 2]),
            EDGE => ([beside(b)[0], beside(b)[1], NONE, NONE], [&[]; 2]),
            VERTEX => ([NONE; 4], [a, b].map(|vertex| shells.faces_at(vertex))),
            _ => ([beside(a)[0], beside(a)[1], beside(b)[0], beside(b)[1]], [&[]; 2]),
        };
        let few = few.into_iter().filter(|&face| face != NONE);
        few.chain(first.iter().chain(last).copied())
    }

    /// Lets the face that faces the normal most of some take the couple of friction. One that a
    /// normal is nearly along would be turned by much for little.
    fn turn(&self, row: &mut ContactRow<R>, distance: R) {
        let mut best = R::of(LEAST_FACING);
        for face in self.faces_of(row.key) {
            let corners = self.at.shells.faces[face as usize].corners;
            let [a, b, c] = corners.map(|corner| self.point(corner));
            let across = (b - a).cross(c - a);
            let area = across.dot(row.normal);
            let facing = area * area / across.dot(across);
            if facing <= best {
                continue;
            }
            best = facing;
            row.turns = true;
            row.turning = corners.map(|corner| self.at.shells.vertices[corner as usize].at);
            row.turns_by = turns_by::<R>([a, b, c], (row.normal, distance));
        }
    }

    /// The mass of both sides of a row, kilograms; none where nothing moves either.
    fn mass(&self, row: &ContactRow<R>) -> Option<R> {
        let each = row.at.iter().zip(row.weights).take(row.count);
        let inverse = each.fold(R::ZERO, |sum, (&at, weight)| {
            sum + weight * weight * self.at.inverse_masses[at as usize]
        });
        (R::ZERO < inverse).then(|| R::ONE / inverse)
    }

    /// Finds the row of a vertex and a face, or of the vertex and an edge or a corner of it.
    pub(super) fn face(&mut self, [vertex, number]: [u32; 2]) {
        let shells = self.at.shells;
        let face = shells.faces[number as usize];
        let here = self.point(vertex);
        let corners = face.corners.map(|corner| self.point(corner) - here);
        let (stop, _) = shells.law_of::<R>(vertex, face.corners[0]);
        let most = stop + self.margin;
        let met = nearest::<R>(corners);
        if most * most <= met.square {
            return;
        }
        let zeros = met.weights.map(|weight| weight == R::ZERO);
        match zeros.iter().filter(|&&zero| zero).count() {
            0 => self.add(key(FACE, vertex, number)),
            1 => {
                let side = match zeros {
                    [true, _, _] => 1,
                    [_, true, _] => 2,
                    _ => 0,
                };
                let edge = face.edges[side];
                let others = shells.edges[edge as usize].faces;
                for other in others.into_iter().filter(|&other| other != number && other != NONE) {
                    let is_own = shells.faces[other as usize].corners.contains(&vertex);
                    let least = met.square * (R::ONE - R::EPSILON * R::of(64.0));
                    if is_own || self.square(here, other) < least {
                        return;
                    }
                }
                self.add(key(EDGE, vertex, edge));
            }
            _ => {
                let corner = zeros.iter().position(|&zero| !zero).unwrap_or(0);
                self.corner(vertex, face.corners[corner]);
            }
        }
    }

    /// Finds the row of a vertex and an edge of no face, or of the vertex and an end of it.
    pub(super) fn end(&mut self, [vertex, number]: [u32; 2]) {
        let [a, b] = self.at.shells.edges[number as usize].ends;
        let here = self.point(vertex);
        let part = part_of_edge::<R>(self.point(a) - here, self.point(b) - here);
        if part == R::ZERO {
            self.corner(vertex, a);
        } else if part == R::ONE {
            self.corner(vertex, b);
        } else {
            self.add(key(EDGE, vertex, number));
        }
    }

    /// Adds the row of two vertices unless one is nearer to an edge at the other.
    fn corner(&mut self, vertex: u32, corner: u32) {
        let shells = self.at.shells;
        let (here, there) = (self.point(vertex), self.point(corner));
        let way = here - there;
        let noise = R::EPSILON * R::of(64.0) * way.dot(way);
        let is_nearer = |&end: &u32| {
            let edge = self.point(end) - there;
            end == vertex || noise < way.dot(edge)
        };
        if shells.joined_to(corner).iter().any(is_nearer) {
            return;
        }
        let (a, b) = (vertex.min(corner), vertex.max(corner));
        self.add(key(VERTEX, a, b));
    }

    /// Finds the row of two edges whose nearest points are inside of both.
    pub(super) fn edges(&mut self, [a, b]: [u32; 2]) {
        let shells = self.at.shells;
        let [own, other] = [a, b].map(|edge| shells.edges[edge as usize].ends);
        let (stop, _) = shells.law_of::<R>(own[0], other[0]);
        let most = stop + self.margin;
        let Some([s, t]) = self.parts([own, other]) else { return };
        let is_inside = |part: R| R::ZERO < part && part < R::ONE;
        if !is_inside(s) || !is_inside(t) {
            return;
        }
        let between = |[a, b]: [u32; 2], part: R| {
            let [from, to] = [a, b].map(|end| self.point(end));
            from + (to - from) * part
        };
        let (here, there) = (between(own, s), between(other, t));
        let square = (here - there).dot(here - there);
        if most * most <= square {
            return;
        }
        let least = square * R::of(1.0 - FLAT);
        for (edge, point, ends) in [(a, there, other), (b, here, own)] {
            for face in shells.edges[edge as usize].faces.into_iter().filter(|&face| face != NONE) {
                let corners = shells.faces[face as usize].corners;
                let is_own = ends.iter().any(|end| corners.contains(end));
                if !is_own && self.square(point, face) < least {
                    return;
                }
            }
        }
        self.add(key(EDGES, a, b));
    }

    /// Adds the rows of obstacles and of vertices that are in a row: one that lies on an obstacle
    /// bears what lies on it.
    pub(super) fn obstacles(&mut self) {
        let At { shells, obstacles, time, .. } = *self.at;
        if obstacles.is_empty() || self.rows.is_empty() {
            return;
        }
        let mut used = core::mem::take(&mut self.used);
        used.sort_unstable();
        used.dedup();
        for &vertex in &used {
            let at = shells.vertices[vertex as usize].at;
            let here = vector::<R>(self.positions, at as usize);
            for index in 0..obstacles.count() {
                let obstacle = obstacles.get(index);
                let gap = obstacle.gap(here, time);
                if self.margin <= gap {
                    continue;
                }
                let row = ContactRow {
                    key: EDGES << 62 | OBSTACLE | u64::from(vertex) << 24 | index as u64,
                    at: [at; 4],
                    weights: [R::ONE, R::ZERO, R::ZERO, R::ZERO],
                    count: 1,
                    normal: obstacle.normal(here, time),
                    gap,
                    carried: obstacle.velocity(here, time),
                    friction: obstacle.law().friction,
                    ..ContactRow::default()
                };
                if let Some(mass) = self.mass(&row) {
                    self.rows.push(ContactRow { mass, ..row });
                }
            }
        }
        self.used = used;
    }
}

/// The square of the cosine between a normal and that of a face, from which on it takes couples.
const LEAST_FACING: f64 = 0.1;

/// The part by which a face must be nearer than an edge of it to count instead of it: where both
/// lie in flat surface they would take turns.
const FLAT: f64 = 2e-3;

/// Two sides of a row, by vertices with weights.
struct Sides<R> {
    vertices: [u32; 4],
    weights: [R; 4],
    count: usize,
}

impl<R: Real> Sides<R> {
    fn new<const N: usize>(vertices: [u32; N], weights: [R; N]) -> Self {
        let mut sides = Sides { vertices: [vertices[0]; 4], weights: [R::ZERO; 4], count: N };
        sides.vertices[..N].copy_from_slice(&vertices);
        sides.weights[..N].copy_from_slice(&weights);
        sides
    }
}

/// The distance of both sides of a row times the gradient of the weights of a face, as seen along
/// the normal of the row.
fn turns_by<R: Real>([a, b, c]: [R::Vec3; 3], (normal, distance): (R::Vec3, R)) -> [R::Vec3; 3] {
    let by = distance / (b - a).cross(c - a).dot(normal);
    [c - b, a - c, b - a].map(|side| normal.cross(side) * by)
}
