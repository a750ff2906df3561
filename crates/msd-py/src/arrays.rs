//! Conversion of numpy arrays: checked reads, and arrays from columns.

use crate::errors::refused;
use msd_core::Vector;
use numpy::ndarray::Array2;
use numpy::{Element, PyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;

static ASARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

/// Returns an array-like as an array, and the letter of its kind of numbers.
fn array<'py>(what: &str, value: &Bound<'py, PyAny>) -> PyResult<(Bound<'py, PyAny>, String)> {
    let py = value.py();
    let wrong = |error: PyErr| refused(py, format!("{what} must be an array of numbers: {error}"));
    let array = ASARRAY.import(py, "numpy", "asarray")?.call1((value,)).map_err(wrong)?;
    let kind = array.getattr("dtype")?.getattr("kind")?.extract()?;
    Ok((array, kind))
}

/// Returns the numbers of an array-like in C order, and its shape; any strides, byte order and
/// number type.
fn read<'py, T: Element + Clone>(
    what: &str,
    value: &Bound<'py, PyAny>,
    (dtype, kinds): (&str, &str),
) -> PyResult<(Vec<T>, Vec<usize>)> {
    let py = value.py();
    let (array, kind) = array(what, value)?;
    let size: usize = array.getattr("size")?.extract()?;
    // An empty array has an arbitrary type.
    if !kinds.contains(&kind) && 0 < size {
        let found = array.getattr("dtype")?;
        let must = if dtype == "int64" { "whole numbers" } else { "real numbers" };
        return Err(refused(py, format!("{what} must hold {must}; it holds {found}")));
    }
    let order = PyDict::new(py);
    order.set_item("order", "C")?;
    let array = ASARRAY.import(py, "numpy", "asarray")?.call((array, dtype), Some(&order))?;
    let array: PyReadonlyArrayDyn<'py, T> = array.extract()?;
    let numbers = array.as_slice().map_err(|error| refused(py, error))?.to_vec();
    Ok((numbers, array.shape().to_vec()))
}

/// Reads real numbers of any shape.
pub fn reals(what: &str, value: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, Vec<usize>)> {
    read(what, value, ("float64", "fiub"))
}

/// Reads non-negative whole numbers of any shape.
pub fn indexes(what: &str, value: &Bound<'_, PyAny>) -> PyResult<(Vec<usize>, Vec<usize>)> {
    let (numbers, shape) = read::<i64>(what, value, ("int64", "iu"))?;
    let negative = numbers.iter().find(|&&number| number < 0);
    if let Some(negative) = negative {
        let message = format!("{what} holds {negative}; indexes are counted from 0");
        return Err(refused(value.py(), message));
    }
    Ok((numbers.into_iter().map(|number| number as usize).collect(), shape))
}

/// Reads particles: their indexes, or an array of `count` booleans.
pub fn particles(what: &str, value: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<usize>> {
    let py = value.py();
    if array(what, value)?.1 == "b" {
        let (mask, shape) = reals(what, value)?;
        if shape != [count] {
            return Err(wrong_shape(py, what, &shape, &format!("({count},)")));
        }
        return Ok((0..count).filter(|&particle| mask[particle] != 0.0).collect());
    }
    let (particles, shape) = indexes(what, value)?;
    if 1 < shape.len() {
        return Err(wrong_shape(py, what, &shape, "(k,)"));
    }
    check_below(py, what, &particles, count)?;
    Ok(particles)
}

/// Refuses an index beyond the last particle.
pub fn check_below(py: Python<'_>, what: &str, particles: &[usize], count: usize) -> PyResult<()> {
    match particles.iter().find(|&&particle| count <= particle) {
        Some(particle) => Err(refused(
            py,
            format!("{what} names particle {particle}, but there are only {count}, counted from 0"),
        )),
        None => Ok(()),
    }
}

/// Reads rows of `N` columns; their number must be `count`, if given.
pub fn rows<const N: usize>(
    what: &str,
    value: &Bound<'_, PyAny>,
    count: Option<usize>,
) -> PyResult<Vec<[f64; N]>> {
    let (numbers, shape) = reals(what, value)?;
    check_rows(value.py(), what, (&shape, N), count)?;
    Ok(numbers.as_chunks::<N>().0.to_vec())
}

/// Reads rows of indexes.
pub fn index_rows<const N: usize>(
    what: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<Vec<[usize; N]>> {
    let (numbers, shape) = indexes(what, value)?;
    check_rows(value.py(), what, (&shape, N), None)?;
    Ok(numbers.as_chunks::<N>().0.to_vec())
}

fn check_rows(
    py: Python<'_>,
    what: &str,
    (shape, columns): (&[usize], usize),
    count: Option<usize>,
) -> PyResult<()> {
    let is_right = match *shape {
        [found, width] => width == columns && count.is_none_or(|count| found == count),
        // An empty list has no columns: `[]` is an array of (0,).
        [0] => count.is_none_or(|count| count == 0),
        _ => false,
    };
    if is_right {
        return Ok(());
    }
    let rows = count.map_or("n".to_owned(), |count| count.to_string());
    Err(wrong_shape(py, what, shape, &format!("({rows}, {columns})")))
}

/// Reads a number for each of `count` rows, from a scalar or an array.
pub fn for_each(what: &str, value: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<f64>> {
    let (numbers, shape) = reals(what, value)?;
    match (&numbers[..], shape.len()) {
        (&[one], 0) => Ok(vec![one; count]),
        (_, 1) if numbers.len() == count => Ok(numbers),
        _ => {
            let must = format!("a number or ({count},)");
            Err(wrong_shape(value.py(), what, &shape, &must))
        }
    }
}

fn wrong_shape(py: Python<'_>, what: &str, shape: &[usize], must: &str) -> PyErr {
    let shape: Vec<String> = shape.iter().map(usize::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    refused(py, format!("{what} has the shape ({}{comma}); it must be {must}", shape.join(", ")))
}

/// Returns an empty vector with capacity for `count` numbers.
///
/// # Errors
/// MemoryError, with the memory that `what` would need.
pub fn room<T>(what: &str, count: Option<usize>) -> PyResult<Vec<T>> {
    let mut numbers = Vec::new();
    let refused = |size: f64| {
        let message = format!("{what} would take {:.1} GB; ask for less", size / 1e9);
        Err(PyMemoryError::new_err(message))
    };
    let size = size_of::<T>() as f64;
    match count {
        Some(count) if numbers.try_reserve_exact(count).is_ok() => Ok(numbers),
        Some(count) => refused(count as f64 * size),
        None => refused(f64::INFINITY),
    }
}

/// Returns the components of vectors one after the other.
pub fn flat<V: Vector>(vectors: impl Iterator<Item = V>, count: usize) -> Vec<V::Scalar>
where
    V::Scalar: Copy,
{
    let mut numbers = Vec::with_capacity(3 * count);
    vectors.for_each(|vector| numbers.extend_from_slice(&vector.components()));
    numbers
}

/// Returns an array of (n, 3) from consecutive rows.
pub fn vectors<T: Element>(py: Python<'_>, numbers: Vec<T>) -> PyResult<Bound<'_, PyArray2<T>>> {
    // Quicker than an array of numpy that is reshaped.
    let array = Array2::from_shape_vec([numbers.len() / 3, 3], numbers);
    Ok(PyArray2::from_owned_array(py, array.map_err(|error| refused(py, error))?))
}
