//! The point of a triangle that is nearest to another point.

use crate::number::{Real, Vector};

/// The point of a triangle that is nearest to the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest<R: Real> {
    /// The weights of the corners, whose sum is one; a corner or an edge that is not nearest has
    /// zeros.
    pub(crate) weights: [R; 3],
    /// The square of its distance.
    pub(crate) square: R,
}

impl<R: Real> Nearest<R> {
    fn of(corners: [R::Vec3; 3], weights: [R; 3]) -> Self {
        let [a, b, c] = [corners[0] * weights[0], corners[1] * weights[1], corners[2] * weights[2]];
        let point = a + b + c;
        Nearest { weights, square: point.dot(point) }
    }
}

/// Finds the point of a triangle that is nearest to the origin, and where two are, that of the
/// first edge.
///
/// Where the origin lies over the triangle, the weights are the areas that it makes with the edges.
/// Elsewhere the nearest point is on an edge that has the origin on its outer side (after Ericson,
/// Real-Time Collision Detection, 2005, section 5.1.5). Of a triangle without an area, which has no
/// sides, all edges are looked at. Corners that are NaN are nowhere near.
#[inline(always)]
pub(crate) fn nearest<R: Real>(corners: [R::Vec3; 3]) -> Nearest<R> {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let areas = [normal.dot(b.cross(c)), normal.dot(c.cross(a)), normal.dot(a.cross(b))];
    if areas.iter().all(|&area| R::ZERO < area) {
        let sum = areas[0] + areas[1] + areas[2];
        return Nearest::of(corners, [areas[0] / sum, areas[1] / sum, areas[2] / sum]);
    }
    let mut found = Nearest { square: R::LARGEST, ..Nearest::of(corners, CORNER.map(R::of)) };
    for opposite in (0..3).filter(|&corner| areas[corner] <= R::ZERO) {
        let [from, to] = [1, 2].map(|by| (opposite + by) % 3);
        let part = part_of_edge(corners[from], corners[to]);
        let mut weights = [R::ZERO; 3];
        (weights[from], weights[to]) = (R::ONE - part, part);
        let on_edge = Nearest::of(corners, weights);
        if on_edge.square < found.square {
            found = on_edge;
        }
    }
    found
}

/// The weights of a corner.
const CORNER: [f64; 3] = [1.0, 0.0, 0.0];

/// The part of the way from one point to another at which the point nearest to the origin is; 0 or
/// 1 exactly where it is an end.
#[inline(always)]
pub(crate) fn part_of_edge<R: Real>(from: R::Vec3, to: R::Vec3) -> R {
    let way = to - from;
    let (along, square) = (-from.dot(way), way.dot(way));
    if along <= R::ZERO {
        R::ZERO
    } else if square <= along {
        R::ONE
    } else {
        along / square
    }
}
