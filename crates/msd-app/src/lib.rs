//! The window: a scene that runs, and a hand that plays with it.
//!
//! Three layers. [`session`] and what lies above it is logic: it knows no window, and its tests
//! need none. [`viewer`] and [`panel`] are egui: they draw a session and let a person act on it.
//! `window` is the shell: winit, the surface, the frames.
#![forbid(unsafe_code)]

pub mod clock;
pub mod trace;
pub mod margin;
pub mod ration;
pub mod accuracy;
pub mod edits;
pub mod hand;
pub mod session;
mod reading;
mod tuning;
mod stepping;
mod grasp;
mod taping;
pub mod keys;
pub mod lens;
mod gesture;
pub mod viewer;
mod pointing;
pub mod theme;
pub mod panel;
mod canvas;
mod window;
#[cfg(not(target_arch = "wasm32"))]
pub mod report;
pub mod start;

#[cfg(target_arch = "wasm32")]
pub use start::start_web;
pub use start::{Missing, ViewError, catalogue};
#[cfg(not(target_arch = "wasm32"))]
pub use start::{ViewOptions, view, view_as, view_with};
