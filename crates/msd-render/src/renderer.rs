//! The renderer: a snapshot is uploaded once, then drawn in two passes, shadow and scene.

use crate::device::buffers::Rows;
use crate::device::pipelines::{Casters, Pipelines};
use crate::device::quality::Quality;
use crate::device::targets::{DEPTH_FORMAT, SHADE_FORMAT, Targets, texture};
use crate::device::uniforms::{Globals, Light};
use crate::picture::compose::set_geometry;
use crate::picture::geometry::Geometry;
use crate::picture::ground::{depth_map, light_direction, scene_radius};
use crate::picture::legend::{self, legend};
use crate::viewing::view::View;
use glam::Vec3;
use msd_core::{Real, Snapshot};
use wgpu::{BindGroup, Buffer, BufferUsages, CommandEncoder, Device, Queue, RenderPass};
use wgpu::{RenderPipeline, TextureFormat, TextureView};

/// Colour around the viewport, sRGB; an application covers it with its panels.
const SURROUND: f64 = 0.12;
const CLEAR: wgpu::LoadOp<wgpu::Color> =
    wgpu::LoadOp::Clear(wgpu::Color { r: SURROUND, g: SURROUND, b: SURROUND, a: 1.0 });

/// Draws snapshots into textures of one format; one picture at a time.
///
/// Call [`Renderer::prepare`] whenever the snapshot or the view changed, then [`Renderer::draw`],
/// and submit the encoder before the next `prepare`.
#[derive(Debug)]
pub struct Renderer {
    device: Device,
    format: TextureFormat,
    quality: Quality,
    pipelines: Pipelines,
    bindings: Bindings,
    rows: AllRows,
    geometry: Geometry,
    targets: Option<Targets>,
    /// The results of the last `prepare` for `draw`.
    prepared: Option<Prepared>,
}

#[derive(Debug)]
struct Prepared {
    queue: Queue,
    view: View,
    light: Light,
}

/// Uniforms, and pictures of depths.
#[derive(Debug)]
struct Bindings {
    /// Those of the picture, and those of the ground seen from below.
    globals: [(Buffer, BindGroup); 2],
    shadow_map: TextureView,
    ground_map: TextureView,
    shade_map: TextureView,
    shadow_group: BindGroup,
}

/// The buffers, by kind.
#[derive(Debug)]
struct AllRows {
    vertices: Rows,
    triangles: Rows,
    lines: Rows,
    points: Rows,
    patches: Rows,
    rects: Rows,
}

impl Renderer {
    /// Compiles the pipelines for targets of this format, and pictures of this quality.
    ///
    /// Into a format without `Srgb` in its name the shaders write sRGB themselves, as egui wants.
    pub fn new(device: &Device, (format, quality): (TextureFormat, Quality)) -> Self {
        let layouts = [globals_layout(device), shadow_layout(device)];
        let rows = |label| Rows::new(label, BufferUsages::VERTEX);
        Self {
            device: device.clone(),
            format,
            quality,
            pipelines: Pipelines::new(device, (format, quality), [&layouts[0], &layouts[1]]),
            bindings: Bindings::new(device, &layouts, quality),
            rows: AllRows {
                vertices: rows("surface vertices"),
                triangles: Rows::new("surface triangles", BufferUsages::INDEX),
                lines: rows("lines"),
                points: rows("points"),
                patches: rows("planes"),
                rects: rows("legend"),
            },
            geometry: Geometry::default(),
            targets: None,
            prepared: None,
        }
    }

    /// Sets the errors of particles, metres, from the next [`Renderer::prepare`] on, for a style
    /// that colours by [`crate::Quantity::Error`]. As long as there is none for each particle,
    /// bodies have their own colours.
    pub fn set_errors(&mut self, errors: impl IntoIterator<Item = f32>) {
        self.geometry.errors.clear();
        self.geometry.errors.extend(errors);
    }

