//! Limits of stability: the longest substep before a run blows up, predicted from the spectrum.
//!
//! The fastest motions of a system are found without a matrix and compared with the [`Region`] of a
//! method. Where damping couples motions - dampers that do not go with the stiffness of their
//! springs - no single oscillator decides. Then a step of the method is taken on the few fastest
//! motions together, as a matrix, and its powers show whether anything grows. For symplectic Euler
//! the answer is exact in general: bounded while h²/4 K + h/2 D < M.

mod dense;
mod region;
mod spectrum;
mod euler;
mod few;
mod pieces;
mod slowest;

pub use region::{Mode, Region, is_stable};

use crate::elements::{Block, Blocks, Derivatives, Products};
use crate::number::Real;
use crate::system::{Columns, Model};
use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::ControlFlow;
pub(crate) use dense::Matrix;
use few::{Few, single_substep};
use glam::DVec3;
use pieces::{Growth, Phase};
use spectrum::{Basis, OperatingPoint, Rough};

/// Products until the fastest motion of a lattice is known to 0.3 % in w².
const VECTORS: usize = 30;
/// The fewest products, of systems so large that their vectors would fill the memory: 2 % in w².
const FEWEST_VECTORS: usize = 12;
/// The most memory of the vectors, bytes, as far as the fewest fit.
const MOST_BYTES: usize = 256 << 20;
/// Rayleigh quotients until the fastest motion has converged to rounding.
const MOST_QUOTIENTS: usize = 20;
/// Slow motions that are sought at most.
const MOST_SLOWEST: usize = 5;

/// Predicts the largest stable substep of any number of states; allocates at the first only, unless
/// there are user-defined elements.
///
/// A prediction takes some 40 products with stiffness and damping, each about two evaluations of
/// the forces. An element without products of its own is evaluated four times for each. Contact
/// adds no stiffness here: obstacles move particles instead of pushing them.
#[derive(Clone, Debug, Default)]
pub struct Estimator {
    // Their matrices are too large to be moved about on the small stack of a browser.
    basis: Box<Basis>,
    /// Sums over all elements at each particle.
    sums: Vec<Mode>,
    /// Stiffness and damping of some elements at each particle.
    rows: Vec<[f64; 2]>,
    /// Weight of each particle in a rough vector.
    weights: Vec<f64>,
    /// Progress of a prediction in pieces, and the motions that it resolves.
    phase: Phase,
    few: Box<Few>,
    euler: euler::Search,
}

/// The fastest motion about a state, taken for a single oscillator: that is exact where damping
/// goes with stiffness.
pub(crate) fn fastest_mode<R: Real>(model: &Model<R>, state: &Columns<R>, time: f64) -> Mode {
    let mut estimator = Estimator::default();
    let point = OperatingPoint { model, motion: state.motion(&model.slots, time) };
    let Some((_, vectors)) = estimator.explore(&point, false) else {
        return Mode::default();
    };
    estimator.mode(&vectors)
}

/// The slowest motions about a state that anything resists, at most `count`, slowest first; see
/// [`slowest::slowest`].
pub(crate) fn slowest_modes<R: Real>(
    (model, state): (&Model<R>, &Columns<R>),
    time: f64,
    count: usize,
) -> Vec<Mode> {
    let point = OperatingPoint { model, motion: state.motion(&model.slots, time) };
    slowest::slowest(&point, count.min(MOST_SLOWEST))
}

/// The displacement of each particle in the fastest motion about a state, the largest of length 1;
/// empty where nothing pulls.
pub(crate) fn fastest_motion<R: Real>(
    model: &Model<R>,
    state: &Columns<R>,
    time: f64,
) -> Vec<DVec3> {
    let mut estimator = Estimator::default();
    let point = OperatingPoint { model, motion: state.motion(&model.slots, time) };
    let Some((_, vectors)) = estimator.explore(&point, false) else {
        return Vec::new();
    };
    let first = &vectors.rows[0][..vectors.size];
    let mut motion = estimator.basis.displacements(first);
    let largest = motion.iter().map(|way| way.length_squared()).fold(0.0, f64::max);
    let searchable = 0.0 < largest && largest.is_finite();
    if !searchable {
        return Vec::new();
    }
    motion.iter_mut().for_each(|way| *way /= Real::sqrt(largest));
    motion
}

