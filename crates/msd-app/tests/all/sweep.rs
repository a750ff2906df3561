//! `msd sweep` in one process or several, at once or in pieces: the same result.

use crate::common::{done, outcome, refused, text};
use msd_study::sweep::{Datum, Store, Sweep, Table, TableFormat};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Twelve cells of a few milliseconds.
const SMALL: &str = "version = 1\nscene = 'chain'\nduration = 0.2\nerror = true\n[grid]\n\
    'solver.integrator' = ['velocity-verlet', 'rk4']\n'solver.substeps' = [4, 8, 16]\n\
    'bodies[0].stiffness' = [10, 40]\n'solver.precision' = ['f64']\n";

/// Cells long enough for a kill between two of them, or in the middle of one.
const LONG: &str = "version = 1\nscene = 'chain'\nduration = 200\n[grid]\n\
    'solver.substeps' = { from = 100, to = 123, count = 24 }\n";

fn folder(sweep: &str) -> TempDir {
    let folder = crate::common::folder();
    fs::write(folder.path().join("small.toml"), sweep).expect("a file");
    folder
}

fn msd(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = crate::common::msd(folder, &[&["sweep", "small.toml"], arguments].concat());
    command.env("MSD_CACHE", folder.join("cache"));
    command
}

fn start(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = msd(folder, arguments);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("msd starts")
}

/// Returns the files of cells; unfinished files of a killed run begin with a dot.
fn cells(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder.join("small")) else { return Vec::new() };
    let paths = entries.flatten().map(|entry| entry.path());
    let shown = |path: &PathBuf| {
        !path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'))
    };
    paths.filter(shown).collect()
}

/// Reads the table of the whole sweep without the columns of durations.
fn table(folder: &Path) -> Vec<Vec<Datum>> {
    timeless(&read(folder, &folder.join("small.csv")))
}

/// Reads a table in the folder of the sweep, which defines the types of the CSV columns.
fn read(folder: &Path, path: &Path) -> Table {
    let sweep = Sweep::open(&folder.join("small.toml")).expect("a sweep");
    let columns = Store::of(&sweep, None).collect(&sweep).expect("a table").0.columns;
    Table::read(path, TableFormat::Csv, &columns).expect("a whole file")
}

fn timeless(table: &Table) -> Vec<Vec<Datum>> {
    let times = ["cpu_seconds", "cpu_per_second", "wall_seconds", "spring_updates_per_second"];
    let kept = |place: &usize| !times.contains(&table.columns[*place].name.as_str());
    let places: Vec<usize> = (0..table.columns.len()).filter(kept).collect();
    assert_eq!(places.len() + times.len(), table.columns.len());
    let row = |row: &Vec<Datum>| places.iter().map(|&place| row[place].clone()).collect();
    table.rows.iter().map(row).collect()
}

/// Returns the result of a single process for the small sweep.
fn alone() -> Vec<Vec<Datum>> {
    let folder = folder(SMALL);
    let said = done(msd(folder.path(), &[]));
    assert_eq!(
        said.lines().collect::<Vec<_>>(),
        ["12 cells: 12 run, 0 done before; in small", "12 rows in small.csv"]
    );
    let rows = table(folder.path());
    assert_eq!((rows.len(), cells(folder.path()).len()), (12, 12));
    rows
}

#[test]
fn four_processes_make_the_same_table_as_one() {
    let alone = alone();
    // Each process runs a part, as on a cluster.
    let parts = folder(SMALL);
    let blocks = ["0-2", "3-5", "6-8", "9-99"];
    let children = blocks.map(|block| start(parts.path(), &["--tasks", block]));
    for child in children {
        let output = child.wait_with_output().expect("msd ends");
        assert!(text(&output.stdout).starts_with("3 cells: 3 run"), "{}", text(&output.stderr));
    }
    assert!(!parts.path().join("small.csv").exists());
    let said = done(msd(parts.path(), &["--collect", "small.csv"]));
    assert_eq!(said, "12 rows in small.csv\n");
    assert_eq!(table(parts.path()), alone);
    // Each process runs everything.
    let whole = folder(SMALL);
    let children = [(); 4].map(|()| start(whole.path(), &["-j", "2"]));
    for child in children {
        let output = child.wait_with_output().expect("msd ends");
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }
    assert_eq!(table(whole.path()), alone);
    assert_eq!(cells(whole.path()).len(), 12);
}

