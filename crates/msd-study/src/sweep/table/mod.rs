//! Tables of results, written and read again.

mod csv_file;
#[cfg(feature = "parquet")]
mod parquet_file;
#[cfg(not(feature = "parquet"))]
#[path = "without_parquet.rs"]
mod parquet_file;

use msd_scene::{FileError, Output, shown_path};
use serde::Deserialize;
use std::path::Path;

const WITHOUT_PARQUET: &str =
    "this msd was built without Parquet; build it with --features parquet, or use csv";

/// The format of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TableFormat {
    /// Comma-separated values, `.csv`: a header and a line per row.
    #[default]
    Csv,
    /// Apache Parquet, `.parquet`: columns with their types. Needs the feature `parquet`.
    Parquet,
}

impl TableFormat {
    /// The ending of its files, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            TableFormat::Csv => "csv",
            TableFormat::Parquet => "parquet",
        }
    }

    /// Advice for a format that this program was built without; `None` for one that it can write.
    pub fn missing(self) -> Option<&'static str> {
        (self == TableFormat::Parquet && !cfg!(feature = "parquet")).then_some(WITHOUT_PARQUET)
    }

    /// The format that the ending of a file name stands for.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_lowercase();
        [TableFormat::Csv, TableFormat::Parquet].into_iter().find(|known| known.ending() == ending)
    }
}

/// Kind of the values of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// True or false.
    Flag,
    /// Whole numbers.
    Whole,
    /// Numbers.
    Number,
    /// Text.
    Text,
}

/// A value of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Datum {
    /// No value.
    Nothing,
    /// True or false.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// Text.
    Text(String),
}

impl Datum {
    /// A number; infinity and NaN are missing values.
    pub fn number(number: f64) -> Self {
        if number.is_finite() { Datum::Number(number) } else { Datum::Nothing }
    }

    /// The number, if it is one.
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Datum::Number(number) => Some(*number),
            Datum::Whole(number) => Some(*number as f64),
            _ => None,
        }
    }
}

impl std::fmt::Display for Datum {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Datum::Nothing => Ok(()),
            Datum::Flag(flag) => write!(f, "{flag}"),
            Datum::Whole(number) => write!(f, "{number}"),
            // The shortest digits that read back to the same bits.
            Datum::Number(number) => write!(f, "{number:?}"),
            Datum::Text(text) => f.write_str(text),
        }
    }
}

/// A column: its name and its kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// The name.
    pub name: String,
    /// The kind of its values; a value may be missing in every column.
    pub kind: Kind,
}

/// A table of results, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, each as long as there are columns.
    pub rows: Vec<Vec<Datum>>,
}

impl Table {
    /// The place of a column.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// Writes a file, whole or not at all.
    ///
    /// # Errors
    /// [`FileError::Unwritable`], also for a row that is not as long as there are columns.
    pub fn write(&self, path: &Path, format: TableFormat) -> Result<(), FileError> {
        let uneven = |row: &Vec<Datum>| row.len() != self.columns.len();
        if let Some(row) = self.rows.iter().position(uneven) {
            let [values, columns] = [self.rows[row].len(), self.columns.len()];
            let reason = format!("row {row} has {values} values for {columns} columns");
            return Err(FileError::Unwritable { file: shown_path(path), reason });
        }
        let output = Output::create(path)?;
        match format {
            TableFormat::Csv => csv_file::write(self, output),
            TableFormat::Parquet => parquet_file::write(self, output),
        }
    }

    /// Reads a file that [`Table::write`] wrote. CSV does not store the kinds of its columns:
    /// `columns` gives them, and a column without a kind is text.
    ///
    /// # Errors
    /// [`FileError::Unreadable`].
    pub fn read(path: &Path, format: TableFormat, columns: &[Column]) -> Result<Self, FileError> {
        let refused = |reason: String| FileError::Unreadable { file: shown_path(path), reason };
        match format {
            TableFormat::Csv => csv_file::read(path, columns).map_err(refused),
            TableFormat::Parquet => parquet_file::read(path).map_err(refused),
        }
    }
}
