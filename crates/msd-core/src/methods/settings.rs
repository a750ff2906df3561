//! The settings of a step.

use super::Integrator;
use crate::error::Error;
use crate::number::Real;
use crate::scene::check::check;

/// The settings by which a system is stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
pub struct Settings {
    /// The method. Default velocity Verlet.
    pub integrator: Integrator,
    /// Length of a step, seconds. Default 1/60.
    pub step: f64,
    /// Substeps per step, at least 1. Default 8.
    /// Unused by adaptive methods.
    pub substeps: u32,
    /// Local error that an adaptive method allows per substep, as a fraction of the size of the
    /// scene, see [`crate::Model::size`]; positive, at most 1. Default 1e-6: near the limit of
    /// stability a looser one costs hardly less, and excites motions that dampers then dissipate.
    pub tolerance: f64,
    /// Newton iterations per substep of an implicit method, at least 1. Default 1, which is the
    /// linearised method.
    pub newton: u32,
}

/// The most Newton iterations of a substep: those that converge do so in about ten.
const MOST_NEWTON: u32 = 1000;

impl Default for Settings {
    fn default() -> Self {
        Settings {
            integrator: Integrator::default(),
            step: 1.0 / 60.0,
            substeps: 8,
            tolerance: 1e-6,
            newton: 1,
        }
    }
}

impl Settings {
    /// Length of a substep, seconds.
    pub fn substep(&self) -> f64 {
        self.step / f64::from(self.substeps)
    }

    pub(crate) fn check<R: Real>(&self) -> Result<(), Error> {
        let at = ("setting", 0);
        check(0 < self.substeps, "substeps", at, f64::from(self.substeps), "at least 1")?;
        let usable = (1..=MOST_NEWTON).contains(&self.newton);
        check(usable, "newton", at, f64::from(self.newton), "from 1 to 1000")?;
        let tolerance = self.tolerance;
        let usable = 0.0 < tolerance && tolerance <= 1.0;
        check(usable, "tolerance", at, tolerance, "positive and at most 1")?;
        // A substep that rounds to zero or whose square does would stop the clock silently.
        let h = R::of(self.substep());
        let usable =
            R::ZERO < h && R::ZERO < h * h && (R::ONE / h).to_f64().is_finite() && self.step <= 1e6;
        check(usable, "step", at, self.step, "positive, finite and at most 1e6 s")
    }
}
