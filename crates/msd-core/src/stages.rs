//! What happens within one substep of Dormand and Prince, given the accelerations at its stages?

use crate::real::{Real, Vector};
use crate::system::State;
use crate::tableau::{self, BENDS, ERROR_BEND, ERROR_SLOPE, Row, SLOPES, STAGES, TIMES};
use alloc::vec;
use alloc::vec::Vec;

/// Roundings of a coordinate that are not told from an error.
pub(crate) const ROUNDINGS: f64 = 64.0;

/// A substep: where it starts, its accelerations, and where it is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stages<R: Real> {
    /// The state at the start.
    pub(crate) start: State<R>,
    /// The state at the stage at hand, after the last stage the end.
    pub(crate) here: State<R>,
    /// The accelerations of each stage, metres per second squared.
    pub(crate) slopes: [Vec<R::Vec3>; STAGES],
    /// The power taken away at each stage, watts.
    pub(crate) powers: Row,
    /// Length, seconds; a number of `R`.
    pub(crate) length: f64,
}

/// A stage that wastes more than this times what both ends of a substep do is of no motion.
const WILD: f64 = 2.0;

impl<R: Real> Stages<R> {
    /// Makes the columns for `count` particles.
    pub(crate) fn new(count: usize) -> Self {
        let column = || vec![R::Vec3::ZERO; count];
        let state = || State { positions: column(), velocities: column() };
        Stages {
            start: state(),
            here: state(),
            slopes: core::array::from_fn(|_| column()),
            powers: [0.0; STAGES],
            length: 0.0,
        }
    }

    /// Starts a substep of `length` seconds, rounded once so that every stage has the same.
    pub(crate) fn start(&mut self, state: &State<R>, length: f64) {
        self.length = R::of(length).to_f64();
        copy(state, &mut self.start);
    }

    /// Moves to a stage. One function per number of slopes lets the compiler unroll the sum.
    pub(crate) fn go_to(&mut self, stage: usize) {
        match stage {
            1 => self.go_to_stage::<1>(),
            2 => self.go_to_stage::<2>(),
            3 => self.go_to_stage::<3>(),
            4 => self.go_to_stage::<4>(),
            5 => self.go_to_stage::<5>(),
            _ => self.go_to_stage::<6>(),
        }
    }

    fn go_to_stage<const N: usize>(&mut self) {
        let weights = Weights::<R, N>::new(TIMES[N], &SLOPES[N], &BENDS[N], self.length);
        weights.set(&self.start, &self.slopes, &mut self.here);
    }

    /// Makes the last stage the first one of the next substep.
    pub(crate) fn shift(&mut self) {
        self.slopes.swap(0, STAGES - 1);
        self.powers.swap(0, STAGES - 1);
    }

    /// Overwrites `state` with the one at a fraction of the substep.
    pub(crate) fn interpolate(&self, fraction: f64, state: &mut State<R>) {
        let slope = tableau::dense_slope(fraction);
        let bend = tableau::bend(slope);
        let weights = Weights::<R, STAGES>::new(fraction, &slope, &bend, self.length);
        weights.set(&self.start, &self.slopes, state);
    }

    /// The energy taken away up to a fraction of the substep, joules: the power integrated by the
    /// weights of the method.
    ///
    /// At a loose tolerance, near the limit of stability, the velocities inside a substep are those
    /// of no motion, and a negative weight may rule: where a stage wastes far more than both ends,
    /// the trapezoidal rule over the ends stands in.
    pub(crate) fn taken(&self, fraction: f64) -> f64 {
        let [first, last] = [self.powers[0], self.powers[STAGES - 1]];
        let largest = self.powers.iter().copied().fold(0.0, f64::max);
        if WILD * first.max(last) < largest {
            let there = first + (last - first) * fraction;
            return 0.5 * (first + there) * fraction * self.length;
        }
        let weights = tableau::dense_slope(fraction);
        let terms = weights.iter().zip(&self.powers).map(|(weight, power)| weight * power);
        terms.sum::<f64>() * self.length
    }

