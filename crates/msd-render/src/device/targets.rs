//! Textures into which a picture is drawn before it reaches its target.

use wgpu::{Device, TextureFormat, TextureUsages, TextureView};

/// Format of depth. A float, because depth falls to zero far away.
pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

/// Format of the map of shade on the ground: a share of light.
pub(crate) const SHADE_FORMAT: TextureFormat = TextureFormat::R8Unorm;

/// Colour, if it has several samples per pixel, and depth, of the size of the target.
#[derive(Debug)]
pub(crate) struct Targets {
    /// Size, pixels.
    pub size: [u32; 2],
    /// Colour, to be resolved into the target; none where that is drawn on at once.
    pub colour: Option<TextureView>,
    /// Depth.
    pub depth: TextureView,
}

impl Targets {
    /// Makes the textures.
    pub fn new(device: &Device, format: TextureFormat, (size, samples): ([u32; 2], u32)) -> Self {
        let colour = (1 < samples).then(|| texture(device, "picture", format, (size, samples)));
        let depth = texture(device, "depth", DEPTH_FORMAT, (size, samples));
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
