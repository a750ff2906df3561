//! Choices for a scene: a method, how finely it steps, and in which precision.

use msd_core::{Integrator, Settings};
use msd_scene::Precision;
use serde::{Deserialize, Serialize};

/// Length of a frame, seconds: every choice ends a step at every frame.
pub const FRAME: f64 = 1.0 / 60.0;

/// A way to step a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// The method.
    pub integrator: Integrator,
    /// Its substeps or its tolerance.
    pub fineness: Fineness,
    /// The precision.
    pub precision: Precision,
}

/// Substeps or tolerance of a method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fineness {
    /// Substeps per frame of 1/60 s.
    Substeps(u32),
    /// Local error per substep of an adaptive method, as a fraction of the size of the scene.
    Tolerance(f64),
}

impl Choice {
    /// The settings of a run: one step per frame.
    pub fn settings(&self) -> Settings {
        let default = Settings { integrator: self.integrator, step: FRAME, ..Settings::default() };
        match self.fineness {
            Fineness::Substeps(substeps) => Settings { substeps, ..default },
            Fineness::Tolerance(tolerance) => Settings { tolerance, substeps: 1, ..default },
        }
    }

    /// The choice that settings stand for, with its substep brought to a whole fraction of a frame.
    pub fn of(settings: Settings, precision: Precision) -> Self {
        let integrator = settings.integrator;
        let fineness = if integrator.is_adaptive() {
            Fineness::Tolerance(settings.tolerance)
        } else {
            Fineness::Substeps((FRAME / settings.substep()).round().max(1.0) as u32)
        };
        Choice { integrator, fineness, precision }
    }

    /// Its substeps or tolerance, in words: `8 substeps` or `tolerance 1e-5`.
    pub fn fineness(&self) -> String {
        match self.fineness {
            Fineness::Substeps(1) => "1 substep".into(),
            Fineness::Substeps(substeps) => format!("{substeps} substeps"),
            Fineness::Tolerance(tolerance) => format!("tolerance {}", rounded(tolerance)),
        }
    }
}

/// A number with at most three digits.
fn rounded(number: f64) -> String {
    let digits = format!("{number:.2e}");
    match digits.split_once('e') {
        Some((digits, power)) => {
            format!("{}e{power}", digits.trim_end_matches('0').trim_end_matches('.'))
        }
        None => digits,
    }
}

impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {}, {}", self.integrator, self.fineness(), self.precision)
    }
}
