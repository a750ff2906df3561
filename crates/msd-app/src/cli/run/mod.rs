//! `msd run`: a run of a scene without a window.

mod advice;
pub mod prepare;
mod report;
mod files;
mod replay;
mod follow;

pub use follow::follow;
pub use prepare::{is_endless, link, open_draft, open_scene};
pub use replay::replay;
pub use report::evaluations;

use super::arguments::RunArguments;
use super::device::{Stepper, Stop};
use super::failure::{Failure, hush, say};
use super::steps::Interrupt;
use super::steps::Steps;
use advice::{advise, appended};
use files::Files;
use msd_core::{Divergence, Error};
use msd_run::rescue::LASTING;
use msd_run::{Kind, Runner};
use msd_scene::set_keys;
use msd_study::quantity::quantity;
use prepare::{FRAME, Prepared, prepare};
use report::{Done, RunReport};
use std::path::Path;
use web_time::{Duration, Instant};

/// Runs a scene, writes the requested files and prints the result.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    hush(arguments.quiet);
    let scene = arguments.scene.as_deref().unwrap_or(Path::new(""));
    let mut prepared =
        prepare((scene, &arguments.set), &arguments.solver, ("--duration", arguments.duration))?;
    let opened = Stepper::open(&arguments.device, &prepared.name, &prepared.runner);
    let (mut stepper, note) = opened?;
    prepared.notes.extend(note);
    // From here on: until the scene is open, there is nothing to keep.
    let interrupt = Interrupt::catch();
    let mut files = Files::open(arguments, &prepared)?;
    let began = prepared.runner.time();
    let (mut done, stopped) = step_all(&mut prepared, &mut stepper, (&mut files, &interrupt));
    let (diverged, refused) = match stopped {
        Some(Stop::Step(error)) => (Some(error), None),
        Some(Stop::Device(failure)) => (None, Some(failure)),
        None => (None, None),
    };
    let has_ended = diverged.is_some() || refused.is_some();
    let is_interrupted = !has_ended && done.steps < prepared.steps;
    let advice = late_advice(&prepared, diverged.as_ref());
    let diverged =
        diverged.map(|error| explain_divergence(&prepared.name, error, advice.as_deref()));
    (done.diverged, done.interrupted) = (diverged.is_some(), is_interrupted);
    let advice = advice.filter(|_| diverged.is_none());
    // After a divergence, the shapes of cells are not meaningful.
    match diverged {
        None => prepared.watch.count(&prepared.runner),
        Some(_) => prepared.watch.count_crossings(&prepared.runner),
    }
    let ended = diverged.or(refused);
    let ended = ended.or_else(|| is_interrupted.then(|| interrupted(&prepared.runner)));
    prepared.warn(advice.as_deref());
    let unwritten = files.finish(&prepared.runner);
    prepared.warnings.extend(unwritten.clone());
    done.simulated = prepared.runner.time() - began;
    let (set, device) = (set_keys(&arguments.set.set), stepper.name().to_owned());
    let report = RunReport { set, device, ..RunReport::new(prepared, done) };
    tell_report(&report, arguments, (ended, unwritten))
}

/// Returns advice after a divergence, or if the limit moved below the step; empty if it was given
/// before the run.
fn late_advice(prepared: &Prepared, diverged: Option<&Error>) -> Option<String> {
    let is_of_step = diverged.is_some_and(Error::is_of_step);
    let found = prepared.watch.findings(&prepared.runner);
    if !is_of_step
        && !found.iter().any(|finding| matches!(finding.kind, Kind::StabilityLimit { .. }))
    {
        return None;
    }
    if prepared.is_advised() {
        return Some(String::new());
    }
    let (mut runner, ended) = (prepared.runner.clone(), prepared.runner.time());
    runner.go_back(&prepared.start).ok()?;
    let lasting = (1.2 * (ended - runner.time())).max(LASTING);
    let stable = prepared.watch.read().least.unwrap_or(prepared.stable);
    Some(advise(&runner, FRAME, stable, lasting))
}

/// Returns the failure of a run that the user interrupted.
pub fn interrupted(runner: &Runner) -> Failure {
    let time = quantity(runner.time(), "s");
    Failure::interrupted(format!("interrupted at t = {time}; the files hold the run so far"))
}

/// Prints the report of a run, the reason of an early end, and the files that could not be written.
pub fn tell_report(
    report: &RunReport,
    arguments: &RunArguments,
    (ended, unwritten): (Option<Failure>, Vec<String>),
) -> Result<(), Failure> {
    let said = match (arguments.json, arguments.quiet) {
        (true, _) => say(&report.json().map_err(Failure::input)?),
        (false, true) => Ok(()),
        (false, false) => say(&report.summary()),
    };
    let unwritten = unwritten.into_iter().map(Failure::input);
    Failure::all(unwritten.chain(said.err()).chain(ended))
}

/// Steps until the end, a divergence or an interruption; times only the steps.
fn step_all(
    prepared: &mut Prepared,
    stepper: &mut Stepper,
    (files, interrupt): (&mut Files, &Interrupt),
) -> (Done, Option<Stop>) {
    let mut progress = Steps::new(prepared.steps, &prepared.name);
    let (mut done, mut wall) = (Done::default(), Duration::ZERO);
    let mut failed = None;
    while done.steps < prepared.steps && failed.is_none() {
        let left = prepared.steps - done.steps;
        let most = left.min(stepper.most(done.steps)).min(files.most(done.steps));
        let (start, before) = (Instant::now(), prepared.runner.steps());
        let advanced = stepper.advance(&mut prepared.runner, most);
        wall += start.elapsed();
        let Prepared { runner, watch, steps, .. } = &mut *prepared;
        // Of those that were to be taken at once, some may precede one that fails. A device that
        // computes other bits leaves the run before an earlier step.
        let taken = runner.steps().saturating_sub(before);
        if 0 < taken {
            done.note(runner, taken);
            if stepper.is_read(done.steps) || done.steps == *steps {
                watch.follow(runner);
            }
            files.follow(runner, (done.steps, taken));
            progress.tell(done.steps);
        }
        match advanced {
            Ok(None) => {}
            Ok(Some(why)) => {
                files.note(&why);
                prepared.add_warning(why);
            }
            Err(stop) => {
                if let Stop::Device(failure) = &stop {
                    files.note(&failure.message);
                }
                failed = Some(stop);
            }
        }
        if failed.is_none() && interrupt.is_asked() {
            break;
        }
    }
    let failed = failed.or_else(|| stepper.finish(&mut prepared.runner).err());
    (done.wall, done.on_device) = (wall.as_secs_f64(), stepper.taken());
    (done, failed)
}

/// Explains a divergence. Empty advice was given before the run; without advice, the message
/// includes the limit from the error, which is that of a broken state.
pub fn explain_divergence(scene: &str, error: Error, advice: Option<&str>) -> Failure {
    let told = match (&error, advice) {
        (Error::Diverged(divergence), Some(_)) => where_it_diverged(divergence),
        _ => error.to_string(),
    };
    let message = format!("{scene}: {told}{}", appended(advice));
    if error.is_of_step() { Failure::diverged(message) } else { Failure::input(message) }
}

fn where_it_diverged(divergence: &Divergence) -> String {
    let Divergence { particle, step, time, .. } = divergence;
    format!(
        "diverged: particle {particle} left the world in step {step} (t = {time:.6} s); the last \
         good state is kept"
    )
}
