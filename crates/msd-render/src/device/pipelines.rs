//! Render pipelines, one for each kind of thing.

use crate::device::quality::Quality;
use crate::device::shaders;
use crate::device::targets::{DEPTH_FORMAT, SHADE_FORMAT};
use wgpu::{BindGroupLayout, Device, RenderPipeline, TextureFormat, VertexAttribute};

const SURFACE: [VertexAttribute; 6] = wgpu::vertex_attr_array![
    0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Unorm8x4, 4 => Unorm8x4, 5 => Unorm8x4
];
const LINE: [VertexAttribute; 6] = wgpu::vertex_attr_array![
    0 => Float32x3, 1 => Float32, 2 => Float32x3, 3 => Float32, 4 => Unorm8x4, 5 => Float32
];
const POINT: [VertexAttribute; 4] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Unorm8x4, 3 => Float32];
const PATCH: [VertexAttribute; 5] = wgpu::vertex_attr_array![
    0 => Float32x3, 1 => Float32x2, 2 => Float32x3, 3 => Float32x3, 4 => Float32
];
const RECT: [VertexAttribute; 3] =
    wgpu::vertex_attr_array![0 => Float32x4, 1 => Unorm8x4, 2 => Unorm8x4];

/// The rows a pipeline reads: their attributes, and whether a row is a vertex or an instance.
#[derive(Clone, Copy)]
struct Input {
    attributes: &'static [VertexAttribute],
    per_instance: bool,
}

/// The way in which fragments meet those that are there already.
#[derive(Clone, Copy)]
struct Output {
    test_depth: bool,
    write_depth: bool,
    /// Whether opacity chooses samples instead of blending.
    coverage: bool,
    /// The side of triangles left out.
    cull: Option<wgpu::Face>,
}

const OPAQUE: Output = Output { test_depth: true, write_depth: true, coverage: false, cull: None };
const GLASS: Output = Output { write_depth: false, ..OPAQUE };
const PAINTED: Output = Output { test_depth: false, ..GLASS };

/// Every pipeline of a picture.
#[derive(Debug)]
pub(crate) struct Pipelines {
    pub sky: RenderPipeline,
    /// The side of surfaces that faces the viewer.
    pub surface_front: RenderPipeline,
    /// The other side; drawn later, so that fragments behind the first are never shaded.
    pub surface_back: RenderPipeline,
    pub ground_front: RenderPipeline,
    pub ground_back: RenderPipeline,
    pub line: RenderPipeline,
    /// Round lines.
    pub rod: RenderPipeline,
    pub point: RenderPipeline,
    pub overlay: RenderPipeline,
    /// Into the map of the sun, and into that of shade on the ground.
    pub casters: [Casters; 2],
}

/// Pipelines of all that casts shadows.
#[derive(Debug)]
pub(crate) struct Casters {
    pub surface: RenderPipeline,
    pub line: RenderPipeline,
    pub point: RenderPipeline,
}

/// Data that all pipelines share.
struct Maker<'a> {
    device: &'a Device,
    format: TextureFormat,
    quality: Quality,
    /// The uniforms, and the shadow map.
    groups: [&'a BindGroupLayout; 2],
}