    /// Uploads the parts of a snapshot that a view shows.
    ///
    /// Positions that are not finite, and all that touches them, are left out. So are lines and
    /// points that do not fit into the largest buffer of the device; that is logged.
    pub fn prepare<R: Real>(
        &mut self,
        device: &Device,
        queue: &Queue,
        snapshot: &Snapshot<'_, R>,
        view: &View,
    ) {
        let geometry = &mut self.geometry;
        set_geometry(geometry, snapshot, view, device.limits().max_buffer_size);
        self.rows.vertices.upload(device, queue, &geometry.vertices);
        self.rows.triangles.upload(device, queue, &geometry.triangles);
        self.rows.lines.upload(device, queue, &geometry.lines);
        self.rows.points.upload(device, queue, &geometry.points);
        self.rows.patches.upload(device, queue, &geometry.patches);
        let mut view = *view;
        // A pattern would pass for a difference.
        view.style.pattern &= geometry.scale.is_none();
        let shown = geometry.scale.filter(|_| view.style.legend);
        let rects = shown.map_or(Vec::new(), |scale| legend(scale, view.style.scale()));
        self.rows.rects.upload(device, queue, &rects);
        let light = Light {
            sun: depth_map(geometry, light_direction(&view), self.quality.shadow_size()),
            ground: depth_map(geometry, Vec3::NEG_Y, self.quality.ground_size()),
            level: geometry.level,
            radius: scene_radius(geometry.bounds),
        };
        self.prepared = Some(Prepared { queue: queue.clone(), view, light });
    }

    /// Encodes the picture prepared last into `target`, a view of `target_size` pixels.
    ///
    /// `viewport` is the rectangle of the picture in the target: left, top, width and height,
    /// pixels; it is clamped to the target. All the rest of the target is cleared to a dark grey;
    /// without a sky all of it is transparent at first, and colours are multiplied by opacity.
    /// Nothing is drawn before the first `prepare`.
    pub fn draw(
        &mut self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        target_size: [u32; 2],
        viewport: [f32; 4],
    ) {
        let ops = wgpu::Operations { load: CLEAR, store: wgpu::StoreOp::Discard };
        self.draw_over(encoder, target, target_size, (viewport, ops));
    }

    /// The same, where [`Renderer::draw_beside`] follows.
    pub fn draw_first(
        &mut self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        target_size: [u32; 2],
        viewport: [f32; 4],
    ) {
        let ops = wgpu::Operations { load: CLEAR, store: wgpu::StoreOp::Store };
        self.draw_over(encoder, target, target_size, (viewport, ops));
    }