#[test]
fn a_row_has_time_and_error_and_finer_steps_err_less() {
    let folder = folder(SMALL);
    done(msd(folder.path(), &["-j", "2"]));
    let table = read(folder.path(), &folder.path().join("small.csv"));
    let value = |row: usize, name: &str| {
        let value = &table.rows[row][table.place(name).expect(name)];
        value.as_number().unwrap_or_else(|| panic!("{name} of row {row} is {value:?}"))
    };
    for row in 0..12 {
        assert!(0.0 < value(row, "cpu_seconds") && value(row, "rms_error") < 1e-3);
        assert!(value(row, "rms_error") <= value(row, "max_error"));
        let relative = value(row, "rms_error") / value(row, "size");
        assert!((value(row, "relative_error") / relative - 1.0).abs() < 1e-12);
        assert_eq!(value(row, "samples"), 12.0);
    }
    // Rows 0, 2 and 4: velocity Verlet with 4, 8 and 16 substeps, each with a second-order error.
    for (coarse, fine) in [(0, 2), (2, 4)] {
        let ratio = value(coarse, "rms_error") / value(fine, "rms_error");
        assert!((3.0..5.0).contains(&ratio), "{ratio}");
    }
}

/// Asserts that each visible file of a cell is whole.
fn assert_whole(folder: &Path) {
    for path in cells(folder) {
        let table = read(folder, &path);
        assert_eq!(table.rows.len(), 1, "{}", path.display());
    }
}

#[test]
fn a_sweep_that_is_killed_leaves_whole_files_and_is_resumed() {
    let folder = folder(LONG);
    let mut child = start(folder.path(), &[]);
    let patience = Instant::now() + Duration::from_secs(60);
    while cells(folder.path()).len() < 3 {
        assert!(Instant::now() < patience, "no cell was finished");
        assert_whole(folder.path());
        std::thread::sleep(Duration::from_millis(1));
    }
    // SIGKILL: no handler runs.
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    assert_whole(folder.path());
    let before = cells(folder.path()).len();
    assert!((3..24).contains(&before), "{before} cells are done");
    assert!(!folder.path().join("small.csv").exists());
    // The leftover of a process that was killed during a write.
    fs::write(folder.path().join("small/.msd-killed.part"), "PAR1").expect("a file");
    let listed = done(msd(folder.path(), &["--list"]));
    assert_eq!(listed.matches("  done   solver").count(), before);
    assert_eq!(listed.matches("  to-do  solver").count(), 24 - before);
    let said = done(msd(folder.path(), &["-j", "2"]));
    let expected = format!("24 cells: {} run, {before} done before; in small\n", 24 - before);
    assert!(said.starts_with(&expected), "{said}");
    assert_eq!((table(folder.path()).len(), cells(folder.path()).len()), (24, 24));
    assert!(done(msd(folder.path(), &[])).starts_with("24 cells: 0 run, 24 done before"));
}

#[test]
fn a_list_has_number_hash_state_and_values_of_each_cell() {
    let folder = folder(SMALL);
    let listed = done(msd(folder.path(), &["--list"]));
    let lines: Vec<&str> = listed.lines().collect();
    assert_eq!(lines.len(), 12);
    let sweep = Sweep::open(&folder.path().join("small.toml")).expect("a sweep");
    let cell = sweep.cell(3).expect("a cell");
    let words = "solver.integrator = \"velocity-verlet\", solver.substeps = 8, \
        bodies[0].stiffness = 40, solver.precision = \"f64\"";
    assert_eq!(lines[3], format!(" 3  {}  to-do  {words}", cell.hash));
    assert!(!folder.path().join("small").exists());
    let output = outcome(msd(folder.path(), &["--task", "3"]));
    assert_eq!(text(&output.stdout), "1 cell: 1 run, 0 done before; in small\n");
    assert!(text(&output.stderr).starts_with("[1/1] cell 3 finished, "));
    let store = Store::of(&sweep, None);
    assert!(store.path(&cell).is_file());
    assert!(done(msd(folder.path(), &["--list"])).contains(&format!(" 3  {}  done ", cell.hash)));
    assert!(done(msd(folder.path(), &["--task", "3"])).starts_with("1 cell: 0 run, 1 done before"));
}

