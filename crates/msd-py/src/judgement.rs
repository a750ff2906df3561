//! Tuning, studies and inspection of a scene.

use crate::caller::Caller;
use crate::errors::{core_error, file_error, refused};
use crate::scene::Scene;
use crate::values::from_serde;
use msd_scene::set_keys;
use msd_study::choice::{Choice, Fineness};
use msd_study::conduct::Plan;
use msd_study::inspection::InspectReport;
use msd_study::tune::{Goal, TuneReport};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

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
/// An error is the largest over time of the root mean square over particles of their distances from
/// a reference; single particles may be further off. Where the motion is chaotic, particles are
/// compared only until `compared_until`, seconds.
///
/// `duration` is the time simulated, seconds. `progress` is called with words now and then; what it
/// raises ends the search, as does Ctrl-C.
///
/// Returns a dict with the keys of `msd tune --json`: `met`, `integrator`, `substeps` per frame of
/// 1/60 s, `verified_error`, `ms_per_frame` and others. Its `settings` are the keywords of a run
/// with the choice. Its `substep`, seconds, is `step` in the JSON.
///
/// >>> import msd
/// >>> chain = msd.open("chain")
/// >>> found = msd.tune(chain, 0.1, max_error=0.1)
/// >>> found["met"], found["verified_error"] <= 0.1
/// (True, True)
/// >>> run = msd.Simulation(chain, **found["settings"])
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
    let report = TuneReport::new(&loaded.name, set_keys(set), &tuned);
    let report = from_serde(py, &report)?;
    add_settings(&report, tuned.best.trial.choice)?;
    if let Some(other) = tuned.others.first() {
        add_settings(&report.get_item("runner_up")?, other.trial.choice)?;
    }
    Ok(report)
}

/// Adds the keywords of a run with a choice to its report, and calls its substep so.
fn add_settings(report: &Bound<'_, PyAny>, choice: Choice) -> PyResult<()> {
    let settings = choice.settings();
    let keywords = PyDict::new(report.py());
    keywords.set_item("integrator", settings.integrator.name())?;
    keywords.set_item("precision", choice.precision.name())?;
    keywords.set_item("step", settings.step)?;
    match choice.fineness {
        Fineness::Substeps(substeps) => keywords.set_item("substeps", substeps)?,
        Fineness::Tolerance(tolerance) => keywords.set_item("tolerance", tolerance)?,
    }
    if settings.integrator.is_implicit() {
        keywords.set_item("newton", settings.newton)?;
    }
    report.set_item("settings", keywords)?;
    report.set_item("substep", report.get_item("step")?)?;
    report.del_item("step")
}

/// Study what accuracy costs: try methods and settings, and compare each with a reference.
///
/// `duration` is the time simulated, seconds; `max_error`, metres, is the error that the words are
/// about, as `tune` measures it; `time` is the processor time to spend on trials, seconds. A study
/// that was interrupted resumes unless `fresh`. `progress` is called with words; what it raises
/// ends the study, as does Ctrl-C. Returns a dict with the keys of `msd study --json`, with an
/// array for each list of numbers.
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

/// Write the report of a study, a dict of `msd.study`, as a page to open in a browser.
///
/// The page `path` needs nothing beside it. A build without the feature `report` raises Error.
#[pyfunction]
pub fn report(py: Python<'_>, study: &Bound<'_, PyAny>, path: PathBuf) -> PyResult<()> {
    let page = page(py, study)?;
    let written = py.detach(|| msd_scene::write_file(&path, page.as_bytes()));
    written.map_err(|error| file_error(py, error))
}

#[cfg(feature = "report")]
fn page(py: Python<'_>, study: &Bound<'_, PyAny>) -> PyResult<String> {
    let wrong = |error| refused(py, format!("this is not a dict of msd.study: {error}"));
    let study = serde_json::from_value(crate::values::to_json(study)?).map_err(wrong)?;
    Ok(py.detach(|| msd_report::html(&study)))
}

#[cfg(not(feature = "report"))]
fn page(py: Python<'_>, _study: &Bound<'_, PyAny>) -> PyResult<String> {
    let todo = "pip install . -C maturin.build-args=\"--features report\"";
    Err(crate::errors::error(
        py,
        format!("this build of msd writes no reports; in a checkout, run {todo}"),
    ))
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
    let report = py.detach(|| InspectReport::new(loaded, set_keys(set)));
    from_serde(py, &report.map_err(|error| core_error(py, error))?)
}
