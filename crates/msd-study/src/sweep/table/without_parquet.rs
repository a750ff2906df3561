//! Parquet files in a program that was built without them.

use crate::sweep::table::{Table, WITHOUT_PARQUET};
use msd_scene::{FileError, Output};
use std::path::Path;

pub(super) fn write(_: &Table, output: Output) -> Result<(), FileError> {
    Err(FileError::Unwritable { file: output.name().to_owned(), reason: WITHOUT_PARQUET.into() })
}

pub(super) fn read(_: &Path) -> Result<Table, String> {
    Err(WITHOUT_PARQUET.into())
}
