//! Scene files: text, tree of values, rows, scene.
//!
//! A text is read into a [`tree`] of values that know where they were written, some of which may be
//! replaced. [`decode`] makes the rows of the [`schema`] of it, each of whose [`keys`] stands once.
//! [`build`] checks each number against its domain ([`check`]) and makes the rows of a scene,
//! obstacle by obstacle ([`obstacles`]) and body by body ([`bodies`], [`substance`], [`look`]),
//! within a [`budget`] of memory. [`sets`] are particles that pins hold and links join.
//! [`refusals`] finds the other errors of a file that was refused. [`refine`] makes the same scene
//! at a part of its spacing, [`json_schema`] describes the format to other programs.

pub mod tree;
pub mod keys;
mod decode;
pub mod schema;
mod check;
mod turn;
mod budget;
mod substance;
mod sets;
mod bodies;
mod obstacles;
mod touch;
mod look;
mod build;
mod refusals;
mod refine;
mod json_schema;

pub(crate) use bodies::MeshReader;
pub(crate) use budget::{Budget, count_lattice};
pub use budget::{limit_memory, memory_of};
pub(crate) use build::{Understood, understand};
pub use decode::decode;
pub use json_schema::json_schema;
pub use look::{look_of, look_row};
pub(crate) use refine::refine;
pub(crate) use refusals::refusals;
pub use schema::Edits;
pub use touch::{default_shell, shells_of, touch_rows};
pub(crate) use tree::text::ending;
pub use tree::text::{SceneFormat, format_of, read_text};
