//! Arguments of runs: counts, vectors, selections, and how a run is to be stepped.

use crate::errors::{core_error, refused};
use msd_core::glam::DVec3;
use msd_core::{Integrator, Select, Settings};
use msd_run::{Runner, on};
use msd_scene::schema::Solver;
use msd_scene::{Loaded, Precision, nearest, tame};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyRange, PySlice, PyString};

/// A non-negative whole number: a count, or an index.
#[derive(Clone, Copy)]
pub struct Count(pub u64);

impl Count {
    pub fn index(self) -> usize {
        usize::try_from(self.0).unwrap_or(usize::MAX)
    }
}

impl<'py> FromPyObject<'_, 'py> for Count {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let py = value.py();
        if let Ok(count) = value.extract::<u64>() {
            return Ok(Count(count));
        }
        // numpy integers convert by `__index__`.
        let whole = py.import("operator")?.getattr("index")?;
        let whole = whole.call1((value,)).map_err(|_| {
            let kind = value.get_type().name().map(|name| name.to_string()).unwrap_or_default();
            PyTypeError::new_err(format!("it must be a whole number; it is of type {kind}"))
        })?;
        let must = format!("it is {whole}; it must be a whole number from 0 to {}", u64::MAX);
        whole.extract().map(Count).map_err(|_| refused(py, must))
    }
}

/// A vector: three real numbers in a tuple, a list or an array.
#[derive(Clone, Copy)]
pub struct Triple(pub DVec3);

impl<'py> FromPyObject<'_, 'py> for Triple {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(numbers) = value.extract::<[f64; 3]>() {
            return Ok(Triple(DVec3::from_array(numbers)));
        }
        let must = "three real numbers";
        Err(refused(value.py(), format!("{} is not a vector; give {must}", value.repr()?)))
    }
}

/// Resolves `of`: all springs or particles, those of a body, one, or a range.
pub fn select(runner: &Runner, of: &Of) -> Result<Select, String> {
    Ok(match of {
        Of::All => Select::All,
        Of::One(index) => Select::One(*index),
        Of::Range(start, end) => Select::Range(*start, *end),
        Of::Body(name) => {
            let bodies = on!(runner, simulation => simulation.model().bodies());
            let found = bodies.iter().position(|body| body.name == *name);
            let names = bodies.iter().map(|body| &body.name[..]);
            let meant = nearest(name, names.clone());
            Select::Body(found.ok_or_else(|| match meant {
                Some(near) => format!("no body `{}`: did you mean `{near}`?", tame(name)),
                None => {
                    let all = names.collect::<Vec<_>>().join(", ");
                    format!("no body `{}`; the bodies are {all}", tame(name))
                }
            })?)
        }
    })
}

/// Value of an argument `of`.
pub enum Of {
    All,
    Body(String),
    One(usize),
    Range(usize, usize),
}

impl<'py> FromPyObject<'_, 'py> for Of {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let py = value.py();
        if value.is_none() {
            return Ok(Of::All);
        }
        if let Ok(name) = value.cast::<PyString>() {
            return Ok(Of::Body(name.to_string_lossy().into_owned()));
        }
        let ends = |start: &Bound<'_, PyAny>, end: &Bound<'_, PyAny>, step: &Bound<'_, PyAny>| {
            if !step.is_none() && !step.eq(1)? {
                return Err(refused(py, format!("the step of {} must be 1", value.repr()?)));
            }
            if end.is_none() {
                return Err(refused(py, format!("{} must have an end", value.repr()?)));
            }
            let start = if start.is_none() { Count(0) } else { start.extract()? };
            Ok(Of::Range(start.index(), end.extract::<Count>()?.index()))
        };
        if value.is_instance_of::<PyRange>() || value.is_instance_of::<PySlice>() {
            let [start, stop, step] = ["start", "stop", "step"].map(|name| value.getattr(name));
            return ends(&start?, &stop?, &step?);
        }
        value.extract::<Count>().map(|one| Of::One(one.index()))
    }
}

/// The most threads of a run.
const MOST_THREADS: usize = 1024;

