//! Textures into which a picture is drawn before it reaches its target.

use wgpu::{Device, TextureFormat, TextureUsages, TextureView};

/// Samples per pixel; every adapter has four.
pub(crate) const SAMPLES: u32 = 4;
/// Format of depth. A float, because depth falls to zero far away.
pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

/// Colour and depth with several samples per pixel, of the size of the target.
#[derive(Debug)]
pub(crate) struct Targets {
    /// Size, pixels.
    pub size: [u32; 2],
    /// Colour.
    pub colour: TextureView,
    /// Depth.
    pub depth: TextureView,
}

impl Targets {
    /// Makes the textures.
    pub fn new(device: &Device, format: TextureFormat, size: [u32; 2]) -> Self {
        let colour = texture(device, "picture", format, (size, SAMPLES));
        let depth = texture(device, "depth", DEPTH_FORMAT, (size, SAMPLES));
        Self { size, colour, depth }
    }
}

/// Makes a texture that can be drawn to, and read by a shader if it has one sample.
pub(crate) fn texture(
    device: &Device,
    label: &str,
    format: TextureFormat,
    (size, samples): ([u32; 2], u32),
) -> TextureView {
    let read = if samples == 1 { TextureUsages::TEXTURE_BINDING } else { TextureUsages::empty() };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT | read,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
