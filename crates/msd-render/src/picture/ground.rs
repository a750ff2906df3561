//! The planes and half spaces that a picture shows, and the depth maps of the light.

use crate::math::{direction_or, is_drawable, tangents};
use crate::picture::geometry::{Geometry, Patch};
use crate::viewing::pick::flats;
use crate::viewing::view::View;
use glam::camera::rh::{proj::directx, view::look_to_mat4};
use glam::{Mat4, Vec3};
use msd_core::{Real, Snapshot};

/// A floor, and a wall along it, reach this many scene sizes: their rim is lost in the haze.
const FLOOR_REACH: f32 = 40.0;
/// A slope reaches this many scene sizes: it must not hide the sky.
const SLOPE_REACH: f32 = 3.0;
/// A wall so many scene sizes away is seen, and one so many away is not.
const WALL_SEEN: [f32; 2] = [3.0, 5.0];
/// A plane whose normal has this part upwards is level; a wall has as little.
const LEVEL: f32 = 0.95;
const UPRIGHT: f32 = 0.1;

/// Opacity of a hint of ground.
const HINTED: f32 = 0.5;

/// The radius of a ball around the scene, metres; never zero.
pub(crate) fn scene_radius(bounds: (Vec3, Vec3)) -> f32 {
    (0.5 * (bounds.1 - bounds.0).length()).max(0.1)
}

/// Adds a patch of every plane and half space near the scene; those seen from their front come
/// first.
pub(crate) fn add_planes<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    view: &View,
) {
    let eye = view.camera.eye();
    let middle = (geometry.bounds.0 + geometry.bounds.1) * 0.5;
    for front in [true, false] {
        for (normal, offset) in flats(snapshot) {
            let normal = direction_or(normal, Vec3::Y);
            // Particles meet it as points: their balls would be sunk in it.
            let offset = offset - geometry.ball_radius;
            let centre = middle - normal * (normal.dot(middle) - offset);
            let is_front = offset <= normal.dot(eye);
            if !is_drawable(centre) || is_front != front {
                continue;
            }
            geometry.patches.extend(patch(geometry, view, (normal, centre)));
        }
        if front {
            geometry.front_patches = geometry.patches.len();
        }
    }
}

/// The drawn height of the highest level plane or half space, metres.
pub(crate) fn level<R: Real>(geometry: &Geometry, snapshot: &Snapshot<'_, R>) -> Option<f32> {
    let level = flats(snapshot).filter(|(normal, _)| LEVEL < normal.y);
    let heights = level.map(|(_, offset)| offset - geometry.ball_radius);
    heights.filter(|height| is_drawable(Vec3::Y * *height)).reduce(f32::max)
}

/// The height of a hint of ground below bodies that hang on pins above no plane, metres.
///
/// It is a place for a shadow: the body would hang before an empty sky. Nothing meets it.
///
/// A step of its size below, so that it stays in place while the body moves a little.
pub(crate) fn hint<R: Real>(
    geometry: &Geometry,
    snapshot: &Snapshot<'_, R>,
    view: &View,
) -> Option<f32> {
    let is_void = flats(snapshot).next().is_none();
    let hangs = snapshot.inverse_masses.contains(&R::ZERO);
    if !view.style.sky || !is_void || !hangs {
        return None;
    }
    let step = 0.5 * (2.0 * scene_radius(geometry.bounds)).log2().ceil().exp2();
    let height = ((geometry.bounds.0.y / step - 0.25).floor()) * step;
    is_drawable(Vec3::Y * height).then_some(height)
}

/// Adds that hint.
pub(crate) fn add_hint(geometry: &mut Geometry, view: &View, height: f32) {
    let middle = (geometry.bounds.0 + geometry.bounds.1) * 0.5;
    let centre = Vec3::new(middle.x, height, middle.z);
    if height <= view.camera.eye().y {
        let hint = patch(geometry, view, (Vec3::Y, centre));
        geometry.patches.extend(hint.map(|hint| Patch { opacity: HINTED, ..hint }));
        geometry.front_patches = geometry.patches.len();
    }
}

