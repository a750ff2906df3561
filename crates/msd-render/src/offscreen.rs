//! Pictures in memory: drawn into a texture and read back.

use crate::device::gpu::Gpu;
use crate::device::quality::Quality;
use crate::error::RenderError;
use crate::renderer::Renderer;
use crate::viewing::view::View;
use msd_core::{Real, Snapshot};
use wgpu::{Buffer, Device, Texture, TextureFormat, TextureUsages, TextureView};

/// A picture in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Red, green, blue and opacity of each pixel, sRGB, row by row from the top.
    pub rgba: Vec<u8>,
}

/// Draws pictures of one size without a window; pipelines and textures are made once.
#[derive(Debug)]
pub struct Offscreen {
    gpu: Gpu,
    renderer: Renderer,
    sheet: Sheet,
}

/// A texture of one size to draw on, which can be read back.
#[derive(Debug)]
pub struct Sheet {
    size: [u32; 2],
    texture: Texture,
    buffer: Buffer,
    /// Bytes from one row to the next in `buffer`; the device wants a multiple of 256.
    row_bytes: u32,
}

/// Draws one picture; for several of one size an [`Offscreen`] is faster.
///
/// # Errors
/// Those of [`Sheet::new`] and [`Sheet::read`].
pub fn render_image<R: Real>(
    gpu: &Gpu,
    snapshot: &Snapshot<'_, R>,
    view: &View,
    width: u32,
    height: u32,
) -> Result<Image, RenderError> {
    Offscreen::new(gpu, width, height)?.render(snapshot, view)
}

impl Offscreen {
    /// Prepares for pictures of this size, pixels, and of full quality.
    ///
    /// # Errors
    /// See [`Sheet::new`].
    pub fn new(gpu: &Gpu, width: u32, height: u32) -> Result<Self, RenderError> {
        Self::with_quality(gpu, [width, height], Quality::Full)
    }

    /// Prepares for pictures of this size, pixels, and quality.
    ///
    /// # Errors
    /// See [`Sheet::new`].
    pub fn with_quality(
        gpu: &Gpu,
        [width, height]: [u32; 2],
        quality: Quality,
    ) -> Result<Self, RenderError> {
        let sheet = Sheet::new(gpu, width, height)?;
        let renderer = Renderer::new(&gpu.device, (Sheet::FORMAT, quality));
        Ok(Self { gpu: gpu.clone(), renderer, sheet })
    }

    /// Draws a picture and waits for it.
    ///
    /// # Errors
    /// See [`Sheet::read`].
    pub fn render<R: Real>(
        &mut self,
        snapshot: &Snapshot<'_, R>,
        view: &View,
    ) -> Result<Image, RenderError> {
        let Gpu { device, queue, .. } = &self.gpu;
        self.renderer.prepare(device, queue, snapshot, view);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let size = self.sheet.size();
        let viewport = [0.0, 0.0, size[0] as f32, size[1] as f32];
        self.renderer.draw(&mut encoder, &self.sheet.target(), size, viewport);
        queue.submit([encoder.finish()]);
        let mut image = self.sheet.read(&self.gpu)?;
        if !view.style.sky {
            image.divide_by_opacity();
        }
        Ok(image)
    }
}

impl Image {
    /// Brings back the colours of pixels that were multiplied by their opacity.
    fn divide_by_opacity(&mut self) {
        for pixel in self.rgba.chunks_exact_mut(4) {
            let [colour @ .., opacity] = pixel else { continue };
            let opacity = u32::from(*opacity);
            for part in colour {
                let whole = (u32::from(*part) * 255 + opacity / 2).checked_div(opacity);
                *part = whole.map_or(0, |whole| whole.min(255) as u8);
            }
        }
    }
}

impl Sheet {
    /// The format of its pixels.
    pub const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

    /// A sheet of this size, pixels.
    ///
    /// # Errors
    /// [`RenderError::Size`] if a side is zero or larger than a texture can be,
    /// [`RenderError::Memory`] if the picture does not fit into a buffer.
    pub fn new(gpu: &Gpu, width: u32, height: u32) -> Result<Self, RenderError> {
        let limits = gpu.device.limits();
        let limit = limits.max_texture_dimension_2d;
        if !(1..=limit).contains(&width) || !(1..=limit).contains(&height) {
            return Err(RenderError::Size { width, height, limit });
        }
        let row_bytes = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(row_bytes) * u64::from(height);
        if limits.max_buffer_size < bytes {
            let limit = limits.max_buffer_size;
            return Err(RenderError::Memory { width, height, bytes, limit });
        }
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("off screen"),
            size: extent([width, height]),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Self::FORMAT,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: bytes,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Self { size: [width, height], texture, buffer, row_bytes })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The texture on which a pass draws.
    pub fn target(&self) -> TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// Waits for submitted commands, and reads the picture.
    ///
    /// # Errors
    /// [`RenderError::ReadBack`] if the device was lost meanwhile.
    pub fn read(&self, gpu: &Gpu) -> Result<Image, RenderError> {
        let Gpu { device, queue, .. } = gpu;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &self.buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(self.row_bytes),
                    rows_per_image: None,
                },
            },
            extent(self.size),
        );
        queue.submit([encoder.finish()]);
        let [width, height] = self.size;
        Ok(Image { width, height, rgba: self.map(device)? })
    }

    fn map(&self, device: &Device) -> Result<Vec<u8>, RenderError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        self.buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver waits below, unless polling failed and nobody asks any more.
            let _ = sender.send(result);
        });
        let failed = |what: &dyn std::fmt::Display| RenderError::ReadBack(what.to_string());
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| failed(&e))?;
        receiver.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
        let mut rgba = Vec::with_capacity(4 * self.size[0] as usize * self.size[1] as usize);
        {
            let mapped = self.buffer.get_mapped_range(..).map_err(|e| failed(&e))?;
            for row in mapped.chunks_exact(self.row_bytes as usize) {
                rgba.extend_from_slice(&row[..4 * self.size[0] as usize]);
            }
        }
        self.buffer.unmap();
        Ok(rgba)
    }
}

fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: 1 }
}
