//! `msd run --replay`: a bit-exact replay of a recording, or one beside a run with another solver.

use super::files::Files;
use super::prepare::{Prepared, is_endless, row, watch_from};
use super::report::{Comparison, Distance, Done, RunReport};
use super::tell_report;
use super::{explain_divergence, interrupted};
use crate::cli::arguments::{RunArguments, SolverArguments, Substeps};
use crate::cli::failure::{Failure, hush, note};
use crate::cli::steps::Interrupt;
use msd_core::Error;
use msd_run::recording::{Recording, load_recording, load_salvaged};
use msd_run::replay::{Change, Replay};
use msd_run::rescue::LASTING;
use msd_run::twin::{Apart, Twin};
use msd_run::{Runner, Watch};
use msd_scene::schema::{OrAuto, SolverRow};
use msd_scene::{Viewpoint, plain, shown_path, state_hash};
use std::path::Path;
use web_time::{Duration, Instant};

/// Replays a recording, writes the requested files and prints the result.
pub fn replay(arguments: &RunArguments, path: &Path) -> Result<(), Failure> {
    hush(arguments.quiet);
    let interrupt = Interrupt::catch();
    let recording = load(path, arguments.salvage)?;
    let file = shown_path(path);
    let changes = changes(&arguments.solver)?;
    let refused = |error: Error| Failure::input(format!("{file}: {error}"));
    let mut course = Course::new(&recording, changes).map_err(refused)?;
    if changes == SolverRow::default() && arguments.distances.is_some() {
        let reason = "--distances needs another solver to compare with, as by --precision f64";
        return Err(Failure::input(reason));
    }
    let mut prepared = prepare(&recording, course.runner())?;
    let mut files = Files::open(arguments, &prepared)?;
    let mut done = Done::default();
    let watched = (&mut done, &mut prepared.watch, recording.steps());
    let diverged = step_all(&mut course, watched, (&mut files, &interrupt));
    // Any other error is an event that does not fit, after which nothing is written.
    let diverged = match diverged {
        Some(error) if error.is_of_step() => Some(error),
        Some(error) => return Err(refused(error)),
        None => None,
    };
    let unwritten = files.finish(course.runner());
    prepared.warnings.extend(unwritten.clone());
    prepared.runner = course.runner().clone();
    prepared.watch.count(&prepared.runner);
    prepared.warn(None);
    done.diverged = diverged.is_some();
    let advice = prepared.is_advised().then_some("");
    let diverged = diverged.map(|error| explain_divergence(&prepared.name, error, advice));
    let ended = diverged.or_else(|| done.interrupted.then(|| interrupted(course.runner())));
    let is_whole = ended.is_none();
    let mut report = RunReport::new(prepared, done);
    report.replay = Some(course.compare(&recording, is_whole));
    let told = tell_report(&report, arguments, (ended, unwritten));
    let elsewhere = report.replay.is_some_and(|replay| replay.same_bits == Some(false));
    let elsewhere = elsewhere.then(|| {
        Failure::input(format!(
            "{file}: the replay ended in a different state than the recording; was it recorded \
             by another version of msd?"
        ))
    });
    Failure::all(told.err().into_iter().chain(elsewhere))
}

/// Reads a recording, or its intact part.
fn load(path: &Path, salvage: bool) -> Result<Recording, Failure> {
    if salvage {
        return load_salvaged(path).map_err(Failure::input);
    }
    load_recording(path).map_err(|error| {
        let some_is_whole = load_salvaged(path).is_ok();
        let advice = if some_is_whole { "; --salvage replays the intact part" } else { "" };
        Failure::input(format!("{error}{advice}"))
    })
}

/// Returns the solver options that replace those of the recording.
fn changes(solver: &SolverArguments) -> Result<SolverRow, Failure> {
    if solver.substeps == Some(Substeps::Auto) {
        let reason = "--substeps auto cannot be used with --replay: omit it to use the recorded \
                      substeps, or give a number";
        return Err(Failure::input(reason));
    }
    // The substeps divide a recorded step.
    Ok(SolverRow { step: OrAuto::Auto, ..row(solver) })
}

