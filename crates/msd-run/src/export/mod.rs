//! Runs in files of other programs: meshes of a moment, and motion over time.
//!
//! `skin.rs` holds the visible parts of a scene; each other file writes a format. See
//! `docs/reference/export.md`.

mod skin;
mod mesh_files;
mod mesh_cache;
mod npz_file;
mod vtk_file;
mod glb_look;
mod glb_file;
#[cfg(feature = "parquet")]
mod parquet_file;

use crate::runner::Runner;
use glb_file::{Glb, MOST_MOMENTS};
use mesh_cache::{Cache, MeshCache};
use mesh_files::{write_obj, write_ply};
pub use msd_core::PALETTE;
use msd_scene::{FileError, Output, Spool, shown_path, write_state};
use npz_file::Npz;
use skin::Skin;
use std::io;
use std::path::{Path, PathBuf};
use vtk_file::{Collection, write_vtu};

/// A format of files that other programs read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// State file, `.csv`: positions and velocities of one moment.
    Csv,
    /// Mesh of one moment, `.obj`.
    Obj,
    /// Mesh of one moment with velocities, `.ply`, binary.
    Ply,
    /// Particles, springs and surfaces of one moment for ParaView, `.vtu`.
    Vtu,
    /// The same over time, `.pvd`, with a `.vtu` file per moment beside it.
    Pvd,
    /// Arrays of numpy over time, `.npz`.
    Npz,
    /// A row per particle and moment, `.parquet`. Needs the feature `parquet`.
    Parquet,
    /// Mesh cache over time, `.pc2`, with the mesh as `.obj` beside it.
    Pc2,
    /// Mesh cache over time, `.mdd`, with the mesh as `.obj` beside it.
    Mdd,
    /// Meshes and their motion, `.glb`: binary glTF.
    Glb,
}

impl Format {
    /// All of them.
    pub const ALL: [Format; 10] = [
        Format::Csv,
        Format::Obj,
        Format::Ply,
        Format::Vtu,
        Format::Pvd,
        Format::Npz,
        Format::Parquet,
        Format::Pc2,
        Format::Mdd,
        Format::Glb,
    ];

    /// The ending of its files, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            Format::Csv => "csv",
            Format::Obj => "obj",
            Format::Ply => "ply",
            Format::Vtu => "vtu",
            Format::Pvd => "pvd",
            Format::Npz => "npz",
            Format::Parquet => "parquet",
            Format::Pc2 => "pc2",
            Format::Mdd => "mdd",
            Format::Glb => "glb",
        }
    }

    /// The format that the ending of a file name stands for.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_lowercase();
        Format::ALL.into_iter().find(|format| format.ending() == ending)
    }

    /// Returns whether its files hold a single state: the last.
    pub fn is_of_one_moment(self) -> bool {
        matches!(self, Format::Csv | Format::Obj | Format::Ply | Format::Vtu)
    }

    /// The most moments that a file of it holds.
    pub fn most_moments(self) -> u64 {
        if self == Format::Glb { MOST_MOMENTS } else { u64::MAX }
    }

    /// Advice for a format that this program was built without; `None` for one that it can write.
    pub fn missing(self) -> Option<&'static str> {
        let is_missing = self == Format::Parquet && !cfg!(feature = "parquet");
        is_missing.then_some(
            "this msd was built without Parquet; build it with --features parquet, or use npz",
        )
    }

    /// The files that an export writes: the file itself, and the mesh of a cache. Those of the
    /// moments of a collection come as it goes on.
    pub fn files(self, path: &Path) -> Vec<PathBuf> {
        match self {
            Format::Pc2 | Format::Mdd => vec![path.into(), path.with_extension("obj")],
            _ => vec![path.into()],
        }
    }
}

/// A file that follows a run.
trait Follow {
    /// Adds the current state.
    fn add(&mut self, runner: &Runner) -> io::Result<()>;

    /// Puts the file in its place.
    fn finish(self: Box<Self>) -> Result<(), FileError>;
}

/// A run on its way into a file of another program.
pub struct Export {
    path: PathBuf,
    moments: u64,
    way: Way,
}

enum Way {
    /// The file of the last moment.
    Last(Format, Output),
    /// A file that follows.
    Follow(Box<dyn Follow>),
}

impl Export {
    /// Opens a file for a run that is at its start, and the mesh of a cache; writes no moment yet.
    ///
    /// # Errors
    /// [`FileError::Unwritable`], also for a format that this program was built without.
    pub fn begin(path: &Path, format: Format, runner: &Runner) -> Result<Self, FileError> {
        let refused = |reason: String| FileError::Unwritable { file: shown_path(path), reason };
        if let Some(instead) = format.missing() {
            return Err(refused(instead.into()));
        }
        let output = Output::create(path)?;
        let way = if format.is_of_one_moment() {
            Way::Last(format, output)
        } else {
            let follow = follow(format, (path, output), runner);
            Way::Follow(follow.map_err(|error| refused(error.to_string()))?)
        };
        if let [_, mesh] = &format.files(path)[..] {
            let mut output = Output::create(mesh)?;
            let written = write_obj(runner, &Skin::of(runner), &mut output);
            written.map_err(|error| output.refused(&error))?;
            output.finish()?;
        }
        Ok(Export { path: path.into(), moments: 0, way })
    }

    /// Adds the current state; does nothing for a format that holds a single state.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn add(&mut self, runner: &Runner) -> Result<(), FileError> {
        self.moments += 1;
        let Way::Follow(follow) = &mut self.way else { return Ok(()) };
        follow.add(runner).map_err(|error| {
            let reason = error.to_string();
            FileError::Unwritable { file: shown_path(&self.path), reason }
        })
    }

    /// Puts the file in its place; a format that holds a single state gets the current one. Returns
    /// the number of states in it.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn finish(self, runner: &Runner) -> Result<u64, FileError> {
        match self.way {
            Way::Follow(follow) => follow.finish().map(|()| self.moments),
            Way::Last(format, output) => write_moment(runner, format, output).map(|()| 1),
        }
    }
}

/// Writes the current state of a run; a format that follows runs gets a run of one state.
fn write_moment(runner: &Runner, format: Format, mut output: Output) -> Result<(), FileError> {
    let skin = Skin::of(runner);
    match format {
        Format::Obj => write_obj(runner, &skin, &mut output),
        Format::Ply => write_ply(runner, &skin, &mut output),
        Format::Vtu => write_vtu(runner, &skin, &mut output),
        _ => return write_state(&runner.state(), &mut output).and_then(|()| output.finish()),
    }
    .map_err(|error| output.refused(&error))?;
    output.finish()
}

fn follow(
    format: Format,
    (path, output): (&Path, Output),
    runner: &Runner,
) -> io::Result<Box<dyn Follow>> {
    let skin = Skin::of(runner);
    let spool = || Spool::beside(path);
    Ok(match format {
        Format::Npz => Box::new(Npz::new(output, [spool()?, spool()?], runner)),
        #[cfg(feature = "parquet")]
        Format::Parquet => Box::new(parquet_file::ParquetTable::new(output)?),
        Format::Pc2 => Box::new(MeshCache::new(Cache::Pc2, output, spool()?, &skin)),
        Format::Mdd => Box::new(MeshCache::new(Cache::Mdd, output, spool()?, &skin)),
        Format::Glb => Box::new(Glb::new(output, spool()?, (&skin, runner))?),
        _ => Box::new(Collection::new(output, path, skin)),
    })
}
