//! The solver section of a scene file, rewritten for a choice; the rest of the file stays, comments
//! too.

use crate::candidates::choice::{Choice, Fineness};
use msd_scene::schema::SolverRow;
use msd_scene::{FileError, SceneFormat, read};
use toml_edit::{Item, TableLike, Value};

/// Rewrites the solver section of a scene file so that it asks for a choice.
///
/// # Errors
/// Text that is not a scene file, see [`msd_scene::read`].
pub fn with_choice(
    text: &str,
    format: SceneFormat,
    name: &str,
    choice: Choice,
) -> Result<String, FileError> {
    // Refuses mistakes with the words of a reader of scenes, not of an editor.
    read(text, format, name)?;
    let written = rewritten(text, format, name, choice)?;
    // The editors end lines as Unix does.
    let unix = written.replace("\r\n", "\n");
    Ok(if text.contains("\r\n") { unix.replace('\n', "\r\n") } else { unix })
}

fn rewritten(
    text: &str,
    format: SceneFormat,
    name: &str,
    choice: Choice,
) -> Result<String, FileError> {
    let refused = |reason: String| FileError::Unreadable { file: name.into(), reason };
    match format {
        SceneFormat::Toml => {
            let mut file: toml_edit::DocumentMut =
                text.parse().map_err(|error: toml_edit::TomlError| refused(error.to_string()))?;
            let solver = file.entry("solver").or_insert_with(toml_edit::table);
            let Some(solver) = solver.as_table_like_mut() else {
                return Err(refused("its solver is not a table".into()));
            };
            solver.remove(CONTRADICTED);
            for (key, value) in entries(choice) {
                put(solver, &key, toml_value(value));
            }
            Ok(file.to_string())
        }
        SceneFormat::Json => {
            // The byte order mark, which some editors put first, is not a part of JSON.
            let text = text.trim_start_matches('\u{feff}');
            let mut file: serde_json::Value =
                serde_json::from_str(text).map_err(|error| refused(error.to_string()))?;
            let solver = &mut file["solver"];
            if solver.is_null() {
                *solver = serde_json::json!({});
            }
            let Some(solver) = solver.as_object_mut() else {
                return Err(refused("its solver is not an object".into()));
            };
            solver.shift_remove(CONTRADICTED);
            solver.extend(entries(choice));
            let text = serde_json::to_string_pretty(&file);
            Ok(text.map_err(|error| refused(error.to_string()))? + "\n")
        }
    }
}

/// Sets a key of a table of a scene file; a comment beside its old value stays.
pub fn put(table: &mut dyn TableLike, key: &str, mut value: Value) {
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        None => drop(table.insert(key, toml_edit::value(value))),
    }
}

/// The keys of the solver section that ask for a choice, with their values.
fn entries(choice: Choice) -> serde_json::Map<String, serde_json::Value> {
    let Choice { integrator, fineness, precision } = choice;
    let fineness = match fineness {
        Fineness::Substeps(substeps) => SolverRow::substeps(substeps),
        Fineness::Tolerance(tolerance) => SolverRow::tolerance(tolerance),
    };
    let row = SolverRow { integrator: Some(integrator), precision: Some(precision), ..fineness };
    let mut entries = row.entries();
    entries.insert("steps_per_second".into(), 60.into());
    entries
}

/// The key that excludes `steps_per_second`.
const CONTRADICTED: &str = "step";

fn toml_value(value: serde_json::Value) -> Value {
    match value {
        serde_json::Value::Number(number) => match number.as_i64() {
            Some(whole) => whole.into(),
            None => number.as_f64().unwrap_or(f64::NAN).into(),
        },
        value => value.as_str().unwrap_or_default().into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::Integrator;
    use msd_scene::Precision;
    use msd_scene::parse;

    const TEXT: &str = "version = 1 # first\n[solver]\nstep = 0.01\n# many\nsubsteps = 9 # nine\n\
                        [[bodies]]\n\
                        kind = 'rope'\nsize = [3]\n";

    fn written(format: SceneFormat, text: &str, fineness: Fineness) -> String {
        let (integrator, precision) = (Integrator::Rk4, Precision::F64);
        with_choice(text, format, "a", Choice { integrator, fineness, precision }).unwrap()
    }

    #[test]
    fn a_choice_written_is_the_choice_read_and_comments_stay() {
        let text = written(SceneFormat::Toml, TEXT, Fineness::Substeps(7));
        let loaded = parse(&text, SceneFormat::Toml, "a").unwrap();
        assert_eq!((loaded.settings.integrator, loaded.settings.substeps), (Integrator::Rk4, 7));
        assert_eq!(loaded.precision, Precision::F64);
        assert!((loaded.settings.step - 1.0 / 60.0).abs() < 1e-15);
        for comment in ["# first", "# many", "# nine"] {
            assert!(text.contains(comment), "{text}");
        }
        let text = written(SceneFormat::Toml, &text, Fineness::Tolerance(1e-5));
        let loaded = parse(&text, SceneFormat::Toml, "a").unwrap();
        assert_eq!(loaded.settings.tolerance, 1e-5);
    }

    #[test]
    fn lines_end_as_the_author_ends_them() {
        let json = "{\"version\": 1,\n\"bodies\": [{\"kind\": \"rope\", \"size\": [3]}]}\n";
        for (format, text) in [(SceneFormat::Toml, TEXT), (SceneFormat::Json, json)] {
            let unix = written(format, text, Fineness::Substeps(7));
            assert!(!unix.contains('\r'), "{unix:?}");
            let dos = written(format, &text.replace('\n', "\r\n"), Fineness::Substeps(7));
            assert_eq!(dos, unix.replace('\n', "\r\n"));
        }
    }

    #[test]
    fn a_scene_without_a_solver_section_gets_one_in_either_format() {
        let text = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\n";
        let text = written(SceneFormat::Toml, text, Fineness::Substeps(3));
        assert_eq!(parse(&text, SceneFormat::Toml, "a").unwrap().settings.substeps, 3);
        let text = r#"{"version": 1, "bodies": [{"kind": "rope", "size": [3]}]}"#;
        let text = written(SceneFormat::Json, text, Fineness::Substeps(3));
        assert_eq!(parse(&text, SceneFormat::Json, "a").unwrap().settings.substeps, 3);
    }
}
