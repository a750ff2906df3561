//! `msd study`: what a scene costs at every accuracy.

use super::arguments::StudyArguments;
use super::failure::{Failure, say};
use super::places::{Places, make_folder};
use super::run::{explain_divergence, open_draft, open_scene};
use super::steps::Bar;
use msd_scene::{Loaded, shown_path, write_file};
use msd_study::Study;
use msd_study::choice::FRAME;
use msd_study::conduct::{Plan, Progress, add_space, study};
use msd_study::quantity::{estimate, quantity, rounded};
use msd_study::terms::terms;
use msd_study::words::{off, told};
use std::path::{Path, PathBuf};

/// Studies a scene and writes the report.
pub fn run_study(arguments: &StudyArguments) -> Result<(), Failure> {
    let loaded = open_scene(&arguments.scene, &arguments.set.set)?;
    if arguments.terms {
        return tell_terms(&loaded, arguments);
    }
    let folder = arguments.out.clone();
    let folder = folder.unwrap_or_else(|| PathBuf::from(format!("{}-study", loaded.name)));
    make_folder(&folder)?;
    let mut places = Places::default();
    loaded.files.iter().for_each(|file| places.read("SCENE", file));
    FILES.into_iter().try_for_each(|name| places.write("--out", &folder.join(name)))?;
    let plan = Plan {
        duration: arguments.duration,
        wanted: arguments.max_error,
        budget: arguments.time,
        fresh: arguments.fresh,
        ..Plan::default()
    };
    // What cannot be refined is refused before the long work.
    let draft =
        arguments.mesh.then(|| open_draft(&arguments.scene, &arguments.set.set)).transpose()?;
    if let Some(draft) = &draft {
        let refine = |source| draft.finer(&source, &loaded.scene, 1).map(drop);
        draft.source().and_then(refine).map_err(Failure::input)?;
    }
    let bar = Bar::new();
    let studied = study(&loaded, plan, &mut |Progress { now, done, left, .. }| {
        let left =
            left.map_or(String::new(), |left| format!(", at most {} s left", rounded(left, 2)));
        bar.tell(&format!("{done} trials done{left}: {now}"));
    });
    let mut studied = studied.map_err(|error| explain_divergence(&loaded.name, error, None))?;
    let added = draft.map(|draft| add_space(&mut studied, &draft, plan, &mut |now| bar.tell(now)));
    // What was studied is not lost with it.
    let added = added.and_then(Result::err).map(Failure::input);
    bar.end();
    let json = serde_json::to_string_pretty(&studied).map_err(Failure::input)?;
    let contents = [
        msd_report::html(&studied).into_bytes(),
        msd_report::csv(&studied),
        msd_report::svg(&studied).into_bytes(),
        msd_report::png(&studied),
        json.clone().into_bytes(),
    ];
    let write = |(name, bytes): (&str, Vec<u8>)| write_file(&folder.join(name), &bytes).err();
    let unwritten = FILES.into_iter().zip(contents).filter_map(write).map(Failure::input);
    let unwritten: Vec<Failure> = unwritten.collect();
    let said = if arguments.json { say(&json) } else { say(&summary(&studied, &folder)) };
    Failure::all(added.into_iter().chain(unwritten).chain(said.err()))
}

/// The files of a report.
const FILES: [&str; 5] =
    ["report.html", "study.csv", "work-precision.svg", "work-precision.png", "study.json"];

fn tell_terms(loaded: &Loaded, arguments: &StudyArguments) -> Result<(), Failure> {
    let bar = Bar::new();
    bar.tell("switching off one part at a time");
    let rows = terms(loaded, arguments.duration);
    bar.end();
    let rows = rows.map_err(|error| Failure::input(format!("{}: {error}", loaded.name)))?;
    if arguments.json {
        return say(&serde_json::to_string_pretty(&rows).map_err(Failure::input)?);
    }
    let lines: Vec<String> = rows.into_iter().map(|row| row.words).collect();
    say(&lines.join("\n"))
}

fn summary(study: &Study, folder: &Path) -> String {
    let Study { scene, particles, springs, size, duration, .. } = study;
    let mut lines = vec![format!(
        "{scene}: {particles} particles, {springs} springs, {} across, {}",
        quantity(*size, "m"),
        quantity(*duration, "s")
    )];
    lines.push(study.words.clone());
    lines.push("settings that no other beats:".into());
    for row in study.front() {
        let trial = &study.trials[row];
        lines.push(format!(
            "  {:>9} per frame  {:<36}  {}",
            estimate(trial.cost * FRAME, "s"),
            told(trial),
            off(study, trial)
        ));
    }
    if let Some(balance) = &study.balance {
        lines.push(format!("as it is set, with {}:", balance.choice));
        lines.push(columns("error of", "metres", "of the size", "with", "per simulated second"));
        lines.extend(
            balance.rows(*size).iter().map(|[what, error, part, better, price]| {
                columns(what, error, part, better, price)
            }),
        );
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

/// A row of the table of errors.
fn columns(what: &str, error: &str, part: &str, better: &str, price: &str) -> String {
    format!("  {what:<9}  {error:>9}  {part:>11}  {better:<26}  {price}").trim_end().into()
}
