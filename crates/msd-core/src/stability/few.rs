//! Stability of a few motions that are coupled by dampers.
//!
//! A step of a method takes the motions (x, h v) together to new ones by a matrix. A step whose
//! powers stay bounded is stable; the motion that they amplify first is the one to resolve better.

use super::dense::{MOST, Matrix};
use super::region::{MANY, Mode, Region, first_unstable};
use super::spectrum::{Basis, OperatingPoint};
use crate::number::Real;

/// The region of a method and the substeps of a step.
pub(crate) type How = (Region, u32);

/// Number of motions that are taken together: those that symplectic Euler fails by first,
const FIRST: usize = 6;
/// the stiffest ones
const STIFFEST: usize = 3;
/// and the most damped ones.
const MOST_DAMPED: usize = 1;
/// Motions may share this fraction of their damping and still count as single ones: its effect is
/// its square.
const COUPLED: f64 = 1e-3;
/// Motions with less than this share of the largest w² count as still: rounding a length gives a
/// spring at rest as much.
const STILL: f64 = 1e-6;
/// Squarings of a step: a thousand million steps reveal a growth of 3e-8 per step.
const SQUARINGS: usize = 30;
/// A step whose powers pass this grows: a bounded motion may rise for a while, and a drifting one
/// gains no more than the number of steps.
const EXPLODED: f64 = 1e13;
/// A step whose powers fall below this does not grow again.
const DIED_OUT: f64 = 1e-3;

/// The factors of K, D and D² in h²/4 K + h/2 D − h²/4 D², which is 1 at the limit h of Verlet with
/// one substep per step.
pub(crate) fn single_substep(h: f64) -> [f64; 3] {
    [0.25 * h * h, 0.5 * h, -0.25 * h * h]
}

/// A few motions of a basis, taken together.
#[derive(Clone, Debug, Default)]
pub(crate) struct Few {
    /// The motions as rows, in the basis.
    rows: Matrix,
    stiffness: Matrix,
    damping: Matrix,
}

impl Few {
    /// The first of `motions` of a basis. Where there is damping, they include its stiffest and its
    /// most damped one, for not every method fails by the same, and near the limit of Verlet with
    /// one substep per step those that fail by it.
    pub(crate) fn new(mut motions: Matrix, basis: &Basis, single_step: Option<f64>) -> Self {
        let used = basis.stiffness.size;
        motions.size = FIRST.min(used);
        let mut few = Few { rows: motions, stiffness: Matrix::zero(0), damping: Matrix::zero(0) };
        if 0.0 < basis.damping.norm() {
            for (matrix, count) in [(&basis.stiffness, STIFFEST), (&basis.damping, MOST_DAMPED)] {
                let (_, vectors) = matrix.eigen();
                vectors.rows[..count.min(used)].iter().for_each(|&motion| _ = few.push(motion));
            }
        }
        if let Some(h) = single_step {
            let (_, vectors) = basis.mixture(single_substep(h)).eigen();
            vectors.rows[..STIFFEST.min(used)].iter().for_each(|&motion| _ = few.push(motion));
        }
        few.project(basis);
        few
    }

    /// Sets stiffness and damping between the motions.
    fn project(&mut self, basis: &Basis) {
        let (count, length) = (self.rows.size, basis.stiffness.size);
        (self.stiffness.size, self.damping.size) = (count, count);
        for a in 0..count {
            for b in 0..count {
                let [u, v] = [a, b].map(|row| &self.rows.rows[row][..length]);
                self.stiffness.rows[a][b] = basis.stiffness.between(u, v);
                self.damping.rows[a][b] = basis.damping.between(u, v);
            }
        }
        // A compressed state buckles at any step, as it would without steps: that is not a limit.
        self.stiffness = self.stiffness.above(STILL);
        // Nor is a motion that a user-defined element drives by its velocity.
        if 0.0 < self.damping.norm() {
            self.damping = self.damping.above(0.0);
        }
    }

    /// The limit of the motions together, from a substep that should be stable.
    pub(crate) fn limit(&self, (region, substeps): How, start: f64) -> f64 {
        match self.modes() {
            Some(modes) => {
                let limits = modes.map(|mode| mode.largest_substep(region, substeps));
                limits.fold(f64::INFINITY, f64::min)
            }
            None => {
                let stable = |h: f64| exploded(self.step((region, substeps), h)).is_none();
                first_unstable(start, 1.05, 11, stable)
            }
        }
    }

    /// Whether no two motions share damping.
    pub(crate) fn is_single(&self) -> bool {
        self.modes().is_some()
    }

    /// The motions as single oscillators if no two of them share damping.
    fn modes(&self) -> Option<impl Iterator<Item = Mode>> {
        let count = self.rows.size;
        let (stiffnesses, vectors) = self.stiffness.eigen();
        let between = self.damping;
        let damping = move |a: usize, b: usize| {
            between.between(&vectors.rows[a][..count], &vectors.rows[b][..count])
        };
        let largest = (0..count).map(|a| damping(a, a)).fold(0.0, f64::max);
        let apart = |a: usize| (0..a).all(|b| damping(a, b).abs() <= COUPLED * largest);
        let moves = move |row: usize| STILL * stiffnesses[0] < stiffnesses[row];
        let mode = move |row: usize| Mode {
            stiffness: if moves(row) { stiffnesses[row] } else { 0.0 },
            damping: damping(row, row),
        };
        (0..count).all(apart).then(|| (0..count).map(mode))
    }

