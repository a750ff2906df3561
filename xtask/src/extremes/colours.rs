//! The colours of the cells of a map.

use crate::extremes::outcome::{Outcome, Verdict};
use plotters::style::RGBColor;

/// Errors up to these have different colours, from the best; fractions of the amplitude.
pub(super) const LEVELS: [f64; 4] = [1e-6, 1e-4, 1e-2, 1e-1];

/// Blues from dark, accurate, to light.
const ACCURATE: [RGBColor; 4] = [
    RGBColor(8, 48, 107),
    RGBColor(33, 113, 181),
    RGBColor(107, 174, 214),
    RGBColor(198, 219, 239),
];

/// The colour of a shade of accuracy.
pub(super) fn shade(level: usize) -> RGBColor {
    ACCURATE[level.min(ACCURATE.len() - 1)]
}

/// The colour of an outcome other than accurate: those of Okabe and Ito (2008), which the
/// colour-blind can distinguish, and in order of lightness too.
pub(super) fn colour(outcome: Outcome) -> RGBColor {
    match outcome {
        Outcome::Accurate => shade(0),
        Outcome::Bounded => RGBColor(250, 238, 150),
        Outcome::Growing => RGBColor(230, 159, 0),
        Outcome::Diverged => RGBColor(190, 70, 0),
        Outcome::Unreachable => RGBColor(150, 150, 151),
        Outcome::Refused => RGBColor(222, 222, 223),
        Outcome::HiddenGain | Outcome::NotANumber | Outcome::Hang | Outcome::Panic => {
            RGBColor(0, 0, 0)
        }
    }
}

/// The colour of a cell.
pub(super) fn of(verdict: &Verdict) -> RGBColor {
    let Verdict { outcome: Outcome::Accurate, error: Some(error), .. } = verdict else {
        return colour(verdict.outcome);
    };
    shade(LEVELS.iter().position(|level| error <= level).unwrap_or(LEVELS.len()))
}
