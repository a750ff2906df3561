//! Pictures and films of runs: from where they look at a scene, and the files that hold them.
//!
//! A [`Sighting`] chooses the view of each frame, which an [`msd_render::Offscreen`] on the device
//! of [`open_gpu`] draws, and [`begin`] makes the file.
#![forbid(unsafe_code)]

mod sighting;
#[cfg(not(target_arch = "wasm32"))]
mod drivers;
#[cfg(not(target_arch = "wasm32"))]
mod film;

#[cfg(not(target_arch = "wasm32"))]
pub use drivers::{open_gpu, quietly};
#[cfg(not(target_arch = "wasm32"))]
pub use film::{About, FilmFile, Kind, begin, write_png};
pub use sighting::{Seen, Shot, Sighting, go_to, seen, turn_to, usual_colours};
