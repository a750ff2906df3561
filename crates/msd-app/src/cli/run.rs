//! `msd run`: how does a scene run without a window?

use super::arguments::RunArguments;
use super::failure::{Failure, say, tell};
use super::prepare::{Prepared, advise, prepare};
use super::report::{Gain, Report};
use msd_core::{Divergence, Error, Witness};
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
    let Stepped { wall, diverged, trace, gain } =
        step_all(&mut prepared, trace).map_err(Failure::input)?;
    if let Some(gain) = &gain {
        let warning = gain.warning(prepared.runner.integrator());
        tell(&format!("warning: {warning}"));
        prepared.warnings.push(warning);
    }
    if let Some(mut output) = output {
        write_state(&prepared.runner.state(), &mut output).map_err(Failure::input)?;
        output.finish().map_err(Failure::input)?;
    }
    if let Some(trace) = trace {
        trace.finish().map_err(Failure::input)?;
    }
    let report = Report::new(prepared, wall.as_secs_f64(), (diverged.is_some(), gain));
    let told = if arguments.json { report.json() } else { Ok(report.summary()) };
    say(&told.map_err(Failure::input)?)?;
    match diverged {
        Some(error) => Err(explain_divergence(&report.scene, error)),
        None => Ok(()),
    }
}

/// What stepping came to.
struct Stepped {
    /// Time that the steps took.
    wall: Duration,
    /// Why it ended early.
    diverged: Option<Error>,
    trace: Option<Trace>,
    /// Energy that the integrator added.
    gain: Option<Gain>,
}

/// Takes all steps, or as many as stay in the world; only the steps are timed.
fn step_all(prepared: &mut Prepared, trace: Option<Trace>) -> Result<Stepped, LabError> {
    let runner = &mut prepared.runner;
    let mut done = Stepped { wall: Duration::ZERO, diverged: None, trace, gain: None };
    let mut witness = Witness::default();
    runner.show_to(&mut witness);
    if let Some(trace) = &mut done.trace {
        trace.add(runner)?;
    }
    for _ in 0..prepared.steps {
        let start = Instant::now();
        let stepped = runner.step();
        done.wall += start.elapsed();
        if let Err(error) = stepped {
            done.diverged = Some(error);
            return Ok(done);
        }
        if let Some(trace) = &mut done.trace {
            trace.add(runner)?;
        }
        runner.show_to(&mut witness);
        done.gain = Gain::now(done.gain, witness.gain(), runner.time());
    }
    Ok(done)
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