impl Pipelines {
    /// Compiles all pipelines for a target of this format.
    pub fn new(
        device: &Device,
        (format, quality): (TextureFormat, Quality),
        groups: [&BindGroupLayout; 2],
    ) -> Self {
        let maker = Maker { device, format, quality, groups };
        // Without several samples opacity blends, and depth is written all the same.
        let round = Output { coverage: 1 < quality.samples(), ..OPAQUE };
        let vertices = |attributes| Some(Input { attributes, per_instance: false });
        let instances = |attributes| Some(Input { attributes, per_instance: true });
        let ground =
            |entry, output| maker.pipeline(shaders::GROUND, entry, instances(&PATCH), output);
        let surface =
            |output| maker.pipeline(shaders::SURFACE, "fs_main", vertices(&SURFACE), output);
        Self {
            sky: maker.pipeline(shaders::SKY, "fs_main", None, PAINTED),
            surface_front: surface(Output { cull: Some(wgpu::Face::Back), ..OPAQUE }),
            surface_back: surface(Output { cull: Some(wgpu::Face::Front), ..OPAQUE }),
            ground_front: ground("fs_front", OPAQUE),
            ground_back: ground("fs_back", GLASS),
            line: maker.pipeline(shaders::LINE, "fs_main", instances(&LINE), OPAQUE),
            rod: maker.pipeline(shaders::LINE, "fs_rod", instances(&LINE), OPAQUE),
            point: maker.pipeline(shaders::POINT, "fs_main", instances(&POINT), round),
            overlay: maker.pipeline(shaders::OVERLAY, "fs_main", instances(&RECT), PAINTED),
            casters: [false, true].map(|shades| Casters {
                surface: maker.shadow("vs_surface", (&SURFACE, false), shades),
                line: maker.shadow("vs_line", (&LINE, true), shades),
                point: maker.shadow("vs_point", (&POINT, true), shades),
            }),
        }
    }
}

impl Maker<'_> {
    fn pipeline(
        &self,
        source: &str,
        fragment: &str,
        input: Option<Input>,
        output: Output,
    ) -> RenderPipeline {
        let module = self.module(source);
        let blend = (!output.coverage).then_some(wgpu::BlendState::ALPHA_BLENDING);
        let targets = [Some(wgpu::ColorTargetState {
            format: self.format,
            blend,
            write_mask: wgpu::ColorWrites::ALL,
        })];
        let compare = if output.test_depth {
            // Depth is 1 near and 0 far.
            wgpu::CompareFunction::GreaterEqual
        } else {
            wgpu::CompareFunction::Always
        };
        let buffers = input.map(|input| input.layout());
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&self.layout(&self.groups)),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vs_main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: buffer_list(&buffers),
            },
            primitive: wgpu::PrimitiveState { cull_mode: output.cull, ..Default::default() },
            depth_stencil: Some(depth_state(output.write_depth, compare)),
            multisample: wgpu::MultisampleState {
                count: self.quality.samples(),
                mask: !0,
                alpha_to_coverage_enabled: output.coverage,
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    fn shadow(
        &self,
        vertex: &str,
        (attributes, per_instance): (&'static [VertexAttribute], bool),
        shades: bool,
    ) -> RenderPipeline {
        let targets = [Some(SHADE_FORMAT.into())];
        let module = self.module(shaders::SHADOW);
        let buffers = Some(Input { attributes, per_instance }.layout());
        let mut depth = depth_state(true, wgpu::CompareFunction::LessEqual);
        // Steep triangles span more depth within a texel, and shadow themselves without this.
        depth.bias = wgpu::DepthBiasState { constant: 0, slope_scale: 2.0, clamp: 0.0 };
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(vertex),
            layout: Some(&self.layout(&self.groups[..1])),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: buffer_list(&buffers),
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(depth),
            multisample: wgpu::MultisampleState::default(),
            fragment: shades.then_some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fs_shade"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    fn module(&self, source: &str) -> wgpu::ShaderModule {
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(shaders::source(source, self.quality).into()),
        })
    }

    fn layout(&self, groups: &[&BindGroupLayout]) -> wgpu::PipelineLayout {
        let groups: Vec<_> = groups.iter().map(|&group| Some(group)).collect();
        self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &groups,
            immediate_size: 0,
        })
    }
}

impl Input {
    fn layout(self) -> Option<wgpu::VertexBufferLayout<'static>> {
        let ends = self.attributes.iter().map(|part| part.offset + part.format.size());
        Some(wgpu::VertexBufferLayout {
            array_stride: ends.max().unwrap_or(0),
            step_mode: if self.per_instance {
                wgpu::VertexStepMode::Instance
            } else {
                wgpu::VertexStepMode::Vertex
            },
            attributes: self.attributes,
        })
    }
}

/// A list of one buffer, or of none.
fn buffer_list<T>(buffers: &Option<T>) -> &[T] {
    buffers.as_slice()
}

fn depth_state(write: bool, compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}