    /// The same, beside the picture that [`Renderer::draw_first`] drew into a target of this size
    /// before.
    ///
    /// The commands of that picture must have been submitted before this one was prepared: both
    /// are drawn from the same buffers.
    pub fn draw_beside(
        &mut self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        target_size: [u32; 2],
        viewport: [f32; 4],
    ) {
        let ops = wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Discard };
        self.draw_over(encoder, target, target_size, (viewport, ops));
    }

    fn draw_over(
        &mut self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        target_size: [u32; 2],
        (viewport, ops): ([f32; 4], wgpu::Operations<wgpu::Color>),
    ) {
        let size = target_size.map(|side| side.max(1));
        if self.targets.as_ref().is_none_or(|targets| targets.size != size) {
            self.targets =
                Some(Targets::new(&self.device, self.format, (size, self.quality.samples())));
        }
        let area = clamped(viewport, size);
        if let (Some(prepared), Some(area)) = (&self.prepared, area) {
            let encode = !self.format.is_srgb();
            let globals = Globals::new(&prepared.view, &prepared.light, area, encode);
            let below = globals.seen_from_below(&prepared.light);
            for ((buffer, _), globals) in self.bindings.globals.iter().zip([globals, below]) {
                prepared.queue.write_buffer(buffer, 0, bytemuck::bytes_of(&globals));
            }
            if prepared.view.style.shadows {
                let Bindings { globals: [picture, below], .. } = &self.bindings;
                let Bindings { shadow_map, ground_map, shade_map, .. } = &self.bindings;
                let [sun, ground] = &self.pipelines.casters;
                self.draw_depths(encoder, (shadow_map, None), (&picture.1, sun));
                if prepared.light.level.is_some() {
                    self.draw_depths(encoder, (ground_map, Some(shade_map)), (&below.1, ground));
                }
            }
        }
        let Some(targets) = &self.targets else { return };
        let is_open = self.prepared.as_ref().is_some_and(|prepared| !prepared.view.style.sky);
        let ops = match ops.load {
            wgpu::LoadOp::Clear(_) if is_open => {
                wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), ..ops }
            }
            _ => ops,
        };
        let mut pass = scene_pass(encoder, targets, (target, ops));
        if let (Some(_), Some([left, top, width, height])) = (&self.prepared, area) {
            pass.set_viewport(left, top, width, height, 0.0, 1.0);
            pass.set_scissor_rect(left as u32, top as u32, width as u32, height as u32);
            self.draw_scene(&mut pass, height);
        }
    }

    fn draw_depths(
        &self,
        encoder: &mut CommandEncoder,
        (map, shades): (&TextureView, Option<&TextureView>),
        (globals, casters): (&BindGroup, &Casters),
    ) {
        let shades = shades.map(|view| {
            let ops = wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Store,
            };
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops,
            })
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("depths"),
            color_attachments: shades.as_slice(),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: map,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        let rows = &self.rows;
        let lines = (self.geometry.casting_lines as u32).min(rows.lines.count);
        let points = (self.geometry.casting_points as u32).min(rows.points.count);
        pass.set_bind_group(0, globals, &[]);
        draw_surfaces(&mut pass, &casters.surface, rows);
        draw_instances(&mut pass, &casters.line, &rows.lines, (6, 0..lines));
        draw_instances(&mut pass, &casters.point, &rows.points, (36, 0..points));
    }

    fn draw_scene(&self, pass: &mut RenderPass<'_>, height: f32) {
        let (pipelines, rows) = (&self.pipelines, &self.rows);
        pass.set_bind_group(0, &self.bindings.globals[0].1, &[]);
        pass.set_bind_group(1, &self.bindings.shadow_group, &[]);
        if self.prepared.as_ref().is_some_and(|prepared| prepared.view.style.sky) {
            pass.set_pipeline(&pipelines.sky);
            pass.draw(0..3, 0..1);
        }
        draw_surfaces(pass, &pipelines.surface_front, rows);
        draw_surfaces(pass, &pipelines.surface_back, rows);
        let front = (self.geometry.front_patches as u32).min(rows.patches.count);
        draw_instances(pass, &pipelines.ground_front, &rows.patches, (6, 0..front));
        let rods = (self.geometry.rods as u32).min(rows.lines.count);
        draw_instances(pass, &pipelines.rod, &rows.lines, (6, 0..rods));
        draw_instances(pass, &pipelines.line, &rows.lines, (6, rods..rows.lines.count));
        draw_instances(pass, &pipelines.point, &rows.points, (6, 0..rows.points.count));
        let back = front..rows.patches.count;
        draw_instances(pass, &pipelines.ground_back, &rows.patches, (6, back));
        let scale = self.prepared.as_ref().map_or(1.0, |prepared| prepared.view.style.scale());
        // In a small picture the legend would hide the scene.
        if 2.0 * legend::SIZE[1] * scale <= height {
            draw_instances(pass, &pipelines.overlay, &rows.rects, (6, 0..rows.rects.count));
        }
    }
}

impl Bindings {
    fn new(device: &Device, layouts: &[wgpu::BindGroupLayout; 2], quality: Quality) -> Self {
        let group = |layout, entries: &[wgpu::BindGroupEntry<'_>]| {
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries })
        };
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let globals = ["globals", "globals from below"].map(|label| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size_of::<Globals>() as u64,
                usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let resource = buffer.as_entire_binding();
            let group = group(&layouts[0], &[wgpu::BindGroupEntry { binding: 0, resource }]);
            (buffer, group)
        });
        let map = |label, format, side| texture(device, label, format, ([side, side], 1));
        let shadow_map = map("shadow map", DEPTH_FORMAT, quality.shadow_size());
        let ground_map = map("ground map", DEPTH_FORMAT, quality.ground_size());
        let shade_map = map("shade map", SHADE_FORMAT, quality.ground_size());
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("shadow"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            compare: Some(wgpu::CompareFunction::LessEqual),
            ..Default::default()
        });
        let smooth = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("shade"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let entries = [
            entry(0, wgpu::BindingResource::TextureView(&shadow_map)),
            entry(1, wgpu::BindingResource::Sampler(&sampler)),
            entry(2, wgpu::BindingResource::TextureView(&ground_map)),
            entry(3, wgpu::BindingResource::TextureView(&shade_map)),
            entry(4, wgpu::BindingResource::Sampler(&smooth)),
        ];
        let shadow_group = group(&layouts[1], &entries);
        Self { globals, shadow_map, ground_map, shade_map, shadow_group }
    }
}

