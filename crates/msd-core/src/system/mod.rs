//! What runs: a [`Model`] that a step reads and the columns that it advances, in the order of slots;
//! and what may be seen of them, a [`Snapshot`].

pub mod columns;
pub mod hash;
pub mod model;
pub mod slots;
pub mod snapshot;
pub mod state;
pub(crate) mod threads;

pub use model::Model;
pub use snapshot::Snapshot;
pub use state::{Columns, State};
