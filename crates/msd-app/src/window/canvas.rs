//! Rendering of a frame: the scene, and the panels over it.

use crate::viewer::{Side, Viewer};
use egui::{ClippedPrimitive, TexturesDelta};
use egui_wgpu::{RendererOptions, ScreenDescriptor};
use msd_render::{Gpu, Quality, Renderer, Style, View};
use msd_run::on;
use wgpu::{TextureFormat, TextureView};

/// Draw data of egui.
pub(crate) struct Painting {
    pub primitives: Vec<ClippedPrimitive>,
    pub textures: TexturesDelta,
    pub pixels_per_point: f32,
}

impl Painting {
    /// Tessellates the output of a layout.
    pub(crate) fn of(context: &egui::Context, output: egui::FullOutput) -> Self {
        let pixels_per_point = output.pixels_per_point;
        let primitives = context.tessellate(output.shapes, pixels_per_point);
        Painting { primitives, textures: output.textures_delta, pixels_per_point }
    }
}

/// The renderers of scene and panels, on the same device.
pub(crate) struct Canvas {
    pub gpu: Gpu,
    scene: Renderer,
    panels: egui_wgpu::Renderer,
    format: TextureFormat,
    half: Option<Half>,
}

/// A view at half the resolution, with its copy to the target.
struct Half {
    size: [u32; 2],
    view: TextureView,
    blitter: wgpu::util::TextureBlitter,
}

impl Half {
    /// Allocates the half for a target of this size, pixels.
    fn new(device: &wgpu::Device, format: TextureFormat, size: [u32; 2]) -> Self {
        let [width, height] = size.map(|side| side.div_ceil(2).max(1));
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("half of the resolution"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        });
        let blitter = wgpu::util::TextureBlitterBuilder::new(device, format)
            .sample_type(wgpu::FilterMode::Linear)
            .build();
        Half { size, view: texture.create_view(&wgpu::TextureViewDescriptor::default()), blitter }
    }
}

impl Canvas {
    /// Creates the renderers for a texture format and a quality.
    pub(crate) fn new(gpu: Gpu, (format, quality): (TextureFormat, Quality)) -> Self {
        let scene = Renderer::new(&gpu.device, (format, quality));
        let panels = egui_wgpu::Renderer::new(&gpu.device, format, RendererOptions::default());
        Canvas { gpu, scene, panels, format, half: None }
    }

    /// Uploads egui's new textures, before it draws.
    pub(crate) fn take_textures(&mut self, painting: &mut Painting) {
        let Gpu { device, queue, .. } = &self.gpu;
        for (id, deltas) in painting.textures.set.drain() {
            for delta in deltas {
                self.panels.update_texture(device, queue, id, &delta);
            }
        }
    }

    /// Frees the textures that egui has released, after it drew.
    pub(crate) fn free_textures(&mut self, painting: &mut Painting) {
        for id in painting.textures.free.drain() {
            self.panels.free_texture(&id);
        }
    }

    /// Renders a frame to a target of this size, pixels.
    pub(crate) fn draw(
        &mut self,
        target: &TextureView,
        size: [u32; 2],
        viewer: &Viewer,
        painting: &Painting,
    ) {
        let &Painting { ref primitives, pixels_per_point, .. } = painting;
        let format = self.format;
        let half = viewer.sharpness.is_half().then(|| {
            let old = self.half.take().filter(|half| half.size == size);
            old.unwrap_or_else(|| Half::new(&self.gpu.device, format, size))
        });
        let (place, place_size, scale) = match &half {
            Some(half) => (&half.view, size.map(|side| side.div_ceil(2).max(1)), 0.5),
            None => (target, size, 1.0),
        };
        for &side in viewer.sides() {
            self.draw_side(place, place_size, viewer, (side, scale * pixels_per_point));
        }
        let Gpu { device, queue, .. } = &self.gpu;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if let Some(half) = &half {
            half.blitter.copy(device, &mut encoder, &half.view, target);
        }
        self.half = half;
        let screen = ScreenDescriptor { size_in_pixels: size, pixels_per_point };
        // Before the pass, which reads these buffers.
        let panels = &mut self.panels;
        let uploads = panels.update_buffers(device, queue, &mut encoder, primitives, &screen);
        let attachment = wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
        };
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("panels"),
            color_attachments: &[Some(attachment)],
            ..Default::default()
        });
        // egui needs a pass without a lifetime; it must end before the encoder does.
        panels.render(&mut pass.forget_lifetime(), primitives, &screen);
        queue.submit(uploads.into_iter().chain([encoder.finish()]));
    }

    /// Renders the run or its twin to its part of the target.
    fn draw_side(
        &mut self,
        target: &TextureView,
        size: [u32; 2],
        viewer: &Viewer,
        (side, pixels_per_point): (Side, f32),
    ) {
        let Gpu { device, queue, .. } = &self.gpu;
        let style = Style { pixels_per_point, ..viewer.style };
        let view = View { camera: viewer.camera, style };
        // The error belongs to the run.
        let errors = viewer.errors().filter(|_| side == Side::Run);
        self.scene.set_errors(errors.into_iter().flatten());
        on!(viewer.runner_of(side), simulation => {
            self.scene.prepare(device, queue, &simulation.snapshot(), &view);
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let area = viewer.viewport_of(side).rect * pixels_per_point;
        let viewport = [area.left(), area.top(), area.width(), area.height()];
        match (side, viewer.sides()) {
            (Side::Run, [_]) => self.scene.draw(&mut encoder, target, size, viewport),
            (Side::Run, _) => self.scene.draw_first(&mut encoder, target, size, viewport),
            (Side::Twin, _) => self.scene.draw_beside(&mut encoder, target, size, viewport),
        }
        queue.submit([encoder.finish()]);
    }
}