#[test]
fn part_of_a_sweep_is_collected_with_a_warning() {
    let folder = folder(SMALL);
    done(msd(folder.path(), &["--tasks", "4-5", "--out", "elsewhere"]));
    let output = outcome(msd(folder.path(), &["--collect", "now.csv", "--out", "elsewhere"]));
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(text(&output.stderr), "warning: 10 of 12 cells are not done\n");
    assert_eq!(text(&output.stdout), "2 rows in now.csv\n");
    let csv = fs::read_to_string(folder.path().join("now.csv")).expect("a table");
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[0].starts_with(
        "cell,hash,scene,solver.integrator,solver.substeps,bodies[0].stiffness,solver.precision,"
    ));
    assert_eq!(lines.len(), 3);
    assert!(lines[1].starts_with("4,") && lines[2].starts_with("5,"));
}

#[test]
fn bad_arguments_are_refused_in_one_line() {
    let folder = folder(SMALL);
    let told = |arguments: &[&str]| refused(msd(folder.path(), arguments), 2);
    assert_eq!(
        told(&["--task", "12"]),
        "error: --task names cell 12; it must be from 0 to 11: there are 12 cells in small.toml\n"
    );
    assert!(told(&["--tasks", "12-20"]).contains("--tasks names cell 12; it must be from 0 to 11"));
    assert!(told(&["--tasks", "5-3"]).contains("must be A-B, two whole numbers in ascending"));
    assert!(told(&["--task", "-1"]).contains("--task"));
    assert!(told(&["-j", "0"]).contains("must be a whole number from 1 to 4096"));
    assert!(told(&["--list", "--task", "1"]).contains("cannot be used with"));
    let collect = told(&["--collect", "table.xlsx"]);
    assert!(collect.contains("--collect table.xlsx: must end in .csv or .parquet"), "{collect}");
    fs::write(folder.path().join("small.toml"), SMALL.replace("16", "-16")).expect("a file");
    let bad = "error: small.toml:7:28: solver.substeps is -16; it must be a whole number from 1 to \
        4294967295, or \"auto\"\n";
    for arguments in [&[][..], &["--list"], &["--tasks", "0-11"]] {
        assert_eq!(told(arguments), bad);
    }
    assert!(!folder.path().join("small").exists());
    fs::remove_file(folder.path().join("small.toml")).expect("removed");
    assert!(told(&[]).starts_with("error: small.toml: cannot be read: "));
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_sweep_with_a_table_of_the_cells_that_are_done() {
    let folder = folder(LONG);
    let child = start(folder.path(), &["--jobs", "2"]);
    let begin = Instant::now();
    while cells(folder.path()).len() < 2 {
        assert!(begin.elapsed() < Duration::from_secs(120), "no cell is done");
        std::thread::sleep(Duration::from_millis(5));
    }
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &id]).status().expect("kill starts");
    assert!(sent.success());
    let output = child.wait_with_output().expect("msd ends");
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{told}");
    let last = told.lines().next_back().unwrap_or_default();
    assert!(last.starts_with("error: interrupted; ") && last.contains("cells are left"), "{told}");
    let done = cells(folder.path()).len();
    assert!((2..24).contains(&done), "{done}");
    assert_eq!(table(folder.path()).len(), done);
    let names = fs::read_dir(folder.path().join("small")).expect("a folder").flatten();
    let parts = names.filter(|name| name.file_name().to_string_lossy().contains(".part")).count();
    assert_eq!(parts, 0);
}
