//! The surface of the window: a frame is drawn by the renderer of the scene, then by egui's.

use crate::viewer::Viewer;
use egui::{ClippedPrimitive, TexturesDelta};
use egui_wgpu::{RendererOptions, ScreenDescriptor};
use msd_render::{Gpu, Renderer, Style, View};
use msd_run::on;
use std::sync::Arc;
use wgpu::{CurrentSurfaceTexture, SurfaceTexture};
use winit::window::Window;

/// What egui wants drawn.
pub(crate) struct Painting {
    pub primitives: Vec<ClippedPrimitive>,
    pub textures: TexturesDelta,
    pub pixels_per_point: f32,
}

/// A window that can be drawn on.
pub(crate) struct WindowSurface {
    window: Arc<Window>,
    gpu: Gpu,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    scene: Renderer,
    panels: egui_wgpu::Renderer,
}

impl WindowSurface {
    /// Prepares to draw on a window; `None` if the adapter cannot draw on it after all.
    pub(crate) fn new(
        window: Arc<Window>,
        gpu: Gpu,
        surface: wgpu::Surface<'static>,
    ) -> Option<Self> {
        gpu.device.on_uncaptured_error(Arc::new(|error| log::error!("wgpu: {error}")));
        let size = window.inner_size();
        let (width, height) = (size.width.max(1), size.height.max(1));
        let capabilities = surface.get_capabilities(&gpu.adapter);
        let mut config = surface.get_default_config(&gpu.adapter, width, height)?;
        // Not an sRGB format: egui blends in gamma space, and the scene's shaders encode sRGB.
        config.format = egui_wgpu::preferred_framebuffer_format(&capabilities.formats).ok()?;
        config.present_mode = wgpu::PresentMode::AutoVsync;
        let scene = Renderer::new(&gpu.device, config.format);
        let panels =
            egui_wgpu::Renderer::new(&gpu.device, config.format, RendererOptions::default());
        let mut surface = WindowSurface { window, gpu, surface, config, scene, panels };
        surface.resize();
        Some(surface)
    }

    /// The longest side of a texture, pixels.
    pub(crate) fn longest_side(&self) -> usize {
        self.gpu.device.limits().max_texture_dimension_2d as usize
    }

    /// The driver, for the log.
    pub(crate) fn adapter(&self) -> String {
        let info = self.gpu.adapter.get_info();
        format!("{} ({})", info.name, info.backend)
    }

    /// Takes the size of the window; a minimised one has none.
    pub(crate) fn resize(&mut self) {
        let size = self.window.inner_size();
        if size.width == 0 || size.height == 0 {
            return;
        }
        let longest = self.longest_side() as u32;
        self.config.width = size.width.min(longest);
        self.config.height = size.height.min(longest);
        self.surface.configure(&self.gpu.device, &self.config);
    }

    /// Whether there is anything to draw on.
    pub(crate) fn is_visible(&self) -> bool {
        let size = self.window.inner_size();
        0 < size.width && 0 < size.height
    }

    /// Draws a frame, or only takes over egui's textures where the window has none to give.
    pub(crate) fn paint(&mut self, viewer: &Viewer, painting: Painting) {
        let Gpu { device, queue, .. } = &self.gpu;
        let Painting { primitives, mut textures, pixels_per_point } = painting;
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.panels.update_texture(device, queue, id, &delta);
            }
        }
        if let Some(frame) = self.next_frame() {
            self.draw(frame, viewer, &primitives, pixels_per_point);
        }
        for id in textures.free.drain() {
            self.panels.free_texture(&id);
        }
    }

    fn next_frame(&mut self) -> Option<SurfaceTexture> {
        match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(frame) | CurrentSurfaceTexture::Suboptimal(frame) => {
                Some(frame)
            }
            CurrentSurfaceTexture::Outdated => {
                self.resize();
                None
            }
            CurrentSurfaceTexture::Lost => {
                match self.gpu.instance.create_surface(self.window.clone()) {
                    Ok(surface) => self.surface = surface,
                    Err(error) => log::error!("the surface is lost: {error}"),
                }
                self.resize();
                None
            }
            CurrentSurfaceTexture::Timeout
            | CurrentSurfaceTexture::Occluded
            | CurrentSurfaceTexture::Validation => None,
        }
    }

    fn draw(
        &mut self,
        frame: SurfaceTexture,
        viewer: &Viewer,
        primitives: &[ClippedPrimitive],
        pixels_per_point: f32,
    ) {
        let Gpu { device, queue, .. } = &self.gpu;
        let size = [self.config.width, self.config.height];
        let shades = viewer.shades();
        // A pattern would pass for a difference.
        let pattern = viewer.style.pattern && shades.is_none();
        let style = Style { pixels_per_point, pattern, ..viewer.style };
        let view = View { camera: viewer.camera, style };
        self.scene.set_shades(shades.into_iter().flatten());
        on!(viewer.session.runner(), simulation => {
            self.scene.prepare(device, queue, &simulation.snapshot(), &view);
        });
        let target = frame.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let area = viewer.rect * pixels_per_point;
        let viewport = [area.left(), area.top(), area.width(), area.height()];
        self.scene.draw(&mut encoder, &target, size, viewport);
        let screen = ScreenDescriptor { size_in_pixels: size, pixels_per_point };
        // Before the pass, which reads these buffers.
        let panels = &mut self.panels;
        let uploads = panels.update_buffers(device, queue, &mut encoder, primitives, &screen);
        let attachment = wgpu::RenderPassColorAttachment {
            view: &target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
        };
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("panels"),
            color_attachments: &[Some(attachment)],
            ..Default::default()
        });
        // egui wants a pass without a lifetime; it must end before the encoder does.
        panels.render(&mut pass.forget_lifetime(), primitives, &screen);
        queue.submit(uploads.into_iter().chain([encoder.finish()]));
        self.window.pre_present_notify();
        queue.present(frame);
    }
}
