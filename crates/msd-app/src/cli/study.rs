//! `msd study`: error against cost of a scene.

use super::arguments::StudyArguments;
use super::device::{open_for_settings, settle};
use super::failure::{self, Failure, aligned, say, say_json};
use super::places::{Places, make_folder};
use super::run::{explain_divergence, open_draft, open_scene};
use super::steps::Terminal;
use msd_scene::{Loaded, shown_path, write_file};
use msd_study::choice::FRAME;
use msd_study::conduct::{INTERRUPTED, Plan, add_device, add_space, study};
use msd_study::monitor::Halt;
use msd_study::quantity::{counted, estimate, quantity};
use msd_study::terms::terms;
use msd_study::words::{off, told};
use msd_study::{OnDevice, Study};
use std::path::{Path, PathBuf};

/// Studies a scene and writes the report.
pub fn run_study(arguments: &StudyArguments) -> Result<(), Failure> {
    let loaded = open_scene(&arguments.scene, &arguments.set.set)?.restarted();
    if arguments.terms {
        return tell_terms(&loaded, arguments);
    }
    let folder = arguments.out.clone();
    let folder = folder.unwrap_or_else(|| PathBuf::from(format!("{}-study", loaded.name)));
    make_folder(&folder)?;
    let mut places = Places::of(&loaded.files, None);
    FILES.into_iter().try_for_each(|name| places.write("--out", &folder.join(name)))?;
    let plan = Plan {
        duration: arguments.duration,
        wanted: arguments.max_error,
        budget: arguments.time,
        fresh: arguments.fresh,
        ..Plan::default()
    };
    // Refuses a scene that cannot be refined before the long work.
    let draft =
        arguments.mesh.then(|| open_draft(&arguments.scene, &arguments.set.set)).transpose()?;
    if let Some(draft) = &draft {
        let refine = |source| draft.finer(&source, &loaded.scene, 1).map(drop);
        draft.source().and_then(refine).map_err(Failure::input)?;
    }
    let (mut fleet, note) = settle(&arguments.device, &loaded.name, |_| {
        open_for_settings(&arguments.device, &loaded.scene)
    })?;
    note.iter().for_each(|line| failure::note(line));
    let mut terminal = Terminal::new();
    let studied = study(&loaded, plan, &mut terminal);
    let (mut studied, is_whole) = studied.map_err(|halt| halted(&loaded.name, halt))?;
    let mut failures = Vec::new();
    if let Some(fleet) = fleet.as_mut().filter(|_| is_whole) {
        let added = add_device(&mut studied, &loaded.scene, fleet, &mut terminal);
        added.map_err(|halt| halted(&loaded.name, halt))?;
    }
    if let Some(draft) = draft.filter(|_| is_whole) {
        // Written first: a failure of the finer meshes must not lose the study.
        failures.extend(write(&studied, &folder));
        failures = match add_space(&mut studied, &draft, plan, &mut terminal) {
            Ok(()) => Vec::new(),
            Err(Halt::Refused(error)) => vec![Failure::input(error)],
            Err(Halt::Cancelled | Halt::Deadline) => {
                vec![Failure::interrupted("interrupted; the report has no error of space")]
            }
        };
    }
    drop(terminal);
    failures.extend(write(&studied, &folder));
    let said = match arguments.json {
        true => say_json(&studied),
        false => say(&summary(&studied, &folder)),
    };
    failures.extend(said.err());
    Failure::all(failures.into_iter().chain(interruption(&studied, is_whole)))
}

/// The failure of a study that the user ended early.
fn interruption(studied: &Study, is_whole: bool) -> Option<Failure> {
    if !is_whole {
        let count = studied.trials.len();
        return Some(Failure::interrupted(format!(
            "interrupted after {count} trials; the report covers these, and the same command \
             resumes"
        )));
    }
    let fault = studied.on_device.as_ref()?.fault.as_deref();
    (fault == Some(INTERRUPTED)).then(|| {
        Failure::interrupted("interrupted; the report does not have all times of the device")
    })
}

