//! What the user does to the run by hand: grabs, and the wind.

mod grab;
mod wind;

pub(super) use grab::force;
pub use grab::{Grab, MOST_HELD};
pub use wind::Wind;
