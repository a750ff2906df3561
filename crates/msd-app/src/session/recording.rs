//! Recording of a session, for replay.

use super::Session;
use msd_run::Runner;
use msd_run::recording::{Event, Recorder};
use msd_scene::{FileError, Loaded};
use std::path::Path;

/// A recording in progress. It ends by itself if a write fails.
#[derive(Debug, Default)]
pub struct SessionRecording {
    recorder: Option<Recorder>,
    /// Name and bytes of the last finished recording, on systems without files.
    made: Option<(String, Vec<u8>)>,
}

impl SessionRecording {
    /// Returns the name of the file in progress.
    pub fn name(&self) -> Option<&str> {
        self.recorder.as_ref().map(Recorder::name)
    }

    /// Returns whether a recording is in progress.
    pub fn is_on(&self) -> bool {
        self.recorder.is_some()
    }

    /// Begins a recording from the current state of a run, into a file that grows.
    pub(super) fn begin(&mut self, path: &Path, now: &Loaded) -> Result<(), FileError> {
        // A browser has no files: the page downloads the recording at its end.
        let begun = if cfg!(target_arch = "wasm32") {
            Recorder::begin_in_memory(&path.to_string_lossy(), now)
        } else {
            Recorder::begin(path, now)
        };
        self.recorder = Some(begun?);
        Ok(())
    }

    /// Ends the recording with the state of the run.
    pub(super) fn finish(&mut self, runner: &Runner) -> Result<(), FileError> {
        let Some(recorder) = self.recorder.take() else { return Ok(()) };
        let name = recorder.name().to_owned();
        self.made = recorder.finish(runner)?.map(|bytes| (name, bytes));
        Ok(())
    }

    /// Takes name and bytes of the last finished recording, on systems without files.
    pub(super) fn take_made(&mut self) -> Option<(String, Vec<u8>)> {
        self.made.take()
    }

    /// Records a step.
    pub(super) fn step(&mut self) -> Result<(), FileError> {
        self.write(Recorder::step)
    }

    /// Records an event other than a step.
    pub(super) fn event(&mut self, event: &Event) -> Result<(), FileError> {
        self.write(|recorder| recorder.add(event))
    }

    /// Records that a step was taken back; `now` returns the run after that.
    pub(super) fn back(&mut self, now: impl Fn() -> Loaded) -> Result<(), FileError> {
        self.write(|recorder| recorder.back(now))
    }

    fn write(
        &mut self,
        write: impl FnOnce(&mut Recorder) -> Result<(), FileError>,
    ) -> Result<(), FileError> {
        let written = self.recorder.as_mut().map_or(Ok(()), write);
        if written.is_err() {
            self.recorder = None;
        }
        written
    }
}

/// The recording of a session.
impl Session {
    /// Begins a recording from the current state, into a file that grows, and ends a previous
    /// recording.
    pub fn start_recording(&mut self, path: &Path) {
        self.stop_recording();
        self.settle();
        let begun = self.recording.begin(path, &now(&self.loaded, self.run.runner()));
        self.refuse(begun);
    }

    /// Returns the name of the file in progress.
    pub fn recording(&self) -> Option<&str> {
        self.recording.name()
    }

    /// Ends the recording, if one is in progress.
    pub fn stop_recording(&mut self) {
        if self.recording.is_on() {
            self.settle();
            let ended = self.recording.finish(self.run.runner());
            self.refusal = ended.err().map(|error| error.to_string());
        }
    }

    /// Takes name and bytes of a finished recording, on systems without files.
    pub fn take_recording(&mut self) -> Option<(String, Vec<u8>)> {
        self.recording.take_made()
    }

    pub(super) fn record(&mut self, event: &Event) {
        let recorded = self.recording.event(event);
        self.refuse(recorded);
    }

    /// Records that the run was replaced.
    pub(super) fn record_start(&mut self) {
        if self.recording.is_on() {
            self.record(&Event::Start(Box::new(now(&self.loaded, self.run.runner()))));
        }
    }
}

/// A closed window ends its recording.
impl Drop for Session {
    fn drop(&mut self) {
        self.stop_recording();
    }
}

/// Returns a run in its current state, with the camera of its scene.
pub(super) fn now(loaded: &Loaded, runner: &Runner) -> Loaded {
    Loaded { camera: loaded.camera, ..runner.to_loaded(&loaded.name, &loaded.title) }
}
