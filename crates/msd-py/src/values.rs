//! Conversion of values between Python and JSON.

use crate::errors::refused;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use serde::Serialize;
use serde_json::{Map, Number, Value};

/// Largest nesting depth of lists: a list that contains itself has none.
const DEEPEST: usize = 64;

/// Converts a Python value to JSON: numbers, texts, lists, dicts, numpy arrays and scalars, paths.
pub fn to_json(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    json_within(value, DEEPEST)
}

fn json_within(value: &Bound<'_, PyAny>, left: usize) -> PyResult<Value> {
    let py = value.py();
    let Some(left) = left.checked_sub(1) else {
        return Err(refused(py, "the value is nested too deeply; a scene has at most 64 levels"));
    };
    if value.is_none() {
        return Ok(Value::Null);
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(Value::Bool(flag.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        let whole = value.extract::<i64>().map(Number::from);
        let whole = whole.or_else(|_| value.extract::<u64>().map(Number::from));
        return whole.map(Value::Number).map_err(|_| {
            refused(py, format!("the value is {value}; it must be a whole number of 64 bits"))
        });
    }
    if value.is_instance_of::<PyFloat>() {
        let number: f64 = value.extract()?;
        let finite = Number::from_f64(number).map(Value::Number);
        return finite
            .ok_or_else(|| refused(py, format!("the value is {number}; it must be finite")));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::String(text.to_string_lossy().into_owned()));
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        let mut rows = Map::new();
        for (key, value) in dict {
            let Ok(key) = key.extract::<String>() else {
                return Err(refused(py, format!("the key {} must be a text", key.repr()?)));
            };
            rows.insert(key, json_within(&value, left)?);
        }
        return Ok(Value::Object(rows));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter()?.map(|item| json_within(&item?, left));
        return items.collect::<PyResult<_>>().map(Value::Array);
    }
    // numpy and pathlib.
    for method in ["tolist", "__fspath__"] {
        if let Ok(method) = value.getattr(method) {
            return json_within(&method.call0()?, left);
        }
    }
    let kind = value.get_type().name()?;
    let must = "it must be a number, a text, a list, a dict or an array";
    Err(refused(py, format!("the value is of type {kind}; {must}")))
}

/// Converts JSON of the command line to Python: dicts, texts, numbers, and an array for each list
/// of numbers.
pub fn from_serde<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let json = serde_json::to_value(value).map_err(|error| refused(py, error))?;
    from_json(py, &json)
}

/// Converts a JSON value to Python.
pub fn from_json<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Null => py.None().into_bound(py),
        Value::Bool(flag) => PyBool::new(py, *flag).to_owned().into_any(),
        Value::Number(number) => match (number.as_i64(), number.as_u64()) {
            (Some(whole), _) => whole.into_pyobject(py)?.into_any(),
            (None, Some(whole)) => whole.into_pyobject(py)?.into_any(),
            (None, None) => number.as_f64().unwrap_or(f64::NAN).into_pyobject(py)?.into_any(),
        },
        Value::String(text) => text.into_pyobject(py)?.into_any(),
        Value::Array(items) => {
            let numbers: Option<Vec<f64>> = items.iter().map(Value::as_f64).collect();
            match numbers.filter(|numbers| !numbers.is_empty()) {
                Some(numbers) => PyArray1::from_vec(py, numbers).into_any(),
                None => {
                    let items = items.iter().map(|item| from_json(py, item));
                    PyList::new(py, items.collect::<PyResult<Vec<_>>>()?)?.into_any()
                }
            }
        }
        Value::Object(rows) => {
            let dict = PyDict::new(py);
            for (key, value) in rows {
                dict.set_item(key, from_json(py, value)?)?;
            }
            dict.into_any()
        }
    })
}
