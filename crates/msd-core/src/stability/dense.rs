//! Small dense matrices: products and eigenvalues, on the stack, for bare metal too.

use crate::number::Real;

/// The largest size.
pub(crate) const MOST: usize = 40;

/// A square matrix of at most [`MOST`] rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Matrix {
    pub(crate) size: usize,
    pub(crate) rows: [[f64; MOST]; MOST],
}

impl Default for Matrix {
    fn default() -> Self {
        Matrix::zero(0)
    }
}

impl Matrix {
    pub(crate) fn zero(size: usize) -> Self {
        Matrix { size, rows: [[0.0; MOST]; MOST] }
    }

    pub(crate) fn identity(size: usize) -> Self {
        let mut identity = Matrix::zero(size);
        (0..size).for_each(|row| identity.rows[row][row] = 1.0);
        identity
    }

    pub(crate) fn times(&self, other: &Matrix) -> Matrix {
        let mut product = Matrix::zero(self.size);
        for (row, factors) in product.rows.iter_mut().zip(&self.rows).take(self.size) {
            for (factor, other) in factors.iter().zip(&other.rows).take(self.size) {
                let pairs = row.iter_mut().zip(other).take(self.size);
                pairs.for_each(|(value, other)| *value += factor * other);
            }
        }
        product
    }

    /// factor · self + other.
    pub(crate) fn scaled_plus(&self, factor: f64, other: &Matrix) -> Matrix {
        let mut sum = *other;
        for (row, mine) in sum.rows.iter_mut().zip(&self.rows).take(self.size) {
            let pairs = row.iter_mut().zip(mine).take(self.size);
            pairs.for_each(|(value, mine)| *value += factor * mine);
        }
        sum
    }

    /// The largest row sum of magnitudes; a NaN is passed on.
    pub(crate) fn norm(&self) -> f64 {
        let sum = |row: &[f64; MOST]| row[..self.size].iter().map(|value| value.abs()).sum::<f64>();
        let larger = |a: f64, b: f64| if b <= a { a } else { b };
        self.rows[..self.size].iter().map(sum).fold(0.0, larger)
    }

    /// uᵀ self v.
    pub(crate) fn between(&self, u: &[f64], v: &[f64]) -> f64 {
        let dot = |row: &[f64; MOST]| row.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
        u.iter().zip(&self.rows).map(|(u, row)| u * dot(row)).sum()
    }

    /// A symmetric matrix without its eigenvalues below a fraction of the largest, negative ones
    /// included.
    pub(crate) fn above(&self, fraction: f64) -> Matrix {
        let (values, vectors) = self.eigen();
        let least = fraction * values[0].max(0.0);
        let mut sum = *self;
        for (value, vector) in values.iter().zip(&vectors.rows).take(self.size) {
            if *value < least {
                for (row, &u) in sum.rows.iter_mut().zip(vector).take(self.size) {
                    row.iter_mut().zip(vector).for_each(|(sum, v)| *sum -= value * u * v);
                }
            }
        }
        sum
    }

    /// Eigenvalues of a symmetric matrix in descending order, and the eigenvectors as rows, by
    /// rotations (Jacobi, 1846).
    pub(crate) fn eigen(&self) -> ([f64; MOST], Matrix) {
        let (mut rest, mut vectors) = (*self, Matrix::identity(self.size));
        let tiny = 1e-15 * self.norm();
        for _ in 0..30 {
            let mut largest = 0f64;
            for p in 0..self.size {
                for q in p + 1..self.size {
                    largest = largest.max(rest.rows[p][q].abs());
                    if tiny < rest.rows[p][q].abs() {
                        rest.rotate((p, q), &mut vectors);
                    }
                }
            }
            if largest <= tiny {
                break;
            }
        }
        let mut values = [0.0; MOST];
        (0..self.size).for_each(|row| values[row] = rest.rows[row][row]);
        // By selection: there are few.
        for first in 0..self.size {
            let better = |a: usize, b: usize| if values[a] < values[b] { b } else { a };
            let best = (first..self.size).fold(first, better);
            values.swap(first, best);
            vectors.rows.swap(first, best);
        }
        (values, vectors)
    }

    /// Makes element (p, q) zero by a rotation, which `vectors` follows.
    fn rotate(&mut self, (p, q): (usize, usize), vectors: &mut Matrix) {
        let theta = (self.rows[q][q] - self.rows[p][p]) / (2.0 * self.rows[p][q]);
        let root = theta.abs() + Real::sqrt(theta * theta + 1.0);
        let tangent = if theta < 0.0 { -1.0 / root } else { 1.0 / root };
        let cosine = 1.0 / Real::sqrt(tangent * tangent + 1.0);
        let sine = tangent * cosine;
        let turn = |a: &mut f64, b: &mut f64| {
            (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
        };
        for row in &mut self.rows[..self.size] {
            let (mut a, mut b) = (row[p], row[q]);
            turn(&mut a, &mut b);
            (row[p], row[q]) = (a, b);
        }
        for matrix in [self, vectors] {
            let (above, below) = matrix.rows.split_at_mut(q);
            let pairs = above[p].iter_mut().zip(&mut below[0]);
            pairs.for_each(|(a, b)| turn(a, b));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eigenvalues_of_a_chain_are_those_of_the_textbook() {
        let size = 7;
        let mut chain = Matrix::zero(size);
        for row in 0..size {
            chain.rows[row][row] = 2.0;
            if 0 < row {
                (chain.rows[row][row - 1], chain.rows[row - 1][row]) = (-1.0, -1.0);
            }
        }
        let (values, vectors) = chain.eigen();
        for (row, value) in values[..size].iter().enumerate() {
            let angle = core::f64::consts::PI * (size - row) as f64 / (size + 1) as f64;
            // A few roundings of numbers up to 4.
            assert!((value - (2.0 - 2.0 * angle.cos())).abs() < 1e-14, "{row}: {value}");
            let vector = &vectors.rows[row][..size];
            assert!((chain.between(vector, vector) - value).abs() < 1e-14);
        }
    }
}
