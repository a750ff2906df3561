//! Recordings: the events of a run, and after which of its steps each happened.
//!
//! A recording is the saved run that it starts from and the events that followed. It grows while it
//! is made: a crash leaves all events up to the last whole one. See `docs/reference/files.md`.

use crate::runner::Runner;
use msd_core::{Interaction, Settings};
use msd_scene::envelope::{FileKind, Found, Frames, frame};
use msd_scene::{FileError, Loaded, Output, Precision, shown_path, state_hash};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{Seek, Write};
use std::path::Path;

/// Extension of the name of a recording.
pub const ENDING: &str = "msdrec";

/// Raised whenever the written form changes.
const KIND: FileKind = FileKind { what: "recording", format: 18, oldest: 16 };

/// Steps after which a recording is written on at the latest: a second of the default step.
const MOST_UNWRITTEN: u32 = 60;

/// Something that happened to a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Event {
    /// A hand did something, at once.
    Act(Interaction),
    /// It is stepped otherwise from here on.
    Settings(Settings),
    /// It goes on in this precision.
    Precision(Precision),
    /// It took so many steps.
    Steps(u32),
    /// It returned to the state before the last step. The values that a user set stay.
    Back,
    /// Something else took its place: it was restarted, or another scene opened.
    Start(Box<Loaded>),
    /// The recording was ended; the hash of the last state.
    End(u64),
    /// A note of the program that recorded, such as that a device computed other bits.
    Note(String),
}

/// A run and its events.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The run that it starts from.
    pub start: Loaded,
    /// The events, in order.
    pub events: Vec<Event>,
    /// Whether the end is missing: the program that recorded was stopped.
    pub is_cut_short: bool,
    /// Number of bytes at the end of the file that do not form a whole event, and were left out by
    /// [`salvage_recording`]; else 0.
    pub lost_bytes: usize,
}

impl Recording {
    /// Steps to take, those that are taken back among them.
    pub fn steps(&self) -> u64 {
        let steps = |event: &Event| if let Event::Steps(count) = event { *count } else { 0 };
        self.events.iter().map(|event| u64::from(steps(event))).sum()
    }

    /// Integration steps to take: each step counts as its substeps.
    pub fn substeps(&self) -> f64 {
        let (mut now, mut sum) = (self.start.settings.substeps, 0.0);
        for event in &self.events {
            match event {
                Event::Steps(count) => sum += f64::from(*count) * f64::from(now),
                Event::Settings(settings) => now = settings.substeps,
                Event::Start(start) => now = start.settings.substeps,
                _ => {}
            }
        }
        sum
    }

    /// The notes of the program that recorded, each with the number of steps before it.
    pub fn notes(&self) -> impl Iterator<Item = (u64, &str)> {
        let mut steps = 0;
        self.events.iter().filter_map(move |event| match event {
            Event::Steps(count) => {
                steps += u64::from(*count);
                None
            }
            Event::Note(note) => Some((steps, &**note)),
            _ => None,
        })
    }

    /// The hash of the last state, if the recording was ended.
    pub fn hash(&self) -> Option<u64> {
        let Some(Event::End(hash)) = self.events.last() else { return None };
        Some(*hash)
    }
}

/// Reads a recording from a file.
///
/// # Errors
/// A file that cannot be read; everything that [`read_recording`] refuses.
pub fn load_recording(path: &Path) -> Result<Recording, FileError> {
    read_recording(&KIND.load(path)?, &shown_path(path))
}

/// Reads a recording from the bytes of a file called `name`. A replay checks whether its events fit
/// its run. A recording without its end is accepted if its events are whole.
///
/// # Errors
/// [`FileError::Format`] for a file of another format. [`FileError::Malformed`] for bytes that are
/// not a recording, end before its first event or within one, do not fit their checksum, or go on
/// after its end.
pub fn read_recording(bytes: &[u8], name: &str) -> Result<Recording, FileError> {
    match salvage(bytes, name)? {
        (recording, None) => Ok(recording),
        (recording, Some(error)) => Err(with_loss(error, &recording)),
    }
}

/// Reads the whole part of a recording from a file, up to the first damaged event.
///
/// # Errors
/// A file that cannot be read; everything that [`salvage_recording`] refuses.
pub fn load_salvaged(path: &Path) -> Result<Recording, FileError> {
    salvage_recording(&KIND.load(path)?, &shown_path(path))
}

/// Reads the whole part of a recording from the bytes of a file called `name`, up to the first
/// damaged event. [`Recording::lost_bytes`] counts the bytes that are left out.
///
/// # Errors
/// [`FileError::Format`] for a file of another format; [`FileError::Malformed`] for bytes that are
/// not a recording, or whose start is not whole.
pub fn salvage_recording(bytes: &[u8], name: &str) -> Result<Recording, FileError> {
    salvage(bytes, name).map(|(recording, _)| recording)
}

/// The whole part of a recording, and the error where that ends.
fn salvage(bytes: &[u8], name: &str) -> Result<(Recording, Option<FileError>), FileError> {
    let mut frames = KIND.frames(bytes, name)?;
    let start: Loaded = frames.expect()?;
    if !start.is_saved() {
        return Err(frames.damaged());
    }
    let mut recording = Recording { start, events: Vec::new(), is_cut_short: false, lost_bytes: 0 };
    let wrong = loop {
        let rest = frames.rest();
        match next_event(&mut frames, &recording) {
            Ok(Some(event)) => recording.events.push(event),
            Ok(None) => break None,
            Err(error) => {
                recording.lost_bytes = rest;
                break Some(error);
            }
        }
    };
    recording.is_cut_short = recording.hash().is_none();
    Ok((recording, wrong))
}

