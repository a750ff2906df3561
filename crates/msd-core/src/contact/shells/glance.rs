//! Distances of listed features, a register at a time: most turn out to be apart.

use super::distance::{between_edges, minus, of_edge, of_face};
use super::features::Shells;
use super::row::{EDGE, FACE, features};
use crate::columns::LANES;
use crate::number::{Real, Vector};
use crate::pack::{Number, Pack};
use fearless_simd::Simd;

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
