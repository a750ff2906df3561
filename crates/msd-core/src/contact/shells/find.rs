//! Rows of shells that are near each other, and the lists of features from which they are found.

use super::features::{NONE, Shells};
use super::sweep;
use crate::columns::vector;
use crate::contact::Contacts;
use crate::grid::Grid;
use crate::number::{Real, Vector};
use crate::obstacles::Obstacles;
use crate::triangle::{around, nearest};
use alloc::vec::Vec;
use core::convert::Infallible;
use glam::DVec3;

/// A contact: up to four particles, and what keeps two sides of them apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<R: Real> {
    /// Which features: their kind, and the number of each.
    key: u64,
    /// Where the numbers of each particle are in a column of vectors, and their weights: positive
    /// on one side, negative on the other.
    pub(super) at: [u32; 4],
    pub(super) weights: [R; 4],
    pub(super) count: usize,
    /// Direction from the second side to the first, length one.
    pub(super) normal: R::Vec3,
    /// A face that takes the couple of friction: whether there is one, where the numbers of its
    /// corners are, and the distance of both sides times the gradient of their weights.
    pub(super) turns: bool,
    pub(super) turning: [u32; 3],
    pub(super) turns_by: [R::Vec3; 3],
    /// The distance at which it stops them, and by how much they are farther apart, metres.
    pub(super) stop: R,
    pub(super) gap: R,
    /// Velocity of the second side where that is an obstacle, metres per second.
    pub(super) carried: R::Vec3,
    /// The mass that both sides have along the normal, kilograms.
    pub(super) mass: R,
    pub(super) friction: R,
    /// The impulse given along the normal and across it, newton seconds.
    pub(super) push: R,
    pub(super) rub: R::Vec3,
    /// The velocity of one side as seen from the other before the last kick, metres per second, and
    /// the impulse that has been booked already.
    pub(super) before: R::Vec3,
    pub(super) booked: R::Vec3,
}

/// The impulse of a row, from which the next substep starts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RowImpulse {
    /// Which features it is between: their kind, and the number of each.
    pub key: u64,
    /// Along the normal, newton seconds.
    pub push: f64,
    /// Across the normal, newton seconds.
    pub rub: DVec3,
}

/// Kinds of rows, in the highest bits of their keys.
const FACE: u64 = 0;
const EDGE: u64 = 1;
const VERTEX: u64 = 2;
const EDGES: u64 = 3;
/// What marks a row of a vertex and an obstacle among those of edges.
const OBSTACLE: u64 = 1 << 61;

fn key(kind: u64, a: u32, b: u32) -> u64 {
    kind << 62 | u64::from(a) << 30 | u64::from(b)
}

/// The rows of a model, and the features that may be near each other.
#[derive(Clone, Debug)]
pub(crate) struct Rows<R: Real> {
    rows: Vec<Row<R>>,
    /// The rows of the substep before.
    last: Vec<Row<R>>,
    /// Vertices and faces, vertices and edges of no face, and edges that may be near each other.
    facing: Vec<[u32; 2]>,
    ending: Vec<[u32; 2]>,
    crossing: Vec<[u32; 2]>,
    /// Positions where these were listed; empty where there is no list.
    from: Vec<R>,
    /// How far beyond their reach listed features may have been, metres.
    skin: R,
    grid: Grid,
    /// Vertices in rows.
    used: Vec<u32>,
}

impl<R: Real> Default for Rows<R> {
    fn default() -> Self {
        Rows {
            rows: Vec::new(),
            last: Vec::new(),
            facing: Vec::new(),
            ending: Vec::new(),
            crossing: Vec::new(),
            from: Vec::new(),
            skin: R::ZERO,
            grid: Grid::default(),
            used: Vec::new(),
        }
    }
}

/// A state in columns, and what the rows of it depend on.
pub(crate) struct At<'a, R: Real> {
    pub(crate) shells: &'a Shells,
    pub(crate) obstacles: &'a Obstacles<R>,
    pub(crate) inverse_masses: &'a [R],
    /// Simulated time, seconds.
    pub(crate) time: f64,
}

