//! Arguments of runs: counts, vectors, selections, and how a run is to be stepped.

use crate::errors::{core_error, refused};
use msd_core::Select;
use msd_core::glam::DVec3;
use msd_run::{Runner, on};
use msd_scene::schema::{OrAuto, Solver, SolverRow};
use msd_scene::{Loaded, Precision, nearest, tame};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyRange, PySlice, PyString};

/// A non-negative whole number, a count or an index; its name belongs to the message of others.
pub enum Count {
    Of(u64),
    /// A number outside the range, in words.
    Outside(String),
    /// The name of another type.
    Other(String),
}

impl Count {
    pub fn get(&self, py: Python<'_>, name: &str) -> PyResult<u64> {
        match self {
            Count::Of(count) => Ok(*count),
            Count::Outside(whole) => {
                let must = format!("it must be a whole number from 0 to {}", u64::MAX);
                Err(refused(py, format!("{name} is {whole}; {must}")))
            }
            Count::Other(kind) => {
                let message = format!("{name} is of type {kind}; it must be a whole number");
                Err(PyTypeError::new_err(message))
            }
        }
    }

    pub fn index(&self, py: Python<'_>, name: &str) -> PyResult<usize> {
        Ok(usize::try_from(self.get(py, name)?).unwrap_or(usize::MAX))
    }
}

impl<'py> FromPyObject<'_, 'py> for Count {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let py = value.py();
        if let Ok(count) = value.extract::<u64>() {
            return Ok(Count::Of(count));
        }
        // numpy integers convert by `__index__`.
        let Ok(whole) = py.import("operator")?.getattr("index")?.call1((value,)) else {
            return Ok(Count::Other(value.get_type().name()?.to_string()));
        };
        Ok(whole.extract().map_or_else(|_| Count::Outside(whole.to_string()), Count::Of))
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
            let start = if start.is_none() { Count::Of(0) } else { start.extract()? };
            let start = start.index(py, "the start of the range")?;
            Ok(Of::Range(start, end.extract::<Count>()?.index(py, "the end of the range")?))
        };
        if value.is_instance_of::<PyRange>() || value.is_instance_of::<PySlice>() {
            let [start, stop, step] = ["start", "stop", "step"].map(|name| value.getattr(name));
            return ends(&start?, &stop?, &step?);
        }
        match value.extract()? {
            Count::Other(kind) => {
                let must = "it must be the name of a body, a whole number, or a range of them";
                Err(PyTypeError::new_err(format!("of is of type {kind}; {must}")))
            }
            count => count.index(py, "of").map(Of::One),
        }
    }
}

/// The most threads of a run.
const MOST_THREADS: usize = 1024;

/// Returns the solver of a scene with the keywords of a run, and the number of its threads. The
/// keywords mean the same as the options of the command line.
pub fn solver(loaded: &Loaded, options: Option<&Bound<'_, PyDict>>) -> PyResult<(Solver, usize)> {
    let Some(options) = options else { return Ok((loaded.solver(), 1)) };
    let py = options.py();
    let given = |key: &str| -> PyResult<Option<Bound<'_, PyAny>>> {
        Ok(options.get_item(key)?.filter(|value| !value.is_none()))
    };
    let wrong = |key: &str, value: &Bound<'_, PyAny>, must: &str| {
        refused(py, format!("{key} is {value}; it must be {must}"))
    };
    check_names(options)?;
    let mut row = SolverRow::default();
    if let Some(name) = given("integrator")? {
        let name: String = name.extract()?;
        row.integrator = Some(name.parse().map_err(|error| core_error(py, error))?);
    }
    if let Some(step) = given("step")? {
        row.step = OrAuto::Given(step.extract()?);
    }
    if let Some(substeps) = given("substeps")? {
        let must = "a whole number from 1 to 4294967295, or \"auto\"";
        let count = || substeps.extract::<u32>().map_err(|_| wrong("substeps", &substeps, must));
        let is_auto = substeps.eq("auto")?;
        row.substeps = Some(if is_auto { OrAuto::Auto } else { OrAuto::Given(count()?.into()) });
    }
    row.tolerance = given("tolerance")?.map(|tolerance| tolerance.extract()).transpose()?;
    if let Some(newton) = given("newton")? {
        let count = newton.extract::<u32>().map_err(|_| wrong("newton", &newton, "from 1 to 1000"));
        row.newton = Some(count?.into());
    }
    if let Some(name) = given("precision")? {
        let known = [Precision::F32, Precision::F64];
        let found = known.into_iter().find(|it| name.eq(it.name()).unwrap_or(false));
        row.precision = Some(found.ok_or_else(|| wrong("precision", &name, "f32 or f64"))?);
    }
    let solver = loaded.solver().with(&row.with_frame());
    row.check_read(solver.settings.integrator, "").map_err(|reason| refused(py, reason))?;
    let Some(threads) = given("threads")? else { return Ok((solver, 1)) };
    let count = threads.extract().ok().filter(|count| (1..=MOST_THREADS).contains(count));
    let must = format!("from 1 to {MOST_THREADS}");
    Ok((solver, count.ok_or_else(|| wrong("threads", &threads, &must))?))
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
