//! Scene files, built-in scenes, meshes and state files.
#![forbid(unsafe_code)]

pub mod mesh;
pub mod runner;
pub mod scenes;

pub use msd_core;
pub use runner::{AnyState, Precision, Runner};
pub use scenes::{Builtin, Loaded};
