//! A cell as a separate value: all that a worker needs to make its row without a file.

use crate::monitor::{Halt, Monitor};
use crate::sweep::columns::{HEAD, MEASURES};
use crate::sweep::measure::{References, measure};
use crate::sweep::plan::{Cell, Sweep};
use crate::sweep::table::Datum;
use msd_scene::{Draft, FileError, SceneFormat};
use std::collections::BTreeMap;

/// A cell with the text of its scene; its row follows from it alone, times apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// The number of the cell in its sweep.
    pub number: usize,
    /// The hash of the cell.
    pub hash: String,
    /// The scene as the sweep file names it.
    pub scene: String,
    /// Each key of the grid with its value.
    pub values: Vec<(String, Datum)>,
    /// The scene with the values of the cell, JSON.
    pub text: String,
    /// Time to simulate, seconds.
    pub duration: f64,
    /// Whether the cell is compared with a reference, which the cache may hold.
    pub error: bool,
}

impl Task {
    /// The task of a cell, which is checked.
    ///
    /// # Errors
    /// The error of [`Sweep::load`]; a scene that names a mesh file, as its text does not hold it.
    pub fn of(sweep: &Sweep, cell: &Cell) -> Result<Self, FileError> {
        sweep.load(cell)?;
        let (text, keys) = (sweep.text(cell)?, sweep.grid_columns().into_iter());
        let task = Task {
            number: cell.number,
            hash: cell.hash.clone(),
            scene: sweep.scene().into(),
            values: keys.map(|key| key.name).zip(sweep.grid_values(cell)).collect(),
            text,
            duration: sweep.duration(),
            error: sweep.has_error(),
        };
        task.draft().load(&task.draft().source()?)?;
        Ok(task)
    }

    /// Runs the cell and makes its row, column by column as in the table of a sweep; touches no
    /// file but the cache of references.
    ///
    /// # Errors
    /// A scene that cannot be run; the error of [`Monitor::proceed`].
    pub fn run(&self, monitor: &mut dyn Monitor) -> Result<Vec<(String, Datum)>, Halt<FileError>> {
        let draft = self.draft();
        let loaded = draft.load(&draft.source()?)?;
        let slot = self.error.then(|| References::new(1).slot(&self.hash));
        let measured = measure(&loaded, (self.duration, slot), monitor);
        let measured = measured.map_err(|halt| {
            halt.map(|source| {
                let (file, source) = (self.scene.clone(), Box::new(source));
                FileError::Core { file, source }
            })
        })?;
        let number = i64::try_from(self.number).map_or(Datum::Nothing, Datum::Whole);
        let texts = [&self.hash, &self.scene].map(|text| Datum::Text(text.clone()));
        let head = std::iter::once(number).chain(texts);
        let head = HEAD.iter().map(|column| column.0.to_owned()).zip(head);
        let found = MEASURES.iter().map(|(name, _, of)| (String::from(*name), of(&measured)));
        Ok(head.chain(self.values.iter().cloned()).chain(found).collect())
    }

    fn draft(&self) -> Draft {
        let text = (self.text.clone(), SceneFormat::Json);
        Draft::of_text(&self.scene, text, &BTreeMap::new())
    }
}
