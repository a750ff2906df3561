//! Keys that stand in another table than the one they were written in.

use crate::error::{FileError, nearest};
use crate::file::decode::ALL_KEYS;
use crate::file::keys::KeyTable;
use crate::file::schema::{
    BodyRow, CameraRow, LookRow, PlaneRow, SolidRow, SolverRow, TouchRow, WorldRow,
};

/// Names the table that a key belongs to where its own has none like it.
pub(crate) fn elsewhere(error: FileError) -> FileError {
    let FileError::UnknownKey { place, key, table, hint } = error else { return error };
    let found = hint.starts_with(ALL_KEYS).then(|| place_of(&key, &table)).flatten();
    let hint = found.map_or(hint, |found| format!("did you mean `{found}`?"));
    FileError::UnknownKey { place, key, table, hint }
}

/// The key of another table that is like one written in `table`, as it is written there.
fn place_of(key: &str, table: &str) -> Option<String> {
    // A body's own tables are named from there, all others from the top.
    let body = table.split('.').next().filter(|first| first.starts_with("bodies["));
    let from = if body == Some(table) {
        String::new()
    } else {
        format!("{}.", body.unwrap_or("bodies[0]"))
    };
    let tables = [
        (format!("{from}look."), LookRow::TABLE),
        ("solver.".into(), SolverRow::TABLE),
        ("world.".into(), WorldRow::TABLE),
        (from.clone(), BodyRow::TABLE),
        ("world.planes[0].".into(), PlaneRow::TABLE),
        ("world.solids[0].".into(), SolidRow::TABLE),
        (format!("{from}touch."), TouchRow::TABLE),
        ("camera.".into(), CameraRow::TABLE),
    ];
    // The very word first.
    let same = tables.iter().find(|(_, table)| table.find(key).is_some());
    if let Some((path, _)) = same {
        return Some(format!("{path}{key}"));
    }
    let like = tables.iter().find_map(|(path, table)| Some((path, is_like(key, table)?)));
    like.map(|(path, key)| format!("{path}{key}"))
}

/// A key that differs by a letter: among so many tables one that is only near is a guess.
fn is_like(written: &str, table: &KeyTable) -> Option<&'static str> {
    let near = nearest(written, table.keys.iter().map(|row| row.name))?;
    (near.len().abs_diff(written.len()) <= 1 && 3 < written.len()).then_some(near)
}
