//! Bodies that cross at the start: what is inside a closed one is pushed out of it.
//!
//! Ordinary rows keep features on the sides on which they are, and so would keep a particle inside.
//! Two shells that cross at the start have other rows until they are apart: one for each particle
//! that starts inside, with the face straight ahead of it. Both sides part at a bounded speed: by
//! the distance at which they stop each other in each `UNDOING`. All rows of the two have one
//! direction, which keeps the shape of what is pushed out. Towards the nearest face each, particles
//! beside an edge would leave on different sides of it. The work of the rows counts as work of
//! solids.

use super::clusters::Clusters;
use super::find::{Finder, Sides};
use super::lists::NOISE;
use super::row::{ContactRow, EDGES, OVERLAP, SLOP, features};
use super::sweep::UNDOING;
use crate::columns::extent::Extent;
use crate::number::{Real, Vector};
use crate::triangle::{Nearest, nearest};
use alloc::vec::Vec;
use core::cmp::Ordering;

/// The most particles of a shell that are pushed out of another one, spread over all inside: each
/// looks at many faces.
const MOST: usize = 256;
/// The most particles of a shell whose ways out are tried as that of the whole.
const MOST_WAYS: usize = 32;
/// How far outside of a face a line still meets it, as a part of the face: no gap between faces.
const BESIDE: f64 = 0.05;
/// A direction in which no edges of lattices lie.
const ASKEW: [f64; 3] = [0.5291, 0.7127, 0.4607];

/// The clusters of a shell, and the balls around them: where they are, and their radii squared.
pub(super) type Balls<R> = Vec<(u32, <R as Real>::Vec3, R)>;

