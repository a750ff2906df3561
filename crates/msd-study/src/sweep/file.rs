//! Sweep files; `docs/reference/sweeps.md` explains every key.

use crate::sweep::columns::{MEASURES, Measure};
use crate::sweep::table::TableFormat;
use crate::sweep::value::{Axis, Entry, MAX_CELLS};
use msd_scene::tree::{Source, Value};
use msd_scene::{FileError, Place, decode, format_of, nearest, plain, read_text, shown_path};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::path::{Path, PathBuf};

/// The version of the sweep file.
const VERSION: u32 = 1;

/// The keys of a sweep file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepRow {
    version: u32,
    scene: String,
    duration: Option<f64>,
    out: Option<String>,
    format: Option<TableFormat>,
    error: Option<bool>,
    columns: Option<Vec<String>>,
    /// Read from the tree, which remembers where each value was written.
    grid: Option<IgnoredAny>,
}

/// A sweep file that has been understood; the scene is only named.
pub(crate) struct SweepFile {
    pub(crate) path: PathBuf,
    pub(crate) scene: String,
    pub(crate) scene_place: Place,
    /// The folder that names in the file are relative to.
    pub(crate) folder: PathBuf,
    pub(crate) duration: f64,
    pub(crate) duration_place: Place,
    pub(crate) out: PathBuf,
    pub(crate) format: TableFormat,
    pub(crate) error: bool,
    /// The columns of measurements that the table has.
    pub(super) measures: Vec<Measure>,
    pub(crate) axes: Vec<Axis>,
    pub(crate) grid_place: Place,
}

/// Reads a sweep file, TOML or JSON by its ending.
pub(crate) fn read(path: &Path) -> Result<SweepFile, FileError> {
    let name = shown_path(path);
    let text = read_text(path, &name)?;
    let source = Source::parse(&text, format_of(path), &name)?;
    let row: SweepRow = decode(&source).map_err(in_a_sweep)?;
    if row.version != VERSION {
        let key = format_args!("version");
        return Err(source.out_of_domain(key, row.version, format!("{VERSION}")));
    }
    let duration = row.duration.unwrap_or(1.0);
    if !(0.0 < duration && duration.is_finite()) {
        let key = format_args!("duration");
        return Err(source.out_of_domain(key, plain(duration), "positive and finite"));
    }
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let out = match row.out {
        Some(out) if out.is_empty() => {
            return Err(source.out_of_domain(format_args!("out"), "\"\"", "the name of a folder"));
        }
        Some(out) => folder.join(out),
        // The file itself where it has no ending, which `Output` and `create_dir_all` would refuse.
        None if path.extension().is_none() => path.with_extension("out"),
        None => path.with_extension(""),
    };
    if row.grid.is_none() {
        return Err(in_a_sweep(source.missing(format_args!("the scene"), "grid")));
    }
    let format = row.format.unwrap_or_default();
    if let Some(instead) = format.missing() {
        let place = source.place_of("format");
        return Err(FileError::Malformed { place, reason: instead.into() });
    }
    Ok(SweepFile {
        path: path.into(),
        scene: row.scene,
        scene_place: source.place_of("scene"),
        folder,
        duration,
        duration_place: source.place_of("duration"),
        out,
        format,
        error: row.error.unwrap_or(false),
        measures: measures(row.columns.as_deref(), &source)?,
        axes: axes(&source)?,
        grid_place: source.place_of("grid"),
    })
}

/// The columns of measurements of these names, or all, in the order of the table.
fn measures(names: Option<&[String]>, source: &Source<'_>) -> Result<Vec<Measure>, FileError> {
    let Some(names) = names else { return Ok(MEASURES.to_vec()) };
    for (row, name) in names.iter().enumerate() {
        let wrong = |expected: String| {
            let value = format!("{name:?}");
            Err(source.out_of_domain(format_args!("columns[{row}]"), value, expected))
        };
        let known = || MEASURES.iter().map(|measure| measure.0);
        if !known().any(|known| known == name) {
            return wrong(match nearest(name, known()) {
                Some(near) => format!("the name of a measured column, such as {near:?}"),
                None => "the name of a measured column, such as \"state_hash\"".to_owned(),
            });
        }
        if names[..row].contains(name) {
            return wrong("named once".to_owned());
        }
    }
    let is_named = |measure: &&Measure| names.iter().any(|name| name == measure.0);
    Ok(MEASURES.iter().filter(is_named).copied().collect())
}

/// The words of a sweep for errors that it shares with scene files.
fn in_a_sweep(error: FileError) -> FileError {
    let sweep = |table: String| if table == "the scene" { "the sweep".into() } else { table };
    match error {
        FileError::UnknownKey { place, key, table, hint } => {
            FileError::UnknownKey { place, key, table: sweep(table), hint }
        }
        FileError::MissingKey { place, key, table } => {
            FileError::MissingKey { place, key, table: sweep(table) }
        }
        other => other,
    }
}

/// The axes of the grid in the order in which they were written.
fn axes(source: &Source<'_>) -> Result<Vec<Axis>, FileError> {
    let place = source.place_of("grid");
    let expected = "[grid]: keys of the scene, each with a list or range of values";
    let refused = |reason: String| FileError::Malformed { place: place.clone(), reason };
    let Value::Table(top) = &source.root.value else {
        return Err(refused(format!("a sweep needs {expected}")));
    };
    let rows = match top.iter().find(|row| row.0 == "grid").map(|row| &row.2.value) {
        Some(Value::Table(rows)) => rows,
        _ => return Err(refused(format!("grid must be {expected}"))),
    };
    let mut axes = Vec::new();
    for (key, offset, node) in rows {
        let entry = Entry { key: key.clone(), offset: *offset, value: &node.value };
        entry.add_to(&mut axes, source)?;
    }
    // TOML's tables are sorted by key; a person expects their own order.
    axes.sort_by_key(|axis| axis.offset);
    if axes.is_empty() {
        return Err(refused(format!("the grid has no cells; it must have {expected}")));
    }
    for (row, axis) in axes.iter().enumerate() {
        if let Some(other) = axes[..row].iter().find(|other| other.key.overlaps(&axis.key)) {
            let (key, other) = (axis.key.text(), other.key.text());
            let reason = format!("grid keys {other} and {key} set the same value");
            return Err(refused(reason));
        }
    }
    let counts: Vec<usize> = axes.iter().map(|axis| axis.values.len()).collect();
    let cells = counts.iter().try_fold(1usize, |cells, &count| cells.checked_mul(count));
    if cells.is_none_or(|cells| MAX_CELLS < cells) {
        let product: Vec<String> = counts.iter().map(usize::to_string).collect();
        let product = product.join(" x ");
        let cells =
            cells.map_or_else(|| "more cells than can be counted".into(), |n| format!("{n} cells"));
        return Err(refused(format!(
            "the grid has {product} = {cells}; at most {MAX_CELLS} are run as one sweep"
        )));
    }
    Ok(axes)
}
