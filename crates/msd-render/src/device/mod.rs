//! The graphics device, and its parts for a picture: buffers, uniforms, shaders, textures and
//! pipelines.

pub mod gpu;
pub(crate) mod buffers;
pub(crate) mod uniforms;
pub mod quality;
pub mod shaders;
pub(crate) mod targets;
pub(crate) mod pipelines;
