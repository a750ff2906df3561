//! The functions with the loops of a simulation, compiled in this crate for either precision.
//!
//! A generic function is compiled in the crate that calls it. In a debug build of a caller's own,
//! without optimisation, these would be some two hundred times as slow. The two tables below are
//! not generic, so the functions that they point to are compiled here.

use super::Simulation;
use crate::energy::Energy;
use crate::error::Error;
use crate::methods::{Integrator, Settings};
use crate::number::{Real, of_type};
use crate::scene::Scene;
use crate::stability::Estimator;

/// The bodies of [`Simulation::new`], of a step, of two predictions and of the energy.
pub(super) struct Compiled<R: Real> {
    pub(super) start: fn(&Scene, Settings) -> Result<Simulation<R>, Error>,
    pub(super) step: fn(&mut Simulation<R>, bool) -> Result<bool, Error>,
    pub(super) predict: fn(&Simulation<R>, &mut Estimator) -> f64,
    pub(super) predict_on: fn(&Simulation<R>, Integrator, u32, &mut Estimator) -> Option<f64>,
    pub(super) measure: fn(&Simulation<R>) -> (Energy, f64),
}

static SINGLE: Compiled<f32> = Compiled::new();
static DOUBLE: Compiled<f64> = Compiled::new();

impl<R: Real> Compiled<R> {
    const fn new() -> Self {
        Compiled {
            start: Simulation::start,
            step: Simulation::step_or_refuse,
            predict: Simulation::predict,
            predict_on: Simulation::predict_on,
            measure: Simulation::measure,
        }
    }

    /// The functions for a precision.
    pub(super) fn of_precision() -> &'static Self {
        of_type(&SINGLE, &DOUBLE)
    }
}
