//! How is what happens in the window written down, so that it can happen again?

use crate::session::Session;
use msd_lab::recording::Event;
use msd_lab::{LabError, Loaded, Recorder};
use std::path::Path;

impl Session {
    /// Begins to record from the present state on, into a file that grows. Ends a recording that
    /// was being made.
    pub fn start_recording(&mut self, path: &Path) {
        self.stop_recording();
        match Recorder::begin(path, &self.now()) {
            Ok(recorder) => self.recorder = Some(recorder),
            Err(error) => self.refusal = Some(error.to_string()),
        }
    }

    /// Ends the recording, if one is being made.
    pub fn stop_recording(&mut self) {
        let Some(recorder) = self.recorder.take() else { return };
        let ended = recorder.finish(&self.runner);
        self.refusal = ended.err().map(|error| error.to_string());
    }

    /// The file that is being recorded into.
    pub fn recording(&self) -> Option<&str> {
        self.recorder.as_ref().map(Recorder::name)
    }

    /// The run as it is now.
    fn now(&self) -> Loaded {
        Loaded::of(&self.loaded.name, &self.loaded.title, &self.runner)
    }

    /// Writes something down. Where that fails the recording ends, and the person is told.
    pub(crate) fn note(&mut self, write: impl FnOnce(&mut Recorder) -> Result<(), LabError>) {
        let Some(recorder) = &mut self.recorder else { return };
        if let Err(error) = write(recorder) {
            self.recorder = None;
            self.refusal = Some(error.to_string());
        }
    }

    /// Writes down what has happened.
    pub(crate) fn note_event(&mut self, event: Event) {
        self.note(|recorder| recorder.add(&event));
    }

    /// Writes down that the run was replaced.
    pub(crate) fn note_start(&mut self) {
        if self.recorder.is_some() {
            self.note_event(Event::Start(Box::new(self.now())));
        }
    }

    /// Writes down that a step was taken back.
    pub(crate) fn note_back(&mut self) {
        let Some(mut recorder) = self.recorder.take() else { return };
        let noted = recorder.back(|| self.now());
        self.recorder = Some(recorder);
        self.note(|_| noted);
    }
}

/// Ends the recording of a window that is closed.
impl Drop for Session {
    fn drop(&mut self) {
        self.stop_recording();
    }
}
