//! Domains of the values of a scene file.

use crate::precision::Precision;
use std::ops::Bound::{self, Excluded, Included, Unbounded};
use std::ops::RangeBounds;

/// The values that a key may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// Positive.
    Positive,
    /// A mass: positive, and its reciprocal finite.
    Mass,
    /// The length of a step, seconds: its square must not vanish, however many substeps.
    Step,
    /// Steps per second.
    Rate,
    /// Not negative.
    NotNegative,
    /// Not negative, in single precision whatever that of the file.
    Factor,
    /// From 0 to 1.
    Fraction,
    /// Degrees above the horizon.
    Elevation,
    /// Any number.
    Finite,
    /// Positive and at most so much.
    UpTo(f64, &'static str),
    /// Whole and from 1 to so much.
    Count(u64, &'static str),
    /// Three numbers.
    Vector,
    /// Three numbers inside the world.
    Place,
    /// Three numbers that have a direction.
    Direction,
    /// A list of at least one.
    Filled,
    /// Any value of its form.
    Any,
    /// Any value of its form that is of a scene as these words say, which is checked where it is
    /// built.
    Words(&'static str),
}

/// A length that the world may have.
pub(crate) const LENGTH: Domain = Domain::UpTo(1e12, "positive and at most 1e12");
/// The longest step, seconds.
const LONGEST_STEP: f64 = 1e6;

impl Domain {
    /// The domain in words.
    pub fn words(self) -> &'static str {
        match self {
            Domain::Positive => "positive and finite",
            Domain::Mass => "positive and finite, from 3e-39 in f32 and from 6e-309 in f64",
            Domain::Step => {
                "positive and at most 1e6; a substep from 4e-23 in f32 and from 3e-162 in f64"
            }
            Domain::Rate => {
                "finite and from 1e-6; a substep from 4e-23 s in f32 and from 3e-162 s in f64"
            }
            Domain::NotNegative => "finite and not negative",
            Domain::Factor => "finite and not negative, at most 3.4e38",
            Domain::Fraction => "from 0 to 1",
            Domain::Elevation => "from -89 to 89",
            Domain::Finite => "finite",
            Domain::UpTo(_, words) | Domain::Count(_, words) | Domain::Words(words) => words,
            Domain::Vector => "three finite numbers",
            Domain::Place => "inside the world",
            Domain::Direction => "three finite numbers, not all zero; any length",
            Domain::Filled => "at least one",
            Domain::Any => "any value",
        }
    }

    /// The least and the most number in it, in a precision; of a vector, of each component.
    pub fn limits(self, precision: Precision) -> (Bound<f64>, Bound<f64>) {
        let is_single = precision == Precision::F32;
        let shortest_step = if is_single { 4e-23 } else { 3e-162 };
        match self {
            Domain::Positive => (Excluded(0.0), Unbounded),
            // Smaller ones have no finite reciprocal.
            Domain::Mass => (Included(if is_single { 3e-39 } else { 6e-309 }), Unbounded),
            Domain::Step => (Included(shortest_step), Included(LONGEST_STEP)),
            Domain::Rate => (Included(1.0 / LONGEST_STEP), Included(1.0 / shortest_step)),
            Domain::NotNegative => (Included(0.0), Unbounded),
            Domain::Factor => (Included(0.0), Included(f32::MAX.into())),
            Domain::Fraction => (Included(0.0), Included(1.0)),
            Domain::Elevation => (Included(-89.0), Included(89.0)),
            Domain::UpTo(most, _) => (Excluded(0.0), Included(most)),
            Domain::Count(most, _) => (Included(1.0), Included(most as f64)),
            _ => (Unbounded, Unbounded),
        }
    }

    /// Whether a number lies in it, in a precision; of a vector, whether each component may.
    pub(crate) fn holds(self, value: f64, precision: Precision) -> bool {
        value.is_finite() && self.limits(precision).contains(&value)
    }
}
