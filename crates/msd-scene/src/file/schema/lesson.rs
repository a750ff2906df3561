//! Rows of a lesson: a question whose answer msd computes from the scene.

use crate::file::keys::{Domain, rows};
use serde::{Deserialize, Serialize};

/// A number that msd computes from a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// Frequency of the slowest motion that something resists, hertz.
    #[default]
    Frequency,
    /// Damping ratio of that motion.
    DampingRatio,
    /// The longest stable substep, seconds.
    StableSubstep,
    /// Kinetic, elastic and gravitational energy at the end of a run over that at its start.
    EnergyGrowth,
    /// Largest distance of a particle from its exact place at the end of a run, metres.
    Error,
    /// Factor by which twice as many substeps divide that error.
    ErrorRatio,
    /// Logarithm of that factor to base 2.
    Order,
    /// Distance by which the lowest point of the last body sinks in a run, metres.
    Sag,
    /// Limit of that distance as the last three bodies are refined (Aitken, 1926), metres.
    SagLimit,
    /// Friction of the first plane below which particles slide: the tangent of its slope.
    CriticalFriction,
    /// The sine of its slope.
    SlopeSine,
    /// Its slope, radians.
    Slope,
}

impl Answer {
    /// The symbol of its unit; empty for a number without one.
    pub fn unit(self) -> &'static str {
        match self {
            Answer::Frequency => "Hz",
            Answer::StableSubstep => "s",
            Answer::Error | Answer::Sag | Answer::SagLimit => "m",
            Answer::Slope => "rad",
            _ => "",
        }
    }
}

rows! {
    /// A lesson: a question whose answer msd computes from the scene with its current values.
    LessonRow {
        /// The question.
        question: String,
        /// Instructions, one after the other.
        steps: Vec<String> = "none" { domain: Domain::Words("list of texts") },
        /// Number that answers the question.
        answer: Answer,
        /// Duration of the run that gives the number.
        time: Option<f64> = "1" { unit: "s", domain: Domain::Positive },
        /// Accepted deviation, as a fraction of the answer.
        tolerance: f64 { domain: Domain::Fraction },
        /// Reason for this tolerance.
        reason: String,
        /// Explanation, shown with the right answer.
        theory: String,
        /// Wrong answers and what to say to them.
        mistakes: Vec<MistakeRow> = "none",
    }

    /// A wrong answer: `times` · number^`power` + `plus`.
    MistakeRow {
        /// The number.
        answer: Option<Answer> = "that of the lesson",
        /// Factor.
        times: Option<f64> = "1" { domain: Domain::Finite },
        /// Exponent.
        power: Option<f64> = "1" { domain: Domain::Finite },
        /// Summand.
        plus: Option<f64> = "0" { domain: Domain::Finite },
        /// What to say.
        says: String,
    }
}
