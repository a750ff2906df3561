//! What can be read of a session?

use crate::accuracy::Accuracy;
use crate::clock::Pace;
use crate::edits::Shown;
use crate::session::{Failure, Session};
use crate::trace::Trace;
use msd_core::{Energy, Select};
use msd_run::Runner;
use msd_scene::Loaded;

impl Session {
    /// The scene as it was loaded.
    pub fn loaded(&self) -> &Loaded {
        &self.loaded
    }

    /// The simulation.
    pub fn runner(&self) -> &Runner {
        &self.runner
    }

    /// Whether no steps are taken.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Why the run stopped by itself.
    pub fn failure(&self) -> Option<&Failure> {
        self.failure.as_ref()
    }

    /// What was refused last.
    pub fn refusal(&self) -> Option<&str> {
        self.refusal.as_deref()
    }

    /// How fast simulated time should run, 1 for real time.
    pub fn speed(&self) -> f64 {
        self.clock.speed()
    }

    /// Averages over the last frames; all 0 while paused.
    pub fn pace(&self) -> Pace {
        if self.paused { Pace::default() } else { self.clock.pace() }
    }

    /// Simulated time, seconds.
    pub fn time(&self) -> f64 {
        self.runner.time()
    }

    /// How many steps can be taken back.
    pub fn steps_back(&self) -> usize {
        self.history.len()
    }

    /// Where the energy is.
    pub fn energy(&self) -> Energy {
        self.runner.energy()
    }

    /// The energy of the last seconds.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    /// The substep as a share of the largest stable one, if that was predicted.
    pub fn margin(&self) -> Option<f64> {
        self.margin.share(self.runner.settings().substep())
    }

    /// The estimate of the error, while one is asked for.
    pub fn accuracy(&self) -> Option<&Accuracy> {
        self.accuracy.as_ref()
    }

    /// The springs and particles that sliders act on.
    pub fn select(&self) -> Select {
        self.shown.select
    }

    /// What the sliders show.
    pub fn shown(&self) -> &Shown {
        &self.shown
    }

    /// The particle held by the mouse.
    pub fn held(&self) -> Option<usize> {
        self.hold.as_ref().map(|hold| hold.particle)
    }

    /// The particle that buttons and keys act on.
    pub fn selected(&self) -> Option<usize> {
        self.selected
    }
}
