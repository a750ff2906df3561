//! The setting that the trade has chosen last, tried from the state that the run was in then.

use super::CALM;
use super::subject::{Now, subject_here};
use super::task::SoundnessTask;
use super::worker::Worker;
use msd_run::Runner;
use msd_study::choice::Choice;

/// A setting that was taken without being tried from the state of the run, or with.
#[derive(Debug)]
pub(super) struct Adopted {
    /// What it has changed, in words.
    pub text: String,
    pub choice: Choice,
    trial: Trial,
}

/// A trial from the state of the run.
#[derive(Debug)]
enum Trial {
    /// It was made before the setting was taken.
    Done,
    /// It waits until nothing else was chosen for so many seconds of wall clock.
    Waiting(f64),
    Begun(Worker<Option<String>>),
}

impl Adopted {
    pub(super) fn new(text: String, choice: Choice, is_tried: bool) -> Self {
        let trial = if is_tried { Trial::Done } else { Trial::Waiting(0.0) };
        Adopted { text, choice, trial }
    }

    /// Begins to try it once it is not changed any more; whether the trial is under way.
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

    /// Why the run is not to be stepped by it from the state that it was tried from, in words.
    pub(super) fn fault(&self) -> Option<String> {
        let Trial::Begun(worker) = &self.trial else { return None };
        let report = worker.report();
        report.failure.or_else(|| report.found.as_deref().cloned().flatten())
    }
}