impl<R: Real> Rows<R> {
    /// Discards the lists: features are other ones.
    pub(crate) fn forget(&mut self) {
        self.from.clear();
    }

    /// The impulses from which the next substep starts.
    pub(crate) fn impulses(&self) -> Vec<RowImpulse> {
        let mut impulses = Vec::new();
        self.keep(&mut impulses);
        impulses
    }

    /// Overwrites `impulses` with those from which the next substep starts.
    pub(crate) fn keep(&self, impulses: &mut Vec<RowImpulse>) {
        impulses.clear();
        let given = self.rows.iter().filter(|row| row.push != R::ZERO);
        let impulse = |row: &Row<R>| RowImpulse {
            key: row.key,
            push: row.push.to_f64(),
            rub: row.rub.to_f64(),
        };
        impulses.extend(given.map(impulse));
    }

    /// Scales these impulses to another substep.
    pub(crate) fn scale(&mut self, factor: f64) {
        let factor = R::of(factor);
        for row in &mut self.rows {
            (row.push, row.rub) = (row.push * factor, row.rub * factor);
        }
    }

    /// Replaces these impulses, in the order of their keys.
    pub(crate) fn set_impulses(&mut self, impulses: &[RowImpulse]) {
        let row = |impulse: &RowImpulse| Row {
            key: impulse.key,
            push: R::of(impulse.push),
            rub: R::Vec3::of(impulse.rub),
            ..Row::default()
        };
        self.rows.clear();
        self.rows.extend(impulses.iter().map(row));
    }

    /// Lets shells meet after a kick of `length` seconds by some forces, before a drift of `h` seconds, and
    /// returns whether particles are so fast that some may have crossed.
    pub(crate) fn meet(
        &mut self,
        at: &At<'_, R>,
        [positions, velocities]: [&mut [R]; 2],
        forces: &[R],
        (length, h): (R, R),
    ) -> (Contacts, bool) {
        let is_fast = self.find(at, [positions, velocities, &[]], h);
        let (rows, w) = (&mut self.rows, at.inverse_masses);
        sweep::note(rows, [velocities, forces, w], length);
        sweep::give(rows, velocities, w);
        sweep::sweep(rows, velocities, w, Some(h));
        sweep::part(rows, positions, w, h);
        (sweep::work(rows, velocities), is_fast)
    }

    /// Lets the rows of the substep hold after a kick that no drift follows, where their particles
    /// are now.
    pub(crate) fn hold(
        &mut self,
        inverse_masses: &[R],
        (positions, velocities): (&[R], &mut [R]),
        (forces, length): (&[R], R),
    ) -> Contacts {
        let rows = &mut self.rows;
        rows.iter_mut().filter(|row| row.push != R::ZERO).for_each(|row| row.follow(positions));
        sweep::note(rows, [velocities, forces, inverse_masses], length);
        sweep::give(rows, velocities, inverse_masses);
        sweep::sweep(rows, velocities, inverse_masses, None);
        sweep::work(rows, velocities)
    }

    /// Finds the rows at the start of a substep of h seconds, in the stages of which their last
    /// impulses act as constant forces, and returns whether particles are so fast that some may
    /// cross.
    pub(crate) fn begin(&mut self, at: &At<'_, R>, columns: [&[R]; 3], h: R) -> bool {
        self.find(at, columns, h)
    }

    /// Adds the impulses as forces that act for h seconds.
    pub(crate) fn add_forces(&self, forces: &mut [R], h: R) {
        sweep::add_forces(&self.rows, forces, R::ONE / h);
    }

