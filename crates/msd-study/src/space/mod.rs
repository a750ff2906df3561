//! The error of space: the effect of the spacing of the particles, beside the step and the
//! precision.
//!
//! A [`Space`] is the result: the scene was run at its own spacing a, at a/2 and a/4, each as good
//! as exact in time. Richardson's extrapolation (1911) gave the limit of the positions as the
//! spacing goes to zero. An [`ErrorBalance`] has the errors of space, time and precision side by
//! side, with their prices.

mod track;
mod limit;
mod halve;
mod balance;

pub use balance::{ErrorBalance, Share, balance};
pub use halve::{SpacePlan, known, space};
pub(crate) use halve::{halve, of_file};
pub use limit::Verdict;
pub(crate) use track::{Track, picked};

use crate::quantity::{estimate, rounded};
use serde::{Deserialize, Serialize};

/// Estimate of the error of space of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Space {
    /// Time simulated, seconds.
    pub duration: f64,
    /// Time up to which runs were compared, seconds: then the reference is not certain enough.
    pub compared: f64,
    /// Points that were compared: those that are particles at every spacing.
    pub points: usize,
    /// The spacings that were run, coarsest first: the scene's own, then finer ones.
    pub spacings: Vec<Spacing>,
    /// The conclusion.
    pub verdict: Verdict,
    /// Why no finer one was run, in words.
    pub stopped: String,
}

/// A scene at a part of its spacing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spacing {
    /// Parts that the spacing of the scene was cut into: 1, 2, 4.
    pub parts: u32,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Error of space, metres; none where no limit is known.
    pub error: Option<f64>,
    /// Time of the processor that the run took, seconds.
    pub seconds: f64,
}

impl Space {
    /// The error of space of the scene at its own spacing, metres; none where it is not known.
    pub fn error(&self) -> Option<f64> {
        match self.verdict {
            Verdict::Known { error, .. } | Verdict::Below { error } => Some(error),
            Verdict::Lost { .. } | Verdict::Untold => None,
        }
    }

    /// The estimate, in a sentence.
    pub fn words(&self) -> String {
        match self.verdict {
            Verdict::Known { error, band, order, is_seen, until } => {
                let order = if is_seen {
                    format!("of order {} as observed", rounded(order, 2))
                } else {
                    "if it is of order 2, which two spacings cannot tell".into()
                };
                let until = match until < self.duration - 1e-9 {
                    true => format!(
                        " up to t = {} s (after that {})",
                        rounded(until, 2),
                        match until < self.compared - 1e-9 {
                            true => "finer spacings do not approach one motion",
                            false => "the reference is not certain enough",
                        }
                    ),
                    false => String::new(),
                };
                let (error, band) = (estimate(error, "m"), estimate(band, "m"));
                format!("the error of space is {error}{until}, give or take {band}, {order}")
            }
            Verdict::Below { error } => {
                format!("the error of space is below {}", estimate(error, "m"))
            }
            Verdict::Lost { order } => format!(
                "the error of space cannot be told: finer spacings do not approach one motion (an \
                 order of {}), as in a chaotic fall; a shorter --duration may tell",
                rounded(order, 2)
            ),
            Verdict::Untold => format!("the error of space is not known: {}", self.stopped),
        }
    }
}
