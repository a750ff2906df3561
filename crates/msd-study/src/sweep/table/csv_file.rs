//! Tables as CSV files.

use crate::sweep::table::{Column, Datum, Kind, Table};
use msd_scene::{FileError, Output, one_line};
use std::path::Path;

/// Writes a table; a missing value is an empty field.
pub(super) fn write(table: &Table, output: Output) -> Result<(), FileError> {
    let file = output.name().to_owned();
    let refused = |reason: String| FileError::Unwritable { file: file.clone(), reason };
    let mut writer = csv::Writer::from_writer(output);
    let header = table.columns.iter().map(|column| column.name.as_str());
    writer.write_record(header).map_err(|error| refused(one_line(error)))?;
    for row in &table.rows {
        let fields = row.iter().map(Datum::to_string);
        writer.write_record(fields).map_err(|error| refused(one_line(error)))?;
    }
    let output = writer.into_inner().map_err(|error| refused(one_line(error.error())))?;
    output.finish()
}

/// Reads a table.
pub(super) fn read(path: &Path, columns: &[Column]) -> Result<Table, String> {
    let mut reader = csv::Reader::from_path(path).map_err(one_line)?;
    let header = reader.headers().map_err(one_line)?.clone();
    let kind = |name: &str| {
        let known = columns.iter().find(|column| column.name == name);
        known.map_or(Kind::Text, |column| column.kind)
    };
    let column = |name: &str| Column { name: name.into(), kind: kind(name) };
    let mut table = Table { columns: header.iter().map(column).collect(), rows: Vec::new() };
    for record in reader.records() {
        let record = record.map_err(one_line)?;
        let fields = record.iter().zip(&table.columns);
        let row: Result<_, String> = fields.map(|(field, column)| datum(field, column)).collect();
        table.rows.push(row?);
    }
    Ok(table)
}

fn datum(field: &str, column: &Column) -> Result<Datum, String> {
    if field.is_empty() {
        return Ok(Datum::Nothing);
    }
    let read = match column.kind {
        Kind::Flag => field.parse().ok().map(Datum::Flag),
        Kind::Whole => field.parse().ok().map(Datum::Whole),
        Kind::Number => field.parse().ok().map(Datum::Number),
        Kind::Text => Some(Datum::Text(field.into())),
    };
    read.ok_or_else(|| format!("column {} holds \"{field}\"", column.name))
}
