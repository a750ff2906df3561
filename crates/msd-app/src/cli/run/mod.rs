//! `msd run`: a scene runs without a window.

mod prepare;
mod report;
mod watch;
mod files;
mod replay;

pub use prepare::{Prepared, is_endless, prepare};
pub use replay::replay;
pub use report::evaluations;

use super::arguments::RunArguments;
use super::failure::{Failure, say, tell};
use files::Files;
use msd_core::{Divergence, Error};
use prepare::advise;
use report::{Done, RunReport};
use std::path::Path;
use watch::Watch;
use web_time::{Duration, Instant};

/// Runs a scene, writes what was asked for and prints the result.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let scene = arguments.scene.as_deref().unwrap_or(Path::new(""));
    let mut prepared = prepare(scene, &arguments.solver, ("--duration", arguments.duration))?;
    let mut files = Files::open(arguments, &prepared)?;
    let start = (prepared.runner.steps(), prepared.runner.time());
    let mut watch = Watch::new(&prepared.runner, prepared.stable);
    let (wall, diverged) = step_all(&mut prepared, &mut files, &mut watch);
    let warnings = watch.warnings(prepared.runner.settings());
    warnings.iter().for_each(|warning| tell(&format!("warning: {warning}")));
    prepared.warnings.extend(warnings);
    let unwritten = files.finish(&prepared.runner);
    prepared.warnings.extend(unwritten.clone());
    let done = Done {
        steps: prepared.runner.steps() - start.0,
        simulated: prepared.runner.time() - start.1,
        wall: wall.as_secs_f64(),
        diverged: diverged.is_some(),
        gain: watch.gain,
        imbalance: Some(watch.imbalance()),
        solved: watch.solved,
    };
    tell_report(&RunReport::new(prepared, done), arguments, (diverged, unwritten))
}

/// Tells what came of a run, where it diverged, and which files could not be written.
pub fn tell_report(
    report: &RunReport,
    arguments: &RunArguments,
    (diverged, unwritten): (Option<Error>, Vec<String>),
) -> Result<(), Failure> {
    let told = if arguments.json { report.json() } else { Ok(report.summary()) };
    let said = say(&told.map_err(Failure::input)?).err();
    let diverged = diverged.map(|error| explain_divergence(&report.scene, error));
    let unwritten = unwritten.into_iter().map(Failure::input);
    Failure::all(unwritten.chain(said).chain(diverged))
}

/// Takes all steps, or as many as stay in the world; only the steps are timed.
fn step_all(
    prepared: &mut Prepared,
    files: &mut Files,
    watch: &mut Watch,
) -> (Duration, Option<Error>) {
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
    }
    (wall, None)
}

/// What happened, and what to change.
pub fn explain_divergence(scene: &str, error: Error) -> Failure {
    let advice = match &error {
        Error::Diverged(Divergence { stable_substep: Some(stable), substep, .. })
            if stable < substep =>
        {
            format!("; {}", advise(*stable))
        }
        _ => String::new(),
    };
    let message = format!("{scene}: {error}{advice}");
    if error.is_of_step() { Failure::diverged(message) } else { Failure::input(message) }
}
