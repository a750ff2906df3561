//! The Python exceptions: three classes, with the messages of the command line.

use msd_core::Error;
use msd_scene::FileError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple};

/// The exception classes, created when the module is imported.
struct Classes {
    error: Py<PyAny>,
    scene: Py<PyAny>,
    step: Py<PyAny>,
}

/// The attributes of a step that failed; None where a class was called by hand.
const FIELDS: [&str; 4] = ["step", "time", "particle", "stable_substep"];

static CLASSES: PyOnceLock<Classes> = PyOnceLock::new();

fn classes(py: Python<'_>) -> PyResult<&Classes> {
    CLASSES.get_or_try_init(py, || {
        let builtins = py.import("builtins")?;
        let new = |name: &str, doc: &str, bases: Vec<Bound<'_, PyAny>>| -> PyResult<Py<PyAny>> {
            let body = PyDict::new(py);
            if name == "StepError" {
                FIELDS.iter().try_for_each(|field| body.set_item(field, py.None()))?;
            }
            body.set_item("__module__", "msd")?;
            body.set_item("__doc__", doc)?;
            let class = (name, PyTuple::new(py, bases)?, body);
            Ok(builtins.getattr("type")?.call1(class)?.unbind())
        };
        let error = new(
            "Error",
            "An error of msd, in a sentence: what is wrong, the value, its domain.",
            vec![builtins.getattr("Exception")?],
        )?;
        let of = |base: &str| -> PyResult<Vec<Bound<'_, PyAny>>> {
            Ok(vec![error.bind(py).clone(), builtins.getattr(base)?])
        };
        let scene = new(
            "SceneError",
            "A scene, a file, a key or a value that msd refuses; also a ValueError.",
            of("ValueError")?,
        )?;
        let step = new(
            "StepError",
            "A step that failed; the run keeps the state before it. Also an ArithmeticError.\n\n\
              `step` is the step that failed, counted from 1, and `time` its start, seconds.\n\
              `particle` is the lowest-numbered particle outside the world at the end of the\n\
              step, or that with the largest error where a tolerance is out of reach.\n\n\
              `stable_substep` is the longest substep predicted stable in the state kept,\n\
              seconds: infinite if any is, None if none is. The message says `none is` also\n\
              where it is below a millionth of the substep.\n\n\
              An attribute is None where it is unknown, as in a StepError that you make.",
            of("ArithmeticError")?,
        )?;
        Ok(Classes { error, scene, step })
    })
}

/// Adds the classes to the module.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let Classes { error, scene, step } = classes(module.py())?;
    module.add("Error", error)?;
    module.add("SceneError", scene)?;
    module.add("StepError", step)
}

fn raised(py: Python<'_>, of: fn(&Classes) -> &Py<PyAny>, message: String) -> PyErr {
    let made = classes(py).and_then(|classes| of(classes).bind(py).call1((message,)));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Returns an error that concerns neither a scene nor a step.
pub fn error(py: Python<'_>, message: impl ToString) -> PyErr {
    raised(py, |classes| &classes.error, message.to_string())
}

/// Returns the error of a value.
pub fn refused(py: Python<'_>, message: impl ToString) -> PyErr {
    raised(py, |classes| &classes.scene, message.to_string())
}

/// Returns the error of a file or of a scene.
pub fn file_error(py: Python<'_>, error: FileError) -> PyErr {
    match error {
        FileError::Core { source, file } if source.is_of_step() => {
            step_error(py, &source, &format!("{file}: {source}"))
        }
        // Keys of a dict are not options of a command line.
        other => refused(py, other.to_string().replace("--set ", "")),
    }
}

/// Returns an error of the core: of a step, or of a value.
pub fn core_error(py: Python<'_>, error: Error) -> PyErr {
    match error.is_of_step() {
        true => step_error(py, &error, &error.to_string()),
        false => refused(py, error),
    }
}

fn step_error(py: Python<'_>, error: &Error, message: &str) -> PyErr {
    let raised = raised(py, |classes| &classes.step, message.to_owned());
    let (step, time, particle, stable) = match error {
        Error::Diverged(at) => (at.step, at.time, Some(at.particle), at.stable_substep),
        Error::Unreachable { step, time, particle, .. } => (*step, *time, Some(*particle), None),
        Error::TooManyEvaluations { step, time, .. } | Error::Unsolved { step, time, .. } => {
            (*step, *time, None, None)
        }
        _ => return raised,
    };
    let value = raised.value(py);
    let set = value
        .setattr("step", step)
        .and_then(|()| value.setattr("time", time))
        .and_then(|()| value.setattr("particle", particle))
        .and_then(|()| value.setattr("stable_substep", stable));
    set.err().unwrap_or(raised)
}
