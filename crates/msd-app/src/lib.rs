//! The window of msd: a scene that runs, and a user who plays with it.
//!
//! [`session`] is logic: it knows no window, and its tests need none. [`viewer`] adds how a session
//! is looked at, [`input`] what mouse and keys do to both, [`panel`] draws them with egui, and
//! [`window`] is the shell: winit, the surface, the frames.
#![forbid(unsafe_code)]

#[cfg(not(target_arch = "wasm32"))]
pub mod drivers;
pub mod session;
pub mod viewer;
pub mod input;
pub mod panel;
pub mod window;

pub use viewer::catalogue;
#[cfg(target_arch = "wasm32")]
pub use window::start;
pub use window::{Missing, ViewError};
#[cfg(not(target_arch = "wasm32"))]
pub use window::{last_scene, view, view_as, view_link};