fn globals_layout(device: &Device) -> wgpu::BindGroupLayout {
    let uniforms = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    layout(device, wgpu::ShaderStages::VERTEX_FRAGMENT, &[uniforms])
}

fn shadow_layout(device: &Device) -> wgpu::BindGroupLayout {
    let map = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let depths = map(wgpu::TextureSampleType::Depth);
    let shares = map(wgpu::TextureSampleType::Float { filterable: true });
    let [compare, smooth] =
        [wgpu::SamplerBindingType::Comparison, wgpu::SamplerBindingType::Filtering]
            .map(wgpu::BindingType::Sampler);
    let types = [depths, compare, depths, shares, smooth];
    layout(device, wgpu::ShaderStages::FRAGMENT, &types)
}

fn layout(
    device: &Device,
    visibility: wgpu::ShaderStages,
    types: &[wgpu::BindingType],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, &ty): (usize, &wgpu::BindingType)| wgpu::BindGroupLayoutEntry {
        binding: binding as u32,
        visibility,
        ty,
        count: None,
    };
    let entries: Vec<_> = types.iter().enumerate().map(entry).collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
    device.create_bind_group_layout(&descriptor)
}

/// Begins the pass of the scene, which is resolved into `target` at its end.
fn scene_pass<'a>(
    encoder: &'a mut CommandEncoder,
    targets: &Targets,
    (target, ops): (&TextureView, wgpu::Operations<wgpu::Color>),
) -> RenderPass<'a> {
    // A picture drawn on the target at once must stay there.
    let store = if targets.colour.is_none() { wgpu::StoreOp::Store } else { ops.store };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("scene"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: targets.colour.as_ref().unwrap_or(target),
            depth_slice: None,
            resolve_target: targets.colour.as_ref().map(|_| target),
            ops: wgpu::Operations { store, ..ops },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &targets.depth,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

fn draw_surfaces(pass: &mut RenderPass<'_>, pipeline: &RenderPipeline, rows: &AllRows) {
    let (Some(vertices), Some(triangles)) = (rows.vertices.filled(), rows.triangles.filled())
    else {
        return;
    };
    pass.set_pipeline(pipeline);
    pass.set_vertex_buffer(0, vertices.slice(..));
    pass.set_index_buffer(triangles.slice(..), wgpu::IndexFormat::Uint32);
    pass.draw_indexed(0..3 * rows.triangles.count, 0, 0..1);
}

/// Draws a range of instances of so many vertices each.
fn draw_instances(
    pass: &mut RenderPass<'_>,
    pipeline: &RenderPipeline,
    rows: &Rows,
    (vertices, instances): (u32, std::ops::Range<u32>),
) {
    let Some(buffer) = rows.filled() else { return };
    if instances.is_empty() {
        return;
    }
    pass.set_pipeline(pipeline);
    pass.set_vertex_buffer(0, buffer.slice(..));
    pass.draw(0..vertices, instances);
}

/// A viewport in whole pixels inside a target of this size, or nothing if none is left.
fn clamped(viewport: [f32; 4], size: [u32; 2]) -> Option<[f32; 4]> {
    let [left, top, width, height] = viewport;
    let side = |start: f32, length: f32, limit: u32| {
        let end = (start + length).round().clamp(0.0, limit as f32);
        let start = start.round().clamp(0.0, limit as f32);
        // Written so that NaN leaves nothing.
        (1.0 <= end - start).then_some((start, end - start))
    };
    let (left, width) = side(left, width, size[0])?;
    let (top, height) = side(top, height, size[1])?;
    Some([left, top, width, height])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_viewport_is_clamped_to_the_target() {
        let size = [800, 600];
        assert_eq!(clamped([0.0, 0.0, 800.0, 600.0], size), Some([0.0, 0.0, 800.0, 600.0]));
        assert_eq!(clamped([-5.0, 10.4, 900.0, 1e9], size), Some([0.0, 10.0, 800.0, 590.0]));
        assert_eq!(clamped([800.0, 0.0, 10.0, 10.0], size), None);
        assert_eq!(clamped([f32::NAN, 0.0, 10.0, 10.0], size), None);
        assert_eq!(clamped([0.0, 0.0, 0.0, 10.0], size), None);
    }
}