impl<R: Real> Finder<'_, R> {
    /// The rows of two shells that cross, each with its key and its direction; none where they do
    /// not.
    pub(super) fn crossing(
        &self,
        clusters: &Clusters,
        [a, b]: [usize; 2],
        are_closed: &[bool],
    ) -> Vec<ContactRow<R>> {
        let shells = self.at.shells;
        let inside = [[a, b], [b, a]].map(|[own, solid]| {
            let mut all: Vec<u32> = Vec::new();
            if are_closed[solid] {
                let mut balls = Vec::new();
                self.set_balls(clusters, solid, &mut balls);
                all.extend(
                    shells.vertices_of(own).filter(|&v| self.is_inside(clusters, &balls, v)),
                );
            }
            let step = all.len().div_ceil(MOST).max(1);
            let is_part = !all.is_empty() && all.len() < shells.vertices_of(own).len();
            (is_part, all.into_iter().step_by(step).collect::<Vec<u32>>())
        });
        if !inside.iter().any(|(is_part, _)| *is_part) {
            return Vec::new();
        }
        let sides = [(&inside[0].1, b, R::ONE), (&inside[1].1, a, -R::ONE)];
        let Some(out) = self.way_apart(clusters, sides) else { return Vec::new() };
        let sides = inside.iter().zip([(out, b), (-out, a)]);
        let row = |vertex: u32, (normal, solid): (R::Vec3, usize)| ContactRow {
            key: EDGES << 62 | OVERLAP | u64::from(vertex) << 30 | solid as u64,
            normal,
            ..ContactRow::default()
        };
        sides
            .flat_map(|((_, few), side)| few.iter().map(move |&vertex| row(vertex, side)))
            .collect()
    }

    /// The direction in which the first of two shells is soonest out of the other: along the
    /// shortest way out of one of the vertices inside.
    fn way_apart(&self, clusters: &Clusters, sides: [(&Vec<u32>, usize, R); 2]) -> Option<R::Vec3> {
        let each = |(vertices, solid, sign): (&Vec<u32>, usize, R)| {
            let step = vertices.len().div_ceil(MOST_WAYS).max(1);
            let few = vertices.iter().step_by(step).copied();
            few.map(|vertex| (vertex, self.way_out(vertex, solid) * sign)).collect::<Vec<_>>()
        };
        let few = sides.map(each);
        let all = few.iter().flatten().fold(R::Vec3::ZERO, |sum, (_, way)| sum + *way);
        let middle = |(_, solid, _): (&Vec<u32>, usize, R)| {
            let points = self.at.shells.vertices_of(solid).map(|vertex| self.point(vertex));
            Extent::<R>::around(points).middle()
        };
        let ways = few.iter().flatten().map(|(_, way)| *way);
        let ways = ways.chain([all, middle(sides[1]) - middle(sides[0])]);
        let long = ways.filter(|way| R::SHORTEST_SQUARED < way.dot(*way));
        let mut balls = [Vec::new(), Vec::new()];
        for (balls, (_, solid, _)) in balls.iter_mut().zip(sides) {
            self.set_balls(clusters, solid, balls);
        }
        let mut best = None;
        for way in long {
            let out = way * (R::ONE / way.dot(way).sqrt());
            let mut farthest = R::ZERO;
            for ((few, balls), (_, _, sign)) in few.iter().zip(&balls).zip(sides) {
                for &(vertex, _) in few {
                    let exit = self.exit((clusters, balls), (self.point(vertex), out * sign));
                    farthest = farthest.max(exit.map_or(R::ZERO, |(_, way, _)| way));
                }
            }
            if best.is_none_or(|(least, _)| farthest < least) {
                best = Some((farthest, out));
            }
        }
        best.map(|(_, out)| out)
    }

    /// The face through which a line leads out of a shell nearest to where it starts, the way to
    /// it, and the weights of its corners.
    fn exit(
        &self,
        around: (&Clusters, &Balls<R>),
        line: (R::Vec3, R::Vec3),
    ) -> Option<(u32, R, [R; 3])> {
        let mut found: Option<(u32, R, [R; 3])> = None;
        self.visit(around, line, R::of(BESIDE), |face, way, facing, weights| {
            if R::ZERO < facing && found.is_none_or(|(_, known, _)| way.abs() < known.abs()) {
                found = Some((face, way, weights));
            }
        });
        found
    }

    /// Adds the rows of what was inside in the substep before. Two shells have none any more once
    /// all of that is outside by half of the distance at which they stop each other.
    pub(super) fn add_overlaps(
        &mut self,
        clusters: &Clusters,
        before: &[ContactRow<R>],
        balls: &mut Balls<R>,
    ) {
        let shells = self.at.shells;
        self.overlapping.clear();
        let mut looked_at = None;
        for row in before {
            let [_, solid] = features(row.key);
            if looked_at != Some(solid) {
                self.set_balls(clusters, solid as usize, balls);
                looked_at = Some(solid);
            }
            let Some(row) = self.ahead(clusters, balls, row) else { continue };
            if row.gap < -row.stop * R::HALF && !self.is_overlapping(row.overlapping(shells)) {
                let [a, b] = row.overlapping(shells);
                self.overlapping.push([a.min(b), a.max(b)]);
            }
            self.rows.push(row);
        }
        let mut rows = core::mem::take(&mut self.rows);
        rows.retain(|row| self.is_overlapping(row.overlapping(shells)));
        self.rows = rows;
    }

    /// The row of a vertex and the face through which it leaves the other shell, or has left it, in
    /// the direction that it has; none where it meets none any more, or nothing moves either.
    fn ahead(
        &self,
        clusters: &Clusters,
        balls: &Balls<R>,
        before: &ContactRow<R>,
    ) -> Option<ContactRow<R>> {
        let shells = self.at.shells;
        let (key, normal) = (before.key, before.normal);
        let [vertex, _] = features(key);
        let line = (self.point(vertex), normal);
        let (face, way, weights) = self.exit((clusters, balls), line)?;
        let corners = shells.faces[face as usize].corners;
        let Sides { vertices, weights } = Sides::of_face(vertex, corners, weights);
        let stop = shells.stop_of::<R>(vertex, corners[0]);
        let [friction, _] = shells.law_of(vertex, corners[0]);
        let gap = -way - stop;
        let deep = (-gap - stop * R::of(SLOP)).max(R::ZERO).min(stop);
        let carried = normal * (deep * R::of(1.0 / UNDOING));
        let row = ContactRow {
            key,
            vertices,
            weights,
            normal,
            stop,
            gap,
            carried,
            friction,
            ..ContactRow::default()
        };
        Some(ContactRow { mass: self.mass(&row)?, ..row })
    }

    /// Whether a vertex is inside the shell of some clusters, or on it: more faces ahead of it lead
    /// out than in.
    fn is_inside(&self, clusters: &Clusters, balls: &Balls<R>, vertex: u32) -> bool {
        let mut leaves = 0;
        let askew = R::Vec3::from_components(ASKEW.map(R::of));
        let line = (self.point(vertex), askew);
        let noise = R::of(self.at.shells.reach() * NOISE);
        self.visit((clusters, balls), line, R::ZERO, |_, way, facing, _| {
            if R::ZERO < facing {
                leaves += i32::from(-noise < way);
            } else {
                leaves -= i32::from(noise < way);
            }
        });
        0 < leaves
    }

    /// The way from a vertex to the nearest point of a shell.
    fn way_out(&self, vertex: u32, solid: usize) -> R::Vec3 {
        let shells = self.at.shells;
        let here = self.point(vertex);
        let each = shells.faces_of(solid).map(|face| (face, nearest::<R>(self.seen(face, here))));
        let nearer = |(_, a): &(u32, Nearest<R>), (_, b): &(u32, Nearest<R>)| {
            a.square.partial_cmp(&b.square).unwrap_or(Ordering::Equal)
        };
        let Some((face, found)) = each.min_by(nearer) else {
            return R::Vec3::ZERO;
        };
        let corners = self.seen(face, here).into_iter().zip(found.weights);
        corners.fold(R::Vec3::ZERO, |sum, (corner, weight)| sum + corner * weight)
    }

    fn set_balls(&self, clusters: &Clusters, shell: usize, balls: &mut Balls<R>) {
        balls.clear();
        for (number, cluster) in (0..).zip(&clusters.rows) {
            if self.at.shells.shell_of(cluster.vertices[0]) == shell {
                let around = Extent::<R>::around(cluster.corners.iter().map(|&v| self.point(v)));
                balls.push((number, around.middle(), around.diagonal() * R::of(0.25)));
            }
        }
    }

    /// Visits the faces of some clusters that a line through a point meets, or nearly: with the way
    /// to each along it, how far the face leads out, and the weights of its corners.
    fn visit(
        &self,
        (clusters, balls): (&Clusters, &Balls<R>),
        (here, along): (R::Vec3, R::Vec3),
        beside: R,
        mut visit: impl FnMut(u32, R, R, [R; 3]),
    ) {
        let square = along.dot(along);
        for &(cluster, middle, radius) in balls {
            let to = middle - here;
            let ahead = to.dot(along);
            if radius * R::of(1.01) < to.dot(to) - ahead * ahead / square {
                continue;
            }
            for &face in &clusters.rows[cluster as usize].faces {
                let [a, b, c] = self.seen(face, here);
                let normal = (b - a).cross(c - a);
                let facing = normal.dot(along);
                let weights = [b.cross(c), c.cross(a), a.cross(b)].map(|w| w.dot(along) / facing);
                if weights.iter().all(|&weight| -beside <= weight) {
                    visit(face, a.dot(normal) / facing, facing, weights);
                }
            }
        }
    }
}
