//! Lists of features that may be near each other, which serve for many substeps.

use super::features::{Edge, NONE, Shells};
use crate::columns::extent::Extent;
use crate::columns::load;
use crate::grid::Grid;
use crate::number::{Real, Vector, at_level};
use crate::pack::zip;
use crate::scene::shell::do_meet;
use crate::triangle::{around, nearest};
use alloc::vec::Vec;
use core::convert::Infallible;
use fearless_simd::{Level, Simd};
use glam::DVec3;

/// Pairs of features: vertices and faces, vertices and edges of no face, and edges; each in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Pairs {
    pub(super) facing: Vec<ListedPair>,
    pub(super) ending: Vec<ListedPair>,
    pub(super) crossing: Vec<ListedPair>,
}

impl ListedPair {
    fn new(features: [u32; 2]) -> Self {
        ListedPair { features, until: 0.0 }
    }
}

impl Pairs {
    fn each_mut(&mut self) -> [&mut Vec<ListedPair>; 3] {
        [&mut self.facing, &mut self.ending, &mut self.crossing]
    }

    fn is_empty(&self) -> bool {
        self.facing.is_empty() && self.ending.is_empty() && self.crossing.is_empty()
    }
}

/// Two features, and how far in all vertices must come closer to each other before the gap between
/// the two may be closed, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct ListedPair {
    pub(super) features: [u32; 2],
    pub(super) until: f64,
}

/// The square of the diagonal of the box around all displacements.
#[inline(always)]
fn wear<S: Simd, R: Real>(simd: S, shells: &Shells, [from, to]: [&[R]; 2]) -> R {
    let way = |at: usize, part| {
        zip(load(simd, &to[at..], part), load(simd, &from[at..], part), |a, b| a - b)
    };
    Extent::of(simd, &shells.records, way).diagonal()
}

/// Features that may be near each other, and those of them that are closer.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates<R: Real> {
    pub(super) close: Pairs,
    /// The vertices of the close ones and those that edges join to them, in order.
    pub(super) vertices: Vec<u32>,
    /// How far in all vertices may have come closer to each other since there are lists, metres.
    pub(super) worn: f64,
    near: Pairs,
    /// Positions when the near ones were listed, metres; empty where they are to be listed.
    from: Vec<R>,
    /// How far beyond their reach those may have been, metres.
    skin: R,
    /// Positions at the last look, metres, and the wear up to which the close ones serve.
    last: Vec<R>,
    serves_to: f64,
    grid: Grid,
    boxes: Boxes,
    /// Whether each vertex is one of a close pair.
    are_close: Vec<bool>,
}

impl<R: Real> Candidates<R> {
    /// Discards the lists: features are other ones.
    pub(super) fn forget(&mut self) {
        self.from.clear();
    }

    /// Lists features anew unless the close ones hold all that are within their reach and a
    /// margin, metres; returns whether they do. Where features are so long or so many in one place
    /// that each would be near hundreds of others, as in a run that diverges, they do not.
    pub(super) fn serve(
        &mut self,
        level: Level,
        shells: &Shells,
        positions: &[R],
        margin: R,
    ) -> bool {
        let displacement =
            |from: &[R]| at_level!(level, simd => wear(simd, shells, [from, positions])).sqrt();
        let reach = R::of(shells.reach());
        let needed = margin + reach * R::of(NOISE);
        if !self.from.is_empty() && !self.near.is_empty() {
            self.worn += displacement(&self.last).to_f64();
            self.last.copy_from_slice(positions);
            if self.worn + needed.to_f64() <= self.serves_to {
                return true;
            }
        }
        let mut are_all = true;
        let is_listed = !self.from.is_empty();
        let mut left = if is_listed { self.skin - displacement(&self.from) } else { -R::ONE };
        if left < needed {
            let edge = longest_edge(shells, positions);
            left = (R::of(edge) * R::HALF).max(margin + margin) + needed;
            are_all = self.list_near(shells, positions, (left, edge));
        } else if self.near.is_empty() {
            return true;
        }
        let skin = left.min(needed + margin + reach * R::HALF);
        self.list_close(shells, positions, skin);
        if !are_all {
            // Not to be served from again.
            self.forget();
        }
        are_all
    }

