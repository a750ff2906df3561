//! Equidistant moments of a run, as the nearest steps.

use crate::cli::failure::Failure;
use msd_core::Settings;
use msd_scene::plain;
use msd_study::quantity::quantity;

/// Largest number of moments of a run.
const MOST: f64 = 1e6;

/// Times from the start of a run at equal intervals, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// The first one.
    pub from: f64,
    /// End of the interval; a moment if one falls on it.
    pub to: f64,
    /// Time from one to the next; positive.
    pub every: f64,
}

impl Moments {
    /// Returns the step number of each moment, ascending, and whether a moment falls between steps.
    /// `option` is the option that set them.
    ///
    /// # Errors
    /// Moments are closer than steps, or too many.
    pub fn steps(&self, settings: Settings, option: &str) -> Result<(Vec<u64>, bool), Failure> {
        let Moments { from, to, every } = *self;
        let step = settings.step;
        // Slightly more: rounding may leave quotients of equal times below a whole number.
        let last = ((to - from) / every + 1e-6).floor();
        if MOST <= last {
            let most = plain(MOST);
            return Err(Failure::input(format!("{option}: at most {most} moments per file")));
        }
        let exact = |moment: u64| (from + moment as f64 * every) / step;
        let moments = 0..=last as u64;
        let steps: Vec<u64> = moments.clone().map(|moment| exact(moment).round() as u64).collect();
        if steps.windows(2).any(|pair| pair[0] == pair[1]) {
            let (every, step) = (quantity(every, "s"), quantity(step, "s"));
            return Err(Failure::input(format!(
                "{option}: {every} is less than a step of the run, {step}; use a shorter --step"
            )));
        }
        let is_between = moments.zip(&steps).any(|(moment, &step)| {
            // Rounding of the quotient stays far below a millionth of a step.
            1e-6 < (exact(moment) - step as f64).abs()
        });
        Ok((steps, is_between))
    }

    /// Returns the warning for moments between steps.
    pub fn warning(settings: Settings, option: &str) -> String {
        let step = quantity(settings.step, "s");
        format!(
            "{option}: not all moments are at the end of a step of {step}; the nearest are taken"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(from: f64, to: f64, every: f64) -> Result<(Vec<u64>, bool), String> {
        let steps = Moments { from, to, every }.steps(Settings::default(), "--every");
        steps.map_err(|failure| failure.message)
    }

    #[test]
    fn moments_are_at_the_nearest_steps_with_both_ends() {
        assert_eq!(steps(0.0, 0.1, 1.0 / 30.0), Ok((vec![0, 2, 4, 6], false)));
        assert_eq!(steps(1.0, 1.0, 1.0 / 30.0), Ok((vec![60], false)));
        // 24 per second: 2.5 steps apart.
        assert_eq!(steps(0.0, 0.2, 1.0 / 24.0), Ok((vec![0, 3, 5, 8, 10], true)));
        assert_eq!(steps(0.0, 10.0, 1.0 / 30.0).map(|steps| steps.0.len()), Ok(301));
    }

    #[test]
    fn moments_closer_than_steps_and_too_many_are_refused() {
        let told = steps(0.0, 1.0, 1e-3).expect_err("a refusal");
        assert!(told.contains("1 ms is less than a step of the run, 16.67 ms"), "{told}");
        assert!(steps(0.0, 1e9, 1e-3).expect_err("a refusal").contains("at most"));
    }
}
