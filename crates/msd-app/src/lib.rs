//! The window of msd: a running scene that the user watches, edits and drags.
//!
//! [`link`] holds a scene in a line of text. [`session`] is logic without a window, so its tests
//! need none. [`viewer`] adds the view of a session, [`input`] applies mouse and keys to both,
//! [`panel`] draws them with egui, and [`window`] is the shell: winit, the surface, the frames.
//!
//! Features: `window`, on by default, is all of this but links; `gpu`, on by default, lets the
//! command line step on a graphics device; `accessibility` lets screen readers read and press the
//! controls of the window; `parquet` adds tables of sweeps in that format.
#![forbid(unsafe_code)]

pub mod link;
#[cfg(all(feature = "window", not(target_arch = "wasm32")))]
mod background;
#[cfg(feature = "gpu")]
pub mod steppable;
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
