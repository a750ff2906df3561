//! User input: keys become commands, and the pointer over the 3D view turns, pans, zooms, grabs and cuts.

mod drops;
mod keys;
mod picking;
mod stroke;
mod pointer;

pub use drops::take_drops;
pub use keys::{KEYS, take_commands};
pub use pointer::read_pointer;
