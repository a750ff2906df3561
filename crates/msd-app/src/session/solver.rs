//! Solver settings that the user changes while a scene runs.

use super::Session;
use msd_core::{Error, Integrator, Settings};
use msd_run::Runner;
use msd_run::recording::Event;
use msd_scene::{Loaded, Precision};

/// The most substeps that can be chosen.
pub const MOST_SUBSTEPS: u32 = 1000;

/// A change of how the scene is stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tuning {
    /// The method.
    Integrator(Integrator),
    /// Substeps per step; they are automatic no longer.
    Substeps(u32),
    /// Whether the substeps are chosen from the predicted limit of stability.
    Automatic(bool),
    /// The error that an adaptive method allows, as a fraction of the size of the scene.
    Tolerance(f64),
    /// Newton iterations per substep of an implicit method.
    Newton(u32),
    /// The precision; the state stays, rounded once.
    Precision(Precision),
}

impl Tuning {
    /// What it changes, in a word or two.
    pub fn words(self) -> &'static str {
        match self {
            Tuning::Integrator(_) => "method",
            Tuning::Substeps(_) => "substeps",
            Tuning::Automatic(_) => "automatic substeps",
            Tuning::Tolerance(_) => "tolerance",
            Tuning::Newton(_) => "Newton iterations",
            Tuning::Precision(_) => "precision",
        }
    }

    /// Whether a run is stepped like that already.
    pub(super) fn is_set(self, runner: &Runner) -> bool {
        let now = runner.settings();
        match self {
            Tuning::Integrator(integrator) => now.integrator == integrator,
            Tuning::Substeps(substeps) => now.substeps == substeps && !runner.is_automatic(),
            Tuning::Automatic(automatic) => runner.is_automatic() == automatic,
            Tuning::Tolerance(tolerance) => now.tolerance == tolerance,
            Tuning::Newton(newton) => now.newton == newton,
            Tuning::Precision(precision) => runner.precision() == precision,
        }
    }

    /// Applies the change to a run; returns what a recording notes of it.
    pub(super) fn apply(self, runner: &mut Runner) -> Result<Event, Error> {
        let now = runner.settings();
        let settings = match self {
            Tuning::Integrator(integrator) => Settings { integrator, ..now },
            Tuning::Substeps(substeps) => {
                runner.set_automatic(false)?;
                Settings { substeps, ..now }
            }
            Tuning::Automatic(automatic) => {
                runner.set_automatic(automatic)?;
                return Ok(Event::Settings(runner.settings()));
            }
            Tuning::Tolerance(tolerance) => Settings { tolerance, ..now },
            Tuning::Newton(newton) => Settings { newton, ..now },
            Tuning::Precision(precision) => {
                *runner = runner.convert(precision)?;
                return Ok(Event::Precision(precision));
            }
        };
        runner.set_settings(settings)?;
        Ok(Event::Settings(runner.settings()))
    }
}

/// How a scene is stepped. Automatic substeps follow from the state, and are no part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solver {
    settings: Settings,
    precision: Precision,
    is_automatic: bool,
}

impl Solver {
    fn new(settings: Settings, precision: Precision, is_automatic: bool) -> Self {
        let substeps = if is_automatic { 0 } else { settings.substeps };
        Solver { settings: Settings { substeps, ..settings }, precision, is_automatic }
    }

    /// That of a run.
    pub fn of(runner: &Runner) -> Self {
        Solver::new(runner.settings(), runner.precision(), runner.is_automatic())
    }

    /// That which the author of a scene wants.
    pub fn written(loaded: &Loaded) -> Self {
        Solver::new(loaded.settings, loaded.precision, loaded.automatic)
    }
}

/// Automatic substeps of the run.
impl Session {
    /// Goes on with the choice of automatic substeps; returns whether the next step can be taken.
    pub(super) fn prepare(&mut self, stopwatch: &impl Fn() -> f64) -> bool {
        let (settings, revision) = (self.runner().settings(), self.run.revision());
        let prepared = self.run.prepare(&mut self.estimator, stopwatch);
        self.energy.carry_over(revision, &self.run);
        // Of a state that one looks back to they are recorded when the run goes on from there.
        if self.timeline.ahead() == 0 {
            self.note_renewal(settings);
        }
        prepared.unwrap_or_else(|error| {
            self.refusal = Some(error.to_string());
            true
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn automatic_substeps_are_no_difference_and_fixed_ones_are() {
        let cube = msd_scene::open("cube").expect("a built-in scene");
        let loaded = Loaded { automatic: true, ..cube };
        let mut runner = Runner::open(&loaded).expect("a valid scene");
        assert_eq!(Solver::of(&runner), Solver::written(&loaded));
        let substeps = runner.settings().substeps;
        Tuning::Substeps(substeps).apply(&mut runner).expect("in its domain");
        assert_ne!(Solver::of(&runner), Solver::written(&loaded));
        let fixed = Solver::of(&runner);
        Tuning::Substeps(substeps + 1).apply(&mut runner).expect("in its domain");
        assert_ne!(Solver::of(&runner), fixed);
    }
}
