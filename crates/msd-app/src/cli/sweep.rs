//! `msd sweep`: a scene over a grid of its keys.

use super::arguments::{DeviceChoice, SweepArguments};
use super::device::{GpuFleet, Refusal, check_cell, settle};
use super::failure::{self, Failure, say, say_json};
use super::places::Places;
use super::run::link;
use super::steps::Terminal;
use indicatif::ProgressBar;
use msd_run::Runner;
use msd_scene::shown_path;
use msd_study::device::{Device, Pace};
use msd_study::monitor::Progress;
use msd_study::sweep::{Cell, Store, Summary, Sweep, TableFormat, run_on, unfinished};
use serde::Serialize;
use std::ops::Range;
use std::path::Path;

/// Springs and particles of the cells that race, at most.
const MOST_RACED: usize = 400_000;

/// Lists, runs or collects cells.
pub fn run_sweep(arguments: &SweepArguments) -> Result<(), Failure> {
    if link(&arguments.sweep)?.is_some() {
        let text = "a sweep takes a sweep file, not a link: save the scene in the window, and \
                    name the file in a sweep file";
        return Err(Failure::input(text));
    }
    let sweep = Sweep::open(&arguments.sweep).map_err(Failure::input)?;
    let store = Store::of(&sweep, arguments.out.clone());
    if arguments.list {
        return list(&sweep, &store, arguments.json);
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
        let table = collect(&sweep, &store, (path, format))?;
        return tell(&table, arguments.json, || table.words());
    }
    let cells = cells(arguments, sweep.len())?;
    let whole = cells.len() == sweep.len();
    if whole {
        check_place((&sweep, &store), ("the table", &store.table_path()))?;
    }
    let mut fleet = open_fleet(arguments, &sweep, &store, cells.clone())?;
    let summary = run_cells(&sweep, &store, (cells, arguments.jobs, fleet.as_mut()))?;
    if let Some(why) = &summary.fault {
        failure::tell(&format!("warning: {why}; the processor ran the cells that were left"));
    }
    // A part of a sweep does not write the table: every task of an array would read all files.
    let table = || collect(&sweep, &store, (&store.table_path(), sweep.format()));
    let is_any = 0 < summary.run + summary.skipped;
    let (table, failed) = match (whole && is_any).then(table).transpose() {
        Ok(table) => (table, None),
        Err(failure) => (None, Some(failure)),
    };
    let device = fleet.map_or("processor".to_owned(), |fleet| fleet.name());
    let report = SweepReport { device, ..SweepReport::new(&summary, &store, table) };
    let said = tell(&report, arguments.json, || report.words());
    let ended = (0 < summary.left).then(|| {
        let left = summary.left;
        Failure::interrupted(format!("interrupted; {left} cells are left: rerun the command"))
    });
    Failure::all(said.err().into_iter().chain(failed).chain(ended))
}

/// A cell; the keys of `--list --json`.
#[derive(Serialize)]
struct CellRow {
    number: usize,
    hash: String,
    done: bool,
    /// The values of the grid, in readable form.
    values: String,
}

/// A table that was written; the keys of `--collect --json`.
#[derive(Serialize)]
struct TableReport {
    table: String,
    rows: usize,
    /// Cells that are not done.
    missing: usize,
}

/// Summary of a sweep; the keys of `--json`.
#[derive(Serialize)]
struct SweepReport {
    /// Cells run.
    run: usize,
    /// Cells that were already done.
    skipped: usize,
    /// Cells run that diverged.
    diverged: usize,
    /// Cells that Ctrl-C left undone.
    left: usize,
    /// `processor`, or the graphics adapter of the sweep.
    device: String,
    /// Cells run on the adapter.
    on_device: usize,
    folder: String,
    /// Null if only some cells were selected.
    table: Option<TableReport>,
}

impl SweepReport {
    fn new(summary: &Summary, store: &Store, table: Option<TableReport>) -> Self {
        let &Summary { run, skipped, diverged, left, on_device, .. } = summary;
        let (device, folder) = (String::new(), shown_path(store.folder()));
        SweepReport { run, skipped, diverged, left, device, on_device, folder, table }
    }

    fn words(&self) -> String {
        let SweepReport { run, skipped, diverged, folder, table, .. } = self;
        let cells = if run + skipped == 1 { "cell" } else { "cells" };
        let diverged = match diverged {
            0 => String::new(),
            count => format!(" ({count} diverged)"),
        };
        let count = run + skipped;
        let line =
            format!("{count} {cells}: {run} run{diverged}, {skipped} done before; in {folder}");
        let table = table.as_ref().map(TableReport::words);
        [Some(line), table].into_iter().flatten().collect::<Vec<_>>().join("\n")
    }
}

impl TableReport {
    fn words(&self) -> String {
        let TableReport { table, rows, .. } = self;
        let rows = if *rows == 1 { "1 row".into() } else { format!("{rows} rows") };
        format!("{rows} in {table}")
    }
}

/// Prints a report as JSON or in words.
fn tell(
    report: &impl Serialize,
    json: bool,
    words: impl FnOnce() -> String,
) -> Result<(), Failure> {
    match json {
        true => say_json(report),
        false => say(&words()),
    }
}

/// Refuses a table that would overwrite the input of the sweep, or one of its cells.
fn check_place(
    (sweep, store): (&Sweep, &Store),
    (option, path): (&str, &Path),
) -> Result<(), Failure> {
    let mut places = Places::default();
    for number in 0..sweep.len() {
        let cell = sweep.cell(number).map_err(Failure::input)?;
        places.read("a cell", &store.path(&cell));
    }
    // The cells have named their meshes by now.
    sweep.files().iter().for_each(|file| places.read("SWEEP", file));
    places.write(option, path)
}

