//! Uniforms: camera, light and switches, the same for everything in a picture.

use crate::picture::ground::DepthMap;
use crate::viewing::view::View;
use bytemuck::{Pod, Zeroable};
use glam::Mat4;

/// The uniforms of `common.wgsl`, in its order.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Globals {
    view_projection: Mat4,
    light_projection: Mat4,
    ground_projection: Mat4,
    eye: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    forward: [f32; 4],
    light: [f32; 4],
    screen: [f32; 4],
    shadow: [f32; 4],
    ground: [f32; 4],
    look: [f32; 4],
    level: [f32; 4],
}

/// The light of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    /// The depth map as seen from the light.
    pub sun: DepthMap,
    /// The depth map as seen from below the ground.
    pub ground: DepthMap,
    /// Height of the ground, metres, if there is one.
    pub level: Option<f32>,
    /// Radius of the scene, metres.
    pub radius: f32,
}

impl Globals {
    /// Gathers the uniforms for a picture: left, top, width and height, pixels; `encode` if the
    /// shader encodes sRGB.
    pub fn new(
        view: &View,
        light: &Light,
        [left, top, width, height]: [f32; 4],
        encode: bool,
    ) -> Self {
        let camera = &view.camera;
        let style = &view.style;
        let aspect = width / height;
        let tangents = camera.tangents(aspect);
        let switch = |on: bool| if on { 1.0 } else { 0.0 };
        let sizes = |map: &DepthMap| [map.texel, 1.0 / map.side as f32, map.depth, 0.0];
        Self {
            view_projection: camera.view_projection(aspect),
            light_projection: light.sun.matrix,
            ground_projection: light.ground.matrix,
            eye: camera.eye().extend(1.0).to_array(),
            right: (camera.right() * tangents[0]).extend(tangents[0]).to_array(),
            up: (camera.up() * tangents[1]).extend(tangents[1]).to_array(),
            forward: camera.forward().extend(0.0).to_array(),
            light: light.sun.direction.extend(switch(style.shadows)).to_array(),
            screen: [width, height, switch(encode), camera.near()],
            shadow: sizes(&light.sun),
            ground: sizes(&light.ground),
            look: [switch(style.pattern), switch(style.grid), style.scale(), light.radius],
            level: [light.level.unwrap_or(0.0), left, top, switch(light.level.is_some())],
        }
    }

    /// The same, with the map of the ground in place of that of the light: to draw it.
    pub fn seen_from_below(self, light: &Light) -> Self {
        let DepthMap { direction, matrix, side, texel, depth } = light.ground;
        Self {
            light_projection: matrix,
            light: direction.extend(1.0).to_array(),
            shadow: [texel, 1.0 / side as f32, depth, 0.0],
            ..self
        }
    }
}
