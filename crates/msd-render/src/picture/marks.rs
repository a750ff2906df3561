//! Lines and points of a picture: springs, particles, pins, the rails along them, and grabs.

use crate::math::is_drawable;
use crate::picture::colour::{body_colour, bytes, mix, scale_colour};
use crate::picture::geometry::{Geometry, Line, Point, owners};
use crate::viewing::quantity::Scale;
use crate::viewing::view::View;
use msd_core::{Body, Real, Snapshot, Vector};

/// Colour of particles and springs that belong to no body.
const NEUTRAL: [f32; 3] = [0.45, 0.47, 0.52];
/// Colour of free particles.
const PARTICLE: [f32; 3] = [0.93, 0.94, 0.96];
/// Colour of pins and rails.
const PIN: [f32; 3] = [0.98, 0.70, 0.10];
/// Colour of grabs.
const GRAB: [f32; 3] = [0.86, 0.16, 0.55];
/// A spring in a surface wins against it, and loses against an edge.
const SPRING_BIAS: f32 = 0.0015;
/// Pulled in front of everything.
const ON_TOP: f32 = 1e9;

/// Returns whether a body hides its springs and particles behind a surface.
fn is_covered(owner: Option<u32>, bodies: &[Body], view: &View) -> bool {
    let body = owner.and_then(|body| bodies.get(body as usize));
    view.style.surfaces && body.is_some_and(|body| !body.surface.triangles.is_empty())
}

fn own_colour(owner: Option<u32>, bodies: &[Body]) -> [f32; 3] {
    let body = owner.and_then(|index| Some((index as usize, bodies.get(index as usize)?)));
    body.map_or(NEUTRAL, |(index, body)| body_colour(index, body))
}

/// A particle as a ball.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    /// The radius in which it is drawn, metres: the thickness of a rope or a point
    /// that meets others.
    radius: f32,
    /// Whether obstacles meet it at that radius, not its middle.
    is_met: bool,
}

impl Ball {
    /// Depth, metres, by which a particle drawn in a radius is sunk into the obstacle that it lies
    /// on.
    fn sunk(self, radius: f32) -> f32 {
        if self.is_met { 0.0 } else { radius }
    }
}

/// All particles as balls.
pub(crate) fn balls<R: Real>(geometry: &Geometry, snapshot: &Snapshot<'_, R>) -> Vec<Ball> {
    let ball = Ball { radius: geometry.particle_radius, is_met: false };
    let mut balls = vec![ball; geometry.positions.len()];
    for shell in snapshot.shells.iter().filter(|shell| shell.triangles.is_empty()) {
        for particle in shell.particles() {
            if let Some(ball) = balls.get_mut(particle) {
                *ball = Ball { radius: shell.thickness as f32, is_met: shell.obstacles };
            }
        }
    }
    balls
}

/// A rod between balls of this part of their radius, where nothing touches.
const ROD: f32 = 0.45;

/// Radius of a rail, in those of particles.
const RAIL: f32 = 1.3;

/// Adds a rail along every border of a surface that is pinned at both ends, and returns which
/// particles lie on one: they need no marks of their own.
pub(crate) fn add_rails<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    view: &View,
) -> Vec<bool> {
    let mut on_rail = vec![false; geometry.positions.len()];
    if view.style.pins {
        let is_pinned = |particle: u32| {
            snapshot.inverse_masses.get(particle as usize).is_some_and(|&w| w == R::ZERO)
        };
        let radius = RAIL * geometry.particle_radius;
        let colour = bytes(PIN, 1.0);
        let sheets = snapshot.bodies.iter().filter(|body| body.surface.two_sided);
        for [a, b] in sheets.flat_map(|body| body.surface.rim(is_pinned)) {
            let ends = [a, b].map(|end| geometry.drawable(end));
            let [Some(from), Some(to)] = ends else { continue };
            [a, b].iter().for_each(|&end| on_rail[end as usize] = true);
            geometry.lines.push(Line { a: from, width: 1.5, b: to, bias: 0.0, colour, radius });
        }
    }
    (geometry.rods, geometry.casting_lines) = (geometry.lines.len(), geometry.lines.len());
    on_rail
}

