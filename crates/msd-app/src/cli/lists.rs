//! `msd scenes`, `msd lessons`, `msd methods` and `msd schema`: built-in scenes, lessons and their
//! sheets, methods, and keys of scene files.

use super::arguments::{LessonsArguments, ListArguments};
use super::failure::{Failure, aligned, say, say_json};
use super::places::Places;
use super::run::open_scene;
use msd_core::Integrator;
use msd_report::lesson_sheet;
use msd_run::Runner;
use msd_scene::{BUILTINS, Builtin, LESSONS, json_schema, shown_path, write_file};
use serde::Serialize;
use std::path::PathBuf;

/// A built-in scene; the keys of `--json`.
#[derive(Serialize)]
struct SceneRow {
    name: &'static str,
    title: &'static str,
}

/// A method; the keys of `--json`.
#[derive(Serialize)]
struct MethodRow {
    name: &'static str,
    /// Order of convergence on smooth motion.
    order: u32,
    /// Whether it chooses its own substeps.
    adaptive: bool,
    /// Whether it solves a linear system in each substep.
    implicit: bool,
    purpose: &'static str,
}

/// Lists the built-in scenes.
pub fn list_scenes(arguments: &ListArguments) -> Result<(), Failure> {
    let row = |builtin: &Builtin| SceneRow { name: builtin.name, title: builtin.title };
    let rows: Vec<SceneRow> = BUILTINS.iter().map(row).collect();
    list(arguments, &rows, |row| [row.name, row.title])
}

/// Lists the lessons, or writes the sheet of one.
pub fn run_lessons(arguments: &LessonsArguments) -> Result<(), Failure> {
    let Some(scene) = &arguments.scene else {
        let rows = LESSONS.map(|lesson| [lesson.name, lesson.title].map(str::to_owned));
        return say(&aligned(&rows, &[]).join("\n"));
    };
    let loaded = open_scene(scene, &arguments.set.set)?;
    let refused = |why: String| Failure::input(format!("{}: {why}", shown_path(scene)));
    let settings = Runner::open(&loaded).map_err(|error| refused(error.to_string()))?.settings();
    let sheet = lesson_sheet(&loaded, settings).map_err(refused)?;
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| PathBuf::from(format!("{}.html", loaded.name)));
    Places::of(&loaded.files, None).write("--out", &out)?;
    write_file(&out, sheet.as_bytes()).map_err(Failure::input)?;
    say(&format!("wrote {}, the teacher's sheet", shown_path(&out)))
}

/// Lists the methods.
pub fn list_methods(arguments: &ListArguments) -> Result<(), Failure> {
    let row = |method: Integrator| MethodRow {
        name: method.name(),
        order: method.order(),
        adaptive: method.is_adaptive(),
        implicit: method.is_implicit(),
        purpose: method.purpose(),
    };
    let rows = Integrator::ALL.map(row);
    list(arguments, &rows, |row| [row.name, row.purpose])
}

/// Prints the JSON Schema of scene files.
pub fn print_schema() -> Result<(), Failure> {
    say_json(&json_schema())
}

fn list<R: Serialize>(
    arguments: &ListArguments,
    rows: &[R],
    cells: impl Fn(&R) -> [&'static str; 2],
) -> Result<(), Failure> {
    if arguments.json {
        return say_json(rows);
    }
    let rows: Vec<_> = rows.iter().map(|row| cells(row).map(str::to_owned)).collect();
    say(&aligned(&rows, &[]).join("\n"))
}
