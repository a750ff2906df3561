//! The judge of a run, step by step: errors, NaN, energy, beside the findings of the watch.

use crate::extremes::outcome::{Outcome, Verdict};
use msd_core::glam::DVec3;
use msd_core::{Error, Real, Scene, Settings, Vector};
use msd_run::{Finding, Kind, Runner, Watch, on};
use msd_scene::Precision;

/// A run to judge.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The scene to run.
    pub scene: &'a Scene,
    /// How.
    pub settings: Settings,
    /// In which precision.
    pub precision: Precision,
    /// Number of steps.
    pub steps: u64,
    /// Evaluations of the forces after which an adaptive method has been seen enough.
    pub evaluations: u64,
}

/// Up to this error, as a fraction, a run counts as accurate.
pub const ACCURATE: f64 = 0.1;

/// Tells an error from a time, seconds, and the positions of the particles, metres.
type Ruler<'a> = dyn Fn(f64, &dyn Fn(usize) -> DVec3) -> f64 + 'a;

/// The measure of a run.
pub enum Measure<'a> {
    /// The largest error over the run counts.
    Largest(&'a Ruler<'a>),
    /// The error at the end counts.
    Last(&'a Ruler<'a>),
}

/// Runs and judges.
pub fn judge(task: &Task<'_>, measure: &Measure<'_>) -> Verdict {
    let mut runner = match Runner::new(task.scene, task.settings, task.precision) {
        Ok(runner) => runner,
        Err(error) => return Verdict::ended(Outcome::Refused, error.to_string()),
    };
    let mut course = Course::new(&runner, task.scene);
    let mut largest = 0.0;
    for step in 0..task.steps {
        if let Err(error) = runner.step() {
            return ended(&error);
        }
        if !is_sound(&runner) {
            let said = format!("in step {}", runner.steps());
            return Verdict::ended(Outcome::NotANumber, said);
        }
        course.follow(&runner, 4 * step >= 3 * task.steps);
        if let Measure::Largest(error) = measure {
            largest = f64::max(largest, error_of(&runner, error));
        }
        let work = on!(&runner, simulation => simulation.work());
        if work.is_some_and(|work| task.evaluations < work.evaluations) {
            break;
        }
    }
    let error = match measure {
        Measure::Largest(_) => largest,
        Measure::Last(error) => error_of(&runner, error),
    };
    Verdict { outcome: course.outcome(&runner, error), error: Some(error), said: None }
}

fn ended(error: &Error) -> Verdict {
    let outcome = match error {
        Error::Diverged(_) => Outcome::Diverged,
        Error::Unreachable { .. } | Error::Unsolved { .. } => Outcome::Unreachable,
        _ => Outcome::Refused,
    };
    Verdict::ended(outcome, error.to_string())
}

fn error_of(runner: &Runner, error: &Ruler<'_>) -> f64 {
    on!(runner, simulation => {
        error(simulation.time(), &|particle| simulation.position(particle).to_f64())
    })
}

/// Returns whether positions and velocities are finite and the energy is not NaN.
fn is_sound(runner: &Runner) -> bool {
    let finite = on!(runner, simulation => {
        let mut rows = simulation.positions().chain(simulation.velocities());
        rows.all(|vector| vector.extent().to_f64().is_finite())
    });
    finite && !runner.energy().total().is_nan()
}

/// The energy of a run, seen by the watch and, another way, by the judge of the watch.
struct Course {
    watch: Watch,
    /// Kinetic, elastic and gravitational energy at the start, joules.
    start: f64,
    /// Sum and number of the same, without supplied energy, over the last quarter, and the largest
    /// kinetic and elastic part.
    late: (f64, u64),
    moving: f64,
    /// Energy that rounding may have added, joules.
    rounding: f64,
}

impl Course {
    fn new(runner: &Runner, scene: &Scene) -> Self {
        Course {
            watch: Watch::new(runner, scene),
            start: runner.energy().mechanical(),
            late: (0.0, 0),
            moving: 0.0,
            rounding: 0.0,
        }
    }

    fn follow(&mut self, runner: &Runner, late: bool) {
        self.watch.read_energy(runner);
        self.watch.step(runner);
        let (energy, rounding) = on!(runner, simulation => simulation.energy_and_rounding());
        self.rounding += rounding;
        if late {
            self.late.0 += energy.mechanical() - energy.supplied;
            self.late.1 += 1;
            self.moving = f64::max(self.moving, energy.kinetic + energy.elastic);
        }
    }

    /// By another measure than that of the watch: a gain is a mean energy over the last quarter
    /// that exceeds the initial energy by half of the kinetic and elastic part.
    fn outcome(&self, runner: &Runner, error: f64) -> Outcome {
        use Kind::{EnergyAdded, EnergyRisen, Squeezed, TooSoft};
        let mean = self.late.0 / self.late.1.max(1) as f64;
        let gained = !self.watch.is_handled()
            && 0 < self.late.1
            && 0.5 * self.moving + self.rounding < mean - self.start;
        let says = |found: &Finding| {
            matches!(found.kind, EnergyAdded | TooSoft { .. } | EnergyRisen | Squeezed)
        };
        match () {
            () if gained && !self.watch.findings(runner).iter().any(says) => Outcome::HiddenGain,
            () if gained || 0.0 < self.watch.read().witness.gain() => Outcome::Growing,
            () if error <= ACCURATE => Outcome::Accurate,
            () => Outcome::Bounded,
        }
    }
}
