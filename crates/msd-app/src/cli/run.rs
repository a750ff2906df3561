//! `msd run`: how does a scene run without a window?

use super::arguments::RunArguments;
use super::failure::{Failure, say, tell};
use super::prepare::{Prepared, advise, prepare, warn_of_step};
use super::report::Report;
use super::watch::Watch;
use msd_core::{Divergence, Error};
use msd_lab::{LabError, Output, Trace, write_state};
use std::path::Path;
use web_time::{Duration, Instant};

/// Runs a scene, writes what was asked for and tells what came of it.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let RunArguments { scene, solver, duration, .. } = arguments;
    if same_file(arguments.out.as_deref(), arguments.trace.as_deref()) {
        return Err(Failure::input("--out and --trace name the same file"));
    }
    let mut prepared = prepare(scene, solver, ("--duration", *duration))?;
    let count = prepared.runner.particle_count();
    if let Some(particle) = arguments.watch.iter().find(|&&particle| count <= particle) {
        return Err(Failure::input(format!(
            "--watch names particle {particle}; it must be from 0 to {}",
            count - 1
        )));
    }
    // Files are opened before the run: a folder that is not there is no news for its end.
    let output =
        arguments.out.as_deref().map(Output::create).transpose().map_err(Failure::input)?;
    let trace = arguments.trace.as_deref().map(Output::create).transpose();
    let trace = trace.map_err(Failure::input)?;
    let mut trace = trace.map(|output| Trace::begin(output, arguments.watch.clone()));
    let trace = trace.take().transpose().map_err(Failure::input)?;
    let (wall, diverged, trace) = step_all(&mut prepared, trace).map_err(Failure::input)?;
    if let Some(mut output) = output {
        write_state(&prepared.runner.state(), &mut output).map_err(Failure::input)?;
        output.finish().map_err(Failure::input)?;
    }
    if let Some(trace) = trace {
        trace.finish().map_err(Failure::input)?;
    }
    let report = Report::new(prepared, wall.as_secs_f64(), diverged.is_some());
    let told = if arguments.json { report.json() } else { Ok(report.summary()) };
    say(&told.map_err(Failure::input)?)?;
    match diverged {
        Some(error) => Err(explain_divergence(&report.scene, error)),
        None => Ok(()),
    }
}

type Stepped = (Duration, Option<Error>, Option<Trace>);

/// Takes all steps, or as many as stay in the world; only the steps are timed.
fn step_all(prepared: &mut Prepared, trace: Option<Trace>) -> Result<Stepped, LabError> {
    let mut watch = Watch::new(&prepared.runner, prepared.stable);
    let stepped = step_watched(prepared, trace, &mut watch)?;
    let (least, time) = watch.least;
    let settings = prepared.runner.settings();
    if prepared.stable != least
        && let Some(warning) = warn_of_step(settings, least)
    {
        let warning = format!("from {time:.3} s on at the latest {warning}");
        tell(&format!("warning: {warning}"));
        prepared.warnings.push(warning);
    }
    Ok(stepped)
}

fn step_watched(
    prepared: &mut Prepared,
    mut trace: Option<Trace>,
    watch: &mut Watch,
) -> Result<Stepped, LabError> {
    let runner = &mut prepared.runner;
    let mut wall = Duration::ZERO;
    if let Some(trace) = &mut trace {
        trace.add(runner)?;
    }
    for _ in 0..prepared.steps {
        let start = Instant::now();
        let stepped = runner.step();
        wall += start.elapsed();
        if let Err(error) = stepped {
            return Ok((wall, Some(error), trace));
        }
        if let Some(trace) = &mut trace {
            trace.add(runner)?;
        }
        watch.look(runner);
    }
    Ok((wall, None, trace))
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
    match error {
        Error::Diverged(_) | Error::Unreachable { .. } => Failure::diverged(message),
        _ => Failure::input(message),
    }
}

fn same_file(a: Option<&Path>, b: Option<&Path>) -> bool {
    let (Some(a), Some(b)) = (a, b) else { return false };
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    absolute(a) == absolute(b)
}
