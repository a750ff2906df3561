//! The graphics device, and what a picture needs on it: buffers, uniforms, shaders, textures and
//! pipelines.

pub mod gpu;
pub(crate) mod buffers;
pub(crate) mod uniforms;
pub mod quality;
pub mod shaders;
pub(crate) mod targets;
pub(crate) mod pipelines;
