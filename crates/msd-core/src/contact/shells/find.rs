//! Rows of the features that are nearest to each other.

use super::distance::{between_edges, squares};
use super::features::{At, Edge, NONE};
use super::lists::{Candidates, ClusterPair, ListedPair, NOISE};
use super::margins::vertices_of;
use super::patch::Patch;
use super::row::{ContactRow, EDGE, EDGES, FACE, OBSTACLE, SLOP, VERTEX, features, key};
use crate::columns::LANES;
use crate::number::{Real, Vector, at_level};
use crate::triangle::{nearest, part_of_edge};
use alloc::vec::Vec;

/// Rows while they are being found.
pub(super) struct Finder<'a, R: Real> {
    pub(super) at: &'a At<'a, R>,
    pub(super) patch: &'a Patch<R>,
    /// Distance beyond their reach at which features are still found, metres.
    pub(super) margin: R,
    pub(super) rows: Vec<ContactRow<R>>,
    /// The keys of the rows.
    pub(super) keys: Vec<u64>,
    /// The features of a list that may be near each other, and where they are in it.
    pub(super) near: Vec<(u64, usize)>,
    /// Whether each vertex is in a row.
    pub(super) are_held: Vec<bool>,
    /// The pairs of shells that have other rows than those of features.
    pub(super) overlapping: Vec<[usize; 2]>,
}

impl<'a, R: Real> Finder<'a, R> {
    pub(super) fn new(at: &'a At<'a, R>, patch: &'a Patch<R>, margin: R) -> Self {
        Finder {
            at,
            patch,
            margin,
            rows: Vec::new(),
            keys: Vec::new(),
            near: Vec::new(),
            are_held: Vec::new(),
            overlapping: Vec::new(),
        }
    }

    /// Finds the rows of features that may be near each other and of obstacles, in the order of
    /// their keys with those that it has.
    pub(super) fn find(&mut self, lists: &mut Candidates<R>) {
        self.keys.clear();
        let most_margin = self.margin;
        for &number in &lists.due {
            let pair = &mut lists.pairs[number as usize];
            let features = pair.features.start as usize..pair.features.end as usize;
            self.glance(pair, &mut lists.features[features.clone()]);
            let untils = lists.features[features].iter().map(|listed| listed.until);
            pair.until = untils.fold(pair.listed_to, f64::min);
        }
        self.margin = most_margin;
        self.add_rows();
        self.obstacles();
    }

    /// Looks at the listed features of a pair between which the gap may be less than its margin.
    fn glance(&mut self, pair: &ClusterPair<R>, listed: &mut [ListedPair]) {
        self.margin = pair.margin;
        let margin = pair.margin + R::of(self.at.shells.reach() * NOISE);
        let most = pair.worn + margin.to_f64();
        let mut near = core::mem::take(&mut self.near);
        near.resize(listed.len(), (0, 0));
        let mut count = 0;
        // Without a branch: which are near is hard to guess.
        for (at, pair) in listed.iter().enumerate() {
            near[count] = (pair.key, at);
            count += usize::from(pair.until < most);
        }
        near.truncate(count);
        for of_kind in near.chunk_by(|a, b| a.0 >> 62 == b.0 >> 62) {
            for few in of_kind.chunks(LANES) {
                let points = (self.at.shells, &self.patch.points[..]);
                let squares = at_level!(self.at.level, simd => squares::<_, R>(simd, points, few));
                for (&(key, at), square) in few.iter().zip(squares) {
                    let mut gap = square.sqrt() - pair.stop;
                    if gap < margin {
                        gap = self.see(key);
                    }
                    listed[at].until = pair.worn + gap.to_f64();
                }
            }
        }
        self.near = near;
    }

    /// Takes note of the row of two features, if they have one; returns the gap between them.
    #[inline(always)]
    fn see(&mut self, pair: u64) -> R {
        let both = features(pair);
        match pair >> 62 {
            FACE => self.face(both),
            EDGE => self.end(both),
            _ => self.edges(both),
        }
    }

    #[inline(always)]
    pub(super) fn point(&self, vertex: u32) -> R::Vec3 {
        self.patch.points[vertex as usize]
    }

    /// The corners of a face as seen from a point.
    ///
    /// Without `map`, which is not always compiled into the loop around it.
    #[inline(always)]
    pub(super) fn seen(&self, face: u32, from: R::Vec3) -> [R::Vec3; 3] {
        let [a, b, c] = self.at.shells.faces[face as usize].corners;
        [self.point(a) - from, self.point(b) - from, self.point(c) - from]
    }

