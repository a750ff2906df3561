//! The planes that a picture shows, and what the light sees.

use crate::math::{direction_or, is_drawable, tangents};
use crate::picture::geometry::{Geometry, Patch};
use crate::viewing::view::View;
use glam::camera::rh::{proj::directx, view::look_to_mat4};
use glam::{Mat4, Vec3};
use msd_core::{Real, Snapshot, Vector};

/// A floor reaches this many scene sizes, so that its rim is lost in the haze.
const FLOOR_REACH: f32 = 30.0;
/// A wall or slope reaches this many scene sizes: it must not hide the sky.
const WALL_REACH: f32 = 3.0;

/// The radius of a ball around the scene, metres; never zero.
pub(crate) fn scene_radius(bounds: (Vec3, Vec3)) -> f32 {
    (0.5 * (bounds.1 - bounds.0).length()).max(0.1)
}

/// Adds a patch of every plane near the scene; those seen from their front come first.
pub(crate) fn add_planes<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    view: &View,
) {
    let eye = view.camera.eye();
    let middle = (geometry.bounds.0 + geometry.bounds.1) * 0.5;
    for front in [true, false] {
        for plane in snapshot.planes {
            let normal = direction_or(plane.normal.to_f32(), Vec3::Y);
            let offset = plane.offset.to_f64() as f32;
            let centre = middle - normal * (normal.dot(middle) - offset);
            let is_front = offset <= normal.dot(eye);
            if !is_drawable(centre) || is_front != front {
                continue;
            }
            let half = reach(geometry, view, normal);
            let (u, _) = tangents(normal);
            geometry.patches.push(Patch { centre, half, u, normal });
        }
        if front {
            geometry.front_patches = geometry.patches.len();
        }
    }
}

fn reach(geometry: &Geometry, view: &View, normal: Vec3) -> f32 {
    let radius = scene_radius(geometry.bounds);
    if 0.95 < normal.y {
        (FLOOR_REACH * radius).max(12.0 * view.camera.usable().distance)
    } else {
        WALL_REACH * radius
    }
}

/// The direction to the light, length one.
pub(crate) fn light_direction(view: &View) -> Vec3 {
    direction_or(view.style.light, Vec3::Y)
}

/// The matrix from the world to the shadow map, and the size of a texel, metres.
///
/// The map covers just what casts shadows, `map_size` texels wide. Its size grows in steps and its
/// corner moves by whole texels, so that the shadow of a still part does not shimmer when another
/// part moves.
pub(crate) fn light_matrix(geometry: &Geometry, light: Vec3, map_size: u32) -> (Mat4, f32) {
    let helper = if light.y.abs() < 0.99 { Vec3::Y } else { Vec3::X };
    let to_light = look_to_mat4(Vec3::ZERO, -light, helper);
    let seen = geometry.positions.iter().filter(|&&position| is_drawable(position));
    let mut low = Vec3::INFINITY;
    let mut high = Vec3::NEG_INFINITY;
    for &position in seen {
        let point = to_light.transform_point3(position);
        low = low.min(point);
        high = high.max(point);
    }
    if !is_drawable(low) || !is_drawable(high) {
        (low, high) = (Vec3::NEG_ONE, Vec3::ONE);
    }
    let margin = 3.0 * geometry.particle_radius;
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
    (projection * to_light, texel)
}
