//! How long may a substep be before the run blows up? Predicted from the spectrum.
//!
//! The fastest motions of a system are found without a matrix and held against the region of a
//! method (see [`crate::region`]). Where damping couples motions - dampers that do not go with the
//! stiffness of their springs - no single oscillator tells: then a step of the method is taken on
//! the few fastest motions together, as a matrix, and its powers say whether anything grows. For
//! symplectic Euler the answer is exact in general: bounded while h²/4 K + h/2 D < M.

use crate::dense::Matrix;
use crate::few::{Few, single_substep};
use crate::integrator::Integrator;
use crate::real::Real;
pub use crate::region::{Mode, is_stable};
use crate::region::{Step, coefficients};
use crate::spectrum::Basis;
use crate::system::{Model, State};
use alloc::vec::Vec;
use glam::DVec3;

/// Products until the fastest motion of a lattice is known to 0.3 % in w².
const VECTORS: usize = 30;
/// The fewest products, of systems so large that their vectors would fill the memory: 2 % in w².
const FEWEST_VECTORS: usize = 12;
/// The most memory of the vectors, bytes, as far as the fewest fit.
const MOST_BYTES: usize = 256 << 20;
/// Rayleigh quotients until the fastest motion stands still, but for rounding.
const MOST_QUOTIENTS: usize = 20;
/// The search for a limit begins at this share of what is expected.
const START: f64 = 0.93;
/// The most times that the motion that grows first is added to those.
const ROUNDS: usize = 5;

/// Predicts the largest stable substep of any number of states; allocates at the first only.
///
/// A prediction takes some 40 products with stiffness and damping, each about two evaluations of
/// the forces. Contact adds no stiffness here: planes move particles out, they do not push.
#[derive(Clone, Debug)]
pub struct Estimator {
    basis: Basis,
    /// Sums over the springs of each particle.
    sums: Vec<Mode>,
    /// How much of each particle is in a rough vector.
    weights: Vec<f64>,
}

impl Default for Estimator {
    fn default() -> Self {
        Estimator { basis: Basis::new(), sums: Vec::new(), weights: Vec::new() }
    }
}

/// The largest stable substep about a state, seconds: see [`Estimator::limit`].
pub fn limit<R: Real>(
    model: &Model<R>,
    state: &State<R>,
    integrator: Integrator,
    substeps: u32,
) -> f64 {
    Estimator::default().limit((model, state), integrator, substeps)
}

/// The fastest motion about a state, taken for a single oscillator: that is exact where damping
/// goes with stiffness.
pub fn fastest_mode<R: Real>(model: &Model<R>, state: &State<R>) -> Mode {
    let mut estimator = Estimator::default();
    let Some((_, vectors)) = estimator.explore((model, state), false) else {
        return Mode::default();
    };
    estimator.mode(&vectors)
}

/// A substep that is stable about every state in which no spring is compressed to nothing, seconds:
/// from sums over springs alone (after Gershgorin, 1931), two to four times shorter than
/// [`limit`]; 0 for explicit Euler, of which sums tell nothing.
///
/// A spring adds at most its k (1/m_a + 1/m_b) to any motion; all springs of a particle at once add
/// at most the sum of their k over its mass.
pub fn guaranteed_limit<R: Real>(model: &Model<R>, integrator: Integrator) -> f64 {
    let bound = bound(model, &mut Vec::new());
    match coefficients(integrator) {
        Step::Any => f64::INFINITY,
        // The half disc of this radius lies in the region of RK4, and that of 1 in that of
        // Dormand-Prince.
        Step::Polynomial(&[_, _]) if 0.0 < bound.stiffness => 0.0,
        Step::Polynomial(&[_, _]) => 2.0 / bound.damping,
        Step::Polynomial(factors) => {
            let radius = if factors.len() == 5 { 2.6 } else { 0.9 };
            radius / Real::sqrt(bound.stiffness).max(bound.damping)
        }
        // With few substeps a damped step of Verlet bears up to 2 % less than a long one.
        Step::VelocityVerlet if 0.0 < bound.damping => 0.95 * bound.scale(),
        Step::SymplecticEuler | Step::VelocityVerlet => bound.scale(),
    }
}

