//! `xtask extremes`: maps and hardships of every method.

use super::Failure;
use clap::Args;
use msd_core::Integrator;
use msd_scene::{FileError, FileId, shown_path, write_file};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Instant;
use xtask::extremes::conduct::{Extremes, Plan, conduct};
use xtask::extremes::distance::{self, DISTANCES, Loss};
use xtask::extremes::outcome::Outcome;
use xtask::extremes::{figure, tables};
use xtask::marks::put;

/// Arguments of `xtask extremes`.
#[derive(Debug, Args)]
pub struct ExtremesArguments {
    /// The folder of the maps and tables
    #[arg(long, value_name = "FOLDER", default_value = "extremes")]
    out: PathBuf,
    /// Put the tables between the marks of this page as well, as in docs/measured/extremes.md
    #[arg(long, value_name = "PAGE.md")]
    page: Option<PathBuf>,
    /// A coarse look: some seconds instead of some minutes
    #[arg(long)]
    quick: bool,
    /// Runs at once [default: as many as there are cores]
    #[arg(short, long, value_name = "CORES")]
    #[arg(value_parser = clap::value_parser!(u16).range(1..=4096))]
    jobs: Option<u16>,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    json: bool,
}

/// Results; the keys of `--json`.
#[derive(Debug, Serialize)]
struct Report {
    runs: usize,
    seconds: f64,
    /// Cells of the maps by method and outcome.
    cells: BTreeMap<&'static str, BTreeMap<&'static str, usize>>,
    /// Outcomes that must never be; empty.
    failures: Vec<String>,
    distances: Vec<Loss>,
}

/// Runs everything and writes maps and tables.
pub fn run_extremes(arguments: &ExtremesArguments) -> Result<(), Failure> {
    let folder = &arguments.out;
    let refused = |error| Failure::input(format!("{}: {error}", shown_path(folder)));
    std::fs::create_dir_all(folder).map_err(refused)?;
    let page = arguments.page.as_deref().map(|page| open_page(page, folder)).transpose()?;
    let threads = arguments.jobs.map_or_else(available, usize::from);
    let plan = if arguments.quick { Plan::quick(threads) } else { Plan::full(threads) };
    let start = Instant::now();
    let watched = std::io::stderr().is_terminal();
    let extremes = conduct(plan, &mut |done, all| {
        if watched {
            eprint!("\r{done} of {all} runs");
        }
    });
    if watched {
        eprintln!();
    }
    let losses: Result<Vec<Loss>, _> = DISTANCES.into_iter().map(distance::loss).collect();
    let losses = losses.map_err(Failure::input)?;
    let all = all_tables(&extremes, &losses);
    write_all(folder, &extremes, &all).map_err(Failure::input)?;
    if let (Some(path), Some(text)) = (&arguments.page, page) {
        let filled =
            |text: String, (name, table): (&str, &String)| put(&text, name, table).unwrap_or(text);
        let text = NAMES.into_iter().zip(&all).fold(text, filled);
        write_file(path, text.as_bytes()).map_err(Failure::input)?;
    }
    let report = Report {
        runs: extremes.len(),
        seconds: start.elapsed().as_secs_f64(),
        cells: counts(&extremes),
        failures: extremes.failures(),
        distances: losses,
    };
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&report).map_err(Failure::input)?);
    } else {
        println!("{}", summary(&report, folder));
    }
    match report.failures.len() {
        0 => Ok(()),
        count => {
            let all = report.failures.join("; ");
            Err(Failure::broken(format!("{count} runs failed: {all}")))
        }
    }
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

/// Writes every file.
fn write_all(folder: &Path, extremes: &Extremes, all: &[String; 3]) -> Result<(), FileError> {
    let titled = TITLES.iter().zip(all).map(|(title, table)| format!("## {title}\n\n{table}"));
    let tables = [
        titled.collect::<Vec<_>>().join("\n"),
        tables::hardships_csv(extremes),
        tables::maps_csv(extremes),
    ];
    let figures = Integrator::ALL.map(|integrator| figure::svg(extremes, integrator));
    let mut files = names().into_iter().zip(tables.into_iter().chain(figures));
    files.try_for_each(|(name, text)| write_file(&folder.join(name), text.as_bytes()))
}

/// Reads a page that has marks for every table and is none of the files of the folder.
fn open_page(path: &Path, folder: &Path) -> Result<String, Failure> {
    let refused = |why: String| Failure::input(format!("{}: {why}", shown_path(path)));
    let text = std::fs::read_to_string(path).map_err(|error| refused(error.to_string()))?;
    if names().iter().any(|name| FileId::of(&folder.join(name)) == FileId::of(path)) {
        return Err(refused("--out and --page name the same file".into()));
    }
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