/// The keywords of a run, each beside what its scene says; as on the command line, `step` alone
/// takes one substep, and `substeps` alone divide 1/60 s. With the number of its threads.
pub fn solver(loaded: &Loaded, options: Option<&Bound<'_, PyDict>>) -> PyResult<(Solver, usize)> {
    let (mut solver, mut count) = (loaded.solver(), 1);
    let Some(options) = options else { return Ok((solver, count)) };
    let py = options.py();
    let given = |key: &str| -> PyResult<Option<Bound<'_, PyAny>>> {
        Ok(options.get_item(key)?.filter(|value| !value.is_none()))
    };
    check_names(options)?;
    if let Some(name) = given("integrator")? {
        let name: String = name.extract()?;
        let integrator = name.parse::<Integrator>();
        solver.settings.integrator = integrator.map_err(|error| core_error(py, error))?;
    }
    if let Some(step) = given("step")? {
        (solver.settings.step, solver.settings.substeps) = (step.extract()?, 1);
        solver.automatic = false;
    }
    if let Some(substeps) = given("substeps")? {
        if given("step")?.is_none() {
            solver.settings.step = Settings::default().step;
        }
        solver.automatic = substeps.eq("auto")?;
        if !solver.automatic {
            let must = "a whole number from 1 to 4294967295, or \"auto\"";
            let wrong = |_| refused(py, format!("substeps is {substeps}; it must be {must}"));
            solver.settings.substeps = substeps.extract::<u32>().map_err(wrong)?;
        }
    }
    if let Some(tolerance) = given("tolerance")? {
        check_read(py, "tolerance", (&solver.settings, Integrator::is_adaptive))?;
        solver.settings.tolerance = tolerance.extract()?;
    }
    if let Some(newton) = given("newton")? {
        check_read(py, "newton", (&solver.settings, Integrator::is_implicit))?;
        let wrong = |_| refused(py, format!("newton is {newton}; it must be from 1 to 1000"));
        solver.settings.newton = newton.extract::<u32>().map_err(wrong)?;
    }
    if let Some(name) = given("precision")? {
        let known = [Precision::F32, Precision::F64];
        let found = known.into_iter().find(|it| name.eq(it.name()).unwrap_or(false));
        let wrong = || refused(py, format!("precision is {name}; it must be f32 or f64"));
        solver.precision = found.ok_or_else(wrong)?;
    }
    if let Some(threads) = given("threads")? {
        let wrong =
            || refused(py, format!("threads is {threads}; it must be from 1 to {MOST_THREADS}"));
        count = threads.extract().map_err(|_| wrong())?;
        if !(1..=MOST_THREADS).contains(&count) {
            return Err(wrong());
        }
    }
    Ok((solver, count))
}

/// The keywords of a run.
const OPTIONS: [&str; 7] =
    ["integrator", "step", "substeps", "tolerance", "newton", "precision", "threads"];

fn check_names(options: &Bound<'_, PyDict>) -> PyResult<()> {
    for key in options.keys() {
        let key: String = key.extract()?;
        if OPTIONS.contains(&&key[..]) {
            continue;
        }
        let meant = nearest(&key, OPTIONS).map(|near| format!("did you mean `{near}`?"));
        let all = || format!("it takes {}", OPTIONS.join(", "));
        let message = format!("unknown keyword `{key}`; {}", meant.unwrap_or_else(all));
        return Err(PyTypeError::new_err(message));
    }
    Ok(())
}

/// Refuses what the method would not read: it would have no effect silently.
fn check_read(
    py: Python<'_>,
    option: &str,
    (settings, reads): (&Settings, fn(Integrator) -> bool),
) -> PyResult<()> {
    if reads(settings.integrator) {
        return Ok(());
    }
    let readers = Integrator::ALL.into_iter().filter(|&method| reads(method));
    let readers: Vec<&str> = readers.map(Integrator::name).collect();
    let verb = if readers.len() == 1 { "does" } else { "do" };
    let readers = readers.join(" and ");
    let integrator = settings.integrator;
    Err(refused(py, format!("{integrator} does not use {option}; only {readers} {verb}")))
}
