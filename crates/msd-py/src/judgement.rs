//! Tuning, studies and inspection of a scene.
//!
//! The reports of `msd tune` and `msd inspect` stand in the application, which no library names;
//! here are structs of the same keys.

use crate::errors::{core_error, error, refused};
use crate::scene::Scene;
use crate::values::from_serde;
use msd_core::{Error, Simulation};
use msd_scene::Assignment;
use msd_study::choice::{Choice, FRAME, Fineness};
use msd_study::conduct::Plan;
use msd_study::inspection::Inspection;
use msd_study::monitor::{Halt, Monitor, Progress};
use msd_study::tune::{Found, Goal};
use pyo3::prelude::*;
use serde::Serialize;
use serde_json::{Map, Value};
use std::time::{Duration, Instant};

/// How often Python may interrupt what takes long.
const TURN: Duration = Duration::from_millis(40);

/// A monitor that passes progress on to a callable, and cancels at Ctrl-C or where that raises.
pub struct Caller<'a> {
    callable: Option<&'a Py<PyAny>>,
    raised: Option<PyErr>,
    looked: Instant,
}

impl<'a> Caller<'a> {
    pub fn new(callable: Option<&'a Py<PyAny>>) -> Self {
        Caller { callable, raised: None, looked: Instant::now() }
    }

    /// Whether to go on: no signal came, and nothing was raised.
    pub fn may_go_on(&mut self) -> bool {
        if self.raised.is_none() && TURN < self.looked.elapsed() {
            self.looked = Instant::now();
            self.raised = Python::attach(|py| py.check_signals()).err();
        }
        self.raised.is_none()
    }

    /// What was raised.
    pub fn raised(self) -> Option<PyErr> {
        self.raised
    }

    /// What came of the work.
    pub fn outcome<T>(&mut self, py: Python<'_>, done: Result<T, Halt>) -> PyResult<T> {
        match (self.raised.take(), done) {
            (Some(raised), _) => Err(raised),
            (None, Ok(done)) => Ok(done),
            (None, Err(Halt::Refused(error))) => Err(core_error(py, error)),
            (None, Err(Halt::Cancelled | Halt::Deadline)) => {
                Err(error(py, "it ended before anything was tried; give it more time"))
            }
        }
    }
}

impl Monitor for Caller<'_> {
    fn report(&mut self, progress: Progress) {
        if let (Some(callable), None) = (self.callable, &self.raised) {
            let heard = Python::attach(|py| callable.call1(py, (progress.words(),)).map(drop));
            self.raised = heard.err();
        }
    }

    fn proceed(&mut self) -> Result<(), Halt> {
        if self.may_go_on() { Ok(()) } else { Err(Halt::Cancelled) }
    }
}

/// What tuning found, with the keys of `msd tune --json`.
#[derive(Serialize)]
struct TuneReport {
    scene: String,
    set: Map<String, Value>,
    duration: f64,
    compared_until: f64,
    chaotic_after: Option<f64>,
    goal: Goal,
    met: bool,
    #[serde(flatten)]
    best: Row,
    runner_up: Option<Row>,
    reference_uncertainty: f64,
    tried: usize,
    interrupted: bool,
}

/// A choice and what is known of it.
#[derive(Serialize)]
struct Row {
    integrator: &'static str,
    precision: &'static str,
    step: Option<f64>,
    substeps: Option<u32>,
    tolerance: Option<f64>,
    predicted_error: Option<f64>,
    verified_error: f64,
    ms_per_frame: f64,
}

