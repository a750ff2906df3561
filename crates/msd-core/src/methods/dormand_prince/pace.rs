//! Step-size control: the length of the next substep, from the error of the last one.
//!
//! Only + − × ÷ and the square root are used, so that every machine takes the same substeps.

use crate::number::Real;

/// The length tried, as a fraction of the one that would just meet the tolerance.
const SAFETY: f64 = 0.9;
/// A substep is at least this fraction of the one before it, and at most the reciprocal.
const SHRINK: f64 = 0.2;
/// A substep shorter than this fraction of the step will not get there.
const SHORTEST: f64 = 1e-12;
/// More attempts than this in one step will not get there: a step of a thousand particles would
/// take minutes before it said so.
const MOST_ATTEMPTS: u32 = 100_000;

/// The length of the next substep.
///
/// With e the error as a fraction of the tolerance, and e' that of the substep before it, a substep
/// grows by 0.9 e^(−3/20) e'^(3/40). This proportional and integral control avoids the rejections
/// of the plain rule 0.9 e^(−1/5); that rule follows a rejection. Source: Gustafsson (1991), ACM
/// Trans. Math. Softw. 17, 533-554; Hairer, Nørsett and Wanner (1993), section II.4 and Hairer and
/// Wanner (1996), section IV.2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    length: f64,
    step: f64,
    /// Fifth root of the error of the last accepted substep.
    before: f64,
    rejected: bool,
    attempts: u32,
}

impl Pace {
    pub(crate) fn new(length: f64, step: f64) -> Self {
        Pace { length, step, before: 1.0, rejected: false, attempts: 0 }
    }

    /// The length to try when `left` seconds of the step are left. They are halved where one
    /// substep does not reach the end and a second would be cut short.
    pub(crate) fn attempt(&mut self, left: f64) -> f64 {
        self.attempts += 1;
        if left <= self.length {
            left
        } else if left < 2.0 * self.length {
            0.5 * left
        } else {
            self.length
        }
    }

    /// The same for substeps that must not be longer than `most`. A substep that would leave but
    /// rounding takes that too, as a substep as short as that has no error to go by.
    pub(crate) fn attempt_within(&mut self, left: f64, most: f64) -> f64 {
        let length = Real::min(self.attempt(left), most);
        if left - length < SHORTEST * self.step { left } else { length }
    }

    /// Notes an accepted substep of `length` and its error.
    pub(crate) fn accept(&mut self, length: f64, error: f64) {
        let root = fifth_root(error);
        let growth = SAFETY * power_three_eighths(self.before)
            / (Real::sqrt(root) * Real::sqrt(Real::sqrt(root)));
        let most = if self.rejected { 1.0 } else { 1.0 / SHRINK };
        self.length = length * Real::min(Real::max(growth, SHRINK), most);
        self.before = root;
        self.rejected = false;
    }

    /// Notes a rejected attempt of `length`; a NaN or infinite error shrinks most.
    pub(crate) fn reject(&mut self, length: f64, error: f64) {
        let shrink = if error.is_finite() { SAFETY / fifth_root(error) } else { SHRINK };
        self.length = length * Real::max(shrink, SHRINK);
        self.rejected = true;
    }

    /// Whether the tolerance is out of reach.
    pub(crate) fn is_hopeless(&self) -> bool {
        self.length < SHORTEST * self.step || MOST_ATTEMPTS <= self.attempts
    }
}

/// x^(1/5) for x from 1e-10 to 1e10; a number outside is taken to the nearer end.
///
/// Newton's iteration on y⁵ = x from x^(3/16), which is within a third of it.
pub(crate) fn fifth_root(x: f64) -> f64 {
    let x = Real::min(Real::max(x, 1e-10), 1e10);
    let root = Real::sqrt(x);
    let mut y = Real::sqrt(Real::sqrt(root * Real::sqrt(root)));
    for _ in 0..6 {
        let square = y * y;
        y = (4.0 * y + x / (square * square)) / 5.0;
    }
    y
}

fn power_three_eighths(x: f64) -> f64 {
    let quarter = Real::sqrt(Real::sqrt(x));
    quarter * Real::sqrt(quarter)
}

#[cfg(test)]
mod tests {
    use super::fifth_root;

    #[test]
    fn the_fifth_root_is_right_to_rounding() {
        for exponent in -100..=100 {
            let exact = 1.25f64.powi(exponent);
            // Newton's last correction is below rounding; a few operations round.
            let found = fifth_root(exact);
            assert!((found.powi(5) / exact - 1.0).abs() < 1e-14, "{exact}: {found}");
        }
    }
}
