//! The stability light: the substep as a share of the longest stable one.

use msd_core::Integrator;
use msd_core::stability::Estimator;
use msd_run::Runner;

/// Shortest time between two predictions, seconds.
const REFRESH: f64 = 1.0;
/// The largest share of the wall clock that predictions may take.
const SHARE: f64 = 0.005;

/// The predicted longest stable substep, renewed at a bounded rate.
#[derive(Debug, Default)]
pub struct StabilityLight {
    /// Longest stable substep, seconds: 0 if none is, infinite if every one is; `None` before the
    /// first prediction.
    stable: Option<f64>,
    /// Wall-clock time since the last prediction, seconds.
    age: f64,
    /// What the last prediction cost, seconds.
    cost: f64,
    /// Whether something changed since.
    stale: bool,
    estimator: Estimator,
}

impl StabilityLight {
    /// Reports that a setting changed, so that the prediction should be renewed soon.
    pub fn touch(&mut self) {
        self.stale = true;
    }

    /// Lets `real` seconds of wall clock pass, and predicts again if it is time to.
    pub fn refresh(&mut self, runner: &Runner, real: f64, stopwatch: &impl Fn() -> f64) {
        if self.is_due(real) {
            let start = stopwatch();
            let stable = self.predict(runner);
            self.set(stable, stopwatch() - start);
        }
    }

    /// Predicts the longest stable substep of the present state, seconds. Only explicit methods
    /// have one: for the others the spectrum is not needed.
    pub fn predict(&mut self, runner: &Runner) -> f64 {
        if !Integrator::EXPLICIT.contains(&runner.integrator()) {
            return f64::INFINITY;
        }
        runner.stable_substep_by(&mut self.estimator)
    }

    /// The substep as a share of the longest stable one: 1 is the limit, infinite where no step is
    /// stable; `None` before the first prediction.
    pub fn share(&self, substep: f64) -> Option<f64> {
        self.stable.map(|stable| if stable == 0.0 { f64::INFINITY } else { substep / stable })
    }

    /// Lets wall-clock time pass and returns whether to predict now.
    fn is_due(&mut self, real: f64) -> bool {
        self.age += real.max(0.0);
        // A changed setting is answered at once where that is cheap, and never at the price of
        // the motion where it is not.
        let wait = if self.stale { 0.0 } else { REFRESH }.max(self.cost / SHARE);
        self.stable.is_none() || wait <= self.age
    }

    /// Stores a prediction and its cost in seconds.
    fn set(&mut self, stable: f64, cost: f64) {
        // What costs less than a millisecond may be renewed at every change.
        self.cost = if cost < 1e-3 { 0.0 } else { cost };
        (self.stable, self.age, self.stale) = (Some(stable), 0.0, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_answered_at_once_where_cheap() {
        let mut light = StabilityLight::default();
        assert!(light.is_due(0.0));
        light.set(0.01, 2e-4);
        assert!(!light.is_due(0.5));
        light.touch();
        assert!(light.is_due(0.0));
        assert_eq!(light.share(0.005), Some(0.5));
    }

    #[test]
    fn an_expensive_prediction_is_rare() {
        let mut light = StabilityLight::default();
        light.set(0.01, 0.1);
        light.touch();
        assert!(!light.is_due(10.0));
        assert!(light.is_due(10.0));
    }

    #[test]
    fn no_stable_step_is_infinitely_far_over_the_limit() {
        let mut light = StabilityLight::default();
        light.set(0.0, 0.0);
        assert_eq!(light.share(1e-9), Some(f64::INFINITY));
        light.set(f64::INFINITY, 0.0);
        assert_eq!(light.share(1.0), Some(0.0));
    }
}
