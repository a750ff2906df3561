//! The slowest motions of a system about a state.
//!
//! A block of vectors is improved by its residuals, solved for roughly, and by the ways it went
//! before, which is locally optimal (LOBPCG; Knyazev, 2001). Directions that nothing resists, as
//! those of a body as a whole, come first and are left out.

use super::dense::{MOST, Matrix};
use super::region::Mode;
use super::spectrum::{Basis, OperatingPoint, Rough, dot, norm};
use crate::number::Real;
use alloc::vec::Vec;
use glam::DVec3;

/// Vectors of the block: a third of the largest small matrix.
const BLOCK: usize = MOST / 3;
/// Improvements at most.
const MOST_ROUNDS: usize = 200;
/// Products of a solve at most, and the part of a residual that it may leave.
const MOST_SOLVES: usize = 60;
const SOLVED: f64 = 0.05;
/// Below this part of the largest eigenvalue a motion meets no resistance.
const FREE: f64 = 1e-10;
/// The residual of a motion that has converged, as a part of its eigenvalue, whose error is of its
/// square.
const CLOSE: f64 = 1e-4;

/// A vector, and its products with stiffness and damping, all divided by roots of masses.
#[derive(Clone)]
struct Tried {
    vector: Vec<DVec3>,
    products: [Vec<DVec3>; 2],
}

/// The first motions that anything resists, at most `count`, slowest first: taken for single
/// oscillators. Fewer where more than some seven directions meet no resistance, or where the search
/// does not converge.
pub(crate) fn slowest<R: Real>(point: &OperatingPoint<'_, R>, count: usize) -> Vec<Mode> {
    let mut basis = Basis::default();
    basis.prepare(point);
    let mut block: Vec<Tried> = Vec::new();
    let mut rough = Rough(1);
    for _ in 0..BLOCK {
        let vector = basis.roots().iter().map(|&root| {
            let way = rough.next().unwrap_or_default();
            if root == 0.0 { DVec3::ZERO } else { way }
        });
        extend(&mut block, vector.collect(), (&mut basis, point));
    }
    let (mut ways, mut largest) = (Vec::new(), 0.0f64);
    for _ in 0..MOST_ROUNDS {
        let size = block.len();
        let values: Vec<f64> = block.iter().map(|row| dot(&row.vector, &row.products[0])).collect();
        largest = values.iter().fold(largest, |largest, &value| largest.max(value));
        let residual = |(row, &value): (&Tried, &f64)| -> Vec<DVec3> {
            let rows = row.products[0].iter().zip(&row.vector);
            rows.map(|(product, vector)| *product - *vector * value).collect()
        };
        let residuals: Vec<Vec<DVec3>> = block.iter().zip(&values).map(residual).collect();
        let is_free = |value: f64| value <= FREE * largest;
        let lengths: Vec<f64> = residuals.iter().map(|residual| norm(residual)).collect();
        let mut slow = (0..size).filter(|&row| !is_free(values[row])).take(count);
        let has_all = slow.clone().count() == count || size < BLOCK;
        if has_all && slow.all(|row| lengths[row] <= CLOSE * values[row]) {
            let rows = (0..size).filter(|&row| !is_free(values[row])).take(count);
            let damping = |row: usize| dot(&block[row].vector, &block[row].products[1]);
            let mode = |row| Mode { stiffness: values[row], damping: damping(row) };
            return rows.map(mode).collect();
        }
        let corrections = residuals.into_iter().zip(lengths).zip(&values);
        let corrections = corrections
            .filter(|((_, length), value)| 0.1 * CLOSE * value.max(FREE * largest) < *length)
            .map(|((residual, _), _)| solved(residual, (&mut basis, point)));
        let corrections: Vec<Vec<DVec3>> = corrections.collect();
        for vector in corrections.into_iter().chain(core::mem::take(&mut ways)) {
            extend(&mut block, vector, (&mut basis, point));
        }
        let (found, vectors) = projected(&block).eigen();
        largest = largest.max(found[0]);
        // The smallest come last.
        let chosen = (0..block.len()).rev().take(size).map(|row| &vectors.rows[row]);
        let chosen: Vec<_> = chosen.collect();
        let mix = |weights: &[f64; MOST], from: usize, of: &dyn Fn(&Tried) -> &Vec<DVec3>| {
            mixed(&block[from..], &weights[from..], of)
        };
        ways = chosen.iter().map(|weights| mix(weights, size, &|row| &row.vector)).collect();
        let next = chosen.iter().map(|weights| Tried {
            vector: mix(weights, 0, &|row| &row.vector),
            products: [0, 1].map(|number| mix(weights, 0, &|row| &row.products[number])),
        });
        block = next.collect();
    }
    Vec::new()
}

/// The stiffness in the directions of a block.
fn projected(block: &[Tried]) -> Matrix {
    let mut small = Matrix::zero(block.len());
    for (row, a) in block.iter().enumerate() {
        for (column, b) in block[..=row].iter().enumerate() {
            let value = dot(&a.vector, &b.products[0]);
            (small.rows[row][column], small.rows[column][row]) = (value, value);
        }
    }
    small
}

/// A sum of columns of rows of a block, by weights.
fn mixed(block: &[Tried], weights: &[f64], of: &dyn Fn(&Tried) -> &Vec<DVec3>) -> Vec<DVec3> {
    let mut sum = alloc::vec![DVec3::ZERO; block.first().map_or(0, |row| of(row).len())];
    for (row, &weight) in block.iter().zip(weights) {
        sum.iter_mut().zip(of(row)).for_each(|(sum, value)| *sum += *value * weight);
    }
    sum
}

/// An estimate of K⁻¹ r by conjugate gradients: it brings a motion nearer to a slow one than r
/// does.
fn solved<R: Real>(
    residual: Vec<DVec3>,
    (basis, point): (&mut Basis, &OperatingPoint<'_, R>),
) -> Vec<DVec3> {
    let mut sum = alloc::vec![DVec3::ZERO; residual.len()];
    let (mut left, mut way) = (residual.clone(), residual);
    let mut square = dot(&left, &left);
    let goal = SOLVED * SOLVED * square;
    for _ in 0..MOST_SOLVES {
        let [product, _] = basis.products_of(point, &way);
        let curvature = dot(&way, product);
        if curvature <= 0.0 || square <= goal {
            break;
        }
        let step = square / curvature;
        sum.iter_mut().zip(&way).for_each(|(sum, way)| *sum += *way * step);
        left.iter_mut().zip(product).for_each(|(left, product)| *left -= *product * step);
        let before = square;
        square = dot(&left, &left);
        let factor = square / before;
        way.iter_mut().zip(&left).for_each(|(way, left)| *way = *left + *way * factor);
    }
    sum
}

/// Adds the part of a vector that the block lacks, if there is any.
fn extend<R: Real>(
    block: &mut Vec<Tried>,
    mut vector: Vec<DVec3>,
    (basis, point): (&mut Basis, &OperatingPoint<'_, R>),
) {
    let whole = norm(&vector);
    // Twice is enough (Kahan, in Parlett, 1980).
    for _ in 0..2 {
        for row in block.iter() {
            let along = dot(&row.vector, &vector);
            vector.iter_mut().zip(&row.vector).for_each(|(sum, value)| *sum -= *value * along);
        }
    }
    let length = norm(&vector);
    let is_new = 1e-9 * whole < length && length.is_finite() && block.len() < MOST;
    if is_new {
        vector.iter_mut().for_each(|value| *value /= length);
        let products = basis.products_of(point, &vector).clone();
        block.push(Tried { vector, products });
    }
}
