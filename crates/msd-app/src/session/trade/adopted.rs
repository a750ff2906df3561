//! The setting chosen last in the trade-off, and its trial from the current state.

use super::CALM;
use super::subject::{Now, subject_here};
use super::task::SoundnessTask;
use super::worker::Worker;
use msd_run::Runner;
use msd_study::choice::Choice;

/// A chosen setting, with or without a trial from the state of the run.
#[derive(Debug)]
pub(super) struct Adopted {
    /// Its changes, in words.
    pub text: String,
    pub choice: Choice,
    trial: Trial,
}

/// Progress of the trial from the state of the run.
#[derive(Debug)]
enum Trial {
    /// Made before the choice.
    Done,
    /// Waits for a time without another choice; wall-clock time so far, seconds.
    Waiting(f64),
    Begun(Worker<Option<String>>),
}

impl Adopted {
    pub(super) fn new(text: String, choice: Choice, is_tried: bool) -> Self {
        let trial = if is_tried { Trial::Done } else { Trial::Waiting(0.0) };
        Adopted { text, choice, trial }
    }

    /// Begins the trial once the choice stays the same; returns whether the trial is in progress.
    pub(super) fn refresh(
        &mut self,
        (runner, scene): (&Runner, Now<'_>),
        real: f64,
        paused: bool,
    ) -> bool {
        match &mut self.trial {
            Trial::Done => false,
            Trial::Waiting(age) => {
                *age += real.max(0.0);
                if CALM <= *age {
                    let scene = subject_here(runner, scene);
                    self.trial = scene.map_or(Trial::Done, |scene| {
                        Trial::Begun(Worker::start(SoundnessTask(scene, self.choice)))
                    });
                }
                false
            }
            Trial::Begun(worker) => {
                worker.set_paused(paused);
                !worker.report().idle
            }
        }
    }

    /// Returns why the run should not use the setting, from the trial, in words.
    pub(super) fn fault(&self) -> Option<String> {
        let Trial::Begun(worker) = &self.trial else { return None };
        let report = worker.report();
        report.failure.or_else(|| report.found.as_deref().cloned().flatten())
    }
}
