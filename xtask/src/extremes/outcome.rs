//! Outcomes of a run: right ones, reported ones, and those that must never be.

use serde::Serialize;

/// Outcome of a run, from good to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// Within a tenth of the answer.
    Accurate,
    /// Finite to the end, and without more energy than it had.
    Bounded,
    /// Finite to the end, with energy that the method added, which the witness saw.
    Growing,
    /// A method said that its tolerance is out of reach, or that it cannot solve for a step.
    Unreachable,
    /// Left the world; the run stopped and said so.
    Diverged,
    /// A number out of its domain, said before the first step.
    Refused,
    /// Failure: more energy at the end than at the start, and nobody said so.
    HiddenGain,
    /// Failure: a step succeeded, and its state or energy is NaN.
    NotANumber,
    /// Failure: not done when its time was up.
    Hang,
    /// Failure: a panic.
    Panic,
}

impl Outcome {
    /// Every outcome, from good to bad.
    pub const ALL: [Outcome; 10] = [
        Outcome::Accurate,
        Outcome::Bounded,
        Outcome::Growing,
        Outcome::Unreachable,
        Outcome::Diverged,
        Outcome::Refused,
        Outcome::HiddenGain,
        Outcome::NotANumber,
        Outcome::Hang,
        Outcome::Panic,
    ];

    /// Returns whether this must never be.
    pub fn is_failure(self) -> bool {
        Outcome::HiddenGain <= self
    }

    /// Returns whether the method kept the energy that it was given: it neither stopped nor gained.
    pub fn is_kept(self) -> bool {
        self <= Outcome::Bounded
    }

    /// Name for a reader.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Accurate => "accurate",
            Outcome::Bounded => "bounded",
            Outcome::Growing => "gains energy",
            Outcome::Unreachable => "tolerance out of reach",
            Outcome::Diverged => "diverged",
            Outcome::Refused => "refused",
            Outcome::HiddenGain => "GAINS ENERGY UNREPORTED",
            Outcome::NotANumber => "NOT A NUMBER",
            Outcome::Hang => "HANGS",
            Outcome::Panic => "PANICS",
        }
    }
}

/// Outcome of a run, and its error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The outcome.
    pub outcome: Outcome,
    /// The measure of the run, see its scene; none if it did not get to its end.
    pub error: Option<f64>,
    /// The message, where the run ended early.
    pub said: Option<String>,
}

impl Verdict {
    /// A run that ended early.
    pub fn ended(outcome: Outcome, said: String) -> Self {
        Verdict { outcome, error: None, said: Some(said) }
    }
}
