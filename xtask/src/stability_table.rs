//! The table of marginal stiffness: the experiment of the source report, repeated correctly.
//!
//! All springs are made stiffer until a method is marginally stable, by running (see
//! [`msd_study::limits`]) and from the spectrum. That is done at 4 steps per frame, at the steps of
//! the report (7 of Runge-Kutta, 44 of Euler), and at the steps of Euler that take as long as 7 of
//! Runge-Kutta here. Theory for undamped springs: symplectic Euler bears h w = 2 and RK4 2 √2,
//! hence twice the stiffness at an equal step. The report's "Runge-Kutta" weighs its stages by 1,
//! 3, 3, 1; with the stages of RK4 that is a method of second order which bears h w = √7, 1.75
//! times the stiffness.

use msd_core::methods::{Method, Parts, StepContext};
use msd_core::stability::{Region, is_stable};
use msd_core::{Error, Integrator, Real, Scene, Settings, Simulation};
use msd_study::audit::median;
use msd_study::choice::FRAME;
use msd_study::clock::CpuClock;
use msd_study::limits::{Held, edge};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// The marginal stiffnesses of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StabilityTable {
    /// Median stiffness of the unchanged scene, newtons per metre.
    pub stiffness: f64,
    /// Steps of symplectic Euler that take as long as 7 of RK4, measured.
    pub equal_cost: u32,
    /// The rows: without damping, then with that of the scene if it has any.
    pub rows: Vec<StabilityRow>,
}

/// The marginal stiffness of a method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StabilityRow {
    /// Median damping of the springs, newton seconds per metre.
    pub damping: f64,
    /// The method.
    pub method: Scheme,
    /// Steps per frame of 1/60 s.
    pub steps: u32,
    /// Largest median stiffness that is stable, predicted from the spectrum, newtons per metre.
    pub predicted: f64,
    /// The same found by running; none where the prediction is 0.
    pub observed: Option<f64>,
    /// The value that the source report found, in a scene of its own, newtons per metre.
    pub report: Option<f64>,
}

/// A method of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// One of ours.
    Ours(Integrator),
    /// The stages of RK4, weighed by 1, 3, 3, 1.
    Rk1331,
}

impl std::fmt::Display for Scheme {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Scheme::Ours(integrator) => f.pad(integrator.name()),
            Scheme::Rk1331 => f.pad("rk 1-3-3-1"),
        }
    }
}

/// Steps of the report: at an equal step, and of Runge-Kutta and Euler at an equal time.
const EQUAL_STEP: u32 = 4;
const EQUAL_TIME: [u32; 2] = [7, 44];
const EULER: Scheme = Scheme::Ours(Integrator::SymplecticEuler);
const RK4: Scheme = Scheme::Ours(Integrator::Rk4);

/// Makes the table of a scene, of which so many steps of symplectic Euler take as long as 7 of RK4,
/// see [`euler_steps`]. Takes some seconds for a cloth of 31 x 31.
///
/// # Errors
/// A scene that a simulation refuses.
pub fn stability_table(scene: &Scene, equal_cost: u32) -> Result<StabilityTable, Error> {
    let stiffness = median(scene.springs.iter().map(|spring| spring.stiffness)).unwrap_or(0.0);
    let mut plan: Vec<(Scheme, u32, Option<f64>)> = Vec::new();
    plan.extend(Integrator::EXPLICIT.map(|integrator| {
        let scheme = Scheme::Ours(integrator);
        let report = if scheme == EULER { Some(5550.0) } else { None };
        (scheme, EQUAL_STEP, report)
    }));
    plan.push((Scheme::Rk1331, EQUAL_STEP, Some(10_600.0)));
    plan.extend([(RK4, EQUAL_TIME[0], None), (Scheme::Rk1331, EQUAL_TIME[0], Some(40_000.0))]);
    plan.push((EULER, EQUAL_TIME[1], Some(2_150_000.0)));
    if equal_cost != EQUAL_TIME[1] {
        plan.push((EULER, equal_cost, None));
    }
    let mut free = scene.clone();
    free.world.drag = 0.0;
    free.springs.iter_mut().for_each(|spring| spring.damping = 0.0);
    let damping = median(scene.springs.iter().map(|spring| spring.damping)).unwrap_or(0.0);
    let both = [(&free, 0.0), (scene, damping)];
    let mut rows = Vec::new();
    for &(scene, damping) in &both[..if free == *scene { 1 } else { 2 }] {
        for &(method, steps, report) in &plan {
            let [predicted, observed] = marginal(scene, method, steps)?;
            let observed = Some(stiffness * observed).filter(|_| 0.0 < predicted);
            let predicted = stiffness * predicted;
            rows.push(StabilityRow { damping, method, steps, predicted, observed, report });
        }
    }
    Ok(StabilityTable { stiffness, equal_cost, rows })
}

