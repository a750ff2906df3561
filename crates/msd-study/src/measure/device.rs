//! Devices that take the steps of runs in place of the processor.

use msd_core::{Error, Integrator};
use msd_run::Runner;

/// A device that takes the steps of many runs at once, with the bits of the processor: a graphics
/// card, for example.
///
/// It measures neither the time of a single run, nor contacts, nor the energy that is dissipated or
/// supplied.
pub trait Device {
    /// Its name.
    fn name(&self) -> String;

    /// Returns whether it can step a run.
    fn takes(&self, runner: &Runner) -> bool;

    /// Prepares to step some runs together, all of one [`Pace`].
    ///
    /// # Errors
    /// The reason why it cannot step them.
    fn load(&mut self, runners: &[Runner]) -> Result<(), LoadError>;

    /// Advances the runs that were loaded last by so many steps; returns why some of them ended
    /// early, now or before. Those keep their last good state, as on the processor.
    ///
    /// # Errors
    /// The reason why the steps since the runs were loaded are not to be trusted, or are not
    /// complete.
    fn advance(&mut self, runners: &mut [Runner], steps: u64)
    -> Result<Vec<Option<Error>>, String>;

    /// Ends the checks of the steps of the runs that were loaded last.
    ///
    /// # Errors
    /// The reason why those steps are not to be trusted.
    fn finish(&mut self) -> Result<(), String>;
}

/// The reason why a device cannot step some runs, in words.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadError {
    /// They are too large for it; fewer may fit.
    TooLarge(String),
    /// It takes no more steps.
    Failed(String),
}

impl From<LoadError> for String {
    fn from(error: LoadError) -> Self {
        let (LoadError::TooLarge(why) | LoadError::Failed(why)) = error;
        why
    }
}

/// What the runs that step together on a device have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Their method.
    pub integrator: Integrator,
    /// Their substeps per step.
    pub substeps: u32,
    /// The length of a step, seconds.
    pub step: f64,
}

impl Pace {
    /// That of a run.
    pub fn of(runner: &Runner) -> Self {
        let settings = runner.settings();
        Pace { integrator: settings.integrator, substeps: settings.substeps, step: settings.step }
    }
}