/// A substep that is stable about every state in which no spring is compressed to nothing, seconds.
/// It comes from sums over springs alone (after Gershgorin, 1931), two to four times shorter than
/// [`Estimator::limit`]; 0 for explicit Euler, for which such sums give no bound.
///
/// A spring adds at most its k (1/m_a + 1/m_b) to any motion; all springs of a particle at once add
/// at most the sum of their k over its mass. Of bends the largest row sum of magnitudes counts.
/// Volumes and user-defined elements are known about this state alone, the last only
/// where they act on each particle by itself and give their blocks.
pub(crate) fn guaranteed_limit<R: Real>(
    (model, state): (&Model<R>, &Columns<R>),
    time: f64,
    region: Region,
) -> f64 {
    let point = OperatingPoint { model, motion: state.motion(&model.slots, time) };
    let bound = bound(&point, &point.derivatives(), &mut Vec::new(), &mut Vec::new());
    match region {
        Region::Everything => f64::INFINITY,
        Region::EXPLICIT_EULER if 0.0 < bound.stiffness => 0.0,
        Region::EXPLICIT_EULER => 2.0 / bound.damping,
        // No hλ is longer than the longer of these.
        Region::Polynomial(_) => {
            region.half_disc() / Real::sqrt(bound.stiffness).max(bound.damping)
        }
        // With few substeps a damped step of Verlet bears up to 2 % less than a long one.
        Region::VelocityVerlet if 0.0 < bound.damping => 0.95 * bound.scale(),
        Region::SymplecticEuler | Region::VelocityVerlet => bound.scale(),
    }
}

/// A motion at least as stiff and as damped as any; `sums` becomes the same of each particle alone.
fn bound<R: Real>(
    point: &OperatingPoint<'_, R>,
    derivatives: &Derivatives,
    sums: &mut Vec<Mode>,
    rows: &mut Vec<[f64; 2]>,
) -> Mode {
    let OperatingPoint { model, motion } = point;
    let mut kinds = model.kinds();
    rows.clear();
    rows.resize(model.particle_count(), [0.0; 2]);
    kinds.by_ref().take(1).for_each(|springs| springs.add_row_sums(motion, derivatives, rows));
    let weighed = |(&sum, w): (&[f64; 2], &R)| Mode::of(sum).times(w.to_f64());
    sums.clear();
    sums.extend(rows.iter().zip(&model.inverse_masses).map(weighed));
    let mut bound = Mode::default();
    for (_, [a, b]) in model.springs.present() {
        let mut pair = sums[a];
        pair.add(sums[b].stiffness, sums[b].damping);
        bound = bound.larger(pair);
    }
    rows.fill([0.0; 2]);
    kinds.for_each(|kind| kind.add_row_sums(motion, derivatives, rows));
    add_others(point, rows);
    let mut most = Mode::default();
    for (sum, row) in sums.iter_mut().zip(rows.iter().zip(&model.inverse_masses)) {
        let other = weighed(row);
        sum.add(other.stiffness, other.damping);
        most = most.larger(other);
    }
    bound.add(most.stiffness, most.damping);
    bound
}

/// Adds stiffness and damping of elements of which no more is known than their products, N/m and
/// N s/m.
fn add_others<R: Real>(point: &OperatingPoint<'_, R>, rows: &mut [[f64; 2]]) {
    let OperatingPoint { model, motion } = point;
    for element in model.other().into_iter().filter_map(|kind| kind.element()) {
        let count = rows.len();
        let directions: Vec<DVec3> = Rough(0).take(count).collect();
        let [mut stiffness, mut damping] = [0; 2].map(|_| vec![DVec3::ZERO; count]);
        let [mut stiff, mut damp] = [0; 2].map(|_| vec![Block::default(); count]);
        let mut products = Products { stiffness: &mut stiffness, damping: &mut damping };
        let mut blocks = Blocks { stiffness: &mut stiff, damping: &mut damp };
        element.add_products(motion, &directions, &mut products);
        element.add_blocks(motion, &mut blocks);
        // The products with a rough motion, for elements that couple particles or give no blocks.
        for (row, sum) in rows.iter_mut().enumerate() {
            let length = |vector: DVec3| Real::sqrt(vector.dot(vector));
            let met = |product: DVec3| length(product) / length(directions[row]);
            sum[0] += largest_row(&stiff[row]).max(met(stiffness[row]));
            sum[1] += largest_row(&damp[row]).max(met(damping[row]));
        }
    }
}

/// The largest row sum of magnitudes of a block: no eigenvalue is larger (Gershgorin, 1931).
fn largest_row(block: &Block) -> f64 {
    let [xx, xy, xz, yy, yz, zz] = block.map(f64::abs);
    (xx + xy + xz).max(xy + yy + yz).max(xz + yz + zz)
}

