//! Lists of features that may be near each other, which serve for many substeps.

use super::features::{Edge, NONE, Shells};
use crate::columns::vector;
use crate::grid::Grid;
use crate::number::{Real, Vector};
use crate::scene::shell::do_meet;
use crate::triangle::{around, nearest};
use alloc::vec::Vec;
use core::convert::Infallible;
use glam::DVec3;

/// Pairs of features: vertices and faces, vertices and edges of no face, and edges.
#[derive(Clone, Debug, Default)]
pub(super) struct Pairs {
    pub(super) facing: Vec<[u32; 2]>,
    pub(super) ending: Vec<[u32; 2]>,
    pub(super) crossing: Vec<[u32; 2]>,
}

/// Where features were listed, and how far beyond their reach they may have been.
#[derive(Clone, Debug, Default)]
struct Since<R> {
    /// Positions, metres; empty where nothing is listed.
    from: Vec<R>,
    /// Metres.
    skin: R,
}

impl<R: Real> Since<R> {
    fn set(&mut self, positions: &[R], skin: R) {
        self.skin = skin;
        self.from.clear();
        self.from.extend_from_slice(positions);
    }

    /// How much of the skin is left at most, metres; less than none where nothing is listed.
    fn left(&self, shells: &Shells, positions: &[R]) -> R {
        if self.from.is_empty() {
            return -R::ONE;
        }
        self.skin
            - diagonal::<R>(shells.vertices.iter().map(|vertex| {
                let at = vertex.at as usize;
                vector::<R>(positions, at) - vector::<R>(&self.from, at)
            }))
    }
}

/// Features that may be near each other, and those of them that are closer.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates<R: Real> {
    pub(super) close: Pairs,
    near: Pairs,
    close_since: Since<R>,
    near_since: Since<R>,
    grid: Grid,
}

impl<R: Real> Candidates<R> {
    /// Discards the lists: features are other ones.
    pub(super) fn forget(&mut self) {
        self.close_since.from.clear();
        self.near_since.from.clear();
    }

    /// Lists features anew unless the close ones hold all that are within their reach and a
    /// margin, metres; returns whether they do. Where features are so long or so many in one place
    /// that each would be near hundreds of others, as in a run that diverges, they do not.
    pub(super) fn serve(&mut self, shells: &Shells, positions: &[R], margin: R) -> bool {
        if margin <= self.close_since.left(shells, positions) {
            return true;
        }
        let mut are_all = true;
        let mut left = self.near_since.left(shells, positions);
        if left < margin {
            let edge = longest_edge(shells, positions);
            left = (R::of(edge) * R::HALF).max(margin + margin);
            self.near_since.set(positions, left);
            let reach = shells.reach() + left.to_f64();
            let span = Reach { reach, edge, boxes: Boxes::new(shells, positions, reach) };
            are_all = self.list_vertices(shells, positions, &span)
                && self.list_edges(shells, positions, &span);
            if !are_all {
                // Not to be served from again.
                self.near_since.from.clear();
            }
        }
        let reach = R::of(shells.reach());
        let skin = left.min(margin + margin + reach * R::HALF);
        self.close_since.set(positions, skin);
        let most = (reach + skin) * (reach + skin);
        let Candidates { close: Pairs { facing, ending, crossing }, near, .. } = self;
        let point = |vertex: u32| shells.point::<R>(positions, vertex);
        let ends = |edge: u32| shells.edges[edge as usize].ends.map(point);
        let faces = |&&[vertex, face]: &&[u32; 2]| {
            let (here, corners) = (point(vertex), shells.faces[face as usize].corners.map(point));
            nearest::<R>(corners.map(|corner| corner - here)).square < most
        };
        facing.clear();
        facing.extend(near.facing.iter().filter(faces));
        let meets = |&&[vertex, edge]: &&[u32; 2]| {
            let here = point(vertex);
            square_between::<R>([here, here], ends(edge)) < most
        };
        ending.clear();
        ending.extend(near.ending.iter().filter(meets));
        let cross = |&&[a, b]: &&[u32; 2]| square_between::<R>(ends(a), ends(b)) < most;
        crossing.clear();
        crossing.extend(near.crossing.iter().filter(cross));
        are_all
    }

    /// Lists the features near vertices: faces, and edges of no face; returns whether it lists all.
    fn list_vertices(&mut self, shells: &Shells, positions: &[R], span: &Reach) -> bool {
        let at = |vertex: u32| shells.point(positions, vertex).to_f64();
        self.grid.fill(span.reach + span.edge, (0..shells.vertices.len() as u32).map(at));
        self.near.facing.clear();
        for (number, face) in (0u32..).zip(&shells.faces) {
            let corners = around(face.corners.map(at), span.reach);
            if !span.boxes.meet(shells, face.corners[0], corners) {
                continue;
            }
            let [low, high] = corners;
            each_in(&self.grid, corners, |vertex| {
                let is_other = !face.corners.contains(&vertex);
                if is_other && shells.do_meet(vertex, face.corners[0]) {
                    let here = at(vertex);
                    if low.cmple(here).all() && here.cmple(high).all() {
                        self.near.facing.push([vertex, number]);
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
                    self.near.ending.push([vertex, number]);
                }
            });
            if MOST_PAIRS * shells.edges.len() < self.near.ending.len() {
                return false;
            }
        }
        true
    }

    /// Lists edges that are near each other; returns whether it lists all.
    fn list_edges(&mut self, shells: &Shells, positions: &[R], span: &Reach) -> bool {
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
            if !span.boxes.meet(shells, own.ends[0], corners) {
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
                    self.near.crossing.push([number, other]);
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
fn square_between<R: Real>([p, p_end]: [R::Vec3; 2], [q, q_end]: [R::Vec3; 2]) -> R {
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
struct Reach {
    /// The distance up to which they are listed, and the length of the longest edge, metres.
    reach: f64,
    edge: f64,
    boxes: Boxes,
}

/// The diagonal of the box around some vectors.
pub(super) fn diagonal<R: Real>(mut vectors: impl Iterator<Item = R::Vec3>) -> R {
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
        for vertex in 0..shells.vertices.len() as u32 {
            let place = shells.point(positions, vertex).to_f64();
            let [low, high] = &mut boxes[shells.shell_of(vertex)];
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
            do_meet(shells.rows(), [own, other]) && low.cmple(*to).all() && from.cmple(high).all()
        })
    }
}