/// A motion at least as stiff and as damped as any; `sums` tells the same of each particle alone.
fn bound<R: Real>(model: &Model<R>, sums: &mut Vec<Mode>) -> Mode {
    let mut bound = Mode::default();
    sums.clear();
    sums.resize(model.particle_count(), Mode::default());
    for (spring, ends) in model.ends.iter().enumerate() {
        for &end in ends {
            let sum = &mut sums[end as usize];
            sum.stiffness += model.stiffnesses.get(spring).to_f64();
            sum.damping += model.dampings.get(spring).to_f64();
        }
    }
    for (sum, w) in sums.iter_mut().zip(&model.inverse_masses) {
        sum.stiffness *= w.to_f64();
        sum.damping *= w.to_f64();
    }
    for &[a, b] in &model.ends {
        let [a, b] = [sums[a as usize], sums[b as usize]];
        bound.stiffness = bound.stiffness.max(a.stiffness + b.stiffness);
        bound.damping = bound.damping.max(a.damping + b.damping);
    }
    let drag = model.drag.to_f64();
    let lightest = model.inverse_masses.iter().map(|w| w.to_f64()).fold(0.0, f64::max);
    bound.damping += drag * lightest;
    for (sum, w) in sums.iter_mut().zip(&model.inverse_masses) {
        sum.damping += drag * w.to_f64();
    }
    let mut held = Mode::default();
    for grab in &model.grabs {
        let w = model.inverse_masses[grab.particle as usize].to_f64();
        let [stiffness, damping] = [grab.stiffness, grab.damping].map(|value| value.to_f64() * w);
        held.stiffness = held.stiffness.max(stiffness);
        held.damping = held.damping.max(damping);
        let sum = &mut sums[grab.particle as usize];
        sum.stiffness += stiffness;
        sum.damping += damping;
    }
    bound.stiffness += held.stiffness;
    bound.damping += held.damping;
    bound
}

/// What is 1 at the limit h of symplectic Euler, and about that of Verlet: h²/4 K + h/2 D.
fn many_substeps(h: f64) -> [f64; 3] {
    [0.25 * h * h, 0.5 * h, 0.0]
}

impl Estimator {
    /// Predicts the largest stable substep about a state, seconds: 0 where none is stable, infinite
    /// where every one is; that of Dormand-Prince is where stability rather than its tolerance
    /// would set its step.
    ///
    /// Within 0.5 % of what is observed, tested. The exception is explicit Euler with damping that
    /// does not go with stiffness: the motion that grows first need not be a fast one, and the true
    /// limit may be shorter.
    pub fn limit<R: Real>(
        &mut self,
        (model, state): (&Model<R>, &State<R>),
        integrator: Integrator,
        substeps: u32,
    ) -> f64 {
        if coefficients(integrator) == Step::Any {
            return f64::INFINITY;
        }
        // A step of few substeps of Verlet is gentle to strongly damped motions: others fail first.
        let both = integrator == Integrator::VelocityVerlet && substeps == 1;
        let Some((guess, motions)) = self.explore((model, state), both) else {
            return f64::INFINITY;
        };
        if guess == 0.0 {
            return 0.0;
        }
        let how = (integrator, substeps);
        let mut few = Few::new(motions, &self.basis, None);
        let mut limit = few.limit(how, START * guess);
        if both {
            for _ in 0..3 {
                few = Few::new(motions, &self.basis, Some(limit));
                limit = few.limit(how, START * limit);
            }
        }
        for _ in 0..ROUNDS {
            let before = limit;
            if few.is_single() || !few.extend(model, &mut self.basis, (how, limit)) {
                break;
            }
            limit = few.limit(how, START * limit);
            if (limit - before).abs() <= 5e-5 * limit {
                break;
            }
        }
        limit
    }

    /// Makes a basis about a state; returns the limit of symplectic Euler and the motions of the
    /// basis, those first that reach it first. `None` where nothing pulls. With `both` the stiffest
    /// motions of all are in the basis too.
    fn explore<R: Real>(
        &mut self,
        (model, state): (&Model<R>, &State<R>),
        both: bool,
    ) -> Option<(f64, Matrix)> {
        let guess = bound(model, &mut self.sums).scale();
        if guess == f64::INFINITY {
            return None;
        }
        if guess.is_nan() || guess == 0.0 {
            return Some((0.0, Matrix::zero(0)));
        }
        let bytes = size_of::<DVec3>() * model.particle_count().max(1);
        let half = (MOST_BYTES / bytes).clamp(FEWEST_VECTORS, VECTORS) / 2;
        self.weigh(guess);
        self.basis.begin(model, state, &self.weights);
        self.basis.grow(model, many_substeps(guess), half);
        // The mixture of stiffness and damping that matters is known better now.
        let (guess, motions) = self.fastest(guess)?;
        if guess == 0.0 {
            return Some((guess, motions));
        }
        if both {
            self.basis.push_rough(model, &self.weights);
            self.basis.grow(model, single_substep(guess), half);
        } else {
            self.basis.grow(model, many_substeps(guess), half);
        }
        self.fastest(guess)
    }

    /// Gives most weight to the particles with the stiffest springs: fast motions live there.
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
        let Basis { stiffness, damping, .. } = &self.basis;
        let first = &vectors.rows[0][..stiffness.size];
        Mode {
            stiffness: stiffness.between(first, first).max(0.0),
            damping: damping.between(first, first),
        }
    }
}
