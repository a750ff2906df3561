//! One substep: the states at its stages, its error and its interpolant.

use super::tableau::{self, BENDS, ERROR_BEND, ERROR_SLOPE, Row, SLOPES, STAGES, TIMES};
use crate::columns::slots::Slots;
use crate::columns::{Aligned, LANES, RECORD};
use crate::elements::column;
use crate::number::{Real, at_level};
use crate::system::Columns;
use fearless_simd::Level;

/// Roundings of a coordinate that are indistinguishable from an error.
pub(crate) const ROUNDINGS: f64 = 64.0;

/// A substep: where it starts, its accelerations, and where it is.
#[derive(Clone, Debug)]
pub(crate) struct Stages<R: Real> {
    /// The state at the start.
    pub(crate) start: Columns<R>,
    /// The state at the current stage, after the last stage that at the end.
    pub(crate) here: Columns<R>,
    /// The accelerations of each stage, metres per second squared.
    pub(crate) slopes: [Aligned<R>; STAGES],
    /// The powers at each stage, watts.
    pub(crate) powers: Powers,
    /// Simulated time at the start, seconds.
    pub(crate) time: f64,
    /// Length, seconds; a number of `R`.
    pub(crate) length: f64,
}

/// Powers at each stage, watts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Powers {
    /// Dissipated by elements.
    pub(crate) elements: Row,
    /// Dissipated by friction of the particles that obstacles hold.
    pub(crate) friction: Row,
    /// Of the surfaces that move.
    pub(crate) driven: Row,
    /// Of the pins that move.
    pub(crate) pins: Row,
}

/// A stage that dissipates more than this times both ends of a substep is discarded as unphysical.
const WILD: f64 = 2.0;

impl<R: Real> Stages<R> {
    /// Makes the columns.
    pub(crate) fn new(slots: &Slots) -> Self {
        Stages {
            start: Columns::new(slots, 16),
            here: Columns::new(slots, 18),
            slopes: core::array::from_fn(|stage| column(slots, 20 + stage)),
            powers: Powers::default(),
            time: 0.0,
            length: 0.0,
        }
    }

    /// Starts a substep of `length` seconds, rounded once so that every stage has the same.
    pub(crate) fn start(&mut self, state: &Columns<R>, time: f64, length: f64) {
        self.time = time;
        self.length = R::of(length).to_f64();
        self.start.copy_from(state);
    }

    /// Simulated time at a fraction of the substep, seconds.
    pub(crate) fn time_at(&self, fraction: f64) -> f64 {
        self.time + fraction * self.length
    }

    /// Simulated time at a stage, seconds.
    pub(crate) fn time_of(&self, stage: usize) -> f64 {
        self.time_at(TIMES[stage])
    }

    /// Moves to a stage. One function per number of slopes lets the compiler unroll the sum.
    pub(crate) fn go_to(&mut self, level: Level, stage: usize) {
        match stage {
            1 => self.go_to_stage::<1>(level),
            2 => self.go_to_stage::<2>(level),
            3 => self.go_to_stage::<3>(level),
            4 => self.go_to_stage::<4>(level),
            5 => self.go_to_stage::<5>(level),
            _ => self.go_to_stage::<6>(level),
        }
    }

    fn go_to_stage<const N: usize>(&mut self, level: Level) {
        let weights = SlopeWeights::<R, N>::new(TIMES[N], &SLOPES[N], &BENDS[N], self.length);
        weights.set(level, &self.start, &self.slopes, &mut self.here);
    }

    /// Makes the last stage the first one of the next substep.
    pub(crate) fn shift(&mut self) {
        self.slopes.swap(0, STAGES - 1);
        let Powers { elements, friction, driven, pins } = &mut self.powers;
        for row in [elements, friction, driven, pins] {
            row.swap(0, STAGES - 1);
        }
    }

    /// Overwrites a state with the one at a fraction of the substep.
    ///
    /// Fourth order in the length of the substep. Source: Shampine (1986).
    pub(crate) fn interpolate(&self, level: Level, fraction: f64, state: &mut Columns<R>) {
        let slope = tableau::dense_slope(fraction);
        let bend = tableau::bend(slope);
        let weights = SlopeWeights::<R, STAGES>::new(fraction, &slope, &bend, self.length);
        weights.set(level, &self.start, &self.slopes, state);
    }

    /// The energies of the powers up to a fraction of the substep, joules, in their order: the
    /// powers integrated by the weights of the method.
    ///
    /// At a loose tolerance, near the limit of stability, the velocities inside a substep are
    /// unphysical, and a negative weight may dominate. Where a stage dissipates far more than both
    /// ends, the trapezoidal rule over the ends stands in.
    pub(crate) fn energies(&self, fraction: f64) -> [f64; 4] {
        let Powers { elements, friction, driven, pins } = &self.powers;
        let taken: Row = core::array::from_fn(|stage| elements[stage] + friction[stage]);
        let largest = taken.iter().copied().fold(0.0, f64::max);
        let is_wild = WILD * taken[0].max(taken[STAGES - 1]) < largest;
        let weights = tableau::dense_slope(fraction);
        [elements, friction, driven, pins].map(|powers| {
            let [first, last] = [powers[0], powers[STAGES - 1]];
            let there = first + (last - first) * fraction;
            let terms = weights.iter().zip(powers).map(|(weight, power)| weight * power);
            let mean = if is_wild { 0.5 * (first + there) * fraction } else { terms.sum() };
            mean * self.length
        })
    }