/// The next event of a recording of which so much is read.
fn next_event(frames: &mut Frames<'_>, recording: &Recording) -> Result<Option<Event>, FileError> {
    let ended = recording.hash().is_some();
    let event = match frames.next_frame() {
        Found::End => return Ok(None),
        _ if ended => return Err(frames.malformed("goes on after its end")),
        // The length of an event may have been changed as well as its end cut off.
        Found::Torn => return Err(frames.malformed("is cut short or damaged within an event")),
        Found::Damaged => return Err(frames.damaged()),
        Found::Whole(content) => frames.decode(content)?,
    };
    match &event {
        Event::Start(start) if !start.is_saved() => Err(frames.damaged()),
        _ => Ok(Some(event)),
    }
}

/// Adds to an error how much would be lost without the damaged part.
fn with_loss(error: FileError, recording: &Recording) -> FileError {
    let FileError::Malformed { place, reason } = error else { return error };
    let (steps, bytes) = (recording.steps(), recording.lost_bytes);
    let reason = format!("{reason}, after step {steps}; its last {bytes} bytes cannot be used");
    FileError::Malformed { place, reason }
}

/// Destination of a recording.
#[derive(Debug)]
enum Sink {
    File(File),
    Memory(Vec<u8>),
}

/// A recording that is being made.
#[derive(Debug)]
pub struct Recorder {
    sink: Sink,
    name: String,
    /// Steps taken that are not in the file yet.
    unwritten: u32,
    /// Steps since the last start: so many can be taken back.
    steps: u64,
}

impl Recorder {
    /// Begins a recording with the current run, see [`Runner::to_loaded`]. The file exists from
    /// then on and grows with the events.
    ///
    /// # Errors
    /// [`FileError::Unwritable`]; an older file of the name is then unchanged.
    pub fn begin(path: &Path, start: &Loaded) -> Result<Self, FileError> {
        let mut output = Output::create(path)?;
        let name = output.name().to_owned();
        KIND.begin(&mut output, start)?;
        Ok(Recorder { sink: Sink::File(output.open_ended()?), name, unwritten: 0, steps: 0 })
    }

    /// Begins a recording in memory, where there are no files; [`Recorder::finish`] returns it.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn begin_in_memory(name: &str, start: &Loaded) -> Result<Self, FileError> {
        let sink = Sink::Memory(KIND.bytes(start)?);
        Ok(Recorder { sink, name: name.to_owned(), unwritten: 0, steps: 0 })
    }

    /// The file, as the user named it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Adds something that has happened since the last step.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn add(&mut self, event: &Event) -> Result<(), FileError> {
        self.write_steps()?;
        if matches!(event, Event::Start(_)) {
            self.steps = 0;
        }
        self.write(event)
    }

    /// Adds a step.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn step(&mut self) -> Result<(), FileError> {
        self.unwritten += 1;
        self.steps += 1;
        if self.unwritten < MOST_UNWRITTEN { Ok(()) } else { self.write_steps() }
    }

    /// Adds a return to the state before the last step, after it was done. Beyond the start of the
    /// recording that is a new start.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn back(&mut self, now: impl FnOnce() -> Loaded) -> Result<(), FileError> {
        if self.steps == 0 {
            return self.add(&Event::Start(Box::new(now())));
        }
        self.steps -= 1;
        self.add(&Event::Back)
    }

    /// Ends the recording of a run; returns its bytes if it was made in memory.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn finish(mut self, runner: &Runner) -> Result<Option<Vec<u8>>, FileError> {
        self.add(&Event::End(state_hash(&runner.state())))?;
        match &mut self.sink {
            Sink::Memory(bytes) => Ok(Some(std::mem::take(bytes))),
            Sink::File(file) => {
                let safe = file.sync_all();
                safe.map(|()| None).map_err(|error| self.refused(&error))
            }
        }
    }

    fn write_steps(&mut self) -> Result<(), FileError> {
        match std::mem::take(&mut self.unwritten) {
            0 => Ok(()),
            steps => self.write(&Event::Steps(steps)),
        }
    }

    fn write(&mut self, event: &Event) -> Result<(), FileError> {
        let written = frame(event).and_then(|frame| match &mut self.sink {
            Sink::Memory(bytes) => {
                bytes.extend(frame);
                Ok(())
            }
            // A frame in one go: a crash can cut only the last one short.
            Sink::File(file) => {
                let start = file.stream_position();
                let written = file.write_all(&frame);
                if written.is_err() {
                    // On a full disk the events written so far stay a recording. A sink that cannot
                    // be cut off is a pipe, and nobody reads it again.
                    let _ = start.and_then(|start| file.set_len(start));
                }
                written
            }
        });
        written.map_err(|error| self.refused(&error))
    }

    fn refused(&self, error: &std::io::Error) -> FileError {
        FileError::Unwritable { file: self.name.clone(), reason: error.to_string() }
    }
}
