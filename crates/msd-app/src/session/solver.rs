//! What can a person choose of how the scene is stepped, and of what is told about it?

use crate::accuracy::Accuracy;
use crate::session::Session;
use msd_core::{Integrator, Settings};
use msd_lab::Precision;
use msd_lab::recording::Event;

impl Session {
    /// Changes the method.
    pub fn set_integrator(&mut self, integrator: Integrator) {
        self.set_settings(Settings { integrator, ..self.runner.settings() });
    }

    /// Changes the substeps per step.
    pub fn set_substeps(&mut self, substeps: u32) {
        self.set_settings(Settings { substeps, ..self.runner.settings() });
    }

    /// Changes the error that an adaptive method allows, as a fraction of the size of the scene.
    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.set_settings(Settings { tolerance, ..self.runner.settings() });
    }

    /// Changes the Newton iterations per substep of an implicit method.
    pub fn set_newton(&mut self, newton: u32) {
        self.set_settings(Settings { newton, ..self.runner.settings() });
    }

    fn set_settings(&mut self, settings: Settings) {
        self.refusal = self.runner.set_settings(settings).err().map(|error| error.to_string());
        if self.refusal.is_none() {
            self.note_event(Event::Settings(settings));
        }
        self.remeasure();
        self.touch();
    }

    /// Changes the precision; the state stays, rounded once.
    pub fn set_precision(&mut self, precision: Precision) {
        match self.runner.convert(precision) {
            Ok(runner) => {
                self.runner = runner;
                self.note_event(Event::Precision(precision));
            }
            Err(error) => self.refusal = Some(error.to_string()),
        }
        self.remeasure();
        self.touch();
    }

    /// Begins or ends to estimate the error; while it is off nothing is copied.
    pub fn set_estimating(&mut self, on: bool) {
        if on != self.accuracy.is_some() {
            self.accuracy = on.then(Accuracy::default);
        }
    }

    /// Energy that the integrator has added for good since a hand did something, joules; none if
    /// it added none.
    pub fn energy_gain(&self) -> Option<f64> {
        Some(self.witness.gain()).filter(|&gain| 0.0 < gain)
    }

    /// Forgets what was measured: it is of another state or of other settings.
    pub(crate) fn remeasure(&mut self) {
        self.witness.restart();
        if let Some(accuracy) = &mut self.accuracy {
            accuracy.restart();
        }
    }
}
