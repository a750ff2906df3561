//! User input: keyboard shortcuts, dropped files, and the pointer over the 3D view, which orbits,
//! pans, zooms, grabs and cuts.

mod drops;
mod keys;
mod picking;
mod stroke;
mod pointer;

pub use drops::take_drops;
pub use keys::{KEYS, take_commands};
pub use pointer::read_pointer;
