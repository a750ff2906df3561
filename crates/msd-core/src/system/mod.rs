//! The system in columns: model, state and snapshot.
//!
//! A step reads a [`Model`] and advances the columns of a [`State`]; a renderer borrows a
//! [`Snapshot`].

pub mod state;
pub(crate) mod guides;
mod kinds;
pub mod model;
pub mod snapshot;
pub mod hash;

pub use model::Model;
pub use snapshot::Snapshot;
pub use state::{Columns, State};
