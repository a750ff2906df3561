//! Bodies that cross at the start: particles inside a closed one are pushed out of it.
//!
//! Ordinary rows keep features on the sides on which they are, and so would keep a particle inside.
//! Two shells that cross at the start have other rows until they are apart. There is one for each
//! particle that starts inside, with the face straight ahead of it. Both sides part at a bounded
//! speed: by the distance at which they stop each other in each `UNDOING`. All rows of the two have
//! one direction, which keeps the shape of the body that is pushed out. Towards the nearest face
//! each, particles beside an edge would leave on different sides of it. The work of the rows counts
//! as work of solids.

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
/// Distance outside of a face at which a line still meets it, as a part of the face, so that faces
/// leave no gap.
const BESIDE: f64 = 0.05;
/// A direction in which no edges of lattices lie.
const ASKEW: [f64; 3] = [0.5291, 0.7127, 0.4607];

/// The clusters of a shell, and the balls around them: where they are, and their radii squared.
pub(super) type Balls<R> = Vec<(u32, <R as Real>::Vec3, R)>;

/// The vertices of a shell that are inside another one, which they leave in the direction of the
/// first shell of the two, or in the opposite one.
struct Inside<R: Real> {
    vertices: Vec<u32>,
    solid: usize,
    balls: Balls<R>,
    sign: R,
}

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
        let mut crosses = false;
        let sides = [(a, b, R::ONE), (b, a, -R::ONE)].map(|(own, solid, sign)| {
            let mut balls = Vec::new();
            if are_closed[solid] {
                self.set_balls(clusters, solid, &mut balls);
            }
            let own = shells.vertices_of(own);
            let count = own.len();
            let all: Vec<u32> = own.filter(|&v| self.is_inside(clusters, &balls, v)).collect();
            crosses |= !all.is_empty() && all.len() < count;
            Inside { vertices: few(&all, MOST).collect(), solid, balls, sign }
        });
        if !crosses {
            return Vec::new();
        }
        let Some(out) = self.way_apart(clusters, &sides) else { return Vec::new() };
        let row = |vertex: u32, side: &Inside<R>| ContactRow {
            key: EDGES << 62 | OVERLAP | u64::from(vertex) << 30 | side.solid as u64,
            normal: out * side.sign,
            ..ContactRow::default()
        };
        let each = sides.iter().map(|side| (side, &side.vertices));
        each.flat_map(|(side, all)| all.iter().map(move |&vertex| row(vertex, side))).collect()
    }

    /// The direction in which the first of two shells is soonest out of the other: along the
    /// shortest way out of one of the vertices inside.
    fn way_apart(&self, clusters: &Clusters, sides: &[Inside<R>; 2]) -> Option<R::Vec3> {
        let ways: Vec<R::Vec3> = sides
            .iter()
            .flat_map(|side| {
                let way = |vertex| self.way_out(vertex, side.solid) * side.sign;
                few(&side.vertices, MOST_WAYS).map(way)
            })
            .collect();
        let all = ways.iter().fold(R::Vec3::ZERO, |sum, way| sum + *way);
        let [middle, other] = [&sides[1], &sides[0]].map(|side| {
            let points = self.at.shells.vertices_of(side.solid).map(|vertex| self.point(vertex));
            Extent::<R>::around(points).middle()
        });
        let mut best = None;
        for way in ways.into_iter().chain([all, middle - other]) {
            let square = way.dot(way);
            if square <= R::SHORTEST_SQUARED {
                continue;
            }
            let out = way * (R::ONE / square.sqrt());
            let mut farthest = R::ZERO;
            for Inside { vertices, balls, sign, .. } in sides {
                for vertex in few(vertices, MOST_WAYS) {
                    let exit = self.exit((clusters, balls), (self.point(vertex), out * *sign));
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

    /// Adds the rows of vertices that were inside in the previous substep. Two shells have none any
    /// more once all of that is outside by half of the distance at which they stop each other.
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
    /// the direction that it has. None where it meets no face any more, or nothing moves either.
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
            if self.at.shells.shell_of(cluster.vertices[0].number) == shell {
                let corners = &clusters.corners[cluster.corners.clone()];
                let around = Extent::<R>::around(corners.iter().map(|&v| self.point(v)));
                balls.push((number, around.middle(), around.diagonal() * R::of(0.25)));
            }
        }
    }

    /// Visits the faces of some clusters that a line through a point meets, or nearly. Each comes
    /// with the way to it along the line, the part by which it leads out, and the weights of its
    /// corners.
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
            for face in &clusters.rows[cluster as usize].faces {
                let face = face.number;
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

/// At most so many of some vertices, spread over all of them.
fn few(vertices: &[u32], most: usize) -> impl Iterator<Item = u32> + '_ {
    vertices.iter().step_by(vertices.len().div_ceil(most).max(1)).copied()
}
