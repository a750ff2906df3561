//! Changes of the solver during a run.

use super::run::gpu_obstacle;
use super::{Deed, Session};
use msd_core::Error;
use msd_run::recording::Event;
use msd_scene::schema::{OrAuto, SolverRow};

/// Largest number of substeps.
pub const MOST_SUBSTEPS: u32 = 1000;

/// Returns the name of a change of the solver for undo, in a word or two: by its first key.
fn words(change: &SolverRow) -> &'static str {
    match *change {
        SolverRow { integrator: Some(_), .. } => "method",
        SolverRow { substeps: Some(OrAuto::Auto), .. } => "automatic substeps",
        SolverRow { substeps: Some(OrAuto::Given(_)), .. } => "substeps",
        SolverRow { tolerance: Some(_), .. } => "tolerance",
        SolverRow { newton: Some(_), .. } => "Newton iterations",
        _ => "precision",
    }
}

/// The solver of the run.
impl Session {
    /// Changes the solver; a change of precision rounds the state once.
    pub fn tune(&mut self, change: SolverRow) {
        self.tune_as(change, words(&change));
    }

    /// Does the same, with a name for undo.
    pub(in crate::session) fn tune_as(&mut self, change: SolverRow, words: &'static str) {
        let begins = self.remember(Deed::Solver(words));
        let before = self.runner().solver();
        let tuned = self.change(|runner| runner.set_solver(before.with(&change)));
        self.refusal = tuned.as_ref().err().map(Error::to_string);
        if tuned.is_err() {
            if begins {
                self.undo.withdraw();
            }
            return;
        }
        self.limit_of = self.runner().steps();
        let precision = self.runner().precision();
        if precision != before.precision {
            self.record(&Event::Precision(precision));
        }
        self.record(&Event::Settings(self.runner().settings()));
        self.restart_twin();
    }

    /// Continues the choice of automatic substeps; returns whether the next step can be taken.
    pub(super) fn prepare(&mut self, stopwatch: &impl Fn() -> f64) -> bool {
        let (settings, revision) = (self.runner().settings(), self.run.revision());
        let prepared = self.run.prepare(&mut self.estimator, stopwatch);
        self.energy.carry_over(revision, &self.run);
        // For an earlier state, they are recorded when the run resumes from there.
        if self.timeline.ahead() == 0 {
            self.note_renewal(settings);
        }
        prepared.unwrap_or_else(|error| {
            self.refusal = Some(error.to_string());
            true
        })
    }

    /// Returns whether the next step can be taken now: a device may still be computing it. Says why
    /// a device takes no more of them.
    pub(super) fn is_ready(&mut self) -> bool {
        let is_ready = self.run.is_ready();
        self.note_end_of_device();
        is_ready
    }

    /// Shows and records why a device takes no more steps.
    pub(super) fn note_end_of_device(&mut self) {
        if let Some(reason) = self.run.take_end_of_device() {
            self.record(&Event::Note(reason.clone()));
            self.refusal = Some(reason);
        }
    }

    /// Lets a graphics device take the steps to come, or the processor. Says why it cannot.
    pub fn set_device(&mut self, device: Option<msd_gpu::Device>) {
        let refused = self.run.set_device(device).err();
        self.refusal = refused.map(|error| error.to_string());
    }

    /// Lets the first graphics device take the steps to come once it is open, or the processor.
    pub fn use_gpu(&mut self, is_wanted: bool) {
        if !is_wanted {
            self.set_device(None);
        } else if let Some(device) = self.gpu.ask() {
            self.set_device(Some(device));
        }
    }

    /// Returns whether the graphics device is being opened, and uses it once it is.
    pub fn is_gpu_opening(&mut self) -> bool {
        match self.gpu.opened() {
            Some(Ok(device)) => self.set_device(Some(device)),
            Some(Err(reason)) => self.refusal = Some(reason),
            None => {}
        }
        self.gpu.is_opening()
    }

    /// Returns why no graphics device can take the steps, if that is known beforehand.
    pub fn gpu_obstacle(&self) -> Option<&'static str> {
        gpu_obstacle()
    }

    /// Returns the graphics device that takes the steps.
    pub fn device(&self) -> Option<&super::DeviceRun> {
        self.run.device()
    }
}
