//! Which files does a run write, and when?

use super::arguments::RunArguments;
use super::failure::Failure;
use super::prepare::Prepared;
use msd_core::Settings;
use msd_lab::{LabError, Loaded, Output, Recorder, Runner, Trace, write_saved, write_state};
use std::path::{Path, PathBuf};

/// The files that were asked for, opened before the run: a folder that is not there is no news for
/// its end.
pub struct Files {
    out: Option<Output>,
    save: Option<Saver>,
    trace: Option<Trace>,
    recorder: Option<Recorder>,
}

/// Where the run is saved, and how often.
struct Saver {
    path: PathBuf,
    /// The file of the next time.
    next: Option<Output>,
    /// Steps from one time to the next; none for the end alone.
    every: Option<u64>,
    name: String,
    title: String,
}

impl Files {
    /// Opens what was asked for.
    pub fn open(arguments: &RunArguments, prepared: &Prepared) -> Result<Self, Failure> {
        check_different(arguments)?;
        let Prepared { name, title, runner, .. } = prepared;
        let count = runner.particle_count();
        if let Some(particle) = arguments.watch.iter().find(|&&particle| count <= particle) {
            return Err(Failure::input(format!(
                "--watch names particle {particle}; it must be from 0 to {}",
                count - 1
            )));
        }
        let open = |path: &Option<PathBuf>| path.as_deref().map(Output::create).transpose();
        let files = || -> Result<Self, LabError> {
            let out = open(&arguments.out)?;
            let trace = open(&arguments.trace)?;
            let trace = trace.map(|output| Trace::begin(output, arguments.watch.clone()));
            let mut trace = trace.transpose()?;
            trace.as_mut().map(|trace| trace.add(runner)).transpose()?;
            let every = |seconds| steps_in(runner.settings(), seconds);
            let save = open(&arguments.save)?.zip(arguments.save.clone()).map(|(next, path)| {
                let every = arguments.save_every.map(every);
                let (name, title) = (name.clone(), title.clone());
                Saver { path, next: Some(next), every, name, title }
            });
            let begin = |path: &Path| Recorder::begin(path, &Loaded::of(name, title, runner));
            let recorder = arguments.record.as_deref().map(begin).transpose()?;
            Ok(Files { out, save, trace, recorder })
        };
        files().map_err(Failure::input)
    }

    /// Follows a step, the `taken`th of this run.
    pub fn follow(&mut self, runner: &Runner, taken: u64) -> Result<(), LabError> {
        if let Some(trace) = &mut self.trace {
            trace.add(runner)?;
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.step()?;
        }
        match &mut self.save {
            Some(saver) if saver.every.is_some_and(|every| taken.is_multiple_of(every)) => {
                saver.save(runner)
            }
            _ => Ok(()),
        }
    }

    /// Ends every file.
    pub fn finish(self, runner: &Runner) -> Result<(), LabError> {
        if let Some(mut output) = self.out {
            write_state(&runner.state(), &mut output)?;
            output.finish()?;
        }
        if let Some(mut saver) = self.save {
            saver.save(runner)?;
        }
        if let Some(trace) = self.trace {
            trace.finish()?;
        }
        self.recorder.map_or(Ok(()), |recorder| recorder.finish(runner))
    }
}

impl Saver {
    fn save(&mut self, runner: &Runner) -> Result<(), LabError> {
        let output = self.next.take().map_or_else(|| Output::create(&self.path), Ok)?;
        write_saved(&Loaded::of(&self.name, &self.title, runner), output)
    }
}

/// The number of steps nearest to a time, at least one.
fn steps_in(settings: Settings, seconds: f64) -> u64 {
    (seconds / settings.step).round().max(1.0) as u64
}

/// Refuses two files at the same place.
fn check_different(arguments: &RunArguments) -> Result<(), Failure> {
    let RunArguments { out, save, trace, record, distances, .. } = arguments;
    let named = [
        ("--out", out),
        ("--trace", trace),
        ("--save", save),
        ("--record", record),
        ("--distances", distances),
    ];
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let places = named.map(|(flag, path)| (flag, path.as_deref().map(absolute)));
    for (row, (flag, place)) in places.iter().enumerate() {
        let same = |(_, before): &&(&str, Option<PathBuf>)| place.is_some() && before == place;
        if let Some((before, _)) = places[..row].iter().find(same) {
            return Err(Failure::input(format!("{before} and {flag} name the same file")));
        }
    }
    Ok(())
}
