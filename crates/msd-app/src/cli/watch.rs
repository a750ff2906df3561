//! Does a run come near its limit of stability as it goes on?

use msd_core::stability::Estimator;
use msd_core::{Column, Explicit, Family};
use msd_lab::Runner;

/// The largest share of the work of a run that predictions may take.
const SHARE: f64 = 0.02;
/// What a prediction costs in evaluations of the forces: see `cargo bench --bench stability`.
const COST: f64 = 300.0;
/// What it costs besides where dampers couple motions, in springs evaluated.
const COUPLED_COST: f64 = 8e6;

/// Predicts the largest stable substep every so many steps, and notes the smallest.
#[derive(Debug)]
pub struct Watch {
    estimator: Estimator,
    every: u64,
    /// The smallest prediction yet, seconds, and the time of the run when it was made.
    pub least: (f64, f64),
}

impl Watch {
    /// Begins with the prediction for the start, seconds.
    pub fn new(runner: &Runner, stable: f64) -> Self {
        let settings = runner.settings();
        let stages = match settings.integrator.family() {
            Family::Explicit(Explicit::Rk4) => 4.0,
            _ => 1.0,
        };
        let uneven = msd_lab::on!(runner, simulation => {
            matches!(simulation.model().dampings(), Column::Each(_))
        });
        let coupled = if uneven { COUPLED_COST } else { 0.0 };
        let cost = COST + coupled / runner.spring_count().max(1) as f64;
        let every = (cost / (SHARE * stages * f64::from(settings.substeps))).ceil() as u64;
        Watch { estimator: Estimator::default(), every, least: (stable, runner.time()) }
    }

    /// Predicts if it is time to; what is known to be over the limit is not asked again.
    pub fn look(&mut self, runner: &Runner) {
        let (least, _) = self.least;
        let explicit = matches!(runner.integrator().family(), Family::Explicit(_));
        let over = least < runner.settings().substep();
        if !explicit || over || !runner.steps().is_multiple_of(self.every) {
            return;
        }
        let stable = runner.stable_substep_by(&mut self.estimator);
        if stable < least {
            self.least = (stable, runner.time());
        }
    }
}
