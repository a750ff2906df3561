//! The report of tuning, the keys of `msd tune --json`.

use crate::candidates::choice::{Choice, FRAME, Fineness};
use crate::tune::{Found, Goal, Tuned};
use msd_scene::SetKeys;
use serde::Serialize;

/// Result of tuning; the keys of `msd tune --json`.
#[derive(Clone, Debug, Serialize)]
pub struct TuneReport {
    /// Name of the scene.
    pub scene: String,
    /// Keys of the scene that were set.
    pub set: SetKeys,
    /// Time simulated, seconds.
    pub duration: f64,
    /// Time up to which runs were compared, seconds.
    pub compared_until: f64,
    /// Time after which the scene is chaotic, seconds; `None` if it is not.
    pub chaotic_after: Option<f64>,
    /// `processor`, or the graphics adapter whose time costs are.
    pub device: String,
    /// The goal that was asked for.
    pub goal: Goal,
    /// Whether `best` meets it.
    pub met: bool,
    /// The choice, or the nearest where nothing meets the goal.
    #[serde(flatten)]
    pub best: ChoiceReport,
    /// The best of another method or precision that meets the goal too.
    pub runner_up: Option<ChoiceReport>,
    /// Uncertainty of the reference, metres.
    pub reference_uncertainty: f64,
    /// Settings that were tried.
    pub tried: usize,
    /// Whether the search was cancelled before it ended.
    pub interrupted: bool,
    /// The file that the choice was written to.
    pub written: Option<String>,
}

impl TuneReport {
    /// The report of a scene of which some keys were set, tuned for the processor; nothing is
    /// written yet.
    pub fn new(scene: &str, set: SetKeys, tuned: &Tuned) -> Self {
        let row = |found| ChoiceReport::new(found, tuned.uncertainty);
        TuneReport {
            scene: scene.into(),
            set,
            duration: tuned.duration,
            compared_until: tuned.compared,
            chaotic_after: tuned.horizon,
            device: "processor".into(),
            goal: tuned.goal,
            met: tuned.met,
            best: row(&tuned.best),
            runner_up: tuned.others.first().map(row),
            reference_uncertainty: tuned.uncertainty,
            tried: tuned.tried,
            interrupted: tuned.is_cut_short,
            written: None,
        }
    }
}

/// A choice with its cost and its errors.
#[derive(Clone, Debug, Serialize)]
pub struct ChoiceReport {
    /// Name of the method.
    pub integrator: &'static str,
    /// Name of the precision.
    pub precision: &'static str,
    /// Length of an integration step, seconds; `None` for adaptive methods.
    pub step: Option<f64>,
    /// Integration steps per frame; `None` for adaptive methods.
    pub substeps: Option<u32>,
    /// Local error of adaptive methods, as a fraction of the size of the scene.
    pub tolerance: Option<f64>,
    /// Error that was predicted, metres.
    pub predicted_error: Option<f64>,
    /// Error that was measured, metres.
    pub verified_error: f64,
    /// Processor time, or wall-clock time of a device, per frame of 1/60 s, milliseconds.
    pub ms_per_frame: f64,
}

impl ChoiceReport {
    /// A choice that was found; its errors are at least the uncertainty of the reference, metres.
    pub fn new(found: &Found, uncertainty: f64) -> Self {
        let Found { trial, predicted_error } = found;
        let Choice { integrator, fineness, precision } = trial.choice;
        let (substeps, tolerance) = match fineness {
            Fineness::Substeps(substeps) => (Some(substeps), None),
            Fineness::Tolerance(tolerance) => (None, Some(tolerance)),
        };
        ChoiceReport {
            integrator: integrator.name(),
            precision: precision.name(),
            step: substeps.map(|substeps| FRAME / f64::from(substeps)),
            substeps,
            tolerance,
            predicted_error: predicted_error.map(|error| error.max(uncertainty)),
            verified_error: trial.error().max(uncertainty),
            ms_per_frame: 1e3 * trial.cost * FRAME,
        }
    }
}
