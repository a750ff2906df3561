//! The output files of a run: opened before it, extended after each step, completed at its end.

use super::prepare::Prepared;
use crate::cli::arguments::{RunArguments, Watched};
use crate::cli::failure::{Failure, note};
use crate::cli::places::Places;
use msd_core::Settings;
use msd_run::export::{Export, Format};
use msd_run::recording::{Event, Recorder};
use msd_run::twin::{Apart, HEADER};
use msd_run::{Runner, Trace};
use msd_scene::{FileError, Output, shown_path, tame, write_saved};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The requested files, opened before the run, so that a missing folder is reported before the
/// work.
///
/// If a file fails on the way, it is abandoned and reported; the run and the other files continue.
pub struct Files {
    out: Option<Export>,
    save: Option<Saver>,
    trace: Option<Trace>,
    recorder: Option<Recorder>,
    /// Settings of the last step in the recording.
    recorded: Settings,
    distances: Option<Output>,
    /// Files that could not be written, a line each.
    failures: Vec<String>,
}

/// Returns the particles to be traced; `count` is the number of all.
fn watched(wanted: &[Watched], count: usize) -> Result<Vec<usize>, Failure> {
    let mut particles = Vec::new();
    for watched in wanted {
        match *watched {
            Watched::All => particles.extend(0..count),
            Watched::One(particle) if particle < count => particles.push(particle),
            Watched::One(particle) => {
                return Err(Failure::input(format!(
                    "--watch names particle {particle}; it must be from 0 to {}",
                    count - 1
                )));
            }
        }
    }
    Ok(particles)
}

/// Target and interval of saved runs.
struct Saver {
    path: PathBuf,
    /// The file of the next save.
    next: Option<Output>,
    /// Steps from one save to the next; `None` for the end only.
    every: Option<u64>,
    /// Whether the last save failed.
    failed: bool,
    name: String,
    title: String,
}

impl Files {
    /// Opens the requested files.
    pub fn open(arguments: &RunArguments, prepared: &Prepared) -> Result<Self, Failure> {
        check_places(arguments, prepared)?;
        let Prepared { name, title, runner, .. } = prepared;
        let watched = watched(&arguments.watch, runner.particle_count())?;
        let format = arguments.out.as_deref().map(state_format).transpose()?;
        let mut failures = Vec::new();
        let begin = |path: &Path| Export::begin(path, format.unwrap_or(Format::Csv), runner);
        let out = opened(&arguments.out, begin, &mut failures);
        let mut open = |path: &Option<PathBuf>| opened(path, Output::create, &mut failures);
        let trace = open(&arguments.trace);
        let save = open(&arguments.save).zip(arguments.save.clone()).map(|(next, path)| {
            let every = arguments.save_every.map(|seconds| steps_in(runner.settings(), seconds));
            let (name, title) = (name.clone(), title.clone());
            Saver { path, next: Some(next), every, failed: false, name, title }
        });
        let distances = open(&arguments.distances);
        Failure::all(failures.drain(..).map(Failure::input))?;
        // Last, as this overwrites an older recording.
        let begin = |path: &Path| Recorder::begin(path, &runner.to_loaded(name, title));
        let recorder = opened(&arguments.record, begin, &mut failures);
        Failure::all(failures.drain(..).map(Failure::input))?;
        let recorded = runner.settings();
        let mut files = Files { out, save, trace: None, recorder, recorded, distances, failures };
        let columns = (watched, prepared.held.clone());
        files.trace = trace.and_then(|output| files.begin_trace(output, columns, runner));
        files.attempt(|files| &mut files.distances, |output| line(output, HEADER));
        Ok(files)
    }

    fn begin_trace(
        &mut self,
        output: Output,
        (watched, held): (Vec<usize>, Vec<(String, Vec<usize>)>),
        runner: &Runner,
    ) -> Option<Trace> {
        let begun = Trace::begin(output, watched, held);
        let begun = begun.and_then(|mut trace| trace.add(runner).map(|()| trace));
        begun.map_err(|error| self.give_up(&error)).ok()
    }

    /// The most steps to take at once, after so many of this run, for each file to be extended.
    pub fn most(&self, taken: u64) -> u64 {
        let every = self.save.as_ref().and_then(|saver| saver.every).unwrap_or(u64::MAX);
        if self.trace.is_some() { 1 } else { every - taken % every }
    }

    /// Records steps, the last of them the `taken`th of this run.
    pub fn follow(&mut self, runner: &Runner, (taken, steps): (u64, u64)) {
        self.attempt(|files| &mut files.trace, |trace| trace.add(runner));
        let settings = runner.settings();
        if std::mem::replace(&mut self.recorded, settings) != settings {
            // Automatic substeps were renewed before the step.
            let event = Event::Settings(settings);
            self.attempt(|files| &mut files.recorder, |recorder| recorder.add(&event));
        }
        if let Some(gust) = runner.gust() {
            self.attempt(|files| &mut files.recorder, |recorder| recorder.add(&Event::Act(gust)));
        }
        for _ in 0..steps {
            self.attempt(|files| &mut files.recorder, Recorder::step);
        }
        if let Some(saver) = &mut self.save
            && saver.every.is_some_and(|every| taken.is_multiple_of(every))
        {
            saver.save_on_the_way(runner);
        }
    }

