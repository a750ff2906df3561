//! `msd export`: a run as a file for another program.

use super::arguments::ExportArguments;
use super::failure::{Failure, hush, say, say_json};
use super::places::Places;
use super::run::follow;
use super::run::prepare::{Prepared, prepare};
use super::steps::{Interrupt, Moments};
use msd_run::export::{Export, Format};
use msd_scene::{SetKeys, set_keys, shown_path};
use msd_study::quantity::{number, quantity};
use serde::Serialize;
use std::path::Path;

/// Result of an export; the keys of `--json`.
#[derive(Debug, Serialize)]
struct ExportReport {
    scene: String,
    set: SetKeys,
    /// The files, the requested one first.
    files: Vec<String>,
    format: &'static str,
    /// Moments in the file.
    moments: u64,
    /// Time from one moment to the next, seconds; null of one moment.
    every: Option<f64>,
    /// Time of the last moment from the start of the scene, seconds.
    time: f64,
    diverged: bool,
    interrupted: bool,
    notes: Vec<String>,
    warnings: Vec<String>,
}

/// Runs a scene and writes the file, also after a divergence or an interruption.
pub fn run_export(arguments: &ExportArguments) -> Result<(), Failure> {
    let ExportArguments { scene, set, solver, duration, to, every, json, quiet } = arguments;
    hush(*quiet);
    let format = format_of(to)?;
    let mut prepared = prepare((scene, set), solver, ("--duration", *duration))?;
    let interrupt = Interrupt::catch();
    let settings = prepared.runner.settings();
    let moments = Moments { from: 0.0, to: *duration, every: *every };
    let (steps, is_between) = match format.is_of_one_moment() {
        true => (vec![prepared.steps], false),
        false => moments.steps(settings, "--every")?,
    };
    let most = format.most_moments();
    if most < steps.len() as u64 {
        let (ending, count) = (format.ending(), steps.len());
        return Err(Failure::input(format!(
            "--to: a .{ending} file holds at most {most} moments, not {count}; lengthen --every"
        )));
    }
    if is_between {
        prepared.add_warning(Moments::warning(settings, "--every"));
    }
    check_places(arguments, &prepared, format)?;
    let mut export = Export::begin(to, format, &prepared.runner).map_err(Failure::input)?;
    let (_, ended) = follow(&mut prepared, (&steps, &interrupt), |runner, _| {
        export.add(runner).map_err(Failure::input)
    })?;
    let moments = export.finish(&prepared.runner).map_err(Failure::input)?;
    let interrupted = ended.as_ref().is_some_and(Failure::is_interruption);
    let report = ExportReport {
        scene: prepared.name,
        set: set_keys(&set.set),
        files: format.files(to).iter().map(|file| shown_path(file)).collect(),
        format: format.ending(),
        moments,
        every: (!format.is_of_one_moment()).then_some(*every),
        time: prepared.runner.time(),
        diverged: ended.is_some() && !interrupted,
        interrupted,
        notes: prepared.notes,
        warnings: prepared.warnings,
    };
    let said = match (json, quiet) {
        (true, _) => say_json(&report),
        (false, true) => Ok(()),
        (false, false) => say(&summary(&report)),
    };
    Failure::all(said.err().into_iter().chain(ended))
}

/// Returns the format of a file by its extension.
fn format_of(to: &Path) -> Result<Format, Failure> {
    let refused = |reason: String| Failure::input(format!("{}: {reason}", shown_path(to)));
    let format = Format::of(to).ok_or_else(|| {
        let endings = Format::ALL.map(|format| format!(".{}", format.ending()));
        let [others @ .., last] = &endings;
        refused(format!("unknown extension; use {} or {last}", others.join(", ")))
    })?;
    match format.missing() {
        Some(instead) => Err(refused(instead.into())),
        None => Ok(format),
    }
}

fn check_places(
    arguments: &ExportArguments,
    prepared: &Prepared,
    format: Format,
) -> Result<(), Failure> {
    let mut places = Places::of(&prepared.files, arguments.solver.from.as_deref());
    let files = format.files(&arguments.to);
    let options = ["--to", "the mesh of --to"];
    options.iter().zip(&files).try_for_each(|(option, file)| places.write(option, file))
}

fn summary(report: &ExportReport) -> String {
    let ExportReport { scene, files, moments, every, time, .. } = report;
    let what = match every {
        Some(every) => format!(
            "{moments} moments of {scene}, {} apart, to {}",
            quantity(*every, "s"),
            quantity(*time, "s")
        ),
        None => format!("{scene} after {}", quantity(*time, "s")),
    };
    let mut lines = report.notes.clone();
    lines.push(format!("{}: {what}", files[0]));
    lines.extend(files.get(1).map(|mesh| format!("{mesh}: the mesh that it moves")));
    if report.format == Format::Pc2.ending() {
        let every = every.unwrap_or_default();
        lines.push(format!("in Blender, a scene of {} frames per second", number(1.0 / every)));
    }
    lines.join("\n")
}
