//! How long may a substep be before the run blows up? Predicted from the spectrum.
//!
//! Near a state a system is M x'' + D x' + K x = 0. A mode of it is a damped oscillator
//! x'' + c x' + w² x = 0, and one step of a method maps (x, h v) by a 2x2 matrix that depends on
//! W = h² w² and Z = h c alone. The step is stable while no eigenvalue of that matrix is larger
//! than one. For symplectic Euler that is W/4 + Z/2 ≤ 1. Velocity Verlet has the same limit: an
//! eigenvalue reaches −1 for a motion whose accelerations alternate, where the mean of two
//! accelerations in its predictor vanishes.

use crate::integrator::{Explicit, Family, Integrator};
use crate::real::{Real, Vector};
use crate::system::{Model, State};
use alloc::vec;
use alloc::vec::Vec;
use glam::DVec3;

/// The fastest motions of a system about a state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spectrum {
    /// Largest eigenvalue w² of M⁻¹ K, per second squared.
    pub stiffness: f64,
    /// Largest eigenvalue c of M⁻¹ D, per second.
    pub damping: f64,
}

/// Lanczos steps: the largest eigenvalue of a lattice is then within 0.2 %, from below.
const ITERATIONS: usize = 24;

/// Estimates the spectrum about a state by the Lanczos method (Lanczos, 1950), without a matrix.
pub fn spectrum<R: Real>(model: &Model<R>, state: &State<R>) -> Spectrum {
    let operator = Operator::new(model, state);
    let stiffness = operator.largest(|op, x, y| op.add_springs(Term::Stiffness, x, y));
    let damped = !model.dampings.is_zero() || model.drag != R::ZERO || !model.grabs.is_empty();
    let damping =
        if damped { operator.largest(|op, x, y| op.add_springs(Term::Damping, x, y)) } else { 0.0 };
    Spectrum { stiffness, damping }
}

#[derive(Clone, Copy, PartialEq)]
enum Term {
    Stiffness,
    Damping,
}

/// M^(−1/2) A M^(−1/2) for A the stiffness or the damping matrix.
struct Operator<'a, R: Real> {
    model: &'a Model<R>,
    /// Unit vector and length of each spring; the vector is zero where there is no direction.
    directions: Vec<(DVec3, f64)>,
    /// Square roots of the reciprocal masses.
    roots: Vec<f64>,
}

impl<'a, R: Real> Operator<'a, R> {
    fn new(model: &'a Model<R>, state: &State<R>) -> Self {
        let direction = |&[a, b]: &[u32; 2]| {
            let [a, b] = [a, b].map(|end| state.positions[end as usize].to_f64());
            let length = Real::sqrt((b - a).dot(b - a));
            if length == 0.0 { (DVec3::ZERO, 0.0) } else { ((b - a) / length, length) }
        };
        let roots = model.inverse_masses.iter().map(|w| Real::sqrt(w.to_f64()));
        Operator {
            model,
            directions: model.ends.iter().map(direction).collect(),
            roots: roots.collect(),
        }
    }

    /// y += A x of the springs, the grabs and the drag, before the masses.
    fn add_springs(&self, term: Term, x: &[DVec3], y: &mut [DVec3]) {
        for (spring, &[a, b]) in self.model.ends.iter().enumerate() {
            let (direction, length) = self.directions[spring];
            let across = x[b as usize] - x[a as usize];
            let along = direction * direction.dot(across);
            let pull = match term {
                Term::Damping => along * self.model.dampings.get(spring).to_f64(),
                Term::Stiffness => {
                    let stiffness = self.model.stiffnesses.get(spring).to_f64();
                    let rest = self.model.rest_lengths[spring].to_f64();
                    // A stretched spring also resists a sideways motion, as a string does.
                    let sideways = if length == 0.0 { 0.0 } else { 1.0 - rest / length };
                    (along + (across - along) * sideways) * stiffness
                }
            };
            y[a as usize] -= pull;
            y[b as usize] += pull;
        }
        for grab in &self.model.grabs {
            let held = grab.particle as usize;
            let strength = if term == Term::Damping { grab.damping } else { grab.stiffness };
            y[held] += x[held] * strength.to_f64();
        }
        let drag = if term == Term::Damping { self.model.drag.to_f64() } else { 0.0 };
        for (y, &x) in y.iter_mut().zip(x) {
            *y += x * drag;
        }
    }

    fn largest(&self, add: impl Fn(&Self, &[DVec3], &mut [DVec3])) -> f64 {
        let count = self.roots.len();
        let scaled = |x: &[DVec3]| -> Vec<DVec3> {
            x.iter().zip(&self.roots).map(|(&x, &root)| x * root).collect()
        };
        let mut vector = start(count);
        let mut before = vec![DVec3::ZERO; count];
        let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
        let mut length = norm(&vector);
        for _ in 0..ITERATIONS.min(3 * count) {
            vector.iter_mut().for_each(|x| *x /= length);
            let mut next = vec![DVec3::ZERO; count];
            add(self, &scaled(&vector), &mut next);
            next = scaled(&next);
            let here = dot(&next, &vector);
            for (next, (&now, &before)) in next.iter_mut().zip(vector.iter().zip(&before)) {
                *next -= now * here + before * if diagonal.is_empty() { 0.0 } else { length };
            }
            diagonal.push(here);
            before = core::mem::replace(&mut vector, next);
            length = norm(&vector);
            beside.push(length);
            if length <= 1e-12 * here.abs() || !length.is_finite() {
                break;
            }
        }
        largest_eigenvalue(&diagonal, &beside)
    }
}