    /// Corrects the outcome of such a substep by its mean velocities, and then its last ones.
    pub(crate) fn end(
        &mut self,
        inverse_masses: &[R],
        [positions, velocities, means]: [&mut [R]; 3],
        h: R,
    ) -> Contacts {
        let (rows, w) = (&mut self.rows, inverse_masses);
        rows.iter_mut().for_each(|row| row.booked = row.impulse());
        sweep::sweep(rows, means, w, Some(h));
        for row in rows.iter_mut() {
            let change = row.impulse() - row.booked;
            if change != R::Vec3::ZERO {
                row.give(velocities, w, change);
                row.give(positions, w, change * h);
            }
            (row.before, row.booked) = (row.velocity(means), R::Vec3::ZERO);
        }
        let contacts = sweep::work(rows, means);
        sweep::part(rows, positions, w, h);
        for row in rows.iter_mut().filter(|row| row.push != R::ZERO) {
            row.follow(positions);
            (row.before, row.booked) = (row.velocity(velocities), row.impulse());
        }
        sweep::sweep(rows, velocities, w, None);
        contacts + sweep::work(rows, velocities)
    }

    /// Lets the rows of the substep hold velocities that are predicted for its end; they keep their
    /// impulses.
    pub(crate) fn hold_predicted(&mut self, velocities: &mut [R], inverse_masses: &[R]) {
        self.last.clear();
        self.last.extend_from_slice(&self.rows);
        sweep::give(&self.last, velocities, inverse_masses);
        sweep::sweep(&mut self.last, velocities, inverse_masses, None);
    }

    /// Finds the rows at a state that drifts for h seconds, each with the impulse that it gave
    /// last.
    ///
    /// Forces count where the drift is faster than the velocities by them; empty where they do not.
    fn find(&mut self, at: &At<'_, R>, [positions, velocities, forces]: [&[R]; 3], h: R) -> bool {
        let shells = at.shells;
        let mut margin = self.margin(shells, velocities, h);
        if !forces.is_empty() {
            let kick = |place: usize| vector::<R>(forces, place) * (at.inverse_masses[place] * h);
            let kicks = shells.vertices.iter().map(|vertex| kick(vertex.at as usize));
            margin += diagonal::<R>(kicks.chain([R::Vec3::ZERO])) * h;
        }
        let most = R::of(MOST_MARGIN) * R::of(longest_edge(shells, positions));
        let (is_fast, margin) = (most < margin, margin.min(most));
        if self.skin < margin + self.worn(shells, positions) {
            self.list(shells, positions, margin);
        }
        core::mem::swap(&mut self.rows, &mut self.last);
        self.rows.clear();
        let mut found = Found { at, positions, margin, rows: core::mem::take(&mut self.rows), used: core::mem::take(&mut self.used) };
        found.used.clear();
        self.facing.iter().for_each(|&pair| found.face(pair));
        self.ending.iter().for_each(|&pair| found.end(pair));
        self.crossing.iter().for_each(|&pair| found.edges(pair));
        found.rows.sort_unstable_by_key(|row| row.key);
        found.rows.dedup_by_key(|row| row.key);
        found.obstacles();
        (self.rows, self.used) = (found.rows, found.used);
        self.warm();
        is_fast
    }

    /// Gives each row the impulse of that of the substep before between the same features.
    fn warm(&mut self) {
        let mut last = self.last.iter().peekable();
        for row in &mut self.rows {
            while last.next_if(|before| before.key < row.key).is_some() {}
            if let Some(before) = last.next_if(|before| before.key == row.key) {
                row.push = before.push;
                row.rub = before.rub - row.normal * row.normal.dot(before.rub);
            }
        }
    }

    /// How much closer two particles of shells, or one and an obstacle that stands still, can come
    /// in h seconds, metres.
    fn margin(&self, shells: &Shells, velocities: &[R], h: R) -> R {
        let each = shells.vertices.iter().map(|vertex| vector::<R>(velocities, vertex.at as usize));
        diagonal::<R>(each.chain([R::Vec3::ZERO])) * h * R::of(SPARE)
    }

