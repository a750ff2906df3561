//! `msd extremes`: what becomes of a run at the extremes, under every method?

use super::arguments::ExtremesArguments;
use super::failure::{Failure, say};
use super::places::{Places, make_folder, write_file};
use super::progress::Bar;
use msd_core::Integrator;
use msd_lab::extremes::conduct::{Extremes, Plan, conduct};
use msd_lab::extremes::distance::{self, DISTANCES, Loss};
use msd_lab::extremes::outcome::Outcome;
use msd_lab::extremes::{figure, tables};
use msd_lab::marks::put;
use msd_lab::{LabError, shown_path};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use web_time::Instant;

/// What came of it; the keys of `--json`.
#[derive(Debug, Serialize)]
struct Report {
    runs: usize,
    seconds: f64,
    /// Cells of the maps by method and outcome.
    cells: BTreeMap<&'static str, BTreeMap<&'static str, usize>>,
    /// What must never be; empty.
    failures: Vec<String>,
    distances: Vec<Loss>,
}

/// Runs everything and writes maps and tables.
pub fn run_extremes(arguments: &ExtremesArguments) -> Result<(), Failure> {
    let folder = &arguments.out;
    make_folder(folder)?;
    let mut places = Places::default();
    names().iter().try_for_each(|name| places.write("--out", &folder.join(name)))?;
    arguments.page.iter().try_for_each(|page| places.write("--page", page))?;
    let page = arguments.page.as_deref().map(open_page).transpose()?;
    let threads = arguments.jobs.unwrap_or_else(available);
    let plan = if arguments.quick { Plan::quick(threads) } else { Plan::full(threads) };
    let start = Instant::now();
    let bar = Bar::new();
    let extremes = conduct(plan, &mut |done, all| bar.tell(&format!("{done} of {all} runs")));
    let losses: Result<Vec<Loss>, _> = DISTANCES.into_iter().map(distance::loss).collect();
    bar.end();
    let losses = losses.map_err(Failure::input)?;
    let all = all_tables(&extremes, &losses);
    let mut unwritten = write_all(folder, &extremes, &all);
    if let (Some(path), Some(text)) = (&arguments.page, page) {
        let filled =
            |text: String, (name, table): (&str, &String)| put(&text, name, table).unwrap_or(text);
        let text = NAMES.into_iter().zip(&all).fold(text, filled);
        unwritten.extend(write_file(path, text.as_bytes()).err());
    }
    let failures = extremes.failures();
    let report = Report {
        runs: extremes.len(),
        seconds: start.elapsed().as_secs_f64(),
        cells: counts(&extremes),
        failures,
        distances: losses,
    };
    let said = if arguments.json {
        say(&serde_json::to_string_pretty(&report).map_err(Failure::input)?)
    } else {
        say(&summary(&report, folder))
    };
    let count = report.failures.len();
    let failed = (0 < count)
        .then(|| Failure::diverged(format!("{count} runs failed: {}", report.failures.join("; "))));
    let unwritten = unwritten.into_iter().map(Failure::input);
    Failure::all(unwritten.chain(said.err()).chain(failed))
}

fn available() -> usize {
    std::thread::available_parallelism().map_or(1, |count| count.get())
}

/// The tables of a page by the names of their marks, and their titles.
const NAMES: [&str; 3] = ["cells", "hardships", "distances"];
const TITLES: [&str; 3] = ["Cells of the maps", "Hardships", "Far from the origin"];

fn all_tables(extremes: &Extremes, losses: &[Loss]) -> [String; 3] {
    [tables::summary(extremes), tables::hardships(extremes), tables::distances(losses)]
}

/// The files of a folder: tables, and a figure of each method.
fn names() -> Vec<String> {
    let tables = ["tables.md", "hardships.csv", "maps.csv"].map(String::from);
    let figures = Integrator::ALL.map(|integrator| format!("{integrator}.svg"));
    tables.into_iter().chain(figures).collect()
}

/// Writes every file; returns those that could not be.
fn write_all(folder: &Path, extremes: &Extremes, all: &[String; 3]) -> Vec<LabError> {
    let titled = TITLES.iter().zip(all).map(|(title, table)| format!("## {title}\n\n{table}"));
    let tables = [
        titled.collect::<Vec<_>>().join("\n"),
        tables::hardships_csv(extremes),
        tables::maps_csv(extremes),
    ];
    let figures = Integrator::ALL.map(|integrator| figure::svg(extremes, integrator));
    let files = names().into_iter().zip(tables.into_iter().chain(figures));
    let write = |(name, text): (String, String)| write_file(&folder.join(name), text.as_bytes());
    files.filter_map(|file| write(file).err()).collect()
}

/// Reads a page that has marks for every table.
fn open_page(path: &Path) -> Result<String, Failure> {
    let refused = |why: String| Failure::input(format!("{}: {why}", shown_path(path)));
    let text = std::fs::read_to_string(path).map_err(|error| refused(error.to_string()))?;
    match NAMES.into_iter().find(|name| put(&text, name, "").is_none()) {
        Some(name) => {
            Err(refused(format!("it has no marks <!-- begin {name} --> and <!-- end {name} -->")))
        }
        None => Ok(text),
    }
}

fn counts(extremes: &Extremes) -> BTreeMap<&'static str, BTreeMap<&'static str, usize>> {
    let of = |integrator: Integrator| {
        let count = |outcome: Outcome| -> usize {
            extremes.maps_of(integrator).map(|map| map.count(outcome)).sum()
        };
        let counts = Outcome::ALL.map(|outcome| (outcome.name(), count(outcome)));
        (integrator.name(), counts.into_iter().filter(|&(_, count)| 0 < count).collect())
    };
    Integrator::ALL.into_iter().map(of).collect()
}

fn summary(report: &Report, folder: &Path) -> String {
    let mut lines = vec![format!("{} runs in {:.1} s", report.runs, report.seconds)];
    for (method, counts) in &report.cells {
        let counts: Vec<String> =
            counts.iter().map(|(outcome, count)| format!("{count} {outcome}")).collect();
        lines.push(format!("{method:<17} {}", counts.join(", ")));
    }
    lines.push(format!("maps and tables in {}", shown_path(folder)));
    lines.join("\n")
}
