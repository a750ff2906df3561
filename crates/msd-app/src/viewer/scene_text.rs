//! The text of a scene with the values set by the user; the rest of the author's text stays.

use msd_core::{Look, Scene};
use msd_run::Runner;
use msd_scene::materials::Made;
use msd_scene::schema::find;
use msd_scene::{Assignment, Edits, Loaded, tree};
use msd_study::tune::put;
use toml_edit::{Array, DocumentMut, InlineTable, Item, TableLike, Value};

/// Rewrites the text of a scene, TOML, with the values of a run.
///
/// # Errors
/// Text that is not TOML; a key that cannot be written into it.
pub(super) fn with_values(
    text: &str,
    loaded: &Loaded,
    (runner, set): (&Runner, &Edits),
) -> Result<String, String> {
    let mut file: DocumentMut = text.parse().map_err(|error| format!("{error}"))?;
    let solver = runner.solver().row().but_for(&loaded.solver().row());
    if let Some(section) = file.get_mut("solver").and_then(Item::as_table_like_mut)
        && section.get("step").is_some_and(Item::is_str)
    {
        // `step = "auto"` is another name for automatic substeps, written as `substeps`.
        section.remove("step");
        put(section, "substeps", "auto".into());
    }
    solver.assignments().try_for_each(|edit| write_edit(&mut file, &edit))?;
    set.iter().try_for_each(|edit| write_edit(&mut file, edit))?;
    Ok(file.to_string())
}

/// Returns whether a scene read from the new text has the values of a run; `made` are the current
/// materials of its bodies.
pub(super) fn says(written: &Loaded, runner: &Runner, made: &[Option<Made>]) -> bool {
    // Multiplied values agree to single precision.
    let within = if made.iter().any(Option::is_some) { 1e-5 } else { 0.0 };
    let is_near = |read: f64, run: f64| (read - run).abs() <= within * run.abs();
    let world = |scene: &Scene| {
        let looks: Vec<Look> = scene.bodies.iter().map(|body| body.look).collect();
        let Scene { world, planes, shells, .. } = scene;
        (world.gravity, world.drag, planes.clone(), shells.clone(), looks)
    };
    let is_same = |read: &Runner| {
        let ((read, _), (run, progress)) = (read.progress(), runner.progress());
        let mut particles = read.particles.iter().zip(&run.particles);
        let mut springs = read.springs.iter().zip(&run.springs).enumerate();
        world(&read) == world(&run)
            && read.particles.len() == run.particles.len()
            && particles.all(|(read, run)| is_near(read.mass, run.mass))
            && read.springs.len() == run.springs.len()
            && springs.all(|(row, (read, run))| {
                let is_cut = progress.cut.binary_search(&row).is_ok();
                let is_alike = is_near(read.stiffness, run.stiffness);
                is_cut || is_alike && is_near(read.damping, run.damping)
            })
    };
    written.solver() == runner.solver() && Runner::open(written).is_ok_and(|read| is_same(&read))
}

/// Writes the value of a key and removes keys that exclude it.
fn write_edit(file: &mut DocumentMut, edit: &Assignment) -> Result<(), String> {
    let steps: Vec<&str> =
        edit.key().split(['.', '[', ']']).filter(|step| !step.is_empty()).collect();
    let names: Vec<&str> =
        steps.iter().copied().filter(|step| step.parse::<u64>().is_err()).collect();
    let instead_of = find(&names.join(".")).map_or(&[][..], |row| row.instead_of);
    let Some((last, above)) = steps.split_last() else { return Ok(()) };
    each_inside(file.as_table_mut(), above, &mut |table| {
        instead_of.iter().for_each(|key| drop(table.remove(key)));
        match written(edit.value()) {
            Some(value) => put(table, last, value),
            None => drop(table.remove(last)),
        }
    })
}

/// Applies `act` to the table at the end of a path, created if missing. If the path has no index
/// for the rows of a list, applies it to each row.
fn each_inside(
    table: &mut dyn TableLike,
    path: &[&str],
    act: &mut dyn FnMut(&mut dyn TableLike),
) -> Result<(), String> {
    let [name, rest @ ..] = path else {
        act(table);
        return Ok(());
    };
    let empty = || toml_edit::value(InlineTable::new());
    let item = table.entry(name).or_insert_with(empty);
    if let Some(table) = item.as_table_like_mut() {
        return each_inside(table, rest, act);
    }
    let mut rows = rows(Some(item)).into_iter();
    if let [row, rest @ ..] = rest
        && let Ok(row) = row.parse()
    {
        let row = rows.nth(row).ok_or(format!("its {name} are not listed one by one"))?;
        return each_inside(row, rest, act);
    }
    rows.try_for_each(|row| each_inside(row, rest, act))
}

/// Converts a value to TOML; `None` for a key that is left out.
fn written(value: &tree::Value) -> Option<Value> {
    Some(match value {
        tree::Value::Nothing | tree::Value::Any => return None,
        tree::Value::Flag(flag) => (*flag).into(),
        tree::Value::Whole(number) => (*number as i64).into(),
        tree::Value::Number(number) => (*number).into(),
        tree::Value::Text(text) => text.into(),
        tree::Value::List(rows) => {
            Array::from_iter(rows.iter().filter_map(|row| written(&row.value))).into()
        }
        tree::Value::Table(rows) => {
            let row = |row: &(String, _, tree::Node)| Some((row.0.clone(), written(&row.2.value)?));
            InlineTable::from_iter(rows.iter().filter_map(row)).into()
        }
    })
}

/// Returns the tables of an array in either notation.
fn rows(item: Option<&mut Item>) -> Vec<&mut dyn TableLike> {
    match item {
        Some(Item::ArrayOfTables(tables)) => {
            tables.iter_mut().map(|table| table as &mut dyn TableLike).collect()
        }
        Some(Item::Value(Value::Array(array))) => {
            let tables = array.iter_mut().filter_map(Value::as_inline_table_mut);
            tables.map(|table| table as &mut dyn TableLike).collect()
        }
        _ => Vec::new(),
    }
}
