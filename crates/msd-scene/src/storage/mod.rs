//! Files that msd writes and reads back to the last bit: states and saved runs.

pub mod envelope;
mod saved;
mod state_file;

pub(crate) use saved::ENDING;
pub use saved::{load_saved, read_saved, saved_bytes, write_saved};
pub use state_file::{load_state, read_state, write_state};
