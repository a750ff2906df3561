//! A renderer for moments of a simulation: draws a read-only [`msd_core::Snapshot`] with wgpu, in
//! a window or off screen.
//!
//! The renderer never sees the system, only the snapshot. It uses vertex and instance buffers and
//! two uniform bind groups. It has no compute and no storage buffers, so that it also fits the
//! limits of a browser. [`Renderer::prepare`] turns a snapshot into buffers, [`Renderer::draw`]
//! encodes the passes; [`render_image`] does both and reads the picture back.
//!
//! Colours are sRGB, each component from 0 to 1, unless a name says `linear`.
#![forbid(unsafe_code)]

mod math;
pub mod error;
mod viewing;
mod picture;
mod device;
mod renderer;
#[cfg(not(target_arch = "wasm32"))]
mod offscreen;

pub use device::gpu::Gpu;
pub use device::quality::Quality;
pub use device::{gpu, shaders};
pub use error::RenderError;
#[cfg(not(target_arch = "wasm32"))]
pub use offscreen::{Image, Offscreen, Sheet, render_image};
pub use picture::colour;
pub use picture::colour::{back_colour, body_colour, scale_colour, share_colour, strain_colour};
pub use renderer::Renderer;
pub use viewing::camera::{Camera, Ray};
pub use viewing::pick::{bounds, bounds_with_ground, bounds_with_solids, drag_point, ground, pick};
pub use viewing::quantity::{Quantity, Scale};
pub use viewing::view::{Style, View};
pub use viewing::{camera, pick, quantity, view};
pub use wgpu;
