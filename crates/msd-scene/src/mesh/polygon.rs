//! Polygons cut into triangles by clipping ears, with exact signs.
//!
//! By hand, as the crate for it (`earcut`) leaves out corners on straight sides: a crack would open
//! to the neighbour that has such a corner too. Signs are exact by `robust`.

use glam::{DVec2, DVec3};
use robust::{Coord, orient2d};

/// The most corners of a face that is not convex: the time grows with their square.
pub(crate) const MOST_CORNERS: usize = 10_000;

/// The distance from the cut, as a share of its length, within which a corner is on it: a triangle
/// so thin would be dropped, and leave a crack.
const NEAR: f64 = 1e-9;

/// A polygon as triangles.
#[derive(Debug, PartialEq)]
pub(crate) struct Cut {
    /// Three places in the list of corners for each triangle, in the direction of the polygon.
    pub(crate) triangles: Vec<[usize; 3]>,
    /// Whether the polygon crosses itself, so that a fan around its first corner stands for it.
    pub(crate) crossed: bool,
}

/// Cuts a polygon into triangles that cover the same area; `None` if it has too many corners.
///
/// A fan around the first corner wherever that covers the polygon. A hole may be joined to the
/// outline by a slit, along which it runs twice.
pub(crate) fn cut(corners: &[DVec3]) -> Option<Cut> {
    let fan = || (1..corners.len() - 1).map(|i| [0, i, i + 1]).collect::<Vec<_>>();
    let points = flatten(corners);
    let covers = |&[a, b, c]: &[usize; 3]| {
        0.0 < turn(points[a], points[b], points[c])
            && has_area([corners[a], corners[b], corners[c]])
    };
    if corners.len() == 3 || fan().iter().all(covers) {
        return Some(Cut { triangles: fan(), crossed: false });
    }
    if MOST_CORNERS < corners.len() {
        return None;
    }
    Some(Outline::new(&points).clip().map_or_else(
        || {
            let crossed = fan().iter().any(|t| has_area(t.map(|corner| corners[corner])));
            Cut { triangles: fan(), crossed }
        },
        |triangles| Cut { triangles, crossed: false },
    ))
}

/// Whether a triangle has an area: corners that do not lie on a line, to rounding.
pub(crate) fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    1e-12 * longest < (b - a).cross(c - a).length()
}

/// Whether the corners of a triangle differ and do not lie on a line, to rounding.
pub(crate) fn is_face(corners: [u32; 3], positions: &[DVec3]) -> bool {
    let [a, b, c] = corners;
    a != b && b != c && c != a && has_area(corners.map(|corner| positions[corner as usize]))
}

/// The corners without the coordinate along which the polygon is flattest, counter-clockwise. Left
/// out and not projected: the two that stay are exact.
fn flatten(corners: &[DVec3]) -> Vec<DVec2> {
    let origin = corners[0];
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let normal: DVec3 = sides.map(|(&a, &b)| (a - origin).cross(b - origin)).sum();
    let axis = normal.abs().max_position();
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (u, v) = if normal[axis] < 0.0 { (v, u) } else { (u, v) };
    corners.iter().map(|corner| DVec2::new(corner[u], corner[v])).collect()
}

/// Positive where the way from a over b to c turns left, zero where it is straight; its sign is
/// exact.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|point| Coord { x: point.x, y: point.y });
    orient2d(a, b, c)
}

/// The rest of a polygon while ears are clipped.
struct Outline<'a> {
    points: &'a [DVec2],
    next: Vec<usize>,
    previous: Vec<usize>,
    /// Corners that turn left; one that does stays so.
    convex: Vec<bool>,
    /// A corner that is left, and the number of them.
    start: usize,
    left: usize,
}

impl<'a> Outline<'a> {
    /// The outline of a polygon, without corners that repeat the one before.
    fn new(points: &'a [DVec2]) -> Self {
        let count = points.len();
        let next = (1..=count).map(|i| i % count).collect();
        let previous = (0..count).map(|i| (i + count - 1) % count).collect();
        let convex = vec![false; count];
        let mut outline = Self { points, next, previous, convex, start: 0, left: count };
        for corner in 0..count {
            if 1 < outline.left && points[corner] == points[outline.previous[corner]] {
                outline.remove(corner);
            }
        }
        (0..count).for_each(|corner| outline.look(corner));
        outline
    }

    /// The triangles; `None` if no ear is left: the outline crosses itself, or has no area.
    fn clip(mut self) -> Option<Vec<[usize; 3]>> {
        if self.left < 3 {
            return None;
        }
        let mut triangles = Vec::with_capacity(self.left.saturating_sub(2));
        let mut corner = self.start;
        // The number of corners in a row that were not ears, and the distance within which others
        // are on the cut.
        let (mut tried, mut near) = (0, NEAR);
        // A corner beside the last ear: of a spiral only its ends have ears.
        let mut beside = None;
        while 2 < self.left {
            let [a, c] = [self.previous[corner], self.next[corner]];
            if self.is_ear([a, corner, c], near) {
                triangles.push([a, corner, c]);
                self.remove(corner);
                self.look(a);
                self.look(c);
                // Not its neighbour: clipped in a row, ears are long and thin.
                (corner, tried, near) = (self.next[c], 0, NEAR);
                beside = Some(a);
                continue;
            }
            if let Some(a) = beside.take() {
                corner = a;
                continue;
            }
            (corner, tried) = (c, tried + 1);
            if tried == self.left {
                if near == 0.0 {
                    return None;
                }
                (tried, near) = (0, 0.0);
            }
        }
        Some(triangles)
    }