    /// How much closer two particles can have come since features were listed, metres; more than
    /// the skin where there is no list.
    fn worn(&self, shells: &Shells, positions: &[R]) -> R {
        if self.from.is_empty() {
            return self.skin + R::ONE;
        }
        diagonal::<R>(shells.vertices.iter().map(|vertex| {
            let at = vertex.at as usize;
            vector::<R>(positions, at) - vector::<R>(&self.from, at)
        }))
    }

    fn list(&mut self, shells: &Shells, positions: &[R], margin: R) {
        let edge = R::of(longest_edge(shells, positions));
        self.skin = (edge * R::HALF).max(margin + margin);
        self.from.clear();
        self.from.extend_from_slice(positions);
        let reach = (R::of(shells.reach()) + self.skin).to_f64();
        let boxes = Boxes::new(shells, positions, reach);
        let places = shells.vertices.iter().map(|vertex| {
            vector::<R>(positions, vertex.at as usize).to_f64()
        });
        let (grid, edge) = (&mut self.grid, edge.to_f64());
        grid.fill(reach + edge, places);
        self.facing.clear();
        self.ending.clear();
        self.crossing.clear();
        for (number, face) in (0u32..).zip(&shells.faces) {
            let corners = shells.points(positions, face.corners).map(Vector::to_f64);
            let [low, high] = around(corners, reach);
            if !boxes.meet(shells, face.corners[0], [low, high]) {
                continue;
            }
            each_in(grid, [low, high], |vertex| {
                let is_other = !face.corners.contains(&vertex);
                if is_other && shells.do_meet(vertex, face.corners[0]) {
                    self.facing.push([vertex, number]);
                }
            });
        }
        let is_bare = |edge: &&super::features::Edge| edge.faces == [NONE; 2];
        for (number, edge) in (0u32..).zip(&shells.edges).filter(|(_, edge)| is_bare(&edge)) {
            let [a, b] = shells.points(positions, edge.ends).map(Vector::to_f64);
            each_in(grid, around([a, b, b], reach), |vertex| {
                if !edge.ends.contains(&vertex) && shells.do_meet(vertex, edge.ends[0]) {
                    self.ending.push([vertex, number]);
                }
            });
        }
        let middles = shells.edges.iter().map(|edge| {
            let [a, b] = shells.points(positions, edge.ends).map(Vector::to_f64);
            (a + b) * 0.5
        });
        grid.fill(reach + edge, middles);
        for (number, own) in (0u32..).zip(&shells.edges) {
            let [a, b] = shells.points(positions, own.ends).map(Vector::to_f64);
            let corners = around([a, b, b], reach);
            if !boxes.meet(shells, own.ends[0], corners) {
                continue;
            }
            let wide = around([a, b, b], reach + 0.5 * edge);
            each_in(grid, wide, |other| {
                let ends = shells.edges[other as usize].ends;
                let is_other = number < other && !own.ends.iter().any(|end| ends.contains(end));
                if is_other && shells.do_meet(own.ends[0], ends[0]) {
                    let [low, high] = corners;
                    let [a, b] = shells.points(positions, ends).map(Vector::to_f64);
                    if a.min(b).cmple(high).all() && low.cmple(a.max(b)).all() {
                        self.crossing.push([number, other]);
                    }
                }
            });
        }
    }
}

/// More than the part by which particles get faster in a sweep.
const SPARE: f64 = 1.1;
/// The largest margin of a row, in edges: beyond it lists would be of no use.
const MOST_MARGIN: f64 = 4.0;

impl<R: Real> Default for Row<R> {
    fn default() -> Self {
        Row {
            key: 0,
            at: [0; 4],
            weights: [R::ZERO; 4],
            count: 0,
            normal: R::Vec3::ZERO,
            turns: false,
            turning: [0; 3],
            turns_by: [R::Vec3::ZERO; 3],
            stop: R::ZERO,
            gap: R::ZERO,
            carried: R::Vec3::ZERO,
            mass: R::ZERO,
            friction: R::ZERO,
            push: R::ZERO,
            rub: R::Vec3::ZERO,
            before: R::Vec3::ZERO,
            booked: R::Vec3::ZERO,
        }
    }
}

