//! Readings of a run, as arrays and dicts.

use crate::arrays::{self, flat, room};
use crate::errors::{core_error, refused};
use crate::options::{Of, select};
use crate::run::lock::Shared;
use msd_core::glam::DVec3;
use msd_core::{Error, Real, Select, Simulation, Vector};
use msd_run::{Runner, on};
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// Numbers in the precision of a run.
pub enum Numbers {
    F32(Vec<f32>),
    F64(Vec<f64>),
}

impl Numbers {
    /// Converts to an array of (n, 3).
    pub fn array(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(match self {
            Numbers::F32(numbers) => arrays::vectors(py, numbers)?.into_any(),
            Numbers::F64(numbers) => arrays::vectors(py, numbers)?.into_any(),
        })
    }

    /// Converts to an array of (frames, n, 3).
    fn frames(self, py: Python<'_>, shape: [usize; 3]) -> PyResult<Bound<'_, PyAny>> {
        Ok(match self {
            Numbers::F32(numbers) => PyArray1::from_vec(py, numbers).reshape(shape)?.into_any(),
            Numbers::F64(numbers) => PyArray1::from_vec(py, numbers).reshape(shape)?.into_any(),
        })
    }
}

/// Copies the numbers of a column of a run.
macro_rules! numbers {
    ($runner:expr, $column:ident) => {{
        let count = $runner.particle_count();
        match &*$runner {
            msd_run::Runner::F32(it, _) => {
                crate::run::readings::Numbers::F32(crate::arrays::flat(it.$column(), count))
            }
            msd_run::Runner::F64(it, _) => {
                crate::run::readings::Numbers::F64(crate::arrays::flat(it.$column(), count))
            }
        }
    }};
}
pub(crate) use numbers;

/// Returns the forces on all particles, newtons.
pub fn vectors_of(runner: &Runner) -> Numbers {
    let count = runner.particle_count();
    match runner {
        Runner::F32(it, _) => Numbers::F32(flat(it.forces().0.into_iter(), count)),
        Runner::F64(it, _) => Numbers::F64(flat(it.forces().0.into_iter(), count)),
    }
}

/// Appends the positions of all particles, or of some.
fn add_positions<R: Real>(
    simulation: &Simulation<R>,
    points: Option<&[usize]>,
    numbers: &mut Vec<R>,
) where
    R::Vec3: Vector<Scalar = R>,
{
    match points {
        None => simulation.positions().for_each(|at| numbers.extend_from_slice(&at.components())),
        Some(points) => points.iter().for_each(|&particle| {
            numbers.extend_from_slice(&simulation.position(particle).components());
        }),
    }
}

fn keep(runner: &Runner, points: Option<&[usize]>, numbers: &mut Numbers) {
    match (runner, numbers) {
        (Runner::F32(it, _), Numbers::F32(numbers)) => add_positions(it, points, numbers),
        (Runner::F64(it, _), Numbers::F64(numbers)) => add_positions(it, points, numbers),
        _ => unreachable!("a run keeps its precision"),
    }
}

/// Returns the positions at the start and after each of `frames` times `every` steps.
pub fn trajectory<'py>(
    py: Python<'py>,
    (frames, every): (u64, u64),
    points: Option<&[usize]>,
    shared: &Shared,
) -> PyResult<Bound<'py, PyAny>> {
    let (count, is_single) =
        shared.work(py, |runner| (runner.particle_count(), matches!(runner, Runner::F32(..))))?;
    let count = points.map_or(count, <[usize]>::len);
    let rows = usize::try_from(frames).ok().and_then(|frames| frames.checked_add(1));
    let all = rows.and_then(|rows| rows.checked_mul(3 * count));
    let what = format!("a trajectory of {frames} frames of {count} particles");
    let mut numbers = match is_single {
        true => Numbers::F32(room(&what, all)?),
        false => Numbers::F64(room(&what, all)?),
    };
    shared.work(py, |runner| keep(runner, points, &mut numbers))?;
    let (mut frame, mut left) = (0, every);
    while frame < frames {
        let done = shared.work(py, |runner| -> Result<(), Error> {
            let start = std::time::Instant::now();
            while frame < frames && start.elapsed() < crate::run::stepping::TURN {
                left = crate::run::stepping::turn(runner, left)?;
                if left == 0 {
                    keep(runner, points, &mut numbers);
                    (frame, left) = (frame + 1, every);
                }
            }
            Ok(())
        });
        done?.map_err(|error| core_error(py, error))?;
        py.check_signals()?;
    }
    numbers.frames(py, [rows.unwrap_or_default(), count, 3])
}