    /// The square of the distance of a point from a face.
    fn square(&self, point: R::Vec3, face: u32) -> R {
        nearest::<R>(self.seen(face, point)).square
    }

    /// Adds the rows of the keys noted, each once.
    fn add_rows(&mut self) {
        self.keys.sort_unstable();
        self.keys.dedup();
        let mut rows = core::mem::take(&mut self.rows);
        let overlaps = rows.len();
        let met = self.keys.iter().filter(|&&key| !self.is_exempt(key));
        rows.extend(met.filter_map(|&key| self.row(key, self.sides(key))));
        rows.rotate_left(overlaps);
        self.rows = rows;
    }

    /// Whether two shells have other rows than those of features.
    pub(super) fn is_overlapping(&self, [a, b]: [usize; 2]) -> bool {
        self.overlapping.contains(&[a.min(b), a.max(b)])
    }

    /// Whether features are exempt from meeting each other.
    fn is_exempt(&self, key: u64) -> bool {
        let shells = self.at.shells;
        let pair = || vertices_of(shells, key).map(|vertex| shells.shell_of(vertex));
        if !self.overlapping.is_empty() && self.is_overlapping(pair()) {
            return true;
        }
        let [a, b] = features(key);
        let edge = |edge: u32| &shells.edges[edge as usize].ends;
        match key >> 62 {
            FACE => shells.exempts(&[a], &shells.faces[b as usize].corners),
            EDGE => shells.exempts(&[a], edge(b)),
            VERTEX => shells.exempts(&[a], &[b]),
            _ => shells.exempts(edge(a), edge(b)),
        }
    }

    /// The row of some features; none where they are too far apart, or nothing moves either.
    #[inline(always)]
    fn row(&self, key: u64, sides: Sides<R>) -> Option<ContactRow<R>> {
        let Sides { vertices, weights } = sides;
        let stop = self.at.shells.stop_of::<R>(vertices[0], vertices[3]);
        let mut row = ContactRow { key, vertices, weights, stop, ..ContactRow::default() };
        let way = row.relative(&self.patch.points);
        let square = way.dot(way);
        let most = stop + self.margin;
        if most * most <= square || square < R::SHORTEST_SQUARED {
            return None;
        }
        let distance = square.sqrt();
        row.normal = way * (R::ONE / distance);
        row.gap = distance - stop;
        row.mass = self.mass(&row)?;
        [row.friction, row.restitution] = self.at.shells.law_of(vertices[0], vertices[3]);
        Some(row)
    }

    /// The points of two features that are nearest to each other.
    fn sides(&self, key: u64) -> Sides<R> {
        let shells = self.at.shells;
        let [a, b] = features(key);
        match key >> 62 {
            FACE => {
                let corners = shells.faces[b as usize].corners;
                let weights = nearest::<R>(self.seen(b, self.point(a))).weights;
                Sides::of_face(a, corners, weights)
            }
            EDGE => {
                let [from, to] = shells.edges[b as usize].ends;
                let here = self.point(a);
                let part = part_of_edge::<R>(self.point(from) - here, self.point(to) - here);
                Sides::new([a, from, to], [R::ONE, part - R::ONE, -part])
            }
            VERTEX => Sides::new([a, b], [R::ONE, -R::ONE]),
            _ => {
                let edges = [a, b].map(|edge| shells.edges[edge as usize].ends);
                let parts = self.parts(edges).unwrap_or([R::HALF; 2]);
                Sides::of_edges(edges, parts.map(|part| part.max(R::ZERO).min(R::ONE)))
            }
        }
    }

    /// The same of the plane of a face, or the lines of edges, in place of these.
    fn sides_beyond(&self, key: u64) -> Sides<R> {
        let shells = self.at.shells;
        let [a, b] = features(key);
        match key >> 62 {
            FACE => {
                let corners = shells.faces[b as usize].corners;
                let [p, q, r] = self.seen(b, self.point(a));
                let normal = (q - p).cross(r - p);
                let per_area = R::ONE / normal.dot(normal).max(R::SHORTEST_SQUARED);
                let [v, w] = [r.cross(p), p.cross(q)].map(|part| part.dot(normal) * per_area);
                Sides::of_face(a, corners, [R::ONE - v - w, v, w])
            }
            EDGE => {
                let [from, to] = shells.edges[b as usize].ends;
                let [start, end] = [from, to].map(|end| self.point(end) - self.point(a));
                let along = end - start;
                let part = -start.dot(along) / along.dot(along).max(R::SHORTEST_SQUARED);
                Sides::new([a, from, to], [R::ONE, part - R::ONE, -part])
            }
            EDGES => {
                let edges = [a, b].map(|edge| shells.edges[edge as usize].ends);
                Sides::of_edges(edges, self.parts(edges).unwrap_or([R::HALF; 2]))
            }
            _ => self.sides(key),
        }
    }

