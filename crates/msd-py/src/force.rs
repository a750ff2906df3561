//! Forces that a callable of Python returns.

use crate::arrays;
use crate::errors::refused;
use msd_core::elements::{Element, Motion, Vectors};
use msd_core::glam::DVec3;
use msd_core::{Real, Vector};
use numpy::{PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::cell::{Cell, RefCell};

thread_local! {
    /// What a callable raised in the evaluation that goes on in this thread.
    static RAISED: RefCell<Option<PyErr>> = const { RefCell::new(None) };
    /// Whether a callable is asked in this thread.
    static ASKED: Cell<bool> = const { Cell::new(false) };
}

/// What a callable raised in this thread since this was last asked.
pub fn take_raised() -> Option<PyErr> {
    RAISED.with_borrow_mut(Option::take)
}

/// Whether this thread runs a callable that is a force.
pub fn is_asked() -> bool {
    ASKED.get()
}

/// A force that is a callable: (time, positions, velocities) to newtons, an array of (n, 3).
#[derive(Debug)]
pub struct Force(pub Py<PyAny>);

impl Force {
    /// The forces at a motion.
    fn ask<R: Real>(&self, py: Python<'_>, motion: &Motion<'_, R>) -> PyResult<Vec<[f64; 3]>> {
        let count = motion.particle_count();
        let x = arrays::vectors(py, flat::<R>(motion.positions(), count))?;
        let v = arrays::vectors(py, flat::<R>(motion.velocities(), count))?;
        let before = ASKED.replace(true);
        let answer = self.0.call1(py, (motion.time(), x, v));
        ASKED.set(before);
        let answer = answer?;
        // The usual answer needs no conversion.
        if let Ok(array) = answer.bind(py).cast::<PyArray2<f64>>()
            && array.shape() == [count, 3]
            && array.is_c_contiguous()
            && let Ok(array) = array.try_readonly()
            && let Ok(numbers) = array.as_slice()
        {
            return Ok(numbers.as_chunks::<3>().0.to_vec());
        }
        if answer.is_none(py) {
            let message = format!("the force returned None; it must return ({count}, 3) newtons");
            return Err(refused(py, message));
        }
        arrays::rows("what the force returned", answer.bind(py), Some(count))
    }
}

impl<R: Real> Element<R> for Force {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let has_failed = RAISED.with_borrow(Option::is_some);
        let asked = (!has_failed).then(|| Python::attach(|py| self.ask(py, motion)));
        let answer = match asked {
            Some(Ok(answer)) => answer,
            failed => {
                if let Some(Err(raised)) = failed {
                    RAISED.set(Some(raised));
                }
                // NaN makes the core refuse the step, which keeps the state.
                if 0 < motion.particle_count() {
                    forces.add(0, R::Vec3::of(DVec3::NAN));
                }
                return 0.0;
            }
        };
        let (mut power, mut particle) = (0.0, 0);
        // Not `zip`: what is nested is walked faster from inside.
        motion.velocities().for_each(|velocity| {
            let force = DVec3::from_array(answer[particle]);
            forces.add(particle, R::Vec3::of(force));
            power -= force.dot(velocity.to_f64());
            particle += 1;
        });
        power
    }
}

/// The components of vectors in double precision.
fn flat<R: Real>(vectors: impl Iterator<Item = R::Vec3>, count: usize) -> Vec<f64> {
    let mut numbers = Vec::with_capacity(3 * count);
    vectors.for_each(|vector| numbers.extend_from_slice(&vector.to_f64().to_array()));
    numbers
}