impl StabilityTable {
    /// The row of a method without damping at so many steps per frame.
    pub fn undamped(&self, method: Scheme, steps: u32) -> Option<&StabilityRow> {
        let wanted =
            |row: &&StabilityRow| row.damping == 0.0 && row.method == method && row.steps == steps;
        self.rows.iter().find(wanted)
    }

    /// Stiffness that a method bears over that which symplectic Euler does, both found by running
    /// without damping at 4 steps per frame; none where one bears none.
    pub fn ratio(&self, method: Scheme) -> Option<f64> {
        let observed = |method| self.undamped(method, EQUAL_STEP)?.observed;
        Some(observed(method)? / observed(EULER)?)
    }

    /// The table for a terminal, aligned, stiffnesses in newtons per metre.
    pub fn text(&self) -> String {
        let mut text = String::from("  damping  method            steps   predicted    observed");
        text.push_str("  the report\n");
        let number = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.0}"));
        for StabilityRow { damping, method, steps, predicted, observed, report } in &self.rows {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{damping:>9}  {method:16} {steps:>6} {predicted:>11.0} {:>11} {:>11}",
                number(*observed),
                number(*report)
            );
        }
        for (method, theory) in [(RK4, 2.0), (Scheme::Rk1331, 1.75)] {
            if let Some(ratio) = self.ratio(method) {
                let _ = writeln!(
                    text,
                    "At an equal step and without damping {method} bears {ratio:.3} times the \
                     stiffness of {EULER}; theory {theory}, the report 1.91."
                );
            }
        }
        let _ = writeln!(
            text,
            "7 steps of {RK4} take as long as {} of {EULER}, which bear {:.1} times the stiffness; \
             the report used 44 instead.",
            self.equal_cost,
            0.5 * (f64::from(self.equal_cost) / 7.0).powi(2)
        );
        text
    }
}

/// Factors on all stiffnesses at which a method becomes unstable: predicted and observed.
fn marginal(scene: &Scene, method: Scheme, steps: u32) -> Result<[f64; 2], Error> {
    let predicted = predict(scene, method, steps)?;
    if predicted == 0.0 {
        return Ok([0.0, 0.0]);
    }
    let h = FRAME / f64::from(steps);
    let observed = edge(predicted, &mut |factor| {
        let mut stiffer = scene.clone();
        stiffer.springs.iter_mut().for_each(|spring| spring.stiffness *= factor);
        let held = Held::new(&stiffer)?;
        match method {
            Scheme::Ours(integrator) => {
                held.stays(Settings { integrator, substeps: steps, ..Settings::default() })
            }
            Scheme::Rk1331 => {
                let settings = Settings { step: h, substeps: 1, ..Settings::default() };
                held.stays_under(settings, Rk1331)
            }
        }
    })?;
    Ok([predicted, observed])
}