    /// The matrix of a step, which acts on the motions (x, h v).
    fn step(&self, (region, substeps): How, h: f64) -> Matrix {
        let count = self.rows.size;
        let mut flow = Matrix::zero(2 * count);
        for row in 0..count {
            flow.rows[row][count + row] = 1.0;
            for column in 0..count {
                flow.rows[count + row][column] = -h * h * self.stiffness.rows[row][column];
                flow.rows[count + row][count + column] = -h * self.damping.rows[row][column];
            }
        }
        let identity = Matrix::identity(2 * count);
        let mut kick = flow;
        kick.rows[..count].fill([0.0; MOST]);
        match region {
            Region::Polynomial(factors) => {
                let horner =
                    |sum: Matrix, &factor: &f64| identity.scaled_plus(factor, &flow.times(&sum));
                factors.iter().rev().fold(Matrix::zero(2 * count), horner)
            }
            Region::SymplecticEuler => drift(count).times(&kick.scaled_plus(1.0, &identity)),
            Region::VelocityVerlet => verlet(&kick, substeps.clamp(1, MANY)),
            Region::Everything => identity,
        }
    }

    /// Adds the motion that grows first above a limit as the basis cannot show it yet; false where
    /// there is nothing to add.
    pub(crate) fn extend<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        basis: &mut Basis,
        (how, limit): (How, f64),
    ) -> bool {
        let (count, h) = (self.rows.size, 1.002 * limit);
        let Some(power) = exploded(self.step(how, h)) else { return false };
        let first = grown(&power, &[0.0; MOST]);
        let second = grown(&power, &first);
        let mut added = false;
        for grown in [first, second] {
            let used = basis.stiffness.size;
            let (mut x, mut v) = ([0.0; MOST], [0.0; MOST]);
            for (row, motion) in self.rows.rows[..count].iter().enumerate() {
                for (column, &coordinate) in motion[..used].iter().enumerate() {
                    x[column] += grown[row] * coordinate;
                    v[column] += grown[count + row] / h * coordinate;
                }
            }
            let mut residual = [0.0; MOST];
            for (row, value) in residual[..used].iter_mut().enumerate() {
                let along = |matrix: &Matrix, by: &[f64]| {
                    matrix.rows[row].iter().zip(by).map(|(a, b)| a * b).sum::<f64>()
                };
                *value = along(&basis.stiffness, &x[..used]) + along(&basis.damping, &v[..used]);
            }
            let beyond = basis.push_residual(point, &x[..used], &v[..used]);
            if used < basis.stiffness.size {
                residual[used] = beyond;
            }
            added |= self.push(residual);
        }
        self.project(basis);
        added
    }

    /// Adds the part of a motion that the others lack.
    fn push(&mut self, mut motion: [f64; MOST]) -> bool {
        let count = self.rows.size;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let whole = Real::sqrt(dot(&motion, &motion));
        for _ in 0..2 {
            for row in &self.rows.rows[..count] {
                let along = dot(row, &motion);
                motion.iter_mut().zip(row).for_each(|(value, row)| *value -= along * row);
            }
        }
        let length = Real::sqrt(dot(&motion, &motion));
        if length <= 1e-9 * whole || 2 * count + 2 > MOST {
            return false;
        }
        self.rows.rows[count] = motion.map(|value| value / length);
        self.rows.size = count + 1;
        true
    }
}

/// A high power of a step if it grows without end.
fn exploded(mut power: Matrix) -> Option<Matrix> {
    for _ in 0..SQUARINGS {
        let norm = power.norm();
        if norm.is_nan() || EXPLODED < norm {
            return Some(power);
        }
        if norm < DIED_OUT {
            break;
        }
        power = power.times(&power);
    }
    None
}

/// x' = x + h v of `count` motions.
fn drift(count: usize) -> Matrix {
    let mut drift = Matrix::identity(2 * count);
    (0..count).for_each(|row| drift.rows[row][count + row] = 1.0);
    drift
}

/// A step of velocity Verlet, see `methods/explicit.rs`; `kick` takes (x, h v) to (0, h² a).
fn verlet(kick: &Matrix, substeps: u32) -> Matrix {
    let drift = drift(kick.size / 2);
    let mut motion = Matrix::identity(kick.size);
    let mut now = *kick;
    let mut before = now;
    for _ in 0..substeps {
        motion = drift.times(&now.scaled_plus(0.5, &motion));
        let predicted = now.scaled_plus(0.25, &before.scaled_plus(0.25, &motion));
        (before, now) = (now, kick.times(&predicted));
        motion = now.scaled_plus(0.5, &motion);
    }
    motion
}

/// The largest column of a power without its part along `skip`, of length one.
fn grown(power: &Matrix, skip: &[f64; MOST]) -> [f64; MOST] {
    let dot = |a: &[f64; MOST], b: &[f64; MOST]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let scale = 1.0 / power.norm();
    let mut largest = ([0.0; MOST], 0.0);
    for column in 0..power.size {
        let mut vector = [0.0; MOST];
        (0..power.size).for_each(|row| vector[row] = power.rows[row][column] * scale);
        let along = dot(&vector, skip);
        vector.iter_mut().zip(skip).for_each(|(value, skip)| *value -= along * skip);
        let length = Real::sqrt(dot(&vector, &vector));
        if largest.1 < length {
            largest = (vector.map(|value| value / length), length);
        }
    }
    largest.0
}
