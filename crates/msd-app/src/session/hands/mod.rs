//! Hands on the run: grabs, and the wind.

mod grab;
mod acts;

pub use grab::{Grab, MOST_HELD};