/// The distance of both sides of a row times the gradient of the weights of a face, as seen along
/// the normal of the row.
fn turns_by<R: Real>([a, b, c]: [R::Vec3; 3], (normal, distance): (R::Vec3, R)) -> [R::Vec3; 3] {
    let by = distance / (b - a).cross(c - a).dot(normal);
    [c - b, a - c, b - a].map(|side| normal.cross(side) * by)
}

impl<R: Real> Row<R> {
    /// Takes over where its particles are now. The points of a row that hold each other stay the
    /// same points of their features.
    fn follow(&mut self, positions: &[R]) {
        if self.count == 1 {
            return;
        }
        let each = self.at.iter().zip(self.weights).take(self.count);
        let way = each.fold(R::Vec3::ZERO, |way, (&at, weight)| {
            way + vector::<R>(positions, at as usize) * weight
        });
        let square = way.dot(way);
        if square < R::SHORTEST_SQUARED {
            return;
        }
        let distance = square.sqrt();
        self.normal = way * (R::ONE / distance);
        self.rub -= self.normal * self.normal.dot(self.rub);
        if self.turns {
            let corners = self.turning.map(|at| vector::<R>(positions, at as usize));
            self.turns_by = turns_by::<R>(corners, (self.normal, distance));
        }
    }
}

/// The diagonal of the box around some vectors.
fn diagonal<R: Real>(mut vectors: impl Iterator<Item = R::Vec3>) -> R {
    let Some(first) = vectors.next() else { return R::ZERO };
    let first = first.components();
    let (low, high) = vectors.fold((first, first), |(low, high), vector| {
        let vector = vector.components();
        let pick = |a: [R; 3], of: fn(R, R) -> R| {
            [of(a[0], vector[0]), of(a[1], vector[1]), of(a[2], vector[2])]
        };
        (pick(low, R::min), pick(high, R::max))
    });
    let sides = R::Vec3::from_components(high) - R::Vec3::from_components(low);
    sides.dot(sides).sqrt()
}

fn longest_edge<R: Real>(shells: &Shells, positions: &[R]) -> f64 {
    let square = |ends| {
        let [a, b]: [R::Vec3; 2] = shells.points(positions, ends);
        (b - a).dot(b - a)
    };
    let longest = shells.edges.iter().map(|edge| square(edge.ends)).fold(R::ZERO, R::max);
    longest.sqrt().to_f64()
}

/// Sees every point of a grid in the cells that a box touches.
fn each_in(grid: &Grid, corners: [DVec3; 2], mut see: impl FnMut(u32)) {
    let never: Result<(), Infallible> = grid.each_in(corners, |point| {
        see(point as u32);
        Ok(())
    });
    let Ok(()) = never;
}

/// The boxes around shells: most of a body is far from all others.
struct Boxes(Vec<[DVec3; 2]>);

impl Boxes {
    fn new<R: Real>(shells: &Shells, positions: &[R], reach: f64) -> Self {
        let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut boxes = alloc::vec![none; shells.rows().len()];
        for vertex in &shells.vertices {
            let place = vector::<R>(positions, vertex.at as usize).to_f64();
            let [low, high] = &mut boxes[vertex.shell as usize];
            (*low, *high) = (low.min(place), high.max(place));
        }
        for [low, high] in &mut boxes {
            (*low, *high) = (*low - reach, *high + reach);
        }
        Boxes(boxes)
    }

    /// Whether a feature with this box, of the shell of a vertex, may be near one that it meets.
    fn meet(&self, shells: &Shells, vertex: u32, [low, high]: [DVec3; 2]) -> bool {
        let own = shells.shell_of(vertex);
        self.0.iter().enumerate().any(|(other, [from, to])| {
            crate::scene::shell::do_meet(shells.rows(), [own, other])
                && low.cmple(*to).all()
                && from.cmple(high).all()
        })
    }
}