/// Returns the selected cells.
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

fn list(sweep: &Sweep, store: &Store, json: bool) -> Result<(), Failure> {
    // All cells before the first line: a list cut short by an error would look complete.
    let mut rows = Vec::with_capacity(sweep.len());
    for number in 0..sweep.len() {
        let cell = sweep.cell(number).map_err(Failure::input)?;
        let done = store.row(sweep, &cell).is_some();
        if !done {
            sweep.load(&cell).map_err(Failure::input)?;
        }
        rows.push(CellRow { number, hash: cell.hash.clone(), done, values: sweep.words(&cell) });
    }
    let width = (sweep.len() - 1).to_string().len();
    let line = |row: &CellRow| {
        let CellRow { number, hash, done, values } = row;
        let state = if *done { "done" } else { "to-do" };
        format!("{number:>width$}  {hash}  {state:<5}  {values}")
    };
    tell(&rows, json, || rows.iter().map(line).collect::<Vec<_>>().join("\n"))
}

/// Opens the device of a sweep, if it has one, and prints a note on it.
fn open_fleet(
    arguments: &SweepArguments,
    sweep: &Sweep,
    store: &Store,
    cells: Range<usize>,
) -> Result<Option<GpuFleet>, Failure> {
    let SweepArguments { device: choice, jobs, sweep: path, .. } = arguments;
    if *choice == DeviceChoice::Processor {
        return Ok(None);
    }
    let todo = unfinished(sweep, store, cells).map_err(Failure::input)?;
    if todo.is_empty() {
        return Ok(None);
    }
    let checked = check_cells(sweep, &todo, *choice == DeviceChoice::Auto)?;
    let (fleet, note) = settle(choice, &shown_path(path), |is_auto| {
        let samples = checked?;
        let mut fleet = GpuFleet::open(choice)?;
        let note = if is_auto { fleet.win_race(&samples, *jobs)? } else { fleet.verdict().into() };
        let note = format!("{}, {note}", fleet.name());
        Ok((fleet, note))
    })?;
    note.iter().for_each(|line| failure::note(line));
    Ok(fleet)
}

/// Refuses cells that a device does not step, or whose columns it does not measure. Returns the
/// first runs of the pace with the most springs and particles, if they are to race.
fn check_cells(
    sweep: &Sweep,
    todo: &[Cell],
    race: bool,
) -> Result<Result<Vec<Runner>, Refusal>, Failure> {
    let columns = sweep.columns_of_processor();
    if !columns.is_empty() {
        return Ok(Err(Refusal::new(
            format!("a GPU does not measure the columns {}", columns.join(", ")),
            "name others in the sweep file, such as columns = [\"outcome\", \"diverged_time\", \
             \"kinetic\", \"elastic\", \"state_hash\"]",
        )));
    }
    let mut paces: Vec<(Pace, usize, Vec<Runner>)> = Vec::new();
    for cell in todo {
        let runner = sweep.open_cell(cell).map_err(Failure::input)?.1;
        if let Err(Refusal { why, advice }) = check_cell(&runner) {
            let (number, words) = (cell.number, sweep.words(cell));
            let why = format!("cell {number} ({words}): {why}");
            return Ok(Err(Refusal { why, advice }));
        }
        let pace = Pace::of(&runner);
        let row = paces.iter().position(|known| known.0 == pace).unwrap_or_else(|| {
            paces.push((pace, 0, Vec::new()));
            paces.len() - 1
        });
        let (_, size, samples) = &mut paces[row];
        *size += runner.spring_count() + runner.particle_count();
        if race && (*size < MOST_RACED || samples.is_empty()) {
            samples.push(runner);
        }
    }
    let largest = paces.into_iter().max_by_key(|pace| pace.1);
    Ok(Ok(largest.map(|pace| pace.2).unwrap_or_default()))
}

fn run_cells(
    sweep: &Sweep,
    store: &Store,
    (cells, jobs, fleet): (Range<usize>, usize, Option<&mut GpuFleet>),
) -> Result<Summary, Failure> {
    let template = "{elapsed} {wide_bar} {pos}/{len} {msg}";
    let mut terminal = Terminal::of(ProgressBar::new(0), template, |bar, progress| {
        let Progress { now, done, parts, left } = progress;
        let all = parts.map_or(0, |[_, all]| all);
        bar.set_length(all as u64);
        bar.set_position(*done as u64);
        let Some(left) = left else { return bar.set_message(now.clone()) };
        let left = match all.saturating_sub(*done) {
            0 => String::new(),
            _ => format!(", about {} left", duration(*left)),
        };
        bar.set_message(left.trim_start_matches(", ").to_owned());
        bar.suspend(|| failure::tell(&format!("[{done}/{all}{left}] {now}")));
    });
    let fleet = fleet.map(|fleet| fleet as &mut dyn Device);
    run_on(sweep, store, (cells, jobs, fleet), &mut terminal).map_err(Failure::input)
}

/// Formats an estimated time with as few digits.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "a second".into(),
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s if s < 360_000.0 => format!("{:.0} h", s / 3600.0),
        s => format!("{:.0} days", s / 86400.0),
    }
}

fn collect(
    sweep: &Sweep,
    store: &Store,
    (path, format): (&Path, TableFormat),
) -> Result<TableReport, Failure> {
    let (table, missing) = store.collect(sweep).map_err(Failure::input)?;
    if 0 < missing {
        failure::tell(&format!("warning: {missing} of {} cells are not done", sweep.len()));
    }
    table.write(path, format).map_err(Failure::input)?;
    Ok(TableReport { table: shown_path(path), rows: table.rows.len(), missing })
}
