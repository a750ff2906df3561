//! The slope of the error of a method against its fineness, as its trials show it.

use crate::candidates::choice::{Choice, Fineness};
use crate::candidates::ladder::Ladder;
use crate::measure::trial::Trial;

/// Whether a choice is the coarsest that a ladder allows.
pub(super) fn is_coarsest(choice: Choice, ladder: Ladder) -> bool {
    match choice.fineness {
        Fineness::Substeps(substeps) => Some(substeps) <= ladder.fewest,
        Fineness::Tolerance(tolerance) => 1e-2 <= tolerance,
    }
}

/// The error that the last trials of a ladder predict for a fineness, metres, by their order.
pub(super) fn predict(trials: &[Trial], fineness: Fineness, ladder: Ladder) -> Option<f64> {
    let last = trials.last().filter(|trial| trial.errors.is_some())?;
    let doublings = distance(last.choice.fineness, fineness);
    Some(last.error() * (-order(trials, ladder) * doublings).exp2())
}

/// Returns whether the last two trials were no better than one before them: rounding rules, or
/// contact. One alone may be bad luck: the moment of an impact within a substep decides.
pub(super) fn is_stuck(trials: &[Trial], wanted: f64) -> bool {
    let [earlier @ .., before, last] = trials else { return false };
    let best = earlier.iter().map(Trial::error).fold(f64::INFINITY, f64::min);
    let better = before.error().min(last.error());
    !earlier.is_empty() && best.is_finite() && wanted < better && 0.8 * best < better
}

/// Doublings of fineness from one to another.
pub(super) fn distance(from: Fineness, to: Fineness) -> f64 {
    match (from, to) {
        (Fineness::Substeps(a), Fineness::Substeps(b)) => (f64::from(b) / f64::from(a)).log2(),
        (Fineness::Tolerance(a), Fineness::Tolerance(b)) => (a / b).log2(),
        _ => 0.0,
    }
}

/// The order of convergence seen in the last two trials, or else that of the method.
pub(super) fn order(trials: &[Trial], ladder: Ladder) -> f64 {
    let nominal = match ladder.integrator.is_adaptive() {
        true => 1.0,
        false => f64::from(ladder.integrator.order()),
    };
    let [.., before, last] = trials else { return nominal };
    let doublings = distance(before.choice.fineness, last.choice.fineness);
    let seen = (before.error() / last.error()).log2() / doublings;
    if seen.is_finite() { seen.clamp(0.5, nominal + 1.0) } else { nominal }
}

/// A fineness that many times finer, and at least one substep more where it is finer at all.
pub(super) fn scaled(fineness: Fineness, finer: f64, ladder: Ladder) -> Fineness {
    match fineness {
        Fineness::Substeps(substeps) => {
            let fewest = ladder.fewest.unwrap_or(1);
            let scaled = (f64::from(substeps) * finer).min(1e6);
            // Finer means at least one more.
            let scaled = if 1.0 < finer { scaled.ceil() } else { scaled.floor() };
            Fineness::Substeps((scaled as u32).max(fewest))
        }
        Fineness::Tolerance(tolerance) => {
            Fineness::Tolerance((tolerance / finer).clamp(1e-13, 1e-1))
        }
    }
}
