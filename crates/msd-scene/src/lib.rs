//! Scene files, built-in scenes, meshes and state files.
//!
//! ```
//! let loaded = msd_lab::open("jelly")?;
//! let mut runner = loaded.runner()?;
//! runner.step()?;
//! assert_eq!(runner.particle_count(), 1000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod shown;
pub mod mesh;
pub mod error;
pub mod runner;
pub mod rounding;
pub mod schema;
mod node;
mod decode;
pub mod domain;
mod turn;
mod budget;
mod bodies;
mod build;
mod input;
pub mod file_id;
pub mod output;
pub mod marks;
mod envelope;
pub mod loaded;
pub mod saved;
pub mod scenes;
mod nearby;
pub mod peers;
pub mod state_file;
pub mod state_hash;
pub mod trace;
pub mod history;
pub mod recording;
pub mod replay;
pub mod twin;
pub mod trade;
#[cfg(not(target_arch = "wasm32"))]
pub mod extremes;
pub mod solver_section;
#[cfg(not(target_arch = "wasm32"))]
pub mod sweep;

pub use error::{LabError, Place, nearest, plain, shown_path, tame};
pub use file_id::FileId;
pub use msd_core;
pub use node::SceneFormat;
pub use output::Output;
pub use recording::{
    Recorder, Recording, load_recording, load_salvaged, read_recording, salvage_recording,
};
pub use replay::{Changes, Replay};
pub use rounding::Rounding;
pub use runner::{AnyState, Moment, Precision, Runner};
pub use saved::{load_saved, read_saved, write_saved};
pub use scenes::{BUILTINS, Builtin, Loaded, load, open, parse, read, write};
pub use state_file::{load_state, read_state, write_state};
pub use state_hash::state_hash;
pub use trace::Trace;
pub use twin::{Apart, Twin};