    /// Whether a corner sticks out so that no other corner is in its triangle or on the cut.
    fn is_ear(&self, [a, b, c]: [usize; 3], near: f64) -> bool {
        let [pa, pb, pc] = [a, b, c].map(|corner| self.points[corner]);
        let margin = near * pa.distance_squared(pc);
        if !self.convex[b] || turn(pa, pb, pc) <= margin {
            return false;
        }
        let mut other = self.next[c];
        while other != a {
            let point = self.points[other];
            // Where a slit begins, two corners are at one place.
            let blocks = !self.convex[other]
                && ![pa, pb, pc].contains(&point)
                && -margin <= turn(pc, pa, point)
                && 0.0 <= turn(pa, pb, point)
                && 0.0 <= turn(pb, pc, point);
            if blocks {
                return false;
            }
            other = self.next[other];
        }
        true
    }

    /// Finds whether a corner turns left.
    fn look(&mut self, corner: usize) {
        let [a, b, c] = [self.previous[corner], corner, self.next[corner]];
        self.convex[b] = 0.0 < turn(self.points[a], self.points[b], self.points[c]);
    }

    fn remove(&mut self, corner: usize) {
        let [a, c] = [self.previous[corner], self.next[corner]];
        (self.next[a], self.previous[c]) = (c, a);
        (self.start, self.left) = (c, self.left - 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(corners: &[[i32; 2]]) -> Vec<DVec3> {
        corners.iter().map(|&[x, y]| DVec3::new(x.into(), y.into(), 0.0)).collect()
    }

    /// Twice the sum of the areas of the triangles, each of which is positive.
    fn covered(corners: &[DVec3]) -> f64 {
        let cut = cut(corners).unwrap();
        assert!(!cut.crossed);
        let areas = cut.triangles.iter().map(|&[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|corner| corners[corner]);
            let area = (b - a).cross(c - a).z;
            assert!(0.0 < area, "{corners:?}: {:?}", [a, b, c]);
            area
        });
        areas.sum()
    }

    #[test]
    fn what_a_fan_covers_stays_a_fan() {
        let dart = flat(&[[1, 1], [4, 0], [0, 4], [-1, -1]]);
        assert_eq!(cut(&dart).unwrap().triangles, [[0, 1, 2], [0, 2, 3]]);
        let cut = cut(&flat(&[[0, 0], [1, 0], [1, 1], [0, 1]])).unwrap();
        assert_eq!(cut, Cut { triangles: vec![[0, 1, 2], [0, 2, 3]], crossed: false });
    }

    #[test]
    fn a_corner_on_a_straight_side_is_in_the_triangles_wherever_it_stands() {
        let square = [[0, 0], [1, 0], [2, 0], [2, 2], [0, 2]];
        for start in 0..5 {
            let mut turned = square;
            turned.rotate_left(start);
            let corners = flat(&turned);
            assert_eq!(covered(&corners), 8.0);
            assert_eq!(cut(&corners).unwrap().triangles.len(), 3);
        }
    }

    #[test]
    fn a_hole_behind_a_slit_stays_open() {
        let outline = [[0, 0], [6, 0], [6, 6], [0, 6]];
        let hole = [[2, 2], [2, 4], [4, 4], [4, 2]];
        for start in 0..4 {
            let mut keyhole = outline.to_vec();
            keyhole.rotate_left(start);
            keyhole.push(keyhole[0]);
            let nearest = [0, 3, 2, 1][start];
            let around = hole.iter().cycle().skip(nearest).take(5);
            keyhole.extend(around);
            for first in 0..keyhole.len() {
                let mut keyhole = keyhole.clone();
                keyhole.rotate_left(first);
                assert_eq!(covered(&flat(&keyhole)), 2.0 * (36.0 - 4.0), "{start}, {first}");
            }
        }
    }

    #[test]
    fn a_polygon_that_crosses_itself_is_a_fan_and_said_to_be_one() {
        let bow = cut(&flat(&[[0, 0], [2, 2], [2, 0], [0, 1]])).unwrap();
        assert_eq!(bow, Cut { triangles: vec![[0, 1, 2], [0, 2, 3]], crossed: true });
        for line in [vec![[0, 0]; 5], vec![[0, 0], [1, 0], [3, 0], [2, 0]]] {
            assert!(!cut(&flat(&line)).unwrap().crossed, "{line:?}");
        }
    }

    #[test]
    fn a_comb_and_a_spiral_of_thousands_of_corners_are_covered() {
        let teeth = 2000;
        let mut comb: Vec<[i32; 2]> =
            (0..=teeth).flat_map(|i| [[2 * i, 0], [2 * i + 1, 90]]).collect();
        comb.extend([[2 * teeth + 1, -1], [0, -1]]);
        comb.reverse();
        let area = i64::from(teeth) * 180 + 2 * (2 * i64::from(teeth) + 1);
        assert!((covered(&flat(&comb)) - area as f64).abs() < 200.0);
        let arm = |radius: f64| {
            (0..2000).map(move |i| {
                let (sin, cos) = (i as f64 * 0.05).sin_cos();
                (radius + i as f64) * DVec3::new(cos, sin, 0.0)
            })
        };
        let inner: Vec<_> = arm(1000.0).collect();
        let spiral: Vec<_> = arm(1040.0).chain(inner.into_iter().rev()).collect();
        assert!(0.0 < covered(&spiral));
    }
}
