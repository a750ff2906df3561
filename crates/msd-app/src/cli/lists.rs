//! `msd scenes`, `msd methods` and `msd schema`: built-in scenes, methods, and keys of scene files.

use super::arguments::ListArguments;
use super::failure::{Failure, aligned, say, say_json};
use msd_core::Integrator;
use msd_scene::{BUILTINS, Builtin, json_schema};
use serde::Serialize;

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