    /// Where the lines of two edges are nearest to each other, in parts of the edges; none where
    /// they are parallel.
    #[inline(always)]
    fn parts(&self, [own, other]: [[u32; 2]; 2]) -> Option<[R; 2]> {
        let [p, p_end] = [self.point(own[0]), self.point(own[1])];
        let [q, q_end] = [self.point(other[0]), self.point(other[1])];
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

    /// Lets a face take the couple of friction, by its corners. It is the first of some that faces
    /// the normal well, or the one that faces it most. A small couple would turn a face far if the
    /// normal were nearly along it.
    fn turn_one(&self, row: &mut ContactRow<R>, faces: impl Iterator<Item = [u32; 3]>) {
        let mut best = R::of(LEAST_FACING);
        for corners in faces {
            let [a, b, c] = corners.map(|corner| self.point(corner));
            let across = (b - a).cross(c - a);
            let area = across.dot(row.normal);
            let facing = area * area / across.dot(across);
            if facing <= best {
                continue;
            }
            best = facing;
            row.turns = true;
            row.turning = corners;
            row.turns_by = turns_by::<R>([a, b, c], (row.normal, row.gap + row.stop));
            if R::HALF < facing {
                break;
            }
        }
    }

    /// Lets a face at the features of a row take the couple of friction.
    pub(super) fn turn(&self, row: &mut ContactRow<R>) {
        if row.is_of_features() && R::ZERO < row.friction {
            let corners = |face: u32| self.at.shells.faces[face as usize].corners;
            self.turn_one(row, self.faces_of(row.key).map(corners));
        }
    }

    /// Returns whether a vertex passes an edge or another vertex, and the faces there, in a drift
    /// of h seconds at a velocity. The plane between the two, at which a row stops it, is a wall
    /// across its way.
    pub(super) fn passes(&self, row: &ContactRow<R>, velocity: R::Vec3, h: R) -> bool {
        let (shells, [own, other]) = (self.at.shells, features(row.key));
        let (way, drift) = (row.normal * (row.gap + row.stop), velocity * h);
        let along = match row.key >> 62 {
            EDGE => {
                let [from, to] = shells.edges[other as usize].ends;
                self.point(to) - self.point(from)
            }
            VERTEX => R::Vec3::ZERO,
            _ => return false,
        };
        // Balls and ropes have no faces on which vertices lie a bit closer than they stop.
        let mut least = row.stop * R::of(1.0 - 1e-3 * SLOP);
        let length = along.dot(along).max(R::SHORTEST_SQUARED);
        let across = drift - along * (along.dot(drift) / length);
        let part = (-way.dot(across) / across.dot(across)).max(R::ZERO).min(R::ONE);
        let nearest = way + across * part;
        let mut stays_off = |face: u32| {
            let is_own = shells.faces[face as usize].corners.contains(&own);
            let (start, drift) =
                if is_own { (self.point(other), -drift) } else { (self.point(own), drift) };
            let [a, b, c] = self.seen(face, start);
            let normal = (b - a).cross(c - a);
            let height = (a.dot(normal) / normal.dot(normal).sqrt()).abs();
            // A vertex that lies a bit closer than its stop slides on at that distance.
            let slid = row.stop.min(height).max(row.stop * R::of(1.0 - SLOP));
            let limit = slid * R::of(1.0 - 1e-3 * SLOP);
            least = least.min(limit);
            // Where it would be in the plane of the face, or nearest to it.
            let part = a.dot(normal) / drift.dot(normal);
            let is_within = R::ZERO < part && part < R::ONE;
            let place = start + if is_within { drift * part } else { drift };
            limit * limit <= self.square(place, face)
        };
        self.faces_of(row.key).all(&mut stays_off) && least * least <= nearest.dot(nearest)
    }

    /// Lets a row follow its features to their current places; the same face takes the couple. A
    /// row that slid off them stays on the features that continue them: their border would push it
    /// back or on.
    pub(super) fn follow(&self, row: &mut ContactRow<R>) {
        let Some(mut new) = self.row(row.key, self.sides(row.key)) else { return };
        let is_off = |(new, old): (&R, &R)| *new == R::ZERO && *old != R::ZERO;
        if new.weights.iter().zip(&row.weights).any(is_off) {
            let Some(beyond) = self.row(row.key, self.sides_beyond(row.key)) else { return };
            new = beyond;
        }
        if row.turns {
            self.turn_one(&mut new, core::iter::once(row.turning));
        }
        (new.push, new.parting) = (row.push, row.parting);
        new.rub = row.rub - new.normal * new.normal.dot(row.rub);
        *row = new;
    }

    /// The mass of both sides of a row, kilograms; none where nothing moves either.
    pub(super) fn mass(&self, row: &ContactRow<R>) -> Option<R> {
        let each = row.vertices.iter().zip(row.weights);
        let inverse = each.fold(R::ZERO, |sum, (&vertex, weight)| {
            sum + weight * weight * self.patch.inverse_masses[vertex as usize]
        });
        (R::ZERO < inverse).then(|| R::ONE / inverse)
    }

    /// Finds the row of a vertex and a face, or of the vertex and an edge or a corner of it;
    /// returns the gap between them.
    #[inline(always)]
    fn face(&mut self, [vertex, number]: [u32; 2]) -> R {
        let shells = self.at.shells;
        let face = shells.faces[number as usize];
        let here = self.point(vertex);
        let stop = shells.stop_of::<R>(vertex, face.corners[0]);
        let met = nearest::<R>(self.seen(number, here));
        let gap = met.square.sqrt() - stop;
        if self.margin <= gap {
            return gap;
        }
        let zeros = met.weights.map(|weight| weight == R::ZERO);
        match zeros.iter().filter(|&&zero| zero).count() {
            0 => self.keys.push(key(FACE, vertex, number)),
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
                        return gap;
                    }
                }
                self.keys.push(key(EDGE, vertex, edge));
            }
            _ => {
                let corner = zeros.iter().position(|&zero| !zero).unwrap_or(0);
                self.corner(vertex, face.corners[corner]);
            }
        }
        gap
    }

    /// Finds the row of a vertex and an edge of no face, or of the vertex and an end of it; returns
    /// the gap between them.
    fn end(&mut self, [vertex, number]: [u32; 2]) -> R {
        let [a, b] = self.at.shells.edges[number as usize].ends;
        let here = self.point(vertex);
        let [from, to] = [a, b].map(|end| self.point(end) - here);
        let part = part_of_edge::<R>(from, to);
        let way = from + (to - from) * part;
        let stop = self.at.shells.stop_of::<R>(vertex, a);
        let gap = way.dot(way).sqrt() - stop;
        if self.margin <= gap {
            return gap;
        }
        if part == R::ZERO {
            self.corner(vertex, a);
        } else if part == R::ONE {
            self.corner(vertex, b);
        } else {
            self.keys.push(key(EDGE, vertex, number));
        }
        gap
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
        self.keys.push(key(VERTEX, a, b));
    }

    /// Finds the row of two edges whose nearest points are inside of both; returns the gap between
    /// them.
    #[inline(always)]
    fn edges(&mut self, [a, b]: [u32; 2]) -> R {
        let shells = self.at.shells;
        let [own, other] = [a, b].map(|edge| shells.edges[edge as usize].ends);
        let stop = shells.stop_of::<R>(own[0], other[0]);
        let [p, q] = [own, other].map(|ends| ends.map(|end| self.point(end)));
        let is_inside = |parts: &[R; 2]| parts.iter().all(|&s| R::ZERO < s && s < R::ONE);
        let Some([s, t]) = self.parts([own, other]).filter(is_inside) else {
            let [p, q] = [p, q].map(|ends| ends.map(R::Vec3::components));
            return between_edges(p, q).sqrt() - stop;
        };
        let [here, there] = [(p, s), (q, t)].map(|([from, to], part)| from + (to - from) * part);
        let square = (here - there).dot(here - there);
        let gap = square.sqrt() - stop;
        if self.margin <= gap {
            return gap;
        }
        let way = there - here;
        let is_led =
            self.leads(a, (here, way, square), other) || self.leads(b, (there, -way, square), own);
        if !is_led {
            self.keys.push(key(EDGES, a, b));
        }
        gap
    }

    /// Whether a face beside an edge leads from a point of it along a way across the edge, so that
    /// the face is nearer to where the way ends than the edge is. Faces at others do not count.
    fn leads(
        &self,
        edge: u32,
        (here, way, square): (R::Vec3, R::Vec3, R),
        other: [u32; 2],
    ) -> bool {
        let shells = self.at.shells;
        let Edge { ends, faces } = shells.edges[edge as usize];
        let along = self.point(ends[1]) - self.point(ends[0]);
        faces.into_iter().filter(|&face| face != NONE).any(|face| {
            let corners = shells.faces[face as usize].corners;
            let third = corners.into_iter().find(|corner| !ends.contains(corner));
            let Some(third) = third.filter(|_| !other.iter().any(|end| corners.contains(end)))
            else {
                return false;
            };
            let inwards = self.point(third) - here;
            let (leads, slides) = (inwards.dot(way), inwards.dot(along));
            let across = inwards.dot(inwards) - slides * slides / along.dot(along);
            R::ZERO < leads && R::of(FLAT) * (square * across) < leads * leads
        })
    }

    /// Adds the rows of obstacles and of vertices that are in a row: a vertex on an obstacle bears
    /// the particles that lie on it.
    fn obstacles(&mut self) {
        let At { obstacles, time, .. } = *self.at;
        if obstacles.is_empty() || self.rows.is_empty() {
            return;
        }
        self.are_held.clear();
        self.are_held.resize(self.patch.points.len(), false);
        for row in &self.rows {
            row.vertices.iter().for_each(|&vertex| self.are_held[vertex as usize] = true);
        }
        let is_held = |&vertex: &u32| self.are_held[vertex as usize];
        for vertex in (0..self.are_held.len() as u32).filter(is_held) {
            let here = self.point(vertex);
            let radius = self.at.shells.radius_of::<R>(vertex);
            for index in 0..obstacles.count() {
                let obstacle = obstacles.get(index);
                let gap = obstacle.gap(here, time) - radius;
                if self.margin <= gap {
                    continue;
                }
                let row = ContactRow {
                    key: EDGES << 62 | OBSTACLE | u64::from(vertex) << 24 | index as u64,
                    vertices: [vertex; 4],
                    weights: [R::ONE, R::ZERO, R::ZERO, R::ZERO],
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
    }
}

/// The square of the cosine between a normal and that of a face, from which on it takes couples.
const LEAST_FACING: f64 = 0.1;

/// The part by which a face must be nearer than an edge of it to count instead of it. Where both
/// lie in flat surface they would take turns.
const FLAT: f64 = 2e-3;

/// Two sides of a row, by vertices with weights: where they are fewer than four, the last again
/// without a weight.
#[derive(Clone, Copy)]
pub(super) struct Sides<R> {
    pub(super) vertices: [u32; 4],
    pub(super) weights: [R; 4],
}

impl<R: Real> Sides<R> {
    #[inline(always)]
    fn new<const N: usize>(vertices: [u32; N], weights: [R; N]) -> Self {
        let mut sides = Sides { vertices: [vertices[N - 1]; 4], weights: [R::ZERO; 4] };
        sides.vertices[..N].copy_from_slice(&vertices);
        sides.weights[..N].copy_from_slice(&weights);
        sides
    }

    #[inline(always)]
    pub(super) fn of_face(vertex: u32, [a, b, c]: [u32; 3], [u, v, w]: [R; 3]) -> Self {
        Sides::new([vertex, a, b, c], [R::ONE, -u, -v, -w])
    }

    #[inline(always)]
    fn of_edges([own, other]: [[u32; 2]; 2], [s, t]: [R; 2]) -> Self {
        let ends = [own[0], own[1], other[0], other[1]];
        Sides::new(ends, [R::ONE - s, s, t - R::ONE, -t])
    }
}

/// The distance of both sides of a row times the gradient of the weights of a face, as seen along
/// the normal of the row.
fn turns_by<R: Real>([a, b, c]: [R::Vec3; 3], (normal, distance): (R::Vec3, R)) -> [R::Vec3; 3] {
    let by = distance / (b - a).cross(c - a).dot(normal);
    [c - b, a - c, b - a].map(|side| normal.cross(side) * by)
}
