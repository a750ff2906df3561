//! The row of a cell.

use crate::sweep::columns::{HEAD, text};
use crate::sweep::measure::Measured;
use crate::sweep::plan::{Cell, Sweep};
use crate::sweep::table::{Column, Datum, Kind};

/// The columns of a sweep.
pub(super) fn columns(sweep: &Sweep) -> Vec<Column> {
    let column = |(name, kind): (&str, Kind)| Column { name: name.into(), kind };
    let mut columns: Vec<Column> = HEAD.into_iter().map(column).collect();
    columns.extend(sweep.grid_columns());
    columns.extend(sweep.file.measures.iter().map(|&(name, kind, _)| column((name, kind))));
    columns
}

/// The values of a cell up to those of the grid, which are known before it runs.
pub(super) fn head(sweep: &Sweep, cell: &Cell) -> Vec<Datum> {
    let number = i64::try_from(cell.number).map_or(Datum::Nothing, Datum::Whole);
    let mut row = vec![number, text(&cell.hash), text(sweep.scene())];
    row.extend(sweep.grid_values(cell));
    row
}

/// The row of a cell.
pub(super) fn row(sweep: &Sweep, cell: &Cell, measured: &Measured) -> Vec<Datum> {
    let mut row = head(sweep, cell);
    row.extend(sweep.file.measures.iter().map(|measure| measure.2(measured)));
    row
}
