//! Distances between features, by one number or a register, and columns of features for them.
//!
//! Without `map` over arrays: it keeps the compiler from using the instructions of a level.

use super::clusters::Feature;
use super::features::Shells;
use super::row::{EDGE, FACE, features};
use crate::columns::LANES;
use crate::columns::extent::Extent;
use crate::number::{Real, Vector};
use crate::pack::{Number, Pack, dot, splat, zip};
use alloc::vec::Vec;
use fearless_simd::{Simd, SimdMask};

/// The part of the square of two lengths below which the square of their span is rounding.
const PARALLEL: f64 = 1e-6;

/// The squares of the distances of at most sixteen pairs of features of one kind, square metres.
#[inline(always)]
pub(super) fn squares<S: Simd, R: Real>(
    simd: S,
    (shells, points): (&Shells, &[R::Vec3]),
    keys: &[(u64, usize)],
) -> [R; LANES] {
    let mut columns = [[[R::ZERO; LANES]; 3]; 4];
    for (lane, &(key, _)) in keys.iter().enumerate() {
        for (column, vertex) in columns.iter_mut().zip(vertices(shells, key)) {
            let point = points[vertex as usize].components();
            column.iter_mut().zip(point).for_each(|(numbers, number)| numbers[lane] = number);
        }
    }
    let mut squares = [R::ZERO; LANES];
    let Some(kind) = keys.first().map(|(key, _)| key >> 62) else { return squares };
    let lanes = Pack::<S, R>::LEN;
    for part in (0..keys.len()).step_by(lanes) {
        let read = |numbers: &[R; LANES]| Pack::from_slice(simd, &numbers[part..][..lanes]);
        let mut points = [[Pack::<S, R>::new(simd, R::ZERO); 3]; 4];
        for (point, column) in points.iter_mut().zip(&columns) {
            *point = [read(&column[0]), read(&column[1]), read(&column[2])];
        }
        square(kind, points).store_slice(&mut squares[part..][..lanes]);
    }
    squares
}

/// The vertices of two features of a list.
#[inline(always)]
fn vertices(shells: &Shells, key: u64) -> [u32; 4] {
    let [own, other] = features(key);
    let ends = |edge: u32| shells.edges[edge as usize].ends;
    match key >> 62 {
        FACE => {
            let [a, b, c] = shells.faces[other as usize].corners;
            [own, a, b, c]
        }
        EDGE => {
            let [from, to] = ends(other);
            [own, from, to, to]
        }
        _ => {
            let ([a, b], [c, d]) = (ends(own), ends(other));
            [a, b, c, d]
        }
    }
}

#[inline(always)]
fn square<N: Number>(kind: u64, [p, a, b, c]: [[N; 3]; 4]) -> N {
    match kind {
        FACE => of_face([minus(a, p), minus(b, p), minus(c, p)]),
        EDGE => of_edge([minus(a, p), minus(b, p)]),
        _ => between_edges([p, a], [b, c]),
    }
}

/// The square of the distance between two edges, or an edge and a point (Ericson, Real-Time
/// Collision Detection, 2005, section 5.1.9).
#[inline(always)]
pub(super) fn between_edges<N: Number>([p, p_end]: [[N; 3]; 2], [q, q_end]: [[N; 3]; 2]) -> N {
    let (d, e, r) = (minus(p_end, p), minus(q_end, q), minus(p, q));
    let [dd, ee, de, dr, er] = [dot(d, d), dot(e, e), dot(d, e), dot(d, r), dot(e, r)];
    let (zero, one) = (dd.zero(), dd.one());
    let clamp = |part: N| part.max(zero).min(one);
    let sine = dd * ee - de * de;
    let is_slanted = (dd.splat(N::Scalar::of(PARALLEL)) * (dd * ee)).is_less(sine);
    let s = N::select(is_slanted, clamp((de * er - dr * ee) / sine), one.half());
    let t = N::select(zero.is_less(ee), clamp((de * s + er) / ee), zero);
    let s = N::select(zero.is_less(dd), clamp((de * t - dr) / dd), zero);
    let way = zip(zip(r, d, |r, d| r + d * s), e, |way, e| way - e * t);
    dot(way, way)
}

/// The square of the distance of a face from the origin.
#[inline(always)]
pub(super) fn of_face<N: Number>([a, b, c]: [[N; 3]; 3]) -> N {
    let normal = cross(minus(b, a), minus(c, a));
    let [of_a, of_b, of_c] = [cross(b, c), cross(c, a), cross(a, b)];
    let zero = normal[0].zero();
    let is_over = zero.is_less(dot(normal, of_a))
        & zero.is_less(dot(normal, of_b))
        & zero.is_less(dot(normal, of_c));
    let height = dot(a, normal);
    let least = of_edge([a, b]).min(of_edge([b, c])).min(of_edge([c, a]));
    N::select(is_over, height * height / dot(normal, normal), least)
}

/// The square of the distance of an edge from the origin.
#[inline(always)]
pub(super) fn of_edge<N: Number>([from, to]: [[N; 3]; 2]) -> N {
    let way = minus(to, from);
    let (along, square) = (-dot(from, way), dot(way, way));
    let (zero, one) = (square.zero(), square.one());
    let part = N::select(zero.is_less(square), (along / square).max(zero).min(one), zero);
    let nearest = zip(from, way, |from, way| from + way * part);
    dot(nearest, nearest)
}

#[inline(always)]
pub(super) fn minus<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    zip(a, b, |a, b| a - b)
}