    /// Lists features whose boxes are within their reach and a skin, metres; returns whether it
    /// lists all.
    fn list_near(&mut self, shells: &Shells, positions: &[R], (skin, edge): (R, f64)) -> bool {
        for column in [&mut self.from, &mut self.last] {
            column.clear();
            column.extend_from_slice(positions);
        }
        (self.skin, self.worn) = (skin, 0.0);
        let reach = shells.reach() + skin.to_f64();
        self.boxes.set(shells, positions, reach);
        let span = Span { reach, edge };
        let are_all = self.list_vertices(shells, positions, &span)
            && self.list_edges(shells, positions, &span);
        for pairs in self.near.each_mut() {
            pairs.sort_unstable_by_key(|pair| pair.features);
        }
        are_all
    }

    /// Lists those that are within their reach and a skin, metres.
    fn list_close(&mut self, shells: &Shells, positions: &[R], skin: R) {
        let Candidates { close, near, are_close, vertices, worn, serves_to, .. } = self;
        *serves_to = *worn + skin.to_f64();
        are_close.clear();
        are_close.resize(shells.vertices.len(), false);
        let point = |vertex: u32| shells.point::<R>(positions, vertex);
        let ends = |edge: u32| shells.edges[edge as usize].ends;
        let corners = |face: u32| shells.faces[face as usize].corners;
        let mut list = |to: &mut Vec<_>, pair: &mut ListedPair, square: R, of: [&[u32]; 2]| {
            let (stop, _) = shells.law_of::<R>(of[0][0], of[1][0]);
            pair.until = (square.sqrt() - stop).to_f64() + *worn;
            if pair.until < *serves_to {
                to.push(*pair);
                of.into_iter().flatten().for_each(|&vertex| are_close[vertex as usize] = true);
            }
        };
        let [facing, ending, crossing] =
            near.each_mut().map(|pairs| pairs.iter_mut().filter(|pair| pair.until < *serves_to));
        close.each_mut().into_iter().for_each(Vec::clear);
        for pair in facing {
            let [vertex, face] = pair.features;
            let (here, corners) = (point(vertex), corners(face));
            let square = nearest::<R>(corners.map(|corner| point(corner) - here)).square;
            list(&mut close.facing, pair, square, [&[vertex], &corners]);
        }
        for pair in ending {
            let [vertex, edge] = pair.features;
            let (here, ends) = (point(vertex), ends(edge));
            let square = square_between::<R>([here, here], ends.map(point));
            list(&mut close.ending, pair, square, [&[vertex], &ends]);
        }
        for pair in crossing {
            let [own, other] = pair.features.map(ends);
            let square = square_between::<R>(own.map(point), other.map(point));
            list(&mut close.crossing, pair, square, [&own, &other]);
        }
        let is_close = |vertex: u32| are_close[vertex as usize];
        let is_beside = |&vertex: &u32| {
            is_close(vertex) || shells.joined_to(vertex).iter().any(|&other| is_close(other))
        };
        vertices.clear();
        if !close.is_empty() {
            vertices.extend((0..shells.vertices.len() as u32).filter(is_beside));
        }
    }

    /// Lists the features near vertices: faces, and edges of no face; returns whether it lists all.
    fn list_vertices(&mut self, shells: &Shells, positions: &[R], span: &Span) -> bool {
        let at = |vertex: u32| shells.point(positions, vertex).to_f64();
        self.grid.fill(span.reach + span.edge, (0..shells.vertices.len() as u32).map(at));
        self.near.facing.clear();
        for (number, face) in (0u32..).zip(&shells.faces) {
            let corners = around(face.corners.map(at), span.reach);
            if !self.boxes.meet(shells, face.corners[0], corners) {
                continue;
            }
            let [low, high] = corners;
            each_in(&self.grid, corners, |vertex| {
                let is_other = !face.corners.contains(&vertex);
                if is_other && shells.do_meet(vertex, face.corners[0]) {
                    let here = at(vertex);
                    if low.cmple(here).all() && here.cmple(high).all() {
                        self.near.facing.push(ListedPair::new([vertex, number]));
                    }
                }
            });
            if MOST_PAIRS * shells.faces.len() < self.near.facing.len() {
                return false;
            }
        }
        self.near.ending.clear();
        let is_bare = |edge: &Edge| edge.faces == [NONE; 2];
        for (number, edge) in (0u32..).zip(&shells.edges).filter(|(_, edge)| is_bare(edge)) {
            let [a, b] = edge.ends.map(at);
            each_in(&self.grid, around([a, b, b], span.reach), |vertex| {
                if !edge.ends.contains(&vertex) && shells.do_meet(vertex, edge.ends[0]) {
                    self.near.ending.push(ListedPair::new([vertex, number]));
                }
            });
            if MOST_PAIRS * shells.edges.len() < self.near.ending.len() {
                return false;
            }
        }
        true
    }

