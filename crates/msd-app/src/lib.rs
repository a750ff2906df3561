//! The window of msd: a scene that runs, and a user who plays with it.
//!
//! [`link`] is a scene in a line of text. [`session`] is logic: it knows no window, and its tests
//! need none. [`viewer`] adds how a session is looked at, [`input`] what mouse and keys do to both,
//! [`panel`] draws them with egui, and [`window`] is the shell: winit, the surface, the frames.
//!
//! Features: `window`, on by default, is all of this but links; `accessibility` lets screen readers
//! read and press what is in the window; `parquet` is for tables of sweeps.
#![forbid(unsafe_code)]

pub mod link;
#[cfg(all(feature = "window", not(target_arch = "wasm32")))]
mod background;
#[cfg(feature = "window")]
pub mod session;
#[cfg(feature = "window")]
pub mod viewer;
#[cfg(feature = "window")]
pub mod input;
#[cfg(feature = "window")]
pub mod panel;
#[cfg(feature = "window")]
pub mod window;

#[cfg(feature = "window")]
pub use viewer::catalogue;
#[cfg(feature = "window")]
pub use window::{Missing, ViewError};
#[cfg(all(feature = "window", not(target_arch = "wasm32")))]
pub use window::{last_scene, view, view_as, view_link};
#[cfg(all(feature = "window", target_arch = "wasm32"))]
pub use window::{report_panics, start};
