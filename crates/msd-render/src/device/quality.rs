//! Quality of pictures, by their cost.

use wgpu::{Adapter, DeviceType};

/// Quality of a picture: the most beautiful, or one that a processor draws in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Soft shadows, four samples per pixel, a grid on the ground. Default.
    #[default]
    Full,
    /// Plain shadows from a smaller map, one sample per pixel, no grid: several times as fast
    /// without a graphics processor.
    Fast,
}

impl Quality {
    /// The quality that suits an adapter: fast where pictures are computed in software.
    pub fn of(adapter: &Adapter) -> Self {
        match adapter.get_info().device_type {
            DeviceType::Cpu => Quality::Fast,
            _ => Quality::Full,
        }
    }

    /// Samples per pixel; every adapter has one and four.
    pub(crate) fn samples(self) -> u32 {
        match self {
            Quality::Full => 4,
            Quality::Fast => 1,
        }
    }

    /// Side of the shadow map, texels.
    pub(crate) fn shadow_size(self) -> u32 {
        match self {
            Quality::Full => 2048,
            Quality::Fast => 512,
        }
    }

    /// Side of the depth map of bodies above the ground, texels: its softness is wanted.
    pub(crate) fn ground_size(self) -> u32 {
        match self {
            Quality::Full => 256,
            Quality::Fast => 32,
        }
    }
}
