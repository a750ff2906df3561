//! The cells of a sweep, and the scene of each.

use crate::sweep::columns::OF_PROCESSOR;
use crate::sweep::file::{SweepFile, read};
use crate::sweep::measure::meets_frames;
use crate::sweep::table::{Column, Datum, Kind, TableFormat};
use crate::sweep::value::{Axis, canonical};
use msd_core::Settings;
use msd_run::Runner;
use msd_scene::key::shown;
use msd_scene::tree::{Source, Value};
use msd_scene::{Draft, FileError, Loaded, Place, plain};
use std::path::{Path, PathBuf};

/// The most integration steps of a cell: weeks on any machine.
const MAX_STEPS: f64 = 1e10;

/// Raised whenever a change of msd makes the rows of before incomparable.
const REVISION: u32 = 1;

/// A sweep: a scene and the grid of values that some of its keys take.
pub struct Sweep {
    pub(crate) file: SweepFile,
    draft: Draft,
}

/// A cell of the grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Its number in the grid, from 0; the last key of the grid runs fastest.
    pub number: usize,
    /// Its identity, 16 hexadecimal digits: the same cell has the same hash in every sweep.
    pub hash: String,
    /// The hash without solver keys: cells that share it share a reference.
    pub(crate) scene_hash: String,
    /// Which value each key of the grid has, in the order of the grid.
    choices: Vec<usize>,
}

