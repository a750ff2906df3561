//! Lines and points of a picture: springs, particles, pins and grabs.

use crate::math::is_drawable;
use crate::picture::colour::{body_colour, bytes, mix, strain_colour};
use crate::picture::geometry::{Geometry, Line, Point, owners};
use crate::viewing::view::View;
use msd_core::{Body, Real, Snapshot, Touch, Vector};

/// Colour of what belongs to no body.
const NEUTRAL: [f32; 3] = [0.45, 0.47, 0.52];
/// Colour of free particles.
const PARTICLE: [f32; 3] = [0.93, 0.94, 0.96];
/// Colour of pins.
const PIN: [f32; 3] = [0.98, 0.70, 0.10];
/// Colour of grabs.
const GRAB: [f32; 3] = [0.86, 0.16, 0.55];
/// A spring in a surface wins against it, and loses against an edge.
const SPRING_BIAS: f32 = 0.0015;
/// Pulled in front of everything.
const ON_TOP: f32 = 1e9;

/// Whether a body hides its springs and particles behind a surface.
fn is_covered(owner: Option<u32>, bodies: &[Body], view: &View) -> bool {
    let body = owner.and_then(|body| bodies.get(body as usize));
    view.style.surfaces && body.is_some_and(|body| !body.surface.triangles.is_empty())
}

fn own_colour(owner: Option<u32>, bodies: &[Body]) -> [f32; 3] {
    let body = owner.and_then(|index| Some((index as usize, bodies.get(index as usize)?)));
    body.map_or(NEUTRAL, |(index, body)| body_colour(index, body))
}

/// The radius in which each particle is drawn, metres: that in which it touches others, if it does.
fn radii<R: Real>(geometry: &Geometry, snapshot: &Snapshot<'_, R>) -> Vec<f32> {
    let mut radii = vec![geometry.particle_radius; geometry.positions.len()];
    for touch in snapshot.touches {
        for &particle in &touch.particles {
            if let Some(radius) = radii.get_mut(particle) {
                *radius = touch.radius as f32;
            }
        }
    }
    radii
}

/// The radius by which a ball is sunk into what it lies on, metres: all of it, unless obstacles
/// meet the ball instead of its middle.
fn sunk<R: Real>(snapshot: &Snapshot<'_, R>, particle: usize, radius: f32) -> f32 {
    let meets = |touch: &Touch| touch.obstacles && touch.particles.binary_search(&particle).is_ok();
    if snapshot.touches.iter().any(meets) { 0.0 } else { radius }
}

/// A rod between balls of this part of their radius, where nothing touches.
const ROD: f32 = 0.45;

/// Adds springs: all of them by strain if the style says so, else those of bodies without surface.
///
/// Those that no surface covers come first: they cast shadows.
pub(crate) fn add_springs<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    view: &View,
) {
    let style = &view.style;
    (geometry.casting_lines, geometry.rods) = (0, 0);
    if !style.springs && !style.surfaces {
        return;
    }
    let owners = owners(snapshot.bodies.iter().map(|body| &body.springs), snapshot.ends.len());
    let radii = radii(geometry, snapshot);
    let rod = |end: u32| match radii.get(end as usize).copied().unwrap_or_default() {
        radius if radius == geometry.particle_radius => ROD * radius,
        radius => radius,
    };
    let rods: Vec<f32> = match style.springs {
        true => Vec::new(),
        false => snapshot.ends.iter().map(|&[a, b]| rod(a).min(rod(b))).collect(),
    };
    for covered in [false, true] {
        if covered && !style.springs {
            break;
        }
        for (spring, &[a, b]) in snapshot.ends.iter().enumerate() {
            let owner = owners[spring];
            if snapshot.is_cut(spring) || is_covered(owner, snapshot.bodies, view) != covered {
                continue;
            }
            let shades = [a, b].map(|end| geometry.shade(end));
            let (Some(a), Some(b)) = (geometry.drawable(a), geometry.drawable(b)) else { continue };
            let rest = snapshot.rest_lengths.get(spring).map_or(0.0, |rest| rest.to_f64() as f32);
            let (colour, width) = if style.springs {
                let strain = ((a - b).length() - rest) / rest;
                (strain_colour(strain, style.strain_full_scale), style.line_pixels())
            } else {
                let own = match shades {
                    [Some(a), Some(b)] => mix(a, b, 0.5),
                    _ => own_colour(owner, snapshot.bodies),
                };
                (own, style.line_pixels() * 1.5)
            };
            let radius = rods.get(spring).copied().unwrap_or(0.0);
            let bias = if covered { SPRING_BIAS } else { 0.0 };
            let colour = bytes(colour, 1.0);
            geometry.lines.push(Line { a, width, b, bias, colour, radius });
        }
        if !covered {
            geometry.casting_lines = geometry.lines.len();
            geometry.rods = if style.springs { 0 } else { geometry.lines.len() };
        }
    }
}

/// Adds particles and the marks of pins; those that no surface covers come first.
pub(crate) fn add_particles<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    view: &View,
) {
    let style = &view.style;
    let count = geometry.positions.len();
    let owners = owners(snapshot.bodies.iter().map(|body| &body.particles), count);
    let radii = radii(geometry, snapshot);
    geometry.ball_radius = 0.0;
    for covered in [false, true] {
        for (particle, &owner) in owners.iter().enumerate() {
            if is_covered(owner, snapshot.bodies, view) != covered {
                continue;
            }
            let Some(centre) = geometry.drawable(particle as u32) else { continue };
            let shade = geometry.shade(particle as u32);
            let pinned = snapshot.inverse_masses.get(particle).is_some_and(|&w| w == R::ZERO);
            let bare = style.surfaces && !covered;
            let radius = if bare { radii[particle] } else { geometry.particle_radius };
            if pinned && style.pins {
                let radius = (2.0 * geometry.particle_radius).max(1.4 * radius);
                let colour = bytes(PIN, 1.0);
                geometry.points.push(Point { centre, radius, colour, shape: 1.0 });
            } else if style.particles {
                geometry.ball_radius = geometry.ball_radius.max(sunk(snapshot, particle, radius));
                let own = mix(PARTICLE, own_colour(owner, snapshot.bodies), 0.25);
                let colour = bytes(shade.unwrap_or(own), 1.0);
                geometry.points.push(Point { centre, radius, colour, shape: 0.0 });
            } else if bare {
                geometry.ball_radius = geometry.ball_radius.max(sunk(snapshot, particle, radius));
                let colour = bytes(shade.unwrap_or(own_colour(owner, snapshot.bodies)), 1.0);
                geometry.points.push(Point { centre, radius, colour, shape: 0.0 });
            }
        }
        if !covered {
            geometry.casting_points = geometry.points.len();
        }
    }
}

/// Adds a line with a handle for every grab, on top of everything.
pub(crate) fn add_grabs<R: Real>(geometry: &mut Geometry, snapshot: &Snapshot<'_, R>, view: &View) {
    let colour = bytes(GRAB, 1.0);
    for grab in snapshot.grabs {
        let target = grab.target.to_f32();
        let Some(held) = geometry.drawable(grab.particle) else { continue };
        if !is_drawable(target) {
            continue;
        }
        let width = 1.5 * view.style.line_pixels();
        geometry.lines.push(Line { a: held, width, b: target, bias: ON_TOP, colour, radius: 0.0 });
        let radius = 2.2 * geometry.particle_radius;
        geometry.points.push(Point { centre: target, radius, colour, shape: 2.0 });
    }
}