/// Adds springs: all of them where colours stand for a quantity of springs, else those of bodies
/// without surface.
///
/// Those that no surface covers come first: they cast shadows.
pub(crate) fn add_springs<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    (view, balls): (&View, &[Ball]),
) {
    let style = &view.style;
    let of_springs = geometry.scale.filter(|scale| scale.quantity.is_of_springs());
    if of_springs.is_none() && !style.surfaces {
        return;
    }
    let owners = owners(snapshot.bodies.iter().map(|body| &body.springs), snapshot.ends.len());
    let ball_radius = geometry.particle_radius;
    let rod = |end: u32| match balls.get(end as usize).map_or(0.0, |ball| ball.radius) {
        radius if radius == ball_radius => ROD * radius,
        radius => radius,
    };
    for covered in [false, true] {
        if covered && of_springs.is_none() {
            break;
        }
        for (spring, &[a, b]) in snapshot.ends.iter().enumerate() {
            let owner = owners[spring];
            if snapshot.is_cut(spring) || is_covered(owner, snapshot.bodies, view) != covered {
                continue;
            }
            let shades = [a, b].map(|end| geometry.shade(end));
            let radius = if of_springs.is_some() { 0.0 } else { rod(a).min(rod(b)) };
            let (Some(a), Some(b)) = (geometry.drawable(a), geometry.drawable(b)) else { continue };
            let value = |scale: Scale| Some((scale, scale.quantity.of_spring(snapshot, spring)?));
            let (colour, width) = match (of_springs.and_then(value), shades) {
                (Some((scale, value)), _) => {
                    (scale_colour(scale, value as f32), style.line_pixels())
                }
                (None, [Some(a), Some(b)]) => (mix(a, b, 0.5), style.line_pixels() * 1.5),
                _ => (own_colour(owner, snapshot.bodies), style.line_pixels() * 1.5),
            };
            let bias = if covered { SPRING_BIAS } else { 0.0 };
            let colour = bytes(colour, 1.0);
            geometry.lines.push(Line { a, width, b, bias, colour, radius });
        }
        if !covered {
            geometry.casting_lines = geometry.lines.len();
            if of_springs.is_none() {
                geometry.rods = geometry.lines.len();
            }
        }
    }
}

/// Adds particles and the marks of pins that are on no rail; those that no surface covers come
/// first.
pub(crate) fn add_particles<R: Real>(
    geometry: &mut Geometry,
    snapshot: &Snapshot<'_, R>,
    (view, balls, on_rail): (&View, &[Ball], &[bool]),
) {
    let style = &view.style;
    let count = geometry.positions.len();
    let owners = owners(snapshot.bodies.iter().map(|body| &body.particles), count);
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
            let ball = balls[particle];
            let radius = if bare { ball.radius } else { geometry.particle_radius };
            if on_rail[particle] {
                continue;
            }
            if pinned && style.pins {
                let radius = (1.6 * geometry.particle_radius).max(1.4 * radius);
                let colour = bytes(PIN, 1.0);
                geometry.points.push(Point { centre, radius, colour, shape: 1.0 });
            } else if style.particles {
                geometry.ball_radius = geometry.ball_radius.max(ball.sunk(radius));
                let own = mix(PARTICLE, own_colour(owner, snapshot.bodies), 0.25);
                let colour = bytes(shade.unwrap_or(own), 1.0);
                geometry.points.push(Point { centre, radius, colour, shape: 0.0 });
            } else if bare {
                geometry.ball_radius = geometry.ball_radius.max(ball.sunk(radius));
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

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::{Material, Pin, Scene, Settings, Simulation, shape};

    /// Returns the rails of a cloth of three rows of three whose particles of these numbers are
    /// pinned: their number, and the particles on them.
    fn rails(pins: &[usize]) -> (usize, Vec<usize>) {
        let part = shape::cloth([3, 3], 1.0, Material::default()).expect("a valid size");
        let mut scene = Scene::of("cloth", part);
        let velocity = glam::DVec3::ZERO;
        scene.pins = pins.iter().map(|&particle| Pin { particle, velocity }).collect();
        let cloth = Simulation::<f32>::new(&scene, Settings::default()).expect("a valid scene");
        let snapshot = cloth.snapshot();
        let mut geometry = Geometry::default();
        geometry.positions.extend(snapshot.positions().map(|position| position.to_f32()));
        let on_rail = add_rails(&mut geometry, &snapshot, &View::default());
        let count = geometry.lines.len();
        assert_eq!([geometry.rods, geometry.casting_lines], [count; 2]);
        (count, (0..9).filter(|&particle| on_rail[particle]).collect())
    }

    #[test]
    fn rails_run_along_the_rim_of_a_cloth_where_it_is_pinned_and_nowhere_else() {
        assert_eq!(rails(&[0, 1, 2, 3, 5, 6, 7, 8]), (8, vec![0, 1, 2, 3, 5, 6, 7, 8]));
        assert_eq!(rails(&[0, 1, 8]), (1, vec![0, 1]));
        // Neighbours across the rim, and particles of the rim that are not neighbours.
        assert_eq!(rails(&[1, 4, 7]), (0, vec![]));
        assert_eq!(rails(&[0, 2]), (0, vec![]));
    }
}