impl Sweep {
    /// Reads a sweep file and its scene; cells are checked by [`Sweep::load`].
    ///
    /// # Errors
    /// A mistake in the sweep file, by place and key; a scene that cannot be read.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let file = read(path)?;
        let draft = Draft::open(Path::new(&file.scene), &file.folder);
        let draft = draft.map_err(|error| FileError::Malformed {
            place: file.scene_place.clone(),
            reason: format!("scene: {error}{}", hint(&file.scene)),
        })?;
        draft.source()?;
        Ok(Sweep { file, draft })
    }

    /// The number of cells, at least 1.
    #[expect(clippy::len_without_is_empty, reason = "a sweep without cells is refused")]
    pub fn len(&self) -> usize {
        self.file.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// The scene as the sweep file names it.
    pub fn scene(&self) -> &str {
        &self.file.scene
    }

    /// Time that each cell simulates, seconds.
    pub fn duration(&self) -> f64 {
        self.file.duration
    }

    /// Whether each cell is compared with a reference.
    pub fn has_error(&self) -> bool {
        self.file.error
    }

    /// Those of its columns that a device does not measure.
    pub fn columns_of_processor(&self) -> Vec<&'static str> {
        let names = self.file.measures.iter().map(|measure| measure.0);
        names.filter(|name| OF_PROCESSOR.contains(name)).collect()
    }

    /// The format of its files.
    pub fn format(&self) -> TableFormat {
        self.file.format
    }

    /// The folder of its files, unless the caller says otherwise.
    pub fn out(&self) -> &Path {
        &self.file.out
    }

    /// The files that it was read from, the sweep file first.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = vec![self.file.path.clone()];
        files.extend(self.draft.files());
        files
    }

    /// The cell of a number below [`Sweep::len`].
    ///
    /// # Errors
    /// A key of the grid that has no place in the scene.
    pub fn cell(&self, number: usize) -> Result<Cell, FileError> {
        let (mut rest, mut choices) = (number, vec![0; self.file.axes.len()]);
        for (choice, axis) in choices.iter_mut().zip(&self.file.axes).rev() {
            *choice = rest % axis.values.len();
            rest /= axis.values.len();
        }
        let mut cell = Cell { number, hash: String::new(), scene_hash: String::new(), choices };
        let mut source = self.source(&cell)?;
        let Value::Table(rows) = &mut source.root.value else { return Ok(cell) };
        // The title of a scene changes no number.
        rows.retain(|row| row.0 != "title");
        cell.hash = self.hash(&source.root.value);
        if let Value::Table(rows) = &mut source.root.value {
            rows.retain(|row| row.0 != "solver");
        }
        cell.scene_hash = self.hash(&source.root.value);
        Ok(cell)
    }

    /// The tree of the scene with the values of a cell.
    fn source(&self, cell: &Cell) -> Result<Source<'_>, FileError> {
        let mut source = self.draft.source()?;
        for (axis, &choice) in self.file.axes.iter().zip(&cell.choices) {
            let (value, place) = &axis.values[choice];
            let set = axis.key.set(&mut source.root, value.clone());
            set.map_err(|reason| FileError::Malformed {
                place: place.clone(),
                reason: format!("grid key {}: {reason}", axis.key.text()),
            })?;
        }
        Ok(source)
    }

    /// Everything that the row of a cell follows from: 16 hexadecimal digits.
    fn hash(&self, root: &Value) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&REVISION.to_le_bytes());
        hasher.update(&self.file.duration.to_bits().to_le_bytes());
        hasher.update(&[u8::from(self.file.error)]);
        let texts = [env!("CARGO_PKG_VERSION").into(), self.file.scene.clone()];
        hasher.update(&canonical(&Value::Text(texts.join("\n"))));
        hasher.update(&canonical(root));
        for file in mesh_files(root) {
            // A mesh that cannot be read is refused where the scene is built.
            let Ok(mesh) = self.draft.mesh(file) else { continue };
            for coordinate in mesh.positions.iter().flat_map(|position| position.to_array()) {
                hasher.update(&coordinate.to_bits().to_le_bytes());
            }
            for corner in mesh.triangles.iter().flatten() {
                hasher.update(&corner.to_le_bytes());
            }
        }
        hasher.finalize().to_hex()[..16].to_owned()
    }

    /// The values of a cell as a person would write them: `solver.substeps = 8, ...`.
    pub fn words(&self, cell: &Cell) -> String {
        let axes = self.file.axes.iter().zip(&cell.choices);
        let word = |(axis, &choice): (&Axis, &usize)| {
            format!("{} = {}", axis.key.text(), shown(&axis.values[choice].0))
        };
        axes.map(word).collect::<Vec<_>>().join(", ")
    }

    /// The scene with the values of a cell, as the text of a scene file in JSON.
    ///
    /// # Errors
    /// A key of the grid that has no place in the scene.
    pub(crate) fn text(&self, cell: &Cell) -> Result<String, FileError> {
        serde_json::to_string(&self.source(cell)?.root.value).map_err(|error| {
            let (file, reason) = (self.file.scene.clone(), error.to_string());
            FileError::Unwritable { file, reason }
        })
    }

    /// The columns of the keys of the grid.
    pub(crate) fn grid_columns(&self) -> Vec<Column> {
        let column = |axis: &Axis| Column { name: axis.key.text().into(), kind: kind(axis) };
        self.file.axes.iter().map(column).collect()
    }

    /// The values of a cell, in those columns.
    pub(crate) fn grid_values(&self, cell: &Cell) -> Vec<Datum> {
        let axes = self.file.axes.iter().zip(&cell.choices);
        axes.map(|(axis, &choice)| datum(&axis.values[choice].0, kind(axis))).collect()
    }

    /// Builds the scene of a cell and checks that it can run.
    ///
    /// # Errors
    /// The first thing that is wrong, at its place in the sweep file where a value of the grid is.
    pub fn load(&self, cell: &Cell) -> Result<Loaded, FileError> {
        self.open_cell(cell).map(|opened| opened.0)
    }

    /// Builds the scene of a cell, checks that it can run, and opens its run.
    ///
    /// # Errors
    /// See [`Sweep::load`].
    pub fn open_cell(&self, cell: &Cell) -> Result<(Loaded, Runner), FileError> {
        let source = self.source(cell)?;
        let loaded = self.draft.load(&source).map_err(|error| self.explain(error, cell))?;
        let settings = loaded.settings;
        // Masses and steps may round to zero and the like.
        let runner = Runner::open(&loaded).map_err(|error| self.refuse(error, cell))?;
        self.check_steps(cell, settings)?;
        Ok((loaded, runner))
    }

    /// Refuses a duration of no step, of too many, and of none that can be compared.
    fn check_steps(&self, cell: &Cell, settings: Settings) -> Result<(), FileError> {
        let duration = self.file.duration;
        let wrong = |expected| FileError::OutOfDomain {
            place: self.file.duration_place.clone(),
            key: "duration".into(),
            value: format!("{} s", plain(duration)),
            expected,
        };
        let steps = (duration / settings.step).round();
        let at = format!("in cell {} ({})", cell.number, self.words(cell));
        if steps < 1.0 {
            let step = plain(settings.step);
            return Err(wrong(format!("at least half a step, which is {step} s {at}")));
        }
        if MAX_STEPS < steps * f64::from(settings.substeps) {
            let substep = settings.substep();
            let most = format!("at most {MAX_STEPS:e} substeps, which are {substep:.3e} s {at}");
            return Err(wrong(most));
        }
        if self.file.error && !meets_frames(settings, duration) {
            return Err(FileError::Malformed {
                place: self.file.grid_place.clone(),
                reason: format!(
                    "error = true compares where a step ends at a whole multiple of 1/60 s, and \
                     no step of {} s does {at}",
                    plain(settings.step)
                ),
            });
        }
        Ok(())
    }

    /// The error of a cell that the core refuses.
    pub(crate) fn refuse(&self, error: msd_core::Error, cell: &Cell) -> FileError {
        let file = self.draft.name.clone();
        self.explain(FileError::Core { file, source: Box::new(error) }, cell)
    }

    /// Adds to an error of a scene which value of the grid caused it.
    fn explain(&self, error: FileError, cell: &Cell) -> FileError {
        let place = |key: &str| -> Option<Place> {
            let mut axes = self.file.axes.iter().zip(&cell.choices);
            let found = axes.find(|(axis, _)| axis.key.concerns(key));
            found.map(|(axis, &choice)| axis.values[choice].1.clone())
        };
        error.placed(&place).unwrap_or_else(|error| {
            let (number, words) = (cell.number, self.words(cell));
            let reason = format!("cell {number} ({words}): {error}");
            FileError::Malformed { place: self.file.grid_place.clone(), reason }
        })
    }
}

