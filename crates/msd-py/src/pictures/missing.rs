//! Pictures in a build without the feature `pictures`: refused.

use super::Picture;
use crate::errors::error;
use crate::run::Simulation;
use crate::run::lock::Shared;
use msd_scene::Viewpoint;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::Path;

fn missing(py: Python<'_>) -> PyErr {
    let todo = "pip install . -C maturin.build-args=\"--features pictures\"";
    error(py, format!("this build of msd cannot draw pictures; in a checkout, run {todo}"))
}

pub fn picture<'py>(
    py: Python<'py>,
    _run: &Simulation,
    _look: Picture<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    Err(missing(py))
}

pub fn film(
    py: Python<'_>,
    _run: &Simulation,
    _frames: (u64, u64),
    _path: &Path,
    _look: Picture<'_, '_>,
) -> PyResult<()> {
    Err(missing(py))
}

pub fn png<'py>(
    _py: Python<'py>,
    _shared: &Shared,
    _subject: (&str, Viewpoint),
) -> Option<Bound<'py, PyBytes>> {
    None
}

pub fn can_draw(_py: Python<'_>) -> bool {
    false
}
