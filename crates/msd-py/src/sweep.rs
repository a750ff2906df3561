//! Sweeps: a scene over a grid of its keys, each cell a dict that any task queue can send.

use crate::caller::Caller;
use crate::errors::{error, file_error, refused};
use crate::options::Count;
use msd_run::quantity::counted;
use msd_study::monitor::Halt;
use msd_study::sweep::{Datum, Sweep as StudySweep, Task};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// The cells of a sweep file: `len`, indexes and iteration give dicts that pickle.
///
/// A cell has its `cell` number, `hash`, `scene`, the `values` of the keys of the grid, the `text`
/// of its scene, `duration` and `error`. `msd.run_cell` makes its row.
#[pyclass(frozen, module = "msd")]
pub struct Sweep {
    sweep: StudySweep,
    path: PathBuf,
}

/// Read a sweep file: a `scene`, the `duration`, seconds, and a `[grid]` of its keys with values.
///
/// The cells are checked when you take them. A scene that names mesh files has no cells here. With
/// `error = true` a row has errors against a reference, which `msd.run_cell` explains.
///
/// >>> import msd, pathlib, tempfile
/// >>> path = pathlib.Path(tempfile.mkdtemp(), "stiffness.toml")
/// >>> _ = path.write_text('''
/// ... version = 1
/// ... scene = "chain"
/// ... duration = 0.1
/// ... error = true
/// ... [grid]
/// ... "bodies[0].stiffness" = [1000, 2000]
/// ... ''')
/// >>> for cell in msd.sweep(path):
/// ...     row = msd.run_cell(cell)
/// ...     print(cell["values"], 0 < row["rms_error"] < 0.1)
/// {'bodies[0].stiffness': 1000} True
/// {'bodies[0].stiffness': 2000} True
#[pyfunction]
pub fn sweep(py: Python<'_>, path: PathBuf) -> PyResult<Sweep> {
    let opened = py.detach(|| StudySweep::open(&path));
    Ok(Sweep { sweep: opened.map_err(|error| file_error(py, error))?, path })
}

fn datum<'py>(py: Python<'py>, datum: &Datum) -> PyResult<Bound<'py, PyAny>> {
    Ok(match datum {
        Datum::Nothing => py.None().into_bound(py),
        Datum::Flag(flag) => flag.into_pyobject(py)?.to_owned().into_any(),
        Datum::Whole(whole) => whole.into_pyobject(py)?.into_any(),
        Datum::Number(number) => number.into_pyobject(py)?.into_any(),
        Datum::Text(text) => text.into_pyobject(py)?.into_any(),
    })
}

fn dict<'py>(py: Python<'py>, rows: &[(String, Datum)]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    rows.iter().try_for_each(|(key, value)| dict.set_item(key, datum(py, value)?))?;
    Ok(dict)
}

#[pymethods]
impl Sweep {
    fn __len__(&self) -> usize {
        self.sweep.len()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, number: isize) -> PyResult<Bound<'py, PyDict>> {
        let count = self.sweep.len();
        let row = if number < 0 { number + count as isize } else { number };
        let row = usize::try_from(row).ok().filter(|&row| row < count);
        let none = || PyIndexError::new_err(format!("there is no cell {number} of {count}"));
        let row = row.ok_or_else(none)?;
        let task = py.detach(|| Task::of(&self.sweep, &self.sweep.cell(row)?));
        let task = task.map_err(|error| file_error(py, error))?;
        let cell = PyDict::new(py);
        cell.set_item("cell", task.number)?;
        cell.set_item("hash", &task.hash)?;
        cell.set_item("scene", &task.scene)?;
        cell.set_item("values", dict(py, &task.values)?)?;
        cell.set_item("text", &task.text)?;
        cell.set_item("duration", task.duration)?;
        cell.set_item("error", task.error)?;
        Ok(cell)
    }

    fn __repr__(&self) -> String {
        let cells = counted(self.sweep.len() as u64, "cell");
        format!("<msd.Sweep {}: {cells}>", self.path.display())
    }
}

/// Run a cell of a sweep and return its row: a dict with the values of the grid, `outcome`
/// ("finished" or "diverged"), `cpu_per_second`, `state_hash` and others.
///
/// With `error = true` it has errors, metres, the largest over time. `rms_error` is the root mean
/// square over particles of their distances from a reference, which `max_error` of `tune` bounds.
/// `max_error` of a row is the distance of the worst particle.
///
/// Where the motion is chaotic, the reference is certain only until `compared_until`, seconds, and
/// `rms_error` and `max_error` cover the time until then. If that is before `duration`, compare the
/// row only with rows of the same `compared_until`.
///
/// The row follows from the cell alone, but for the times it measures; no file is touched but the
/// cache of references of a sweep with `error = true`. Ctrl-C ends the cell.
#[pyfunction]
pub fn run_cell<'py>(py: Python<'py>, cell: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyDict>> {
    let get = |key: &str| {
        let missing = || refused(py, format!("the cell lacks `{key}`; take cells from msd.sweep"));
        cell.get_item(key)?.ok_or_else(missing)
    };
    let values = get("values")?;
    let values = values.cast::<PyDict>()?.iter().map(|(key, value)| {
        let datum = match value {
            value if value.is_none() => Datum::Nothing,
            value if value.is_instance_of::<pyo3::types::PyBool>() => Datum::Flag(value.extract()?),
            value if value.is_instance_of::<pyo3::types::PyInt>() => Datum::Whole(value.extract()?),
            value if value.is_instance_of::<pyo3::types::PyFloat>() => {
                Datum::Number(value.extract()?)
            }
            value => Datum::Text(value.extract()?),
        };
        Ok((key.extract()?, datum))
    });
    let task = Task {
        number: get("cell")?.extract::<Count>()?.index(py, "cell")?,
        hash: get("hash")?.extract()?,
        scene: get("scene")?.extract()?,
        values: values.collect::<PyResult<_>>()?,
        text: get("text")?.extract()?,
        duration: get("duration")?.extract()?,
        error: get("error")?.extract()?,
    };
    let mut caller = Caller::new(None);
    let done = py.detach(|| task.run(&mut caller));
    if let Some(raised) = caller.raised() {
        return Err(raised);
    }
    match done {
        Ok(row) => dict(py, &row),
        Err(Halt::Refused(refused)) => Err(file_error(py, refused)),
        Err(halt) => Err(error(py, halt)),
    }
}