#[inline(always)]
fn cross<N: Number>([ax, ay, az]: [N; 3], [bx, by, bz]: [N; 3]) -> [N; 3] {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

/// Features of so many points each, in columns of whole registers.
#[derive(Clone, Debug)]
pub(super) struct FeatureLanes<R: Real, const POINTS: usize> {
    pub(super) features: Vec<u32>,
    columns: [[Vec<R>; 3]; POINTS],
    /// The boxes around sixteen of them each.
    boxes: Vec<Extent<R>>,
}

impl<R: Real, const POINTS: usize> Default for FeatureLanes<R, POINTS> {
    fn default() -> Self {
        let columns = core::array::from_fn(|_| [Vec::new(), Vec::new(), Vec::new()]);
        FeatureLanes { features: Vec::new(), columns, boxes: Vec::new() }
    }
}

impl<R: Real, const POINTS: usize> FeatureLanes<R, POINTS> {
    /// Overwrites the features by those of some that are within reach of a box.
    pub(super) fn fill(
        &mut self,
        (features, corners): (&[Feature<POINTS>], &[R::Vec3]),
        (around, reach): (Extent<R>, R),
    ) {
        self.features.clear();
        self.boxes.clear();
        let columns = &mut self.columns;
        columns.as_flattened_mut().iter_mut().for_each(Vec::clear);
        for feature in features {
            // Without `map`, which is not always compiled into the loop around it.
            let mut points = [R::Vec3::ZERO; POINTS];
            for (point, &corner) in points.iter_mut().zip(&feature.corners) {
                *point = corners[corner as usize];
            }
            let own = Extent::around(points.into_iter());
            if !around.is_near(own, reach) {
                continue;
            }
            match self.boxes.last_mut() {
                Some(last) if !self.features.len().is_multiple_of(LANES) => *last = last.with(own),
                _ => self.boxes.push(own),
            }
            self.features.push(feature.number);
            for (column, point) in columns.iter_mut().zip(points) {
                for (numbers, number) in column.iter_mut().zip(point.components()) {
                    numbers.push(number);
                }
            }
        }
        let whole = self.features.len().next_multiple_of(LANES);
        for numbers in columns.as_flattened_mut() {
            let last = numbers.last().copied().unwrap_or_default();
            numbers.resize(whole, last);
        }
    }

    /// A feature of one point, and the box around it.
    #[inline(always)]
    pub(super) fn one<S: Simd>(&self, simd: S, at: usize) -> (u32, Extent<R>, [Pack<S, R>; 3]) {
        let [x, y, z] = &self.columns[0];
        let here = R::Vec3::from_components([x[at], y[at], z[at]]);
        (self.features[at], Extent::around([here].into_iter()), splat(simd, here.components()))
    }

    /// Sees the features from the first of them on that are within reach of the content of a box,
    /// by the squares of their distances, a register at a time.
    #[inline(always)]
    pub(super) fn see<S: Simd>(
        &self,
        simd: S,
        (around, reach, first): (Extent<R>, R, usize),
        square: impl Fn([[Pack<S, R>; 3]; POINTS]) -> Pack<S, R>,
        mut see: impl FnMut(u32, R),
    ) {
        let lanes = Pack::<S, R>::LEN;
        let most = reach * reach;
        for (number, of_box) in self.boxes.iter().enumerate().skip(first / LANES) {
            if !of_box.is_near(around, reach) {
                continue;
            }
            let start = number * LANES;
            let end = (start + LANES).min(self.features.len());
            for part in (start..end).step_by(lanes) {
                let read = |numbers: &Vec<R>| Pack::from_slice(simd, &numbers[part..][..lanes]);
                let mut points = [[Pack::<S, R>::new(simd, R::ZERO); 3]; POINTS];
                for (point, column) in points.iter_mut().zip(&self.columns) {
                    *point = [read(&column[0]), read(&column[1]), read(&column[2])];
                }
                let distances = square(points);
                let mut near = distances.is_less(Pack::new(simd, most)).to_bitmask();
                if near == 0 {
                    continue;
                }
                let mut squares = [R::ZERO; LANES];
                distances.store_slice(&mut squares[..lanes]);
                while near != 0 {
                    let lane = near.trailing_zeros() as usize;
                    near &= near - 1;
                    if (first..end).contains(&(part + lane)) {
                        see(self.features[part + lane], squares[lane]);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pack::lanes::{Law, check};
    use crate::triangle::nearest;

    struct OfFace;
    impl Law<9, 1> for OfFace {
        fn of<N: Number>([a, b, c, d, e, f, g, h, i]: [N; 9]) -> [N; 1] {
            [of_face([[a, b, c], [d, e, f], [g, h, i]])]
        }
    }

    struct BetweenEdges;
    impl Law<12, 1> for BetweenEdges {
        fn of<N: Number>([a, b, c, d, e, f, g, h, i, j, k, l]: [N; 12]) -> [N; 1] {
            [between_edges([[a, b, c], [d, e, f]], [[g, h, i], [j, k, l]])]
        }
    }

    #[test]
    fn a_register_has_the_bits_of_each_number() {
        check::<OfFace, 9, 1>();
        check::<BetweenEdges, 12, 1>();
    }

    #[test]
    fn a_face_is_as_far_as_its_nearest_point() {
        let mut state = 7u64;
        let mut coarse = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 40) % 17) as f64 / 8.0 - 1.0
        };
        for _ in 0..2000 {
            let corners = [[(); 3]; 3].map(|corner| corner.map(|()| coarse()));
            let other = nearest::<f64>(corners.map(glam::DVec3::from_array)).square;
            let square = of_face(corners);
            // A few roundings of numbers of at most one.
            assert!((square - other).abs() <= 1e-13, "{corners:?}: {square} and {other}");
        }
    }
}
