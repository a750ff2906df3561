//! The store of a sweep: a folder with one file per cell, named by its hash.

use crate::sweep::plan::{Cell, Sweep};
use crate::sweep::row;
use crate::sweep::table::{Column, Datum, Table, TableFormat};
use msd_scene::{FileError, Output, shown_path};
use std::path::{Path, PathBuf};

/// The folder of a sweep.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
    format: TableFormat,
    columns: Vec<Column>,
}

impl Store {
    /// The store of a sweep, in a folder of the caller's or its own; nothing is touched yet.
    pub fn of(sweep: &Sweep, folder: Option<PathBuf>) -> Self {
        let folder = folder.unwrap_or_else(|| sweep.out().to_path_buf());
        Store { folder, format: sweep.format(), columns: row::columns(sweep) }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The table of the whole sweep, beside the folder.
    pub fn table_path(&self) -> PathBuf {
        // The present folder has no name.
        let mut name = self.folder.file_name().unwrap_or("sweep".as_ref()).to_os_string();
        name.push(".");
        name.push(self.format.ending());
        self.folder.with_file_name(name)
    }

    /// The file of a cell.
    pub fn path(&self, cell: &Cell) -> PathBuf {
        self.folder.join(format!("{}.{}", cell.hash, self.format.ending()))
    }

    /// Makes the folder and sees that it can be written to.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn prepare(&self) -> Result<(), FileError> {
        std::fs::create_dir_all(&self.folder).map_err(|error| FileError::Unwritable {
            file: shown_path(&self.folder),
            reason: error.to_string(),
        })?;
        // Dropped before it is finished: nothing stays.
        Output::create(&self.folder.join("probe"))?;
        Ok(())
    }

    /// The row of a cell that is done. A file that cannot be read or is of another cell, as after
    /// a disk ran full, is as good as none: the cell is run again.
    pub fn row(&self, sweep: &Sweep, cell: &Cell) -> Option<Vec<Datum>> {
        let path = self.path(cell);
        if !path.is_file() {
            return None;
        }
        let mut table = Table::read(&path, self.format, &self.columns).ok()?;
        let row = table.rows.pop().filter(|_| table.rows.is_empty())?;
        let value = |name: &str| table.place(name).and_then(|place| row.get(place)).cloned();
        if value("hash")? != Datum::Text(cell.hash.clone()) {
            return None;
        }
        // The number of a cell and the keys of the grid are the current ones: a sweep may have
        // grown.
        let mut now = row::head(sweep, cell);
        for column in &self.columns[now.len()..] {
            now.push(value(&column.name)?);
        }
        Some(now)
    }

    /// Writes the file of a cell, whole or not at all.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub(super) fn save(&self, cell: &Cell, row: Vec<Datum>) -> Result<(), FileError> {
        let table = Table { columns: self.columns.clone(), rows: vec![row] };
        table.write(&self.path(cell), self.format)
    }

    /// Collects the cells that are done into one table, in the order of the grid; returns also how
    /// many are missing.
    ///
    /// # Errors
    /// The error of [`Sweep::cell`].
    pub fn collect(&self, sweep: &Sweep) -> Result<(Table, usize), FileError> {
        let mut rows = Vec::new();
        for number in 0..sweep.len() {
            rows.extend(self.row(sweep, &sweep.cell(number)?));
        }
        let missing = sweep.len() - rows.len();
        Ok((Table { columns: self.columns.clone(), rows }, missing))
    }
}
