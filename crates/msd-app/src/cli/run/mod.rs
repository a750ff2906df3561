//! `msd run`: a scene runs without a window.

mod advice;
pub mod prepare;
mod report;
mod watch;
mod files;
mod replay;

pub use prepare::{is_endless, link, open_draft, open_scene};
pub use replay::replay;
pub use report::{SetKeys, evaluations, set_keys};

use super::arguments::RunArguments;
use super::failure::{Failure, hush, note, say};
use super::steps::Interrupt;
use super::steps::Steps;
use advice::{advise, appended};
use files::Files;
use msd_core::{Divergence, Error};
use msd_run::rescue::LASTING;
use msd_run::{Moment, Runner};
use msd_study::quantity::quantity;
use prepare::{FRAME, Prepared, prepare};
use report::{Done, RunReport};
use std::path::Path;
use watch::Watch;
use web_time::{Duration, Instant};

/// Runs a scene, writes what was asked for and prints the result.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    hush(arguments.quiet);
    let interrupt = Interrupt::catch();
    let scene = arguments.scene.as_deref().unwrap_or(Path::new(""));
    let mut prepared =
        prepare((scene, &arguments.set), &arguments.solver, ("--duration", arguments.duration))?;
    let mut files = Files::open(arguments, &prepared)?;
    let (start, began) = (prepared.runner.moment(), prepared.runner.time());
    let mut watch = Watch::new(&prepared.runner, prepared.stable);
    let (wall, diverged) = step_all(&mut prepared, &mut files, (&mut watch, &interrupt));
    let ended = prepared.runner.steps() - start.steps;
    let is_interrupted = diverged.is_none() && ended < prepared.steps;
    let advice = late_advice(&prepared, &watch, (&start, began), diverged.as_ref());
    let diverged =
        diverged.map(|error| explain_divergence(&prepared.name, error, advice.as_deref()));
    let advice = advice.filter(|_| diverged.is_none());
    // Cells that flew apart say nothing of the material.
    if diverged.is_none() {
        watch.count_overturned(&prepared.runner);
    }
    let ended = diverged.or_else(|| is_interrupted.then(|| interrupted(&prepared.runner)));
    watch.count_crossings(&prepared.runner);
    let warnings = watch.warnings(prepared.runner.settings(), advice.as_deref());
    warnings.iter().for_each(|warning| note(&format!("warning: {warning}")));
    prepared.warnings.extend(warnings);
    let unwritten = files.finish(&prepared.runner);
    prepared.warnings.extend(unwritten.clone());
    let done = Done {
        steps: prepared.runner.steps() - start.steps,
        simulated: prepared.runner.time() - began,
        substeps: Some(watch.substeps),
        chosen: watch.chosen,
        wall: wall.as_secs_f64(),
        diverged: ended.is_some() && !is_interrupted,
        interrupted: is_interrupted,
        gain: watch.gain,
        imbalance: watch.imbalance(),
        loss: watch.loss(),
        solved: watch.solved,
        crossed: watch.crossed,
        pierced: watch.piercing.first(),
        overturned: watch.overturned,
    };
    let report = RunReport { set: set_keys(&arguments.set.set), ..RunReport::new(prepared, done) };
    tell_report(&report, arguments, (ended, unwritten))
}

/// Advice that was not given before the run: it diverged, or its limit moved below its step. Empty
/// where it was given.
fn late_advice(
    prepared: &Prepared,
    watch: &Watch,
    (start, began): (&Moment, f64),
    diverged: Option<&Error>,
) -> Option<String> {
    let is_of_step = diverged.is_some_and(Error::is_of_step);
    if !is_of_step && !watch.is_over(prepared.runner.settings()) {
        return None;
    }
    if prepared.is_advised {
        return Some(String::new());
    }
    let mut runner = prepared.runner.clone();
    let lasting = (1.2 * (runner.time() - began)).max(LASTING);
    runner.go_back(start).ok()?;
    Some(advise(&runner, FRAME, watch.least(), lasting))
}

/// The failure of a run that the user ended.
pub fn interrupted(runner: &Runner) -> Failure {
    let time = quantity(runner.time(), "s");
    Failure::interrupted(format!("interrupted at t = {time}; the files hold the run up to then"))
}

/// Tells what came of a run, why it ended early, and which files could not be written.
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

/// Takes all steps, or as many as stay in the world and the user waits for; only the steps are
/// timed.
fn step_all(
    prepared: &mut Prepared,
    files: &mut Files,
    (watch, interrupt): (&mut Watch, &Interrupt),
) -> (Duration, Option<Error>) {
    let mut progress = Steps::new(prepared.steps, &prepared.name);
    let runner = &mut prepared.runner;
    let mut wall = Duration::ZERO;
    for taken in 1..=prepared.steps {
        let start = Instant::now();
        let stepped = runner.step();
        wall += start.elapsed();
        if let Err(error) = stepped {
            return (wall, Some(error));
        }
        watch.look(runner);
        files.follow(runner, taken);
        if interrupt.is_asked() {
            break;
        }
        progress.tell(taken);
    }
    (wall, None)
}

/// What happened, and what to change. Empty advice was given before; without any the error itself
/// says what is known of the limit, which is of a state far gone.
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