/// Rows as they are found.
struct Found<'a, R: Real> {
    at: &'a At<'a, R>,
    positions: &'a [R],
    margin: R,
    rows: Vec<Row<R>>,
    /// The vertices in them.
    used: Vec<u32>,
}

impl<R: Real> Found<'_, R> {
    fn point(&self, vertex: u32) -> R::Vec3 {
        self.at.shells.point(self.positions, vertex)
    }

    /// The square of the distance of a point from a face.
    fn square(&self, point: R::Vec3, face: u32) -> R {
        let corners = self.at.shells.faces[face as usize].corners;
        nearest::<R>(corners.map(|corner| self.point(corner) - point)).square
    }

    /// Adds a row between vertices: the first has a positive weight, the last a negative one.
    fn add<const N: usize>(
        &mut self,
        key: u64,
        (vertices, weights): ([u32; N], [R; N]),
        faces: impl Iterator<Item = u32>,
    ) {
        let shells = self.at.shells;
        let (stop, friction) = shells.law_of::<R>(vertices[0], vertices[N - 1]);
        let mut row = Row { key, count: N, stop, friction, ..Row::default() };
        for (lane, (vertex, weight)) in vertices.into_iter().zip(weights).enumerate() {
            row.at[lane] = shells.vertices[vertex as usize].at;
            row.weights[lane] = weight;
        }
        let way = row.relative(self.positions);
        let square = way.dot(way);
        let most = stop + self.margin;
        if most * most <= square || square < R::SHORTEST_SQUARED {
            return;
        }
        let distance = square.sqrt();
        row.normal = way * (R::ONE / distance);
        row.gap = distance - stop;
        if R::ZERO < friction {
            self.turn(&mut row, distance, faces);
        }
        if let Some(mass) = self.mass(&row) {
            self.rows.push(Row { mass, ..row });
            self.used.extend(vertices);
        }
    }

    /// Lets the face that faces the normal most of some take the couple of friction. One that a
    /// normal is nearly along would be turned by much for little.
    fn turn(&self, row: &mut Row<R>, distance: R, faces: impl Iterator<Item = u32>) {
        let mut best = R::of(LEAST_FACING);
        for face in faces.filter(|&face| face != NONE) {
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
    fn mass(&self, row: &Row<R>) -> Option<R> {
        let each = row.at.iter().zip(row.weights).take(row.count);
        let inverse = each.fold(R::ZERO, |sum, (&at, weight)| {
            sum + weight * weight * self.at.inverse_masses[at as usize]
        });
        (R::ZERO < inverse).then(|| R::ONE / inverse)
    }

    /// Finds the row of a vertex and a face, or of the vertex and an edge or a corner of it.
    fn face(&mut self, [vertex, number]: [u32; 2]) {
        let shells = self.at.shells;
        let face = shells.faces[number as usize];
        let here = self.point(vertex);
        let corners = face.corners.map(|corner| self.point(corner) - here);
        let (stop, _) = shells.law_of::<R>(vertex, face.corners[0]);
        let most = stop + self.margin;
        if are_beyond::<R>(corners, most) {
            return;
        }
        let met = nearest::<R>(corners);
        if most * most <= met.square {
            return;
        }
        let zeros = met.weights.map(|weight| weight == R::ZERO);
        match zeros.iter().filter(|&&zero| zero).count() {
            0 => {
                let [a, b, c] = face.corners;
                let [u, v, w] = met.weights;
                let sides = ([vertex, a, b, c], [R::ONE, -u, -v, -w]);
                self.add(key(FACE, vertex, number), sides, [number].into_iter());
            }
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
                self.edge(vertex, edge);
            }
            _ => {
                let corner = zeros.iter().position(|&zero| !zero).unwrap_or(0);
                self.corner(vertex, face.corners[corner]);
            }
        }
    }

    /// Finds the row of a vertex and an edge of no face, or of the vertex and an end of it.
    fn end(&mut self, [vertex, number]: [u32; 2]) {
        let [a, b] = self.at.shells.edges[number as usize].ends;
        let (from, to) = (self.point(a), self.point(b));
        let (way, here) = (to - from, self.point(vertex) - from);
        let (along, square) = (here.dot(way), way.dot(way));
        if along <= R::ZERO {
            self.corner(vertex, a);
        } else if square <= along {
            self.corner(vertex, b);
        } else {
            self.edge(vertex, number);
        }
    }

    /// Adds the row of a vertex and an edge.
    fn edge(&mut self, vertex: u32, edge: u32) {
        let [a, b] = self.at.shells.edges[edge as usize].ends;
        let (from, to) = (self.point(a), self.point(b));
        let way = to - from;
        let along = (self.point(vertex) - from).dot(way) / way.dot(way);
        let part = along.max(R::ZERO).min(R::ONE);
        let sides = ([vertex, a, b], [R::ONE, part - R::ONE, -part]);
        let faces = self.at.shells.edges[edge as usize].faces;
        self.add(key(EDGE, vertex, edge), sides, faces.into_iter());
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
        let faces = shells.faces_at(a).iter().chain(shells.faces_at(b)).copied();
        self.add(key(VERTEX, a, b), ([a, b], [R::ONE, -R::ONE]), faces);
    }

    /// Finds the row of two edges whose nearest points are inside of both.
    fn edges(&mut self, [a, b]: [u32; 2]) {
        let shells = self.at.shells;
        let [own, other] = [a, b].map(|edge| shells.edges[edge as usize].ends);
        let [p, p_end] = own.map(|end| self.point(end));
        let [q, q_end] = other.map(|end| self.point(end));
        let (d, e, r) = (p_end - p, q_end - q, p - q);
        let [dd, ee, de, dr, er] = [d.dot(d), e.dot(e), d.dot(e), d.dot(r), e.dot(r)];
        let sine = dd * ee - de * de;
        if sine < R::of(1e-6) * (dd * ee) {
            return;
        }
        let s = (de * er - dr * ee) / sine;
        let t = (de * s + er) / ee;
        let is_inside = |part: R| R::ZERO < part && part < R::ONE;
        if !is_inside(s) || !is_inside(t) {
            return;
        }
        let (here, there) = (p + d * s, q + e * t);
        let square = (here - there).dot(here - there);
        let (stop, _) = shells.law_of::<R>(own[0], other[0]);
        let most = stop + self.margin;
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
        let ends = [own[0], own[1], other[0], other[1]];
        let faces = [a, b].map(|edge| shells.edges[edge as usize].faces);
        let sides = (ends, [R::ONE - s, s, t - R::ONE, -t]);
        self.add(key(EDGES, a, b), sides, faces.into_iter().flatten());
    }

    /// Adds the rows of obstacles and of vertices that are in a row: one that lies on an obstacle
    /// bears what lies on it.
    fn obstacles(&mut self) {
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
                let row = Row {
                    key: EDGES << 62 | OBSTACLE | u64::from(vertex) << 24 | index as u64,
                    at: [at; 4],
                    weights: [R::ONE, R::ZERO, R::ZERO, R::ZERO],
                    count: 1,
                    normal: obstacle.normal(here, time),
                    gap,
                    carried: obstacle.velocity(here, time),
                    friction: obstacle.law().friction,
                    ..Row::default()
                };
                if let Some(mass) = self.mass(&row) {
                    self.rows.push(Row { mass, ..row });
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

/// Whether the box around a triangle is farther from the origin than this along an axis.
#[inline(always)]
fn are_beyond<R: Real>(corners: [R::Vec3; 3], most: R) -> bool {
    let [a, b, c] = corners.map(Vector::components);
    (0..3).any(|axis| {
        let low = a[axis].min(b[axis]).min(c[axis]);
        let high = a[axis].max(b[axis]).max(c[axis]);
        most < low || high < -most
    })
}
