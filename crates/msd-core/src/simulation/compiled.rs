//! The functions with the loops of a simulation, compiled in this crate for either precision.
//!
//! A generic function is compiled in the crate that calls it. In a debug build of a caller's own,
//! without optimisation, these would be some two hundred times as slow. The two tables below are
//! not generic, so the functions that they point to are compiled here.

use super::{Progress, Simulation};
use crate::energy::Energy;
use crate::error::Error;
use crate::methods::{Integrator, Settings};
use crate::number::{Real, of_type};
use crate::scene::Scene;
use crate::stability::Estimator;
use crate::system::Columns;
use alloc::borrow::Cow;
use alloc::vec::Vec;

/// A force on each particle, newtons, and the power dissipated, watts.
type Forces<R> = (Vec<<R as Real>::Vec3>, f64);

/// The bodies of [`Simulation::new`], [`Simulation::resume`], of a step, of two predictions, of the
/// energy and of the forces in a state, and what moves particles out of obstacles.
pub(super) struct Compiled<R: Real> {
    pub(super) start: fn(Cow<'_, Scene>, Settings) -> Result<Simulation<R>, Error>,
    pub(super) resume: fn(&Scene, &Progress) -> Result<Simulation<R>, Error>,
    pub(super) step: fn(&mut Simulation<R>, bool) -> Result<bool, Error>,
    pub(super) leave_obstacles: fn(&mut Simulation<R>),
    pub(super) predict: fn(&Simulation<R>, &mut Estimator) -> f64,
    pub(super) predict_on: fn(&Simulation<R>, Integrator, u32, &mut Estimator) -> Option<f64>,
    pub(super) measure: fn(&Simulation<R>) -> (Energy, f64),
    pub(super) forces: fn(&Simulation<R>, &Columns<R>) -> Forces<R>,
}

// Not statics: see `system/kinds.rs`.
#[inline(never)]
fn single() -> &'static Compiled<f32> {
    const { &Compiled::new() }
}

#[inline(never)]
fn double() -> &'static Compiled<f64> {
    const { &Compiled::new() }
}

impl<R: Real> Compiled<R> {
    const fn new() -> Self {
        Compiled {
            start: Simulation::start,
            resume: Simulation::resume_from,
            step: Simulation::step_or_refuse,
            leave_obstacles: Simulation::leave_obstacles,
            predict: Simulation::predict,
            predict_on: Simulation::predict_on,
            measure: Simulation::measure,
            forces: Simulation::forces_in,
        }
    }

    /// The functions for a precision.
    pub(super) fn of_precision() -> &'static Self {
        of_type(single(), double())
    }
}
