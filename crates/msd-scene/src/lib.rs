//! Scene files, built-in scenes, meshes, state files and saved runs.
//!
//! [`open()`] takes the user's input - the name of a built-in scene, a scene file, a mesh or a
//! saved run - and returns a [`Loaded`]: the rows of a [`Scene`](msd_core::Scene) and the settings
//! of its author. `msd-run` makes a run of it.
//!
//! ```
//! let loaded = msd_scene::open("jelly")?;
//! assert_eq!(loaded.scene.particles.len(), 1000);
//! # Ok::<(), msd_scene::FileError>(())
//! ```
#![forbid(unsafe_code)]

mod shown;
mod precision;
mod viewpoint;
mod rounding;
mod state;
mod nearby;
pub mod crossing;
pub mod mesh;
mod model;
mod error;
pub mod materials;
mod disk;
mod file;
mod loaded;
mod storage;
mod builtin;
mod open;
pub mod workloads;

pub use builtin::{BUILTINS, Builtin, LESSONS};
pub use disk::{FileId, Output, Spool, write_file};
pub use error::{FileError, Place, nearest, one_line, plain};
pub use file::tree::{Assignment, SetKeys, key, set_keys};
pub use file::{
    Edits, SceneFormat, decode, default_shell, format_of, json_schema, keys, limit_memory, look_of,
    look_row, memory_of, read_text, schema, shells_of, touch_rows, tree,
};
pub use loaded::Loaded;
pub use model::{Wind, parts};
pub use open::{
    Draft, Finer, load, open, open_bytes, open_bytes_with, open_set, parse, read, write,
};
pub use precision::Precision;
pub use rounding::Rounding;
pub use shown::{shown_path, tame};
pub use state::{AnyState, state_hash};
pub use storage::{
    envelope, load_saved, load_state, read_saved, read_state, saved_bytes, write_saved, write_state,
};
pub use viewpoint::{Sight, Viewpoint};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