/// The factors of K, D and D² in h²/4 K + h/2 D, which is 1 at the limit h of symplectic Euler, and
/// at about that of Verlet.
fn many_substeps(h: f64) -> [f64; 3] {
    [0.25 * h * h, 0.5 * h, 0.0]
}

impl Estimator {
    /// Makes a basis about a state; returns the limit of symplectic Euler and the motions of the
    /// basis, those first that reach it first. `None` where nothing pulls. With `both` the stiffest
    /// motions of all are in the basis too.
    fn explore<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        both: bool,
    ) -> Option<(f64, Matrix)> {
        let mut growth = None;
        loop {
            match self.grow(point, both, growth) {
                ControlFlow::Continue(next) => growth = Some(next),
                ControlFlow::Break(explored) => return explored,
            }
        }
    }

    /// Does a piece of that: the bounds and the first vector, or another vector, or the motions.
    fn grow<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        both: bool,
        growth: Option<Growth>,
    ) -> ControlFlow<Option<(f64, Matrix)>, Growth> {
        let Some(Growth { guess, left, is_second }) = growth else { return self.begin(point) };
        if 0 < left {
            let mixture =
                if both && is_second { single_substep(guess) } else { many_substeps(guess) };
            self.basis.grow(point, mixture, 1);
            return ControlFlow::Continue(Growth { guess, left: left - 1, is_second });
        }
        let Some((guess, motions)) = self.fastest(guess) else { return ControlFlow::Break(None) };
        if is_second || guess == 0.0 {
            return ControlFlow::Break(Some((guess, motions)));
        }
        // The mixture of stiffness and damping that matters is known better now.
        if both {
            self.basis.push_rough(point, &self.weights);
        }
        ControlFlow::Continue(Growth { guess, left: self.half(), is_second: true })
    }

    /// Begins a basis by a bound.
    fn begin<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
    ) -> ControlFlow<Option<(f64, Matrix)>, Growth> {
        self.basis.prepare(point);
        let derivatives = self.basis.derivatives();
        let guess = bound(point, derivatives, &mut self.sums, &mut self.rows).scale();
        if guess == f64::INFINITY {
            return ControlFlow::Break(None);
        }
        if guess.is_nan() || guess == 0.0 {
            return ControlFlow::Break(Some((0.0, Matrix::zero(0))));
        }
        self.weigh(guess);
        self.basis.begin(point, &self.weights);
        ControlFlow::Continue(Growth { guess, left: self.half(), is_second: false })
    }

    /// Half of the vectors of a basis.
    fn half(&self) -> usize {
        let bytes = size_of::<DVec3>() * self.sums.len().max(1);
        (MOST_BYTES / bytes).clamp(FEWEST_VECTORS, VECTORS) / 2
    }

    /// Gives most weight to the particles at which the stiffest springs pull: fast motions are
    /// found there.
    fn weigh(&mut self, h: f64) {
        let speed = |sum: &Mode| 0.25 * h * h * sum.stiffness + 0.5 * h * sum.damping;
        let largest = self.sums.iter().map(speed).fold(f64::MIN_POSITIVE, f64::max);
        let weight = |sum: &Mode| {
            let share = speed(sum) / largest;
            share * share * share * share
        };
        self.weights.clear();
        self.weights.extend(self.sums.iter().map(weight));
    }

    /// The root h of the largest eigenvalue of h²/4 K + h/2 D = 1 from a guess, and the
    /// eigenvectors there. A Rayleigh quotient is right to the square of the error of its vector,
    /// so that a few rounds do.
    fn fastest(&self, guess: f64) -> Option<(f64, Matrix)> {
        let (mut h, mut last) = (guess, None);
        for _ in 0..MOST_QUOTIENTS {
            let (_, vectors) = self.basis.mixture(many_substeps(h)).eigen();
            let next = self.mode(&vectors).scale();
            if next == f64::INFINITY {
                return None;
            }
            // Beyond all numbers: no step is known to be stable.
            if next.is_nan() || next == 0.0 {
                return Some((0.0, vectors));
            }
            if (next - h).abs() <= 1e-9 * h {
                return Some((next, vectors));
            }
            (h, last) = (next, Some((next, vectors)));
        }
        // Motions of equal speed may take turns; any of them will do.
        last
    }

    /// The first of the motions as a single oscillator.
    fn mode(&self, vectors: &Matrix) -> Mode {
        let Basis { stiffness, damping, .. } = &*self.basis;
        let first = &vectors.rows[0][..stiffness.size];
        Mode {
            // Zero for a motion that buckles; a NaN stays.
            stiffness: Real::max(stiffness.between(first, first), 0.0),
            damping: damping.between(first, first),
        }
    }
}
