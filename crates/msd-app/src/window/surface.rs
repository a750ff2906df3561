//! The surface of the window: its size, its next texture, and recovery after its loss.

use super::canvas::{Canvas, Painting};
use crate::viewer::Viewer;
use msd_render::{Gpu, Quality};
use std::sync::{Arc, OnceLock};
use wgpu::{CurrentSurfaceTexture, SurfaceTexture};
use winit::window::Window;

/// The surface of a window, with its renderers.
pub(crate) struct WindowSurface {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    pub(super) canvas: Canvas,
    /// Reason for the loss of the device, once it is lost.
    loss: Arc<OnceLock<String>>,
    /// Whether a test simulates the loss of the surface.
    pub(super) is_lost: bool,
}

impl WindowSurface {
    /// Creates the surface of a window; `None` if the adapter does not support it.
    pub(crate) fn new(
        window: Arc<Window>,
        gpu: Gpu,
        surface: wgpu::Surface<'static>,
    ) -> Option<Self> {
        gpu.device.on_uncaptured_error(Arc::new(|error| log::error!("wgpu: {error}")));
        let loss = Arc::new(OnceLock::new());
        let lost = loss.clone();
        gpu.device.set_device_lost_callback(move |reason, text| {
            let text = if text.is_empty() { format!("{reason:?}").to_lowercase() } else { text };
            // The first reason is the cause.
            lost.set(text).ok();
        });
        let size = window.inner_size();
        let (width, height) = (size.width.max(1), size.height.max(1));
        let capabilities = surface.get_capabilities(&gpu.adapter);
        let mut config = surface.get_default_config(&gpu.adapter, width, height)?;
        // Not an sRGB format: egui blends in gamma space, and the scene's shaders encode sRGB.
        config.format = egui_wgpu::preferred_framebuffer_format(&capabilities.formats).ok()?;
        config.present_mode = wgpu::PresentMode::AutoVsync;
        let quality = Quality::of(&gpu.adapter);
        let canvas = Canvas::new(gpu, (config.format, quality));
        let mut surface = WindowSurface { window, surface, config, canvas, loss, is_lost: false };
        surface.resize();
        Some(surface)
    }

    /// Returns the largest side of a texture, pixels.
    pub(crate) fn longest_side(&self) -> usize {
        self.canvas.gpu.device.limits().max_texture_dimension_2d as usize
    }

    /// Returns the quality of the graphics.
    pub(crate) fn quality(&self) -> Quality {
        Quality::of(&self.canvas.gpu.adapter)
    }

    /// Returns the graphics device.
    pub(crate) fn gpu(&self) -> &Gpu {
        &self.canvas.gpu
    }

    /// Returns the name of the adapter, for the log.
    pub(crate) fn adapter(&self) -> String {
        let info = self.canvas.gpu.adapter.get_info();
        format!("{} ({})", info.name, info.backend)
    }

    /// Returns the reason for the loss of the device, if it is lost.
    pub(crate) fn loss(&self) -> Option<&str> {
        self.loss.get().map(String::as_str)
    }

    /// Adapts to the size of the window; a minimised one has none.
    pub(crate) fn resize(&mut self) {
        let size = self.window.inner_size();
        if size.width == 0 || size.height == 0 {
            return;
        }
        let longest = self.longest_side() as u32;
        self.config.width = size.width.min(longest);
        self.config.height = size.height.min(longest);
        self.surface.configure(&self.canvas.gpu.device, &self.config);
    }

    /// Returns whether the window has an area.
    pub(crate) fn is_visible(&self) -> bool {
        let size = self.window.inner_size();
        0 < size.width && 0 < size.height
    }

    /// Renders a frame, or only updates egui's textures if the surface has no texture.
    pub(crate) fn paint(&mut self, viewer: &Viewer, mut painting: Painting) {
        self.canvas.take_textures(&mut painting);
        if let Some(frame) = self.next_frame() {
            let target = frame.texture.create_view(&wgpu::TextureViewDescriptor::default());
            let size = [self.config.width, self.config.height];
            self.canvas.draw(&target, size, viewer, &painting);
            self.window.pre_present_notify();
            self.canvas.gpu.queue.present(frame);
        }
        self.canvas.free_textures(&mut painting);
    }

    fn next_frame(&mut self) -> Option<SurfaceTexture> {
        let texture = if std::mem::take(&mut self.is_lost) {
            CurrentSurfaceTexture::Lost
        } else {
            self.surface.get_current_texture()
        };
        match texture {
            CurrentSurfaceTexture::Success(frame) | CurrentSurfaceTexture::Suboptimal(frame) => {
                Some(frame)
            }
            CurrentSurfaceTexture::Outdated => {
                self.resize();
                // A paused window requests no further frame by itself.
                self.window.request_redraw();
                None
            }
            CurrentSurfaceTexture::Lost => {
                log::warn!("the surface was lost: creating a new one");
                match self.canvas.gpu.instance.create_surface(self.window.clone()) {
                    Ok(surface) => self.surface = surface,
                    Err(error) => log::error!("cannot create another surface: {error}"),
                }
                self.resize();
                self.window.request_redraw();
                None
            }
            CurrentSurfaceTexture::Timeout
            | CurrentSurfaceTexture::Occluded
            | CurrentSurfaceTexture::Validation => None,
        }
    }
}
