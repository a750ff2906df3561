//! The system in columns: a [`Model`] that a step reads, the state that it advances, and a
//! [`Snapshot`] of both for a renderer.

pub mod state;
pub mod model;
pub mod snapshot;
pub mod hash;

pub use model::Model;
pub use snapshot::Snapshot;
pub use state::{Columns, State};
