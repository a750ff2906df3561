//! Hands on the run: grabs, and the wind.

mod grab;
mod wind;
mod acts;

pub use grab::{Grab, MOST_HELD};
pub use wind::Wind;