    /// Records a note on the device that takes the steps.
    pub fn note(&mut self, note: &str) {
        let event = Event::Note(note.to_owned());
        self.attempt(|files| &mut files.recorder, |recorder| recorder.add(&event));
    }

    /// Writes the distance between two runs.
    pub fn add_distance(&mut self, apart: Option<Apart>) {
        let Some(apart) = apart else { return };
        self.attempt(|files| &mut files.distances, |output| line(output, &apart.line()));
    }

    /// Completes every file, and returns those that could not be written, a line each.
    pub fn finish(self, runner: &Runner) -> Vec<String> {
        let Files { out, save, trace, recorder, distances, mut failures, .. } = self;
        let state = |mut export: Export| {
            export.add(runner)?;
            export.finish(runner).map(drop)
        };
        let ended = [
            out.map(state),
            save.map(|mut saver| saver.save(runner)),
            trace.map(Trace::finish),
            recorder.map(|recorder| recorder.finish(runner).map(drop)),
            distances.map(Output::finish),
        ];
        let errors = ended.into_iter().flatten().filter_map(Result::err);
        failures.extend(errors.map(|error| error.to_string()));
        failures
    }

    /// Writes to one of the files, if it is open; abandons it after a failure.
    fn attempt<T>(
        &mut self,
        file: impl Fn(&mut Files) -> &mut Option<T>,
        write: impl FnOnce(&mut T) -> Result<(), FileError>,
    ) {
        if let Some(Err(error)) = file(self).as_mut().map(write) {
            *file(self) = None;
            self.give_up(&error);
        }
    }

    fn give_up(&mut self, error: &FileError) {
        note(&format!("warning: {error}; the run continues without it"));
        self.failures.push(error.to_string());
    }
}

impl Saver {
    fn save(&mut self, runner: &Runner) -> Result<(), FileError> {
        let output = self.next.take().map_or_else(|| Output::create(&self.path), Ok)?;
        write_saved(&runner.to_loaded(&self.name, &self.title), output)
    }

    /// Saves; after a failure, the next save tries again.
    fn save_on_the_way(&mut self, runner: &Runner) {
        let saved = self.save(runner);
        if let (Err(error), false) = (&saved, self.failed) {
            note(&format!("warning: {error}; the run continues, and the next save tries again"));
        }
        self.failed = saved.is_err();
    }
}

/// Formats of a state.
const FORMATS: [Format; 5] = [Format::Csv, Format::Npz, Format::Obj, Format::Ply, Format::Vtu];

/// Returns the format of a state by the extension of its file; CSV without one, as for a pipe.
fn state_format(path: &Path) -> Result<Format, Failure> {
    let Some(ending) = path.extension() else { return Ok(Format::Csv) };
    let format = Format::of(path);
    if let Some(format) = format.filter(|format| FORMATS.contains(format)) {
        return Ok(format);
    }
    let path = shown_path(path);
    let ending = tame(&ending.to_string_lossy());
    if format.is_some() {
        let reason = format!("a .{ending} file holds a run over time, which msd export writes");
        return Err(Failure::input(format!("{path}: {reason}")));
    }
    let [others @ .., last] = FORMATS.map(|format| format!(".{}", format.ending()));
    let others = others.join(", ");
    Err(Failure::input(format!(
        "{path}: cannot write a state as .{ending}; use {others} or {last}"
    )))
}

/// Opens an optional file, or adds the reason why it cannot be opened.
fn opened<T>(
    path: &Option<PathBuf>,
    open: impl Fn(&Path) -> Result<T, FileError>,
    failures: &mut Vec<String>,
) -> Option<T> {
    let file = open(path.as_deref()?);
    file.map_err(|error| failures.push(error.to_string())).ok()
}

fn line(output: &mut Output, text: &str) -> Result<(), FileError> {
    writeln!(output, "{text}").map_err(|error| output.refused(&error))
}

/// Returns the number of steps nearest to a time, at least one.
fn steps_in(settings: Settings, seconds: f64) -> u64 {
    (seconds / settings.step).round().max(1.0) as u64
}

/// Refuses a file that would overwrite another one of the same run.
fn check_places(arguments: &RunArguments, prepared: &Prepared) -> Result<(), Failure> {
    let RunArguments { out, save, trace, record, distances, replay, solver, .. } = arguments;
    let (option, files) = match replay {
        Some(recording) => ("--replay", std::slice::from_ref(recording)),
        None => ("SCENE", &prepared.files[..]),
    };
    let mut places = Places::default();
    let read = |places: &mut Places| files.iter().for_each(|file| places.read(option, file));
    // A saved run may replace itself: the new one continues it.
    if !prepared.is_resumed {
        read(&mut places);
    }
    solver.from.iter().for_each(|state| places.read("--from", state));
    save.iter().try_for_each(|path| places.write("--save", path))?;
    if prepared.is_resumed {
        read(&mut places);
    }
    let named =
        [("--out", out), ("--trace", trace), ("--record", record), ("--distances", distances)];
    for (option, path) in named {
        path.iter().try_for_each(|path| places.write(option, path))?;
    }
    Ok(())
}