/// Writes the positions to an array of (n, 3).
pub fn copy_positions(py: Python<'_>, shared: &Shared, out: &Bound<'_, PyAny>) -> PyResult<()> {
    let must = "it must be a writable, contiguous array of (n, 3) of float32 or float64";
    if let Ok(out) = out.cast::<PyArray2<f32>>() {
        return fill(py, shared, out, |[x, y, z]| [x as f32, y as f32, z as f32]);
    }
    if let Ok(out) = out.cast::<PyArray2<f64>>() {
        return fill(py, shared, out, |numbers| numbers);
    }
    Err(refused(py, format!("out is of type {}; {must}", out.get_type().name()?)))
}

fn fill<T: Element + Copy + Send>(
    py: Python<'_>,
    shared: &Shared,
    out: &Bound<'_, PyArray2<T>>,
    of: impl Fn([f64; 3]) -> [T; 3] + Sync + Send,
) -> PyResult<()> {
    let wrong = |reason: String| refused(py, format!("out {reason}"));
    let shape = [out.shape()[0], out.shape()[1]];
    if !out.is_c_contiguous() {
        return Err(wrong("must be contiguous in the order of C".into()));
    }
    let writable =
        out.try_readwrite().map_err(|error| wrong(format!("cannot be written: {error}")));
    let mut writable = writable?;
    let slice = writable.as_slice_mut().map_err(|_| wrong("must be contiguous".into()))?;
    let done = shared.work(py, |runner| {
        let count = runner.particle_count();
        if shape != [count, 3] {
            return Err(format!("has the shape {shape:?}; it must be [{count}, 3]"));
        }
        let mut rows = slice.as_chunks_mut::<3>().0.iter_mut();
        on!(&*runner, simulation => simulation.positions().for_each(|position| {
            if let Some(row) = rows.next() {
                *row = of(position.to_f64().to_array());
            }
        }));
        Ok(())
    })?;
    done.map_err(wrong)
}

/// Returns the total force of pins on some particles, newtons: minus the forces on those that are
/// pinned.
pub fn pin_force<'py>(
    py: Python<'py>,
    shared: &Shared,
    of: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let count = shared.work(py, |runner| runner.particle_count())?;
    let is_array = of.is_some_and(|of| {
        of.hasattr("dtype").unwrap_or(false) || of.is_instance_of::<pyo3::types::PyList>()
    });
    let listed = match of.filter(|_| is_array) {
        Some(of) => Some(arrays::particles("of", of, count)?),
        None => None,
    };
    let of = match of.filter(|_| !is_array) {
        Some(of) => of.extract()?,
        None => Of::All,
    };
    let force = shared.work(py, |runner| -> Result<DVec3, String> {
        let range = match select(runner, &of)? {
            Select::All => 0..count,
            Select::Body(body) => {
                on!(&*runner, simulation => simulation.model().bodies()[body].particles.clone())
            }
            Select::One(particle) => particle..particle.saturating_add(1),
            Select::Range(start, end) => start..end,
        };
        if count < range.end {
            return Err(format!("of names particles up to {}, but there are {count}", range.end));
        }
        let particles = listed.unwrap_or_else(|| range.collect());
        Ok(on!(&*runner, simulation => simulation.pin_force(particles)))
    })?;
    let force = force.map_err(|reason| refused(py, reason))?;
    Ok(PyArray1::from_slice(py, &force.to_array()).into_any())
}