    /// Lists edges that are near each other; returns whether it lists all.
    fn list_edges(&mut self, shells: &Shells, positions: &[R], span: &Span) -> bool {
        let ends = |edge: &Edge| edge.ends.map(|end| shells.point(positions, end).to_f64());
        let middles = shells.edges.iter().map(|edge| {
            let [a, b] = ends(edge);
            (a + b) * 0.5
        });
        self.grid.fill(span.reach + span.edge, middles);
        self.near.crossing.clear();
        for (number, own) in (0u32..).zip(&shells.edges) {
            let [a, b] = ends(own);
            let corners = around([a, b, b], span.reach);
            if !self.boxes.meet(shells, own.ends[0], corners) {
                continue;
            }
            each_in(&self.grid, around([a, b, b], span.reach + 0.5 * span.edge), |other| {
                let edge = &shells.edges[other as usize];
                let is_other = number < other && !own.ends.iter().any(|at| edge.ends.contains(at));
                if !is_other || !shells.do_meet(own.ends[0], edge.ends[0]) {
                    return;
                }
                let ([low, high], [a, b]) = (corners, ends(edge));
                if a.min(b).cmple(high).all() && low.cmple(a.max(b)).all() {
                    self.near.crossing.push(ListedPair::new([number, other]));
                }
            });
            if MOST_PAIRS * shells.edges.len() < self.near.crossing.len() {
                return false;
            }
        }
        true
    }
}

/// The most pairs for each feature.
const MOST_PAIRS: usize = 256;

/// The square of the distance between two edges, or an edge and a point (Ericson, Real-Time
/// Collision Detection, 2005, section 5.1.9).
pub(super) fn square_between<R: Real>([p, p_end]: [R::Vec3; 2], [q, q_end]: [R::Vec3; 2]) -> R {
    let clamp = |part: R| part.max(R::ZERO).min(R::ONE);
    let (d, e, r) = (p_end - p, q_end - q, p - q);
    let [dd, ee, de, dr, er] = [d.dot(d), e.dot(e), d.dot(e), d.dot(r), e.dot(r)];
    let sine = dd * ee - de * de;
    let is_slanted = R::of(1e-6) * (dd * ee) < sine;
    let s = if is_slanted { clamp((de * er - dr * ee) / sine) } else { R::HALF };
    let t = clamp((de * s + er) / ee);
    let s = if R::ZERO < dd { clamp((de * t - dr) / dd) } else { R::ZERO };
    let way = r + d * s - e * t;
    way.dot(way)
}

/// How far features are looked for.
struct Span {
    /// The distance up to which they are listed, and the length of the longest edge, metres.
    reach: f64,
    edge: f64,
}

/// More than the part of a reach that rounding is worth.
pub(super) const NOISE: f64 = 0.01;

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
#[derive(Clone, Debug, Default)]
struct Boxes(Vec<[DVec3; 2]>);

impl Boxes {
    fn set<R: Real>(&mut self, shells: &Shells, positions: &[R], reach: f64) {
        self.0.clear();
        self.0.resize(shells.rows().len(), [DVec3::INFINITY, DVec3::NEG_INFINITY]);
        for vertex in 0..shells.vertices.len() as u32 {
            let place = shells.point(positions, vertex).to_f64();
            let [low, high] = &mut self.0[shells.shell_of(vertex)];
            (*low, *high) = (low.min(place), high.max(place));
        }
        for [low, high] in &mut self.0 {
            (*low, *high) = (*low - reach, *high + reach);
        }
    }

    /// Whether a feature with this box, of the shell of a vertex, may be near one that it meets.
    fn meet(&self, shells: &Shells, vertex: u32, [low, high]: [DVec3; 2]) -> bool {
        let own = shells.shell_of(vertex);
        self.0.iter().enumerate().any(|(other, [from, to])| {
            do_meet(shells.rows(), [own, other]) && low.cmple(*to).all() && from.cmple(high).all()
        })
    }
}
