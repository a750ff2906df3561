//! `msd sweep`: a scene over a grid of its keys.

use super::arguments::SweepArguments;
use super::failure::{Failure, say, tell};
use super::places::Places;
use super::run::link;
use indicatif::{ProgressBar, ProgressStyle};
use msd_scene::shown_path;
use msd_study::sweep::{Event, Store, Summary, Sweep, TableFormat};
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Lists, runs or collects cells.
pub fn run_sweep(arguments: &SweepArguments) -> Result<(), Failure> {
    if link(&arguments.sweep)?.is_some() {
        let text = "a sweep takes a sweep file, no link: save the scene in the window, and name \
                    the file in a sweep file";
        return Err(Failure::input(text));
    }
    let sweep = Sweep::open(&arguments.sweep).map_err(Failure::input)?;
    let store = Store::of(&sweep, arguments.out.clone());
    if arguments.list {
        return list(&sweep, &store);
    }
    if let Some(path) = &arguments.collect {
        let format = TableFormat::of(path).ok_or_else(|| {
            let path = shown_path(path);
            Failure::input(format!("--collect {path}: must end in .csv or .parquet"))
        })?;
        if let Some(instead) = format.missing() {
            return Err(Failure::input(format!("--collect {}: {instead}", shown_path(path))));
        }
        check_place((&sweep, &store), ("--collect", path))?;
        return collect(&sweep, &store, (path, format));
    }
    let cells = cells(arguments, sweep.len())?;
    let whole = cells.len() == sweep.len();
    if whole {
        check_place((&sweep, &store), ("the table", &store.table_path()))?;
    }
    let summary = run_cells(&sweep, &store, (cells, arguments.jobs))?;
    let said = say(&words(&summary, &store)).err();
    // A part of a sweep leaves the table alone: every task of an array would read all files.
    let table = || collect(&sweep, &store, (&store.table_path(), sweep.format())).err();
    let collected = if whole { table() } else { None };
    Failure::all(said.into_iter().chain(collected))
}

/// Refuses a table over what the sweep is read from, or over one of its cells.
fn check_place(
    (sweep, store): (&Sweep, &Store),
    (option, path): (&str, &Path),
) -> Result<(), Failure> {
    let mut places = Places::default();
    for number in 0..sweep.len() {
        let cell = sweep.cell(number).map_err(Failure::input)?;
        places.read("a cell", &store.path(&cell));
    }
    // By now the cells have named their meshes.
    sweep.files().iter().for_each(|file| places.read("SWEEP", file));
    places.write(option, path)
}

/// The cells that were asked for.
fn cells(arguments: &SweepArguments, count: usize) -> Result<Range<usize>, Failure> {
    let (flag, first, last) = match (arguments.task, arguments.tasks) {
        (Some(task), _) => ("--task", task, task),
        // The last block of an array may be short.
        (None, Some((first, last))) => ("--tasks", first, last.min(count - 1)),
        (None, None) => return Ok(0..count),
    };
    if count <= first {
        let cells = if count == 1 { "is 1 cell" } else { &format!("are {count} cells") };
        let name = shown_path(&arguments.sweep);
        return Err(Failure::input(format!(
            "{flag} names cell {first}; it must be from 0 to {}: there {cells} in {name}",
            count - 1
        )));
    }
    Ok(first..last + 1)
}

fn list(sweep: &Sweep, store: &Store) -> Result<(), Failure> {
    // Every cell before the first line: a list that ends in an error would be taken for whole.
    let mut lines = Vec::with_capacity(sweep.len());
    let width = (sweep.len() - 1).to_string().len();
    for number in 0..sweep.len() {
        let cell = sweep.cell(number).map_err(Failure::input)?;
        let state = if store.row(sweep, &cell).is_some() {
            "done"
        } else {
            sweep.load(&cell).map_err(Failure::input)?;
            "to-do"
        };
        lines.push(format!("{number:>width$}  {}  {state:<5}  {}", cell.hash, sweep.words(&cell)));
    }
    say(&lines.join("\n"))
}

fn run_cells(
    sweep: &Sweep,
    store: &Store,
    (cells, jobs): (Range<usize>, usize),
) -> Result<Summary, Failure> {
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{elapsed} {wide_bar} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    let (done, planned) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let hear = |event: Event| match &event {
        Event::Planned { todo, .. } => {
            planned.store(*todo, Ordering::Relaxed);
            bar.set_length(*todo as u64);
            bar.set_message("checking");
        }
        Event::Checked => bar.inc(1),
        Event::Finished { left, .. } => {
            let (done, planned) =
                (done.fetch_add(1, Ordering::Relaxed) + 1, planned.load(Ordering::Relaxed));
            let left = match planned.saturating_sub(done) {
                0 => String::new(),
                _ => format!(", about {} left", duration(*left)),
            };
            bar.set_position(done as u64);
            bar.set_message(left.trim_start_matches(", ").to_owned());
            bar.suspend(|| tell(&format!("[{done}/{planned}{left}] {event}")));
        }
        _ => {}
    };
    let summary = msd_study::sweep::run(sweep, store, (cells, jobs), &hear);
    bar.finish_and_clear();
    summary.map_err(Failure::input)
}

/// A time in words, no more exact than an estimate is.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "a second".into(),
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s if s < 360_000.0 => format!("{:.0} h", s / 3600.0),
        s => format!("{:.0} days", s / 86400.0),
    }
}

fn words(summary: &Summary, store: &Store) -> String {
    let Summary { run, skipped, diverged } = summary;
    let cells = if run + skipped == 1 { "cell" } else { "cells" };
    let diverged = match diverged {
        0 => String::new(),
        count => format!(" ({count} diverged)"),
    };
    let folder = shown_path(store.folder());
    format!("{} {cells}: {run} run{diverged}, {skipped} done before; in {folder}", run + skipped)
}

fn collect(
    sweep: &Sweep,
    store: &Store,
    (path, format): (&Path, TableFormat),
) -> Result<(), Failure> {
    let (table, missing) = store.collect(sweep).map_err(Failure::input)?;
    if 0 < missing {
        tell(&format!("warning: {missing} of {} cells are not done", sweep.len()));
    }
    table.write(path, format).map_err(Failure::input)?;
    let rows = table.rows.len();
    let rows = if rows == 1 { "1 row".into() } else { format!("{rows} rows") };
    say(&format!("{rows} in {}", shown_path(path)))
}
