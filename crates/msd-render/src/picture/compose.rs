//! The columns of one picture, filled from a snapshot kind by kind.

use crate::picture::geometry::Geometry;
use crate::picture::{ground, marks, solids, surfaces};
use crate::viewing::pick::bounds;
use crate::viewing::quantity::{Quantity, Scale};
use crate::viewing::view::{Style, View};
use glam::Vec3;
use msd_core::{Real, Snapshot};

/// Overwrites all columns with the contents of the snapshot.
///
/// No column gets longer than fits into `limit` bytes.
pub(crate) fn set_geometry<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    view: &View,
    limit: u64,
) {
    geometry.clear();
    snapshot.copy_positions(&mut geometry.positions);
    geometry.bounds = bounds(snapshot).unwrap_or((Vec3::ZERO, Vec3::ZERO));
    geometry.particle_radius = particle_radius(snapshot, view, geometry.bounds);
    set_shades(geometry, snapshot, &view.style);
    if view.style.surfaces {
        surfaces::add_surfaces(geometry, snapshot, limit);
    }
    let balls = marks::balls(geometry, snapshot);
    let on_rail = marks::add_rails(geometry, snapshot, view);
    marks::add_springs(geometry, snapshot, (view, &balls));
    marks::add_particles(geometry, snapshot, (view, &balls, &on_rail));
    if view.style.wireframe {
        surfaces::add_wireframe(geometry, snapshot, view);
    }
    if view.style.grabs {
        marks::add_grabs(geometry, snapshot, view);
    }
    let hint = view.style.planes.then(|| ground::hint(geometry, snapshot, view)).flatten();
    geometry.level =
        view.style.planes.then(|| ground::level(geometry, snapshot)).flatten().or(hint);
    geometry.first_solid = geometry.vertices.len();
    if view.style.planes {
        ground::add_planes(geometry, snapshot, view);
        hint.into_iter().for_each(|height| ground::add_hint(geometry, view, height));
        solids::add_solids(geometry, snapshot, (view, limit));
    }
}

/// Finds the scale of the colours, and the values of particles if it is of these. Without errors
/// they have no scale.
fn set_shades<R: Real>(geometry: &mut Geometry, snapshot: &Snapshot<'_, R>, style: &Style) {
    let Geometry { errors, shades, scale, .. } = geometry;
    let quantity = style.colour_by.filter(|&quantity| {
        quantity != Quantity::Error || errors.len() == snapshot.particle_count()
    });
    *scale = quantity.map(|quantity| {
        let largest = || match quantity {
            Quantity::Error => errors.iter().copied().fold(0.0, f32::max).into(),
            _ => quantity.largest(snapshot),
        };
        let full = style.full_scale.unwrap_or_else(|| quantity.full_scale(largest()));
        Scale { quantity, full }
    });
    match quantity {
        Some(Quantity::Error) => shades.extend_from_slice(errors),
        Some(Quantity::Speed) => {
            let particles = 0..snapshot.particle_count();
            shades.extend(particles.map(|particle| snapshot.speed(particle) as f32));
        }
        _ => {}
    }
}

/// The radius to draw particles with, metres.
fn particle_radius<R: Real>(snapshot: &Snapshot<'_, R>, view: &View, bounds: (Vec3, Vec3)) -> f32 {
    let asked = view.style.particle_radius;
    if asked.is_finite() && 0.0 < asked {
        return asked;
    }
    // A sample is enough: the radius only has to suit the spacing.
    let stride = (snapshot.rest_lengths.len() / 1000).max(1);
    let sample = snapshot.rest_lengths.iter().enumerate().step_by(stride);
    let there = sample.filter(|&(spring, _)| !snapshot.is_cut(spring));
    let mut lengths: Vec<f32> = there.map(|(_, length)| length.to_f64() as f32).collect();
    lengths.retain(|length| length.is_finite() && 0.0 < *length);
    lengths.sort_by(f32::total_cmp);
    match lengths.get(lengths.len() / 2) {
        Some(median) => 0.11 * median,
        None => (0.01 * (bounds.1 - bounds.0).length()).max(0.05),
    }
}
