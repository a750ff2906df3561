//! The watch over a run, step by step: errors, NaN, energy.

use crate::extremes::outcome::{Outcome, Verdict};
use msd_core::glam::DVec3;
use msd_core::{Error, Real, Scene, Settings, Simulation, Vector, Witness};
use msd_scene::Precision;

/// A run to judge.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// What is run.
    pub scene: &'a Scene,
    /// How.
    pub settings: Settings,
    /// In which precision.
    pub precision: Precision,
    /// How many steps.
    pub steps: u64,
    /// Evaluations of the forces after which an adaptive method has been seen enough.
    pub evaluations: u64,
}

/// Up to this error, as a fraction, a run counts as accurate.
pub const ACCURATE: f64 = 0.1;

/// Tells an error from a time, seconds, and the positions of the particles, metres.
type Ruler<'a> = dyn Fn(f64, &dyn Fn(usize) -> DVec3) -> f64 + 'a;

/// What is measured of a run.
pub enum Measure<'a> {
    /// The largest error over the run counts.
    Largest(&'a Ruler<'a>),
    /// The error at the end counts.
    Last(&'a Ruler<'a>),
}

/// Runs and judges.
pub fn judge(task: &Task<'_>, measure: &Measure<'_>) -> Verdict {
    match task.precision {
        Precision::F32 => judge_in::<f32>(task, measure),
        Precision::F64 => judge_in::<f64>(task, measure),
    }
}

fn judge_in<R: Real>(task: &Task<'_>, measure: &Measure<'_>) -> Verdict {
    let mut simulation = match Simulation::<R>::new(task.scene, task.settings) {
        Ok(simulation) => simulation,
        Err(error) => return Verdict::ended(Outcome::Refused, error.to_string()),
    };
    let mut course = Course::new(&simulation);
    let mut largest = 0.0;
    for step in 0..task.steps {
        if let Err(error) = simulation.step() {
            return ended(&error);
        }
        if !is_sound(&simulation) {
            let said = format!("in step {}", simulation.steps());
            return Verdict::ended(Outcome::NotANumber, said);
        }
        course.follow(&simulation, 4 * step >= 3 * task.steps);
        if let Measure::Largest(error) = measure {
            largest = f64::max(largest, error_of(&simulation, error));
        }
        if simulation.work().is_some_and(|work| task.evaluations < work.evaluations) {
            break;
        }
    }
    let error = match measure {
        Measure::Largest(_) => largest,
        Measure::Last(error) => error_of(&simulation, error),
    };
    Verdict { outcome: course.outcome(error), error: Some(error), said: None }
}

fn ended(error: &Error) -> Verdict {
    let outcome = match error {
        Error::Diverged(_) => Outcome::Diverged,
        Error::Unreachable { .. } | Error::Unsolved { .. } => Outcome::Unreachable,
        _ => Outcome::Refused,
    };
    Verdict::ended(outcome, error.to_string())
}

fn error_of<R: Real>(simulation: &Simulation<R>, error: &Ruler<'_>) -> f64 {
    error(simulation.time(), &|particle| simulation.position(particle).to_f64())
}

/// Whether everything that a step left is a number.
fn is_sound<R: Real>(simulation: &Simulation<R>) -> bool {
    let finite = |vector: R::Vec3| vector.extent().to_f64().is_finite();
    let mut rows = simulation.positions().chain(simulation.velocities());
    rows.all(finite) && !simulation.energy().total().is_nan()
}

/// The energy of a run, seen by a witness and, another way, by the judge of the witness.
struct Course {
    witness: Witness,
    told: bool,
    /// Kinetic, elastic and gravitational energy at the start, joules.
    start: f64,
    /// Sum and number of the same over the last quarter, and the largest kinetic and elastic part.
    late: (f64, u64),
    moving: f64,
    /// What rounding may have added, joules.
    rounding: f64,
    handled: bool,
}

impl Course {
    fn new<R: Real>(simulation: &Simulation<R>) -> Self {
        let mut witness = Witness::default();
        let energy = witness.watch(simulation);
        Course {
            witness,
            told: false,
            start: energy.mechanical(),
            late: (0.0, 0),
            moving: 0.0,
            rounding: 0.0,
            handled: false,
        }
    }

    fn follow<R: Real>(&mut self, simulation: &Simulation<R>, late: bool) {
        self.witness.watch(simulation);
        self.told |= 0.0 < self.witness.gain();
        self.handled |= simulation.is_handled();
        let (energy, rounding) = simulation.energy_and_rounding();
        self.rounding += rounding;
        if late {
            self.late.0 += energy.mechanical();
            self.late.1 += 1;
            self.moving = f64::max(self.moving, energy.kinetic + energy.elastic);
        }
    }

    /// An energy that is on average over the last quarter above that of the start by half of what
    /// moves is a gain, by another measure than that of the witness.
    fn outcome(&self, error: f64) -> Outcome {
        let mean = self.late.0 / self.late.1.max(1) as f64;
        let gained = !self.handled
            && 0 < self.late.1
            && 0.5 * self.moving + self.rounding < mean - self.start;
        match () {
            () if gained && !self.told => Outcome::HiddenGain,
            () if gained || 0.0 < self.witness.gain() => Outcome::Growing,
            () if error <= ACCURATE => Outcome::Accurate,
            () => Outcome::Bounded,
        }
    }
}
