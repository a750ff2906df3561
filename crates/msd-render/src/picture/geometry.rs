//! Columns of vertices and instances that are uploaded for one picture.

use crate::math::is_drawable;
use crate::picture::colour::scale_colour;
use crate::picture::sizes::Sizes;
use crate::viewing::quantity::Scale;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::ops::Range;

/// A vertex of a surface; the layout of `surface.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct SurfaceVertex {
    /// Position, metres.
    pub position: Vec3,
    /// Normal, length one.
    pub normal: Vec3,
    /// Place on the pattern; one is once the pattern.
    pub uv: [f32; 2],
    /// Colour of the body, sRGB, and how hollow it is there: 0 an edge, 128 flat, 255 a valley.
    pub colour: [u8; 4],
    /// Colour of its other side, sRGB, and the number of the pattern.
    pub back: [u8; 4],
    /// Roughness, metal, translucency, and whether the other side has a colour of its own.
    pub finish: [u8; 4],
}

/// A line; the layout of `line.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Line {
    /// One end, metres.
    pub a: Vec3,
    /// Width, pixels.
    pub width: f32,
    /// The other end, metres.
    pub b: Vec3,
    /// Distance by which it is pulled to the eye before depth is compared, as a fraction of its
    /// distance.
    pub bias: f32,
    /// Colour and opacity, sRGB.
    pub colour: [u8; 4],
    /// Radius of a round rod, metres; 0 of a line.
    pub radius: f32,
}

/// A round point; the layout of `point.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Point {
    /// Centre, metres.
    pub centre: Vec3,
    /// Radius, metres.
    pub radius: f32,
    /// Colour, sRGB.
    pub colour: [u8; 4],
    /// 0 a ball, 1 a ball with a rim, 2 a ball in a ring on top of everything.
    pub shape: f32,
}

/// A finite piece of a plane; the layout of `ground.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Patch {
    /// Centre, metres.
    pub centre: Vec3,
    /// Half of its sizes along `u` and across it, metres.
    pub half: [f32; 2],
    /// One direction in the plane, length one.
    pub u: Vec3,
    /// The direction out of the solid, length one.
    pub normal: Vec3,
    /// Opacity, 0 to 1.
    pub opacity: f32,
}

/// Everything one picture uploads; kept between pictures so that its memory is reused.
#[derive(Debug, Default)]
pub(crate) struct Geometry {
    /// Vertices of surfaces.
    pub vertices: Vec<SurfaceVertex>,
    /// Index of the first of those of solids, which come last.
    pub first_solid: usize,
    /// Three indices into `vertices` per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Lines; the first `casting_lines` cast shadows, and the first `rods` of these are round.
    pub lines: Vec<Line>,
    /// Number of lines that are round rods.
    pub rods: usize,
    /// Number of lines that cast shadows.
    pub casting_lines: usize,
    /// Points; the first `casting_points` cast shadows.
    pub points: Vec<Point>,
    /// Number of points that cast shadows.
    pub casting_points: usize,
    /// Patches of planes; the first `front_patches` are seen from their front.
    pub patches: Vec<Patch>,
    /// Number of patches that are seen from their front.
    pub front_patches: usize,
    /// Sizes of the patterns, kept from picture to picture.
    pub sizes: Sizes,
    /// The error of each particle, metres, as the caller set it.
    pub errors: Vec<f32>,
    /// The scale of the colours.
    pub scale: Option<Scale>,
    /// The value in whose colour each particle is drawn; empty for own colours.
    pub shades: Vec<f32>,
    /// Drawn positions, metres.
    pub positions: Vec<Vec3>,
    /// Lowest and highest corner around all that can be drawn, metres.
    pub bounds: (Vec3, Vec3),
    /// Radius of a particle, metres.
    pub particle_radius: f32,
    /// Greatest depth, metres, by which balls are sunk into the obstacles that they lie on.
    pub ball_radius: f32,
    /// Height of the drawn ground, metres, if there is any.
    pub level: Option<f32>,
}

impl Geometry {
    /// Empties all columns and keeps their memory.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.triangles.clear();
        self.lines.clear();
        self.points.clear();
        self.patches.clear();
        self.positions.clear();
        self.shades.clear();
    }

    /// The colour of a particle by its shade; none where shades are missing.
    pub fn shade(&self, particle: u32) -> Option<[f32; 3]> {
        let shade = self.shades.get(particle as usize).copied();
        self.scale.zip(shade).map(|(scale, shade)| scale_colour(scale, shade))
    }

    /// The position of a particle, or nothing if it cannot be drawn or does not exist.
    pub fn drawable(&self, particle: u32) -> Option<Vec3> {
        let position = self.positions.get(particle as usize).copied();
        position.filter(|&position| is_drawable(position))
    }
}

/// The owner of each of `count` rows: the index of the last body whose range holds it.
pub(crate) fn owners<'a>(
    ranges: impl Iterator<Item = &'a Range<usize>>,
    count: usize,
) -> Vec<Option<u32>> {
    let mut owners = vec![None; count];
    for (body, range) in ranges.enumerate() {
        let end = range.end.min(count);
        owners[range.start.min(end)..end].fill(Some(body as u32));
    }
    owners
}
