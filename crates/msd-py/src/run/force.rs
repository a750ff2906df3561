//! Forces that a callable of Python returns.

use crate::arrays::{self, flat};
use crate::errors::refused;
use msd_core::elements::{Element, Motion, Vectors};
use msd_core::glam::DVec3;
use msd_core::{Real, Vector};
use numpy::{PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::cell::{Cell, RefCell};
use std::sync::{Arc, Mutex, PoisonError};

thread_local! {
    /// The exception of a callable in the current evaluation of this thread.
    static RAISED: RefCell<Option<PyErr>> = const { RefCell::new(None) };
    /// Set while this thread runs a callable.
    static ASKED: Cell<bool> = const { Cell::new(false) };
}

/// Takes the exception of a callable in this thread.
pub fn take_raised() -> Option<PyErr> {
    RAISED.with_borrow_mut(Option::take)
}

/// Returns whether this thread runs a callable that is a force.
pub fn is_asked() -> bool {
    ASKED.get()
}

/// A callable: (time, positions, velocities) to newtons, an array of (n, 3). Its runs share it, and
/// the garbage collector takes it from a run that only it refers to.
pub type Callable = Arc<Mutex<Option<Py<PyAny>>>>;

/// Returns whether one run alone has a callable, besides its force. One that copies share belongs
/// to none.
pub fn is_own(callable: &Callable) -> bool {
    Arc::strong_count(callable) == 2
}

/// The force of a callable.
#[derive(Debug)]
pub struct Force(pub Callable);

impl Force {
    /// Adds the forces at a motion; returns the power that they take from it, watts.
    fn ask<R: Real>(
        &self,
        py: Python<'_>,
        motion: &Motion<'_, R>,
        forces: &mut Vectors<'_, R>,
    ) -> PyResult<f64> {
        let count = motion.particle_count();
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let callable = kept.as_ref().map(|callable| callable.clone_ref(py));
        drop(kept);
        let gone = || refused(py, "the garbage collector took the force of this run");
        let callable = callable.ok_or_else(gone)?;
        let x = arrays::vectors(py, flat(motion.positions().map(Vector::to_f64), count))?;
        let v = arrays::vectors(py, flat(motion.velocities().map(Vector::to_f64), count))?;
        let before = ASKED.replace(true);
        let answer = callable.call1(py, (motion.time(), x, v));
        ASKED.set(before);
        let answer = answer?;
        // The usual answer needs no conversion.
        if let Ok(array) = answer.bind(py).cast::<PyArray2<f64>>()
            && array.shape() == [count, 3]
            && array.is_c_contiguous()
            && let Ok(array) = array.try_readonly()
            && let Ok(numbers) = array.as_slice()
        {
            return add(py, numbers.as_chunks().0, motion, forces);
        }
        if answer.is_none(py) {
            let message = format!("the force returned None; it must return ({count}, 3) newtons");
            return Err(refused(py, message));
        }
        let rows = arrays::rows("what the force returned", answer.bind(py), Some(count))?;
        add(py, &rows, motion, forces)
    }
}

/// Adds the force on each particle; returns the power that they take, watts.
///
/// # Errors
/// SceneError, if a force is not finite though the motion is.
fn add<R: Real>(
    py: Python<'_>,
    rows: &[[f64; 3]],
    motion: &Motion<'_, R>,
    forces: &mut Vectors<'_, R>,
) -> PyResult<f64> {
    let (mut power, mut particle) = (0.0, 0);
    // Not `zip`: what is nested is walked faster from inside.
    motion.velocities().for_each(|velocity| {
        let force = DVec3::from_array(rows[particle]);
        forces.add(particle, R::Vec3::of(force));
        power -= force.dot(velocity.to_f64());
        particle += 1;
    });
    // A sum with a number that is not finite is not finite.
    if power.is_finite() || is_wild(motion) {
        return Ok(power);
    }
    let numbers = rows.as_flattened();
    match numbers.iter().position(|number| !number.is_finite()) {
        Some(at) => Err(refused(
            py,
            format!(
                "the force returned {} for particle {} at t = {:.6} s; it must be finite",
                numbers[at],
                at / 3,
                motion.time()
            ),
        )),
        None => Ok(power),
    }
}

/// Returns whether a motion is far outside the world, which the core reports at the end of the
/// step: no force can be blamed there.
fn is_wild<R: Real>(motion: &Motion<'_, R>) -> bool {
    const FAR: f64 = 1e30;
    let is_far = |vector: R::Vec3| {
        let vector = vector.to_f64();
        !vector.is_finite() || FAR < vector.abs().max_element()
    };
    motion.positions().any(is_far) || motion.velocities().any(is_far)
}

impl<R: Real> Element<R> for Force {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let has_failed = RAISED.with_borrow(Option::is_some);
        match (!has_failed).then(|| Python::attach(|py| self.ask(py, motion, forces))) {
            Some(Ok(power)) => power,
            failed => {
                if let Some(Err(raised)) = failed {
                    RAISED.set(Some(raised));
                }
                // NaN makes the core refuse the step, which keeps the state.
                if 0 < motion.particle_count() {
                    forces.add(0, R::Vec3::of(DVec3::NAN));
                }
                0.0
            }
        }
    }
}