/// A rough vector without symmetry: bits of a linear congruential generator (Knuth, 1981).
fn start(count: usize) -> Vec<DVec3> {
    let mut bits = 1u64;
    let mut next = || {
        bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (bits >> 40) as f64 / (1u64 << 24) as f64 - 0.5
    };
    (0..count).map(|_| DVec3::new(next(), next(), next())).collect()
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

fn norm(a: &[DVec3]) -> f64 {
    Real::sqrt(dot(a, a))
}

/// The largest eigenvalue of a symmetric tridiagonal matrix, by bisection on the sign count.
fn largest_eigenvalue(diagonal: &[f64], beside: &[f64]) -> f64 {
    let off = |row: usize| if row == 0 { 0.0 } else { beside[row - 1] };
    let last = diagonal.len() - 1;
    let reach = |row: usize| off(row).abs() + if row < last { beside[row].abs() } else { 0.0 };
    let bound = (0..=last).map(|row| diagonal[row] + reach(row)).fold(0.0, f64::max);
    let all_below = |value: f64| {
        let mut pivot = 1.0;
        (0..=last).all(|row| {
            pivot = diagonal[row] - value - off(row) * off(row) / pivot;
            pivot < 0.0
        })
    };
    let (mut low, mut high) = (0.0, bound * (1.0 + 1e-12));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if all_below(middle) { high = middle } else { low = middle }
    }
    high
}

/// The largest stable substep, seconds: 0 where no step is stable, infinite where every step is.
///
/// Implicit methods and XPBD are stable at any step, and Dormand-Prince finds its own. Takes the
/// stiffest and the most damped motion for one mode. That is exact where damping is
/// proportional to stiffness, and on the safe side elsewhere for all methods but explicit Euler.
pub fn largest_substep(spectrum: Spectrum, integrator: Integrator, substeps: u32) -> f64 {
    let Family::Explicit(method) = integrator.family() else {
        return f64::INFINITY;
    };
    let Spectrum { stiffness, damping } = spectrum;
    let fastest = Real::sqrt(stiffness).max(damping);
    if fastest == 0.0 {
        return f64::INFINITY;
    }
    // Every method here is unstable beyond h w = 6 and beyond h c = 6: RK4 near critical damping
    // bears 5.6.
    let (reach, samples) = (6.0 / fastest, 768);
    let at = |sample: i32| reach * f64::from(sample) / f64::from(samples);
    let stable = |h: f64| is_stable(method, substeps, h * h * stiffness, h * damping);
    let Some(first) = (1..=samples).find(|&sample| !stable(at(sample))) else {
        return reach;
    };
    let (mut low, mut high) = (at(first - 1), at(first));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if stable(middle) { low = middle } else { high = middle }
    }
    low
}

/// Whether one step of `substeps` substeps keeps the oscillator with W = h² w², Z = h c bounded.
pub fn is_stable(method: Explicit, substeps: u32, w: f64, z: f64) -> bool {
    if method == Explicit::Euler {
        // In closed form (Jury's conditions), for no rounding may pass for damping.
        return w <= z && 2.0 * z <= 4.0 + w;
    }
    // Longer steps of Verlet differ from the limit of many substeps by less than 1e-3.
    let substeps = substeps.clamp(1, 64);
    let columns = [[1.0, 0.0], [0.0, 1.0]].map(|x| oscillate(method, substeps, (w, z), x));
    let [[a, c], [b, d]] = columns;
    let (half_trace, determinant) = (0.5 * (a + d), a * d - b * c);
    let discriminant = half_trace * half_trace - determinant;
    let squared = if discriminant < 0.0 {
        determinant
    } else {
        let radius = half_trace.abs() + Real::sqrt(discriminant);
        radius * radius
    };
    // An undamped mode sits on the boundary: room for rounding over the substeps of a step.
    squared <= 1.0 + 1e-9 * f64::from(substeps)
}

/// Runs the oscillator for a step from (x, h v).
fn oscillate(
    method: Explicit,
    substeps: u32,
    (w, z): (f64, f64),
    [mut x, mut v]: [f64; 2],
) -> [f64; 2] {
    let pull = |x: f64, v: f64| -w * x - z * v;
    let mut now = pull(x, v);
    let mut before = now;
    for _ in 0..substeps {
        match method {
            Explicit::Euler => (x, v) = (x + v, v + pull(x, v)),
            Explicit::SymplecticEuler => {
                v += pull(x, v);
                x += v;
            }
            Explicit::VelocityVerlet => {
                v += 0.5 * now;
                x += v;
                (before, now) = (now, pull(x, v + 0.25 * (now + before)));
                v += 0.5 * now;
            }
            Explicit::Rk4 => {
                let (x1, v1) = (v, pull(x, v));
                let (x2, v2) = (v + 0.5 * v1, pull(x + 0.5 * x1, v + 0.5 * v1));
                let (x3, v3) = (v + 0.5 * v2, pull(x + 0.5 * x2, v + 0.5 * v2));
                let (x4, v4) = (v + v3, pull(x + x3, v + v3));
                x += (x1 + 2.0 * (x2 + x3) + x4) / 6.0;
                v += (v1 + 2.0 * (v2 + v3) + v4) / 6.0;
            }
        }
    }
    [x, v]
}
