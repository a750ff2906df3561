//! Several refusals of one scene file at once, so that they can be mended in one go.

use crate::error::FileError;
use crate::file::decode::mend;
use crate::file::keys::{Domain, without_rows};
use crate::file::schema::elsewhere::elsewhere;
use crate::file::schema::{SceneFile, find};
use crate::file::tree::{Node, Source, Value};
use crate::precision::Precision;

/// The most refusals at once.
const MOST: usize = 10;
/// The longest text in which more is looked for, bytes: a second tree takes memory and time.
const LONGEST: usize = 1 << 20;

/// The refusals of a scene, in the order of the file, at most ten: `first` is one.
///
/// The others do not depend on it nor on each other: an unknown key, a missing one, a value of
/// another kind than its key has, or one outside the domain that its key has in every scene.
pub(crate) fn refusals(source: &Source<'_>, first: FileError) -> FileError {
    if first.place().is_none() || LONGEST < source.text.len() {
        return first;
    }
    let mut found = vec![first];
    let mut mended = source.clone();
    while found.len() < MOST
        && let Some(error) = mend::<SceneFile>(&mut mended).map(elsewhere)
        && add(&mut found, error)
    {}
    // Where none is asked for that can be read, one that holds every number.
    let asked = mended.walk("solver.precision").last().flatten().map(|node| &node.value);
    mended.precision.set(match asked {
        None => Precision::F32,
        Some(Value::Text(name)) if name == Precision::F32.name() => Precision::F32,
        Some(_) => Precision::F64,
    });
    check(&mended, &mended.root, &mut String::new(), &mut found);
    let position = |error: &FileError| error.place().and_then(|place| place.position);
    found.sort_by_key(position);
    match <[FileError; 1]>::try_from(found) {
        Ok([only]) => only,
        Err(several) => FileError::Several(several),
    }
}

/// Adds a refusal of another value than those before; says whether there may be more.
fn add(found: &mut Vec<FileError>, error: FileError) -> bool {
    let is_first = found[0] == error;
    let is_of_key = |other: &FileError| match (other, &error) {
        (FileError::OutOfDomain { key, .. }, FileError::OutOfDomain { key: new, .. }) => key == new,
        _ => false,
    };
    let is_known = found.iter().any(|other| *other == error || is_of_key(other));
    if !is_known {
        found.push(error);
    }
    is_first || !is_known
}

/// Checks each number in a tree against the domain that its key has in every scene.
fn check(source: &Source<'_>, node: &Node, key: &mut String, found: &mut Vec<FileError>) {
    if found.len() == MOST {
        return;
    }
    let length = key.len();
    match &node.value {
        Value::Table(rows) => {
            for (name, _, node) in rows {
                key.extend([if length == 0 { "" } else { "." }, name]);
                check(source, node, key, found);
                key.truncate(length);
            }
        }
        Value::List(rows) => {
            for (row, node) in rows.iter().enumerate() {
                key.push_str(&format!("[{row}]"));
                check(source, node, key, found);
                key.truncate(length);
            }
        }
        Value::Whole(number) => check_number(source, key, *number as f64, found),
        Value::Number(number) => check_number(source, key, *number, found),
        _ => {}
    }
}

fn check_number(source: &Source<'_>, key: &str, value: f64, found: &mut Vec<FileError>) {
    let Some(row) = find(&without_rows(key)) else { return };
    let domain = match row.domain {
        Domain::Any | Domain::Words(_) => return,
        Domain::Vector | Domain::Place | Domain::Direction => Domain::Finite,
        other => other,
    };
    if let Err(error) = source.number_in(domain, format_args!("{key}"), value) {
        add(found, error);
    }
}