    /// The error as a fraction of the tolerance: the root mean square over particles.
    pub(crate) fn error(&self, level: Level, slots: &Slots, allowance: Allowance) -> f64 {
        let (weights, slopes) = (allowance.weights(self.length), self.columns());
        let positions = &*self.start.positions;
        let sum = at_level!(level, _simd => sum_of_squares(&weights, slopes, positions));
        Real::sqrt(sum / slots.particle_count().max(1) as f64)
    }

    /// The particle with the largest error, the first one whose error is NaN.
    pub(crate) fn worst(&self, slots: &Slots, allowance: Allowance) -> usize {
        let (weights, slopes) = (allowance.weights(self.length), self.columns());
        let (mut worst, mut largest) = (0, R::ZERO);
        for (particle, at) in slots.places().enumerate() {
            let errors = squares(&weights, slopes, &self.start.positions, at / RECORD);
            let error = errors[at % RECORD];
            if error.to_f64().is_nan() {
                return particle;
            }
            if largest < error {
                (worst, largest) = (particle, error);
            }
        }
        worst
    }

    fn columns(&self) -> [&[R]; STAGES] {
        self.slopes.each_ref().map(|column| &**column)
    }
}

/// The error allowed in a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowance {
    /// Error per particle, metres.
    pub(crate) error: f64,
    /// The least time for which an error of a velocity counts, seconds.
    pub(crate) horizon: f64,
}

impl Allowance {
    fn weights<R: Real>(self, h: f64) -> ErrorWeights<R> {
        // Divided by the tolerance before it is squared: the square of a length may not fit.
        let ahead = Real::max(h, self.horizon);
        ErrorWeights {
            slopes: ERROR_SLOPE.map(|weight| R::of(ahead * h * weight / self.error)),
            bends: ERROR_BEND.map(|weight| R::of(h * h * weight / self.error)),
            rounding: R::of(ROUNDINGS * R::EPSILON.to_f64() / self.error),
        }
    }
}

/// Weights of each slope, and of the distance from the origin, in the error as a fraction.
struct ErrorWeights<R> {
    slopes: [R; STAGES],
    bends: [R; STAGES],
    rounding: R,
}

/// The sum over all particles; lanes without a particle have no error.
#[inline(always)]
fn sum_of_squares<R: Real>(
    weights: &ErrorWeights<R>,
    slopes: [&[R]; STAGES],
    positions: &[R],
) -> f64 {
    let mut sums = [0.0; LANES];
    for record in 0..positions.len() / RECORD {
        let squares = squares(weights, slopes, positions, record);
        for lane in 0..LANES {
            sums[lane] += squares[lane].to_f64();
        }
    }
    sums.iter().sum()
}

/// The square of the error of each particle of a record as a fraction of its tolerance.
#[inline(always)]
fn squares<R: Real>(
    weights: &ErrorWeights<R>,
    slopes: [&[R]; STAGES],
    positions: &[R],
    record: usize,
) -> [R; LANES] {
    let (mut squared, mut far) = ([R::ZERO; LANES], [R::ONE; LANES]);
    for axis in 0..3 {
        let from = record * RECORD + axis * LANES;
        let (mut moved, mut kicked) = ([R::ZERO; LANES], [R::ZERO; LANES]);
        let both = weights.bends.iter().zip(&weights.slopes);
        for (column, (&bend, &slope)) in slopes.iter().zip(both) {
            let here: &[R; LANES] = column[from..].first_chunk().expect("a record");
            for lane in 0..LANES {
                moved[lane] += here[lane] * bend;
                kicked[lane] += here[lane] * slope;
            }
        }
        let x: &[R; LANES] = positions[from..].first_chunk().expect("a record");
        for lane in 0..LANES {
            let rounding = x[lane] * weights.rounding;
            far[lane] += rounding * rounding;
            squared[lane] += moved[lane] * moved[lane] + kicked[lane] * kicked[lane];
        }
    }
    for lane in 0..LANES {
        squared[lane] /= far[lane];
    }
    squared
}

/// Weights of each of N slopes in a position and in a velocity over a part of a substep.
struct SlopeWeights<R, const N: usize> {
    time: R,
    slopes: [R; N],
    bends: [R; N],
}

impl<R: Real, const N: usize> SlopeWeights<R, N> {
    fn new(part: f64, slopes: &Row, bends: &Row, h: f64) -> Self {
        SlopeWeights {
            time: R::of(part * h),
            slopes: core::array::from_fn(|stage| R::of(h * slopes[stage])),
            bends: core::array::from_fn(|stage| R::of(h * h * bends[stage])),
        }
    }

    /// x' = x + t v + Σ bends a, v' = v + Σ slopes a.
    fn set(
        &self,
        level: Level,
        start: &Columns<R>,
        slopes: &[Aligned<R>; STAGES],
        to: &mut Columns<R>,
    ) {
        let slopes: [&[R]; N] = core::array::from_fn(|stage| &*slopes[stage]);
        let start = [&*start.positions, &*start.velocities];
        let Columns { positions, velocities } = to;
        at_level!(level, _simd => self.set_sums(start, slopes, positions, velocities));
    }

    #[inline(always)]
    fn set_sums(&self, start: [&[R]; 2], slopes: [&[R]; N], to_x: &mut [R], to_v: &mut [R]) {
        let n = to_x.len();
        let ([x, v], to_v) = (start.map(|column| &column[..n]), &mut to_v[..n]);
        let slopes = slopes.map(|column| &column[..n]);
        for i in 0..n {
            let (mut moved, mut kicked) = (v[i] * self.time, R::ZERO);
            let weights = self.bends.iter().zip(&self.slopes);
            for (column, (&bend, &slope)) in slopes.iter().zip(weights) {
                moved += column[i] * bend;
                kicked += column[i] * slope;
            }
            to_x[i] = x[i] + moved;
            to_v[i] = v[i] + kicked;
        }
    }
}
