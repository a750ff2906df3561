//! Uniforms: camera, light and switches, the same for everything in a picture.

use crate::viewing::view::View;
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};

/// Side of the shadow map, texels: soft enough with its filter, and cheap to clear in software.
pub(crate) const SHADOW_SIZE: u32 = 1024;

/// The uniforms of `common.wgsl`, in its order.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Globals {
    view_projection: Mat4,
    light_projection: Mat4,
    eye: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    forward: [f32; 4],
    light: [f32; 4],
    screen: [f32; 4],
    shadow: [f32; 4],
    look: [f32; 4],
}

/// The light of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    /// Direction to the light, length one.
    pub direction: Vec3,
    /// The matrix from the world to the shadow map.
    pub matrix: Mat4,
    /// Size of a texel of the shadow map, metres.
    pub texel: f32,
    /// Radius of a particle, metres.
    pub particle_radius: f32,
}

impl Globals {
    /// Gathers the uniforms for a picture of `size` pixels; `encode` if the shader encodes sRGB.
    pub fn new(view: &View, light: &Light, size: [f32; 2], encode: bool) -> Self {
        let camera = &view.camera;
        let style = &view.style;
        let aspect = size[0] / size[1];
        let tangents = camera.tangents(aspect);
        let switch = |on: bool| if on { 1.0 } else { 0.0 };
        Self {
            view_projection: camera.view_projection(aspect),
            light_projection: light.matrix,
            eye: camera.eye().extend(1.0).to_array(),
            right: (camera.right() * tangents[0]).extend(0.0).to_array(),
            up: (camera.up() * tangents[1]).extend(0.0).to_array(),
            forward: camera.forward().extend(0.0).to_array(),
            light: light.direction.extend(switch(style.shadows)).to_array(),
            screen: [size[0], size[1], switch(encode), camera.near()],
            shadow: [light.texel, 1.0 / SHADOW_SIZE as f32, light.particle_radius, 0.0],
            look: [switch(style.pattern), switch(style.grid), style.scale(), 0.0],
        }
    }
}