    /// The error as a fraction of what is allowed: the root mean square over particles.
    pub(crate) fn error(&self, allowed: f64, horizon: f64) -> f64 {
        let sum: f64 = self.errors(allowed, horizon).sum();
        Real::sqrt(sum / self.start.positions.len() as f64)
    }

    /// The particle with the largest error, the first one whose error is no number.
    pub(crate) fn worst(&self, allowed: f64, horizon: f64) -> usize {
        let (mut worst, mut largest) = (0, 0.0);
        for (particle, error) in self.errors(allowed, horizon).enumerate() {
            if error.is_nan() {
                return particle;
            }
            if largest < error {
                (worst, largest) = (particle, error);
            }
        }
        worst
    }

    /// The square of the error of each particle as a fraction of what it is allowed.
    fn errors(&self, allowed: f64, horizon: f64) -> impl Iterator<Item = f64> {
        // Divided by what is allowed before it is squared: the square of a length may not fit.
        let h = self.length;
        let ahead = Real::max(h, horizon);
        let slope = ERROR_SLOPE.map(|weight| R::of(ahead * h * weight / allowed));
        let bend = ERROR_BEND.map(|weight| R::of(h * h * weight / allowed));
        let rounding = R::of(ROUNDINGS * R::EPSILON.to_f64() / allowed);
        let count = self.start.positions.len();
        let columns: [&[R::Vec3]; STAGES] =
            core::array::from_fn(|stage| &self.slopes[stage][..count]);
        (0..count).map(move |row| {
            let (mut moved, mut kicked) = (R::Vec3::ZERO, R::Vec3::ZERO);
            for stage in 0..STAGES {
                let here = columns[stage][row];
                moved += here * bend[stage];
                kicked += here * slope[stage];
            }
            let far = self.start.positions[row] * rounding;
            let squared = moved.dot(moved) + kicked.dot(kicked);
            (squared / (R::ONE + far.dot(far))).to_f64()
        })
    }
}

/// Overwrites a state with another.
pub(crate) fn copy<R: Real>(from: &State<R>, to: &mut State<R>) {
    to.positions.copy_from_slice(&from.positions);
    to.velocities.copy_from_slice(&from.velocities);
}

/// What each of N slopes does to a position and to a velocity over a part of a substep.
struct Weights<R, const N: usize> {
    time: R,
    slopes: [R; N],
    bends: [R; N],
}

impl<R: Real, const N: usize> Weights<R, N> {
    fn new(part: f64, slopes: &Row, bends: &Row, h: f64) -> Self {
        Weights {
            time: R::of(part * h),
            slopes: core::array::from_fn(|stage| R::of(h * slopes[stage])),
            bends: core::array::from_fn(|stage| R::of(h * h * bends[stage])),
        }
    }

    /// x' = x + t v + Σ bends a, v' = v + Σ slopes a.
    fn set(&self, start: &State<R>, slopes: &[Vec<R::Vec3>; STAGES], to: &mut State<R>) {
        let count = start.positions.len();
        let columns: [&[R::Vec3]; N] = core::array::from_fn(|stage| &slopes[stage][..count]);
        let (positions, velocities) = (&start.positions[..count], &start.velocities[..count]);
        let (to_x, to_v) = (&mut to.positions[..count], &mut to.velocities[..count]);
        for row in 0..count {
            let velocity = velocities[row];
            let (mut moved, mut kicked) = (velocity * self.time, R::Vec3::ZERO);
            for (column, (&bend, &slope)) in columns.iter().zip(self.bends.iter().zip(&self.slopes))
            {
                moved += column[row] * bend;
                kicked += column[row] * slope;
            }
            to_x[row] = positions[row] + moved;
            to_v[row] = velocity + kicked;
        }
    }
}