impl Row {
    fn of(found: &Found, uncertainty: f64) -> Self {
        let Found { trial, predicted_error } = found;
        let Choice { integrator, fineness, precision } = trial.choice;
        let (substeps, tolerance) = match fineness {
            Fineness::Substeps(substeps) => (Some(substeps), None),
            Fineness::Tolerance(tolerance) => (None, Some(tolerance)),
        };
        Row {
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

fn set_keys(set: &[Assignment]) -> Map<String, Value> {
    let value = |set: &Assignment| serde_json::to_value(set.value()).unwrap_or_default();
    set.iter().map(|set| (set.key().into(), value(set))).collect()
}

fn check_positive(py: Python<'_>, name: &str, value: Option<f64>) -> PyResult<()> {
    match value {
        Some(value) if !(0.0 < value && value.is_finite()) => {
            Err(refused(py, format!("{name} is {value}; it must be positive and finite")))
        }
        _ => Ok(()),
    }
}

/// Find the cheapest setting within `max_error`, metres, or the most accurate one within `budget`,
/// seconds of processor time per frame of 1/60 s.
///
/// `duration` is the time simulated, seconds. `progress` is called with words now and then; what
/// it raises ends the search. Returns a dict with the keys of `msd tune --json`: `met`,
/// `integrator`, `substeps`, `verified_error`, `ms_per_frame` and others.
///
/// >>> import msd
/// >>> msd.tune(msd.open("chain"), 0.1, max_error=0.1)["met"]
/// True
#[pyfunction]
#[pyo3(signature = (scene, duration=1.0, *, max_error=None, budget=None, progress=None))]
pub fn tune<'py>(
    py: Python<'py>,
    scene: &Bound<'py, Scene>,
    duration: f64,
    max_error: Option<f64>,
    budget: Option<f64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    check_positive(py, "duration", Some(duration))?;
    check_positive(py, "max_error", max_error)?;
    check_positive(py, "budget", budget)?;
    let goal = match (max_error, budget) {
        (Some(error), None) => Goal::MaxError(error),
        (None, Some(budget)) => Goal::Budget(budget),
        _ => {
            let message = "give one of max_error, metres, and budget, seconds per frame";
            return Err(pyo3::exceptions::PyTypeError::new_err(message));
        }
    };
    let Scene { loaded, set, .. } = scene.get();
    let mut caller = Caller::new(progress.as_ref());
    let tuned = py.detach(|| {
        let restarted = loaded.clone().restarted();
        msd_study::tune::tune(&restarted.scene, duration, goal, &mut caller)
    });
    let tuned = caller.outcome(py, tuned)?;
    let report = TuneReport {
        scene: loaded.name.clone(),
        set: set_keys(set),
        duration: tuned.duration,
        compared_until: tuned.compared,
        chaotic_after: tuned.horizon,
        goal,
        met: tuned.met,
        best: Row::of(&tuned.best, tuned.uncertainty),
        runner_up: tuned.others.first().map(|found| Row::of(found, tuned.uncertainty)),
        reference_uncertainty: tuned.uncertainty,
        tried: tuned.tried,
        interrupted: tuned.is_cut_short,
    };
    from_serde(py, &report)
}

/// Study what accuracy costs: try methods and settings, and compare each with a reference.
///
/// `duration` is the time simulated, seconds; `max_error`, metres, is the error that the words are
/// about; `time` is the processor time to spend on trials, seconds. A study that was interrupted
/// resumes unless `fresh`. `progress` is called with words; what it raises ends the study. Returns
/// a dict with the keys of `msd study --json`, with an array for each list of numbers.
#[pyfunction]
#[pyo3(signature = (scene, duration=1.0, *, max_error=None, time=60.0, fresh=false, progress=None))]
pub fn study<'py>(
    py: Python<'py>,
    scene: &Bound<'py, Scene>,
    duration: f64,
    max_error: Option<f64>,
    time: f64,
    fresh: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    check_positive(py, "duration", Some(duration))?;
    check_positive(py, "max_error", max_error)?;
    check_positive(py, "time", Some(time))?;
    let loaded = &scene.get().loaded;
    let plan = Plan { duration, wanted: max_error, budget: time, fresh, ..Plan::default() };
    let mut caller = Caller::new(progress.as_ref());
    let studied =
        py.detach(|| msd_study::conduct::study(&loaded.clone().restarted(), plan, &mut caller));
    let (study, _) = caller.outcome(py, studied)?;
    from_serde(py, &study)
}

/// What the bodies of a scene amount to, with the keys of `msd inspect --json`.
#[derive(Serialize)]
struct InspectReport<'a> {
    scene: &'a str,
    set: Map<String, Value>,
    integrator: &'static str,
    stable_step: f64,
    bodies: Vec<Inspection>,
    notes: &'a [String],
}

/// Inspect what the bodies of a scene amount to as materials: masses, moduli, frequencies.
///
/// Returns a dict with the keys of `msd inspect --json`.
///
/// >>> import msd
/// >>> msd.inspect(msd.open("cloth"))["bodies"][0]["particles"]
/// 961
#[pyfunction]
pub fn inspect<'py>(py: Python<'py>, scene: &Bound<'py, Scene>) -> PyResult<Bound<'py, PyAny>> {
    let Scene { loaded, set, .. } = scene.get();
    let inspected = py.detach(|| -> Result<_, Error> {
        let bodies = msd_study::inspection::inspect(&loaded.scene)?;
        let simulation = Simulation::<f64>::new(&loaded.scene, loaded.settings)?;
        Ok((bodies, simulation.stable_substep()))
    });
    let (bodies, stable_step) = inspected.map_err(|error| core_error(py, error))?;
    let report = InspectReport {
        scene: &loaded.name,
        set: set_keys(set),
        integrator: loaded.settings.integrator.name(),
        stable_step,
        bodies,
        notes: &loaded.notes,
    };
    from_serde(py, &report)
}
