//! Where does a method blow up? Observed by bisection, beside the prediction.

use msd_core::Integrator;
use serde::{Deserialize, Serialize};

/// The largest stable substep of a method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// The method.
    pub integrator: Integrator,
    /// Predicted from the spectrum at the start, seconds.
    pub predicted: f64,
    /// Longest substep that stayed bounded, found by bisection, seconds; none where every one did.
    pub observed: Option<f64>,
}