/// Returns the failure of a halted study or search.
pub fn halted(scene: &str, halt: Halt) -> Failure {
    match halt {
        Halt::Refused(error) => explain_divergence(scene, error, None),
        Halt::Cancelled | Halt::Deadline => {
            Failure::interrupted(format!("{scene}: interrupted before anything was tried"))
        }
    }
}

/// Writes the files of a report; returns those that could not be written.
fn write(study: &Study, folder: &Path) -> Vec<Failure> {
    let json = match serde_json::to_string_pretty(study) {
        Ok(json) => json,
        Err(error) => return vec![Failure::input(error)],
    };
    let contents = [
        msd_report::html(study).into_bytes(),
        msd_report::csv(study),
        msd_report::svg(study).into_bytes(),
        msd_report::png(study),
        json.into_bytes(),
    ];
    let write = |(name, bytes): (&str, Vec<u8>)| write_file(&folder.join(name), &bytes).err();
    FILES.into_iter().zip(contents).filter_map(write).map(Failure::input).collect()
}

/// The files of a report.
const FILES: [&str; 5] =
    ["report.html", "study.csv", "work-precision.svg", "work-precision.png", "study.json"];

fn tell_terms(loaded: &Loaded, arguments: &StudyArguments) -> Result<(), Failure> {
    let rows = terms(loaded, arguments.duration, &mut Terminal::new());
    let rows = rows.map_err(|halt| match halt {
        Halt::Refused(error) => Failure::input(format!("{}: {error}", loaded.name)),
        Halt::Cancelled | Halt::Deadline => {
            Failure::interrupted("interrupted; some model terms have no result")
        }
    })?;
    if arguments.json {
        return say_json(&rows);
    }
    let lines: Vec<String> = rows.into_iter().map(|row| row.words).collect();
    say(&lines.join("\n"))
}

fn summary(study: &Study, folder: &Path) -> String {
    let Study { scene, particles, springs, size, duration, .. } = study;
    let springs = counted(*springs as u64, "spring");
    let mut lines = vec![format!(
        "{scene}: {particles} particles, {springs}, {} across, {}",
        quantity(*size, "m"),
        quantity(*duration, "s")
    )];
    lines.push(study.words.clone());
    lines.push("Pareto front:".into());
    let cells = |(row, cost): (usize, f64)| {
        let trial = &study.trials[row];
        let price = format!("{} per frame", estimate(cost * FRAME, "s"));
        [price, told(trial), off(study, trial)]
    };
    let front = study.front().into_iter().map(|row| (row, study.trials[row].cost));
    lines.extend(indented(&front.map(cells).collect::<Vec<_>>(), &[0]));
    if let Some(OnDevice { name, .. }) = &study.on_device {
        lines.push(format!("Pareto front on {name}, transfers included:"));
        let front = study.front_on_device().into_iter();
        lines.extend(indented(&front.map(cells).collect::<Vec<_>>(), &[0]));
    }
    if let Some(balance) = &study.balance {
        lines.push(format!("with the scene's solver, {}:", balance.choice));
        let heads = ["error of", "metres", "of the size", "with", "per simulated second"];
        let mut rows = vec![heads.map(String::from)];
        rows.extend(balance.rows(*size));
        lines.extend(indented(&rows, &[1, 2]));
        lines.push(balance.advice.clone());
    }
    lines.push(study.space_line());
    lines.push(format!(
        "{} trials; report: {}",
        study.trials.len(),
        shown_path(&folder.join(FILES[0]))
    ));
    lines.join("\n")
}

/// Indents a table below its heading.
fn indented<const N: usize>(rows: &[[String; N]], right: &[usize]) -> Vec<String> {
    aligned(rows, right).into_iter().map(|line| format!("  {line}")).collect()
}