/// The part of a plane that is drawn, from the point of it that is nearest to the scene.
fn patch(geometry: &Geometry, view: &View, (normal, centre): (Vec3, Vec3)) -> Option<Patch> {
    let radius = scene_radius(geometry.bounds);
    let (u, v) = tangents(normal);
    let far = (FLOOR_REACH * radius).max(15.0 * view.camera.usable().distance);
    let whole = Patch { centre, half: [far; 2], u, normal, opacity: 1.0 };
    if LEVEL < normal.y {
        return Some(whole);
    }
    let middle = (geometry.bounds.0 + geometry.bounds.1) * 0.5;
    let [near, gone] = WALL_SEEN;
    let away = centre.distance(middle) / radius;
    let opacity = ((gone - away) / (gone - near)).clamp(0.0, 1.0);
    if UPRIGHT < normal.y.abs() {
        return Some(Patch { half: [SLOPE_REACH * radius; 2], ..whole });
    }
    // Its top stays in place while the bodies before it move a little.
    let step = (2.0 * radius).log2().ceil().exp2();
    let bottom = geometry.level.unwrap_or(((middle.y / step).floor() - 1.0) * step);
    let top = bottom + ((geometry.bounds.1.y - bottom) / step * 1.1).ceil().max(1.0) * step;
    let raised = centre + v * ((0.5 * (bottom + top) - centre.y) * v.y.signum());
    let half = [far, 0.5 * (top - bottom)];
    (0.0 < opacity).then_some(Patch { centre: raised, half, opacity, ..whole })
}

/// The direction to the light, length one.
pub(crate) fn light_direction(view: &View) -> Vec3 {
    direction_or(view.style.light, Vec3::Y)
}

/// A picture of depths, seen from far away.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthMap {
    /// The direction to where it is seen from, length one.
    pub direction: Vec3,
    /// The matrix from the world to the map.
    pub matrix: Mat4,
    /// Side, texels.
    pub side: u32,
    /// Size of a texel, metres.
    pub texel: f32,
    /// Depth of its values from 0 to 1, metres.
    pub depth: f32,
}

/// The picture of depths that the light sees, `map_size` texels wide; or another one from far away.
///
/// It covers the bodies, and the parts of solids near them. Its size grows in steps and its corner
/// moves by whole texels. The shadow of a still part therefore does not shimmer when another part
/// moves.
pub(crate) fn depth_map(geometry: &Geometry, light: Vec3, map_size: u32) -> DepthMap {
    let helper = if light.y.abs() < 0.99 { Vec3::Y } else { Vec3::X };
    let to_light = look_to_mat4(Vec3::ZERO, -light, helper);
    let bodies = box_around(geometry.positions.iter().copied(), to_light);
    let (low, high) = bodies.unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
    // As much of the solids as the bodies are large: the rest would take their texels.
    let reach = Vec3::splat((high - low).max_element());
    let solids = geometry.vertices[geometry.first_solid..].iter().map(|vertex| vertex.position);
    let (least, most) = (low - reach, high + reach);
    let solids = box_around(solids, to_light)
        .filter(|(from, to)| from.cmple(most).all() && least.cmple(*to).all());
    let (low, high) =
        solids.map_or((low, high), |(from, to)| (low.min(from.max(least)), high.max(to.min(most))));
    let margin = 3.0 * geometry.particle_radius.max(geometry.ball_radius);
    let side = (high - low).truncate().max_element() + 2.0 * margin;
    // A sixteenth of an octave at a time, plus 8 texels for the soft rim.
    let side = ((side.log2() * 16.0).ceil() / 16.0).exp2() * (1.0 + 8.0 / map_size as f32);
    let texel = side / map_size as f32;
    let middle = (low + high) * 0.5;
    let corner = ((middle - 0.5 * side) / texel).floor() * texel;
    // Looking along −z: near and far are distances in front, so their signs turn.
    let (near, far) = (-high.z - margin - 0.01 * side, -low.z + margin + 0.01 * side);
    let projection =
        directx::orthographic(corner.x, corner.x + side, corner.y, corner.y + side, near, far);
    let matrix = projection * to_light;
    DepthMap { direction: light, matrix, side: map_size, texel, depth: far - near }
}

/// The box around points that can be drawn, seen through a matrix; none around nothing.
fn box_around(points: impl Iterator<Item = Vec3>, matrix: Mat4) -> Option<(Vec3, Vec3)> {
    let seen = points.filter(|&point| is_drawable(point));
    let placed = seen.map(|point| matrix.transform_point3(point));
    let boxes = placed.filter(|&point| is_drawable(point)).map(|point| (point, point));
    boxes.reduce(|(low, high), (point, _)| (low.min(point), high.max(point)))
}