/// The common kind of the values of a key.
fn kind(axis: &Axis) -> Kind {
    let all = |is: fn(&Value) -> bool| axis.values.iter().all(|(value, _)| is(value));
    if all(|value| matches!(value, Value::Whole(number) if i64::try_from(*number).is_ok())) {
        return Kind::Whole;
    }
    if all(|value| matches!(value, Value::Whole(_) | Value::Number(_))) {
        return Kind::Number;
    }
    if all(|value| matches!(value, Value::Flag(_))) { Kind::Flag } else { Kind::Text }
}

fn datum(value: &Value, kind: Kind) -> Datum {
    match (value, kind) {
        (Value::Flag(flag), Kind::Flag) => Datum::Flag(*flag),
        (Value::Whole(number), Kind::Whole) => {
            i64::try_from(*number).map_or(Datum::Nothing, Datum::Whole)
        }
        (Value::Whole(number), Kind::Number) => Datum::number(*number as f64),
        (Value::Number(number), Kind::Number) => Datum::number(*number),
        (Value::Text(text), _) => Datum::Text(text.clone()),
        (other, _) => Datum::Text(shown(other)),
    }
}

/// The mesh files that a scene names.
fn mesh_files(root: &Value) -> Vec<&str> {
    fn of<'v>(value: &'v Value, name: &str) -> Option<&'v Value> {
        let Value::Table(rows) = value else { return None };
        rows.iter().find(|row| row.0 == name).map(|row| &row.2.value)
    }
    let Some(Value::List(bodies)) = of(root, "bodies") else { return Vec::new() };
    let mut files = Vec::new();
    for body in bodies {
        if let Some(Value::Text(file)) = of(&body.value, "file") {
            files.push(file.as_str());
        }
    }
    files
}

/// Advice to a user who sweeps a link.
fn hint(scene: &str) -> &'static str {
    match scene.contains("#scene=") {
        true => "; a sweep takes no link: save the scene in the window and name the file",
        false => "",
    }
}