/// The factor on all stiffnesses at which the spectrum makes a method unstable; 0 where every one
/// does.
fn predict(scene: &Scene, method: Scheme, steps: u32) -> Result<f64, Error> {
    let (held, h) = (Held::new(scene)?, FRAME / f64::from(steps));
    let mode = held.simulation.fastest_mode();
    let (w, z) = (h * h * mode.stiffness, h * mode.damping);
    let region = match method {
        Scheme::Ours(integrator) => Region::from(integrator),
        Scheme::Rk1331 => Method::<f64>::region(&Rk1331),
    };
    let stable = |factor: f64| is_stable(region, steps, factor * w, z);
    // No method here is stable beyond h w = 4.
    let (reach, samples) = (16.0 / w, 1000);
    let at = |sample: u32| reach * f64::from(sample) / f64::from(samples);
    let first = (1..=samples).find(|&sample| !stable(at(sample))).unwrap_or(samples);
    let (mut low, mut high) = (at(first - 1), at(first));
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if stable(middle) { low = middle } else { high = middle }
    }
    // The result of bisection about an unstable zero is not a stiffness.
    Ok(if low < 1e-9 * reach || !reach.is_finite() { 0.0 } else { low })
}

/// The stages of RK4, weighed by 1, 3, 3, 1.
#[derive(Debug)]
struct Rk1331;

impl<R: Real> Method<R> for Rk1331 {
    fn region(&self) -> Region {
        Region::Polynomial(&[1.0, 1.0, 1.0 / 2.0, 5.0 / 32.0, 1.0 / 32.0])
    }

    fn columns(&self) -> usize {
        4
    }

    fn advance(&self, step: &mut StepContext<'_, R>) {
        let h = step.substep();
        let half = h * R::HALF;
        for _ in 0..step.substeps() {
            let mut taken = 0.0;
            let stages = [(1.0, half), (3.0, half), (3.0, h), (1.0, R::ZERO)];
            for (stage, (weight, reach)) in stages.into_iter().enumerate() {
                taken += step.set_forces(step.time()) * weight * h.to_f64() / 8.0;
                let Parts { positions: x, velocities: v, forces, inverse_masses, work } =
                    step.parts();
                let [x0, v0, sx, sv] = work else { return };
                if stage == 0 {
                    x0.copy_from_slice(x);
                    v0.copy_from_slice(v);
                    sx.fill(R::ZERO);
                    sv.fill(R::ZERO);
                }
                let weight = R::of(weight);
                for i in 0..x.len() {
                    let (velocity, acceleration) = (v[i], forces[i] * inverse_masses[i]);
                    sx[i] += velocity * weight;
                    sv[i] += acceleration * weight;
                    x[i] = x0[i] + velocity * reach;
                    v[i] = v0[i] + acceleration * reach;
                }
            }
            let Parts { positions: x, velocities: v, work, .. } = step.parts();
            let [x0, v0, sx, sv] = work else { return };
            for i in 0..x.len() {
                x[i] = x0[i] + sx[i] * (h / R::of(8.0));
                v[i] = v0[i] + sv[i] * (h / R::of(8.0));
            }
            step.finish_substep(taken);
        }
    }
}

/// Measures how many steps of symplectic Euler take as long as 7 of RK4: the best of several runs
/// of each that take turns, by the time of the processor.
///
/// # Errors
/// A scene that a simulation refuses.
pub fn euler_steps(scene: &Scene) -> Result<u32, Error> {
    const SUBSTEPS: u32 = 20;
    let methods = [Integrator::Rk4, Integrator::SymplecticEuler];
    let mut runs = Vec::new();
    for integrator in methods {
        // So short a step that nothing moves: only the arithmetic is timed.
        let step = 1e-6;
        let settings = Settings { integrator, step, substeps: SUBSTEPS, ..Settings::default() };
        runs.push(Simulation::<f64>::new(scene, settings)?);
    }
    let mut best = [f64::INFINITY; 2];
    for _ in 0..15 {
        for (run, best) in runs.iter_mut().zip(&mut best) {
            let clock = CpuClock::start();
            run.step()?;
            *best = best.min(clock.seconds());
        }
    }
    // A clock too coarse for a tiny scene says nothing: then evaluations count, four to one.
    let ratio = if 0.0 < best[0] && 0.0 < best[1] { best[0] / best[1] } else { 4.0 };
    Ok((f64::from(EQUAL_TIME[0]) * ratio).round().max(1.0) as u32)
}
