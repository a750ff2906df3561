//! User input: keys become commands; the pointer over the 3D view turns, pans, zooms, grabs and
//! cuts; dropped files are opened.

mod drops;
mod keys;
mod picking;
mod stroke;
mod pointer;

pub use drops::take_drops;
pub use keys::{KEYS, take_commands};
pub use pointer::read_pointer;
