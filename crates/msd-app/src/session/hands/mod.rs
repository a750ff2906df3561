//! User forces: grabs and wind.

mod grab;
mod acts;

pub use grab::{Grab, MOST_HELD};
