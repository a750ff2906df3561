//! State files, read back to the last bit.
//!
//! A state file is CSV with the header `particle,x,y,z,vx,vy,vz` and a row per particle in the
//! order of the scene. Each number has the fewest digits that read back as the same number of its
//! precision.

use crate::disk::{Output, open_regular};
use crate::error::{FileError, Place, one_line};
use crate::precision::Precision;
use crate::shown::shown_path;
use crate::state::AnyState;
use glam::DVec3;
use msd_core::{Real, State, Vector};
use std::io::{Read, Write};
use std::path::Path;
use std::str::FromStr;

/// The first line of a state file.
pub const HEADER: [&str; 7] = ["particle", "x", "y", "z", "vx", "vy", "vz"];

/// More than the longest row takes, bytes: seven numbers of at most 25 characters. Bytes beyond
/// that are not read, so that a file without line ends cannot fill the memory.
const ROW_BYTES: u64 = 1024;

/// Writes a state.
///
/// # Errors
/// [`FileError::Unwritable`], also for a state with columns of different lengths.
pub fn write_state(state: &AnyState, output: &mut Output) -> Result<(), FileError> {
    let [positions, velocities] = match state {
        AnyState::F32(state) => [state.positions.len(), state.velocities.len()],
        AnyState::F64(state) => [state.positions.len(), state.velocities.len()],
    };
    if positions != velocities {
        let reason = format!("the state has {positions} positions and {velocities} velocities");
        return Err(FileError::Unwritable { file: output.name().into(), reason });
    }
    let written = match state {
        AnyState::F32(state) => write_rows(state, output),
        AnyState::F64(state) => write_rows(state, output),
    };
    written.map_err(|error| output.refused(&error))
}

fn write_rows<R: Real>(state: &State<R>, output: &mut Output) -> std::io::Result<()> {
    writeln!(output, "{}", HEADER.join(","))?;
    for (row, (position, velocity)) in state.positions.iter().zip(&state.velocities).enumerate() {
        // `Debug` is the shortest text that reads back as the same number, with an exponent where
        // that is shorter.
        let [[x, y, z], [vx, vy, vz]] = [position.components(), velocity.components()];
        writeln!(output, "{row},{x:?},{y:?},{z:?},{vx:?},{vy:?},{vz:?}")?;
    }
    Ok(())
}

/// Reads a state of `count` particles in the precision of its run.
///
/// # Errors
/// A file that cannot be read, another header, a row that is missing, too many or out of order, a
/// value that is not a finite number: each names the row, counted from 1 after the header, and the
/// column.
pub fn load_state(path: &Path, precision: Precision, count: usize) -> Result<AnyState, FileError> {
    let name = shown_path(path);
    let file = open_regular(path, ROW_BYTES.saturating_mul(count as u64 + 2))?;
    read_state(std::io::BufReader::new(file), precision, (&name, count))
}

/// Reads a state of `count` particles from a reader called `name`.
///
/// # Errors
/// See [`load_state`].
pub fn read_state(
    reader: impl Read,
    precision: Precision,
    (name, count): (&str, usize),
) -> Result<AnyState, FileError> {
    Ok(match precision {
        Precision::F32 => AnyState::F32(read_rows(reader, name, count)?),
        Precision::F64 => AnyState::F64(read_rows(reader, name, count)?),
    })
}

fn read_rows<R: Real + FromStr>(
    reader: impl Read,
    name: &str,
    count: usize,
) -> Result<State<R>, FileError> {
    let mut rows = csv::ReaderBuilder::new().flexible(true).from_reader(reader);
    let header = rows.headers().map_err(|error| csv_error(name, &error))?;
    if !header.iter().map(str::trim).eq(HEADER) {
        let written = header.iter().collect::<Vec<_>>().join(",");
        let value = format!("\"{}\"", shorten(&written));
        return Err(wrong((name, None), "the header", value, &HEADER.join(",")));
    }
    let mut state = State { positions: Vec::new(), velocities: Vec::new() };
    let mut record = csv::StringRecord::new();
    while rows.read_record(&mut record).map_err(|error| csv_error(name, &error))? {
        let row = state.positions.len();
        if row == count {
            return Err(wrong_length(name, "more than ", count, count));
        }
        let at = (name, Some(row + 1));
        if record.len() != HEADER.len() {
            let expected = format!("{}", HEADER.len());
            return Err(wrong(at, "the number of values", record.len().to_string(), &expected));
        }
        if record[0].trim() != row.to_string() {
            let value = format!("\"{}\"", shorten(&record[0]));
            return Err(wrong(at, HEADER[0], value, &format!("{row}: rows go by number")));
        }
        state.positions.push(vector::<R>(at, &record, 1)?);
        state.velocities.push(vector::<R>(at, &record, 4)?);
    }
    match state.positions.len() {
        found if found == count => Ok(state),
        found => Err(wrong_length(name, "", found, count)),
    }
}

/// Three columns of a row. Parsed in the precision of the run: by way of f64 a number of the f32
/// run would be rounded twice.
fn vector<R: Real + FromStr>(
    at: (&str, Option<usize>),
    record: &csv::StringRecord,
    first: usize,
) -> Result<R::Vec3, FileError> {
    let mut components = [0.0; 3];
    for (axis, component) in components.iter_mut().enumerate() {
        let (text, column) = (record[first + axis].trim(), HEADER[first + axis]);
        let number = text.parse::<R>().ok().map(Real::to_f64).filter(|number| number.is_finite());
        *component = number.ok_or_else(|| {
            let expected = format!("a number that is finite in {}", R::NAME);
            wrong(at, column, format!("\"{}\"", shorten(text)), &expected)
        })?;
    }
    Ok(R::Vec3::of(DVec3::from_array(components)))
}

fn wrong(
    (file, row): (&str, Option<usize>),
    quantity: &str,
    value: String,
    expected: &str,
) -> FileError {
    FileError::StateRow {
        file: file.into(),
        row,
        quantity: quantity.into(),
        value,
        expected: expected.into(),
    }
}

fn wrong_length(file: &str, how: &str, found: usize, count: usize) -> FileError {
    let counted = |count: usize, what: &str| match count {
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    };
    let (rows, particles) = (counted(found, "row"), counted(count, "particle"));
    let reason = format!("has {how}{rows}, but the scene has {particles}");
    FileError::Malformed { place: Place { file: file.into(), position: None }, reason }
}

fn csv_error(file: &str, error: &csv::Error) -> FileError {
    let reason = match error.kind() {
        csv::ErrorKind::Utf8 { .. } => "it is not UTF-8 text".into(),
        csv::ErrorKind::Io(error) => error.to_string(),
        _ => one_line(error),
    };
    FileError::Unreadable { file: file.into(), reason }
}

/// The beginning of a value too long for a message.
fn shorten(value: &str) -> String {
    const LONGEST: usize = 40;
    let mut short: String = value.chars().take(LONGEST).filter(|c| !c.is_control()).collect();
    if value.chars().nth(LONGEST).is_some() {
        short.push('…');
    }
    short
}