/// Prepares a replay, for its report.
fn prepare(recording: &Recording, runner: &Runner) -> Result<Prepared, Failure> {
    let (settings, steps, start) = (runner.settings(), recording.steps(), &recording.start);
    let work = recording.substeps().max(steps as f64 * f64::from(settings.substeps));
    if is_endless(work) {
        let work = plain(work);
        return Err(Failure::input(format!("{}: {work} steps would take weeks", start.name)));
    }
    let stable = runner.stable_substep();
    // The substeps divide a recorded step.
    let (watch, early, mut warnings) =
        watch_from((runner, &start.scene), settings.step, stable, LASTING);
    if 0 < recording.lost_bytes {
        warnings.push(format!(
            "the recording is damaged after step {steps}; its last {} bytes are lost",
            recording.lost_bytes
        ));
    } else if recording.is_cut_short {
        let told = "the end of the recording is missing; the intact part is replayed";
        warnings.push(told.into());
    }
    let noted = |(steps, note): (u64, &str)| format!("recorded after step {steps}: {note}");
    warnings.extend(recording.notes().map(noted));
    warnings.iter().for_each(|warning| note(&format!("warning: {warning}")));
    let (name, title, notes) = (start.name.clone(), start.title.clone(), start.notes.clone());
    let (files, made) = (Vec::new(), Vec::new());
    let (is_resumed, runner) = (false, runner.clone());
    Ok(Prepared {
        held: Vec::new(),
        name,
        title,
        notes,
        files,
        made,
        camera: Viewpoint::default(),
        is_resumed,
        start: runner.moment(),
        runner,
        stable,
        watch,
        early,
        steps,
        warnings,
    })
}

/// A replay alone, or beside one with another solver.
enum Course<'a> {
    Alone(Box<Replay<'a>>),
    Beside(Box<Twin<'a>>),
}

impl<'a> Course<'a> {
    fn new(recording: &'a Recording, changes: SolverRow) -> Result<Self, Error> {
        if changes == SolverRow::default() {
            Ok(Course::Alone(Box::new(Replay::new(recording, changes)?)))
        } else {
            Ok(Course::Beside(Box::new(Twin::new(recording, changes)?)))
        }
    }

    /// Returns the reported run: the one with another solver, if there is one.
    fn runner(&self) -> &Runner {
        match self {
            Course::Alone(replay) => replay.runner(),
            Course::Beside(twin) => twin.changed().runner(),
        }
    }

    /// Takes the next step; returns whether there was one, and the distance between the two runs.
    fn advance(&mut self) -> Result<(bool, Option<Apart>), Error> {
        match self {
            Course::Alone(replay) => Ok((replay.advance()?, None)),
            Course::Beside(twin) => twin.advance().map(|apart| (apart.is_some(), apart)),
        }
    }

    /// Returns the change of that run before its last step.
    fn change(&self) -> Option<Change> {
        match self {
            Course::Alone(replay) => replay.change(),
            Course::Beside(twin) => twin.changed().change(),
        }
    }

    fn compare(&self, recording: &Recording, is_whole: bool) -> Comparison {
        let apart = match self {
            Course::Alone(_) => None,
            Course::Beside(twin) => Some(distance(twin)),
        };
        let recorded = match self {
            Course::Alone(replay) => replay.runner(),
            Course::Beside(twin) => twin.recorded().runner(),
        };
        let hash = state_hash(&recorded.state());
        Comparison {
            recorded_hash: recording.hash().map(|hash| format!("{hash:016x}")),
            same_bits: recording.hash().filter(|_| is_whole).map(|recorded| recorded == hash),
            cut_short: recording.is_cut_short,
            lost_bytes: recording.lost_bytes,
            apart,
        }
    }
}

fn distance(twin: &Twin<'_>) -> Distance {
    let Apart { rms, max, particle, .. } = twin.last();
    Distance {
        recorded_integrator: twin.recorded().runner().integrator(),
        rms,
        max,
        particle,
        size: twin.size(),
        noticeable_at: twin.noticed().map(|apart| apart.time),
    }
}

/// Replays until the end, a divergence or an interruption; times only the steps.
fn step_all(
    course: &mut Course<'_>,
    (done, watch, steps): (&mut Done, &mut Watch, u64),
    (files, interrupt): (&mut Files, &Interrupt),
) -> Option<Error> {
    let mut wall = Duration::ZERO;
    // Time and number of the steps before those of the current length.
    let (mut before, mut since, mut length) = (0.0, 0, course.runner().settings().step);
    let error = loop {
        let start = Instant::now();
        let advanced = course.advance();
        wall += start.elapsed();
        let apart = match advanced {
            Err(error) => break Some(error),
            Ok((false, _)) => break None,
            Ok((true, apart)) => apart,
        };
        let runner = course.runner();
        match course.change() {
            Some(Change::Start) => *watch = Watch::new(runner, &runner.progress().0),
            Some(Change::Edit) => watch.change(runner),
            None => {}
        }
        watch.follow(runner);
        done.note(runner, 1);
        // Steps times their length instead of a running sum; a new scene or step length restarts
        // it.
        let step = course.runner().settings().step;
        if step != length {
            (before, since, length) = (done.simulated, done.steps - 1, step);
        }
        done.simulated = before + (done.steps - since) as f64 * length;
        files.follow(course.runner(), (done.steps, 1));
        files.add_distance(apart);
        if interrupt.is_asked() && done.steps < steps {
            done.interrupted = true;
            break None;
        }
    };
    done.wall = wall.as_secs_f64();
    error
}
