//! Notes on bodies that start inside obstacles and inside each other.

use super::spacing_of;
use crate::error::{FileError, plain};
use crate::file::obstacles::{short, told};
use crate::file::tree::Source;
use crate::mesh::Inside;
use crate::nearby::Nearest;
use glam::DVec3;
use msd_core::obstacles::{Obstacle, Placed};
use msd_core::scene::{Shell, do_meet};
use msd_core::{Body, Scene};
use std::collections::BTreeSet;

/// The depth inside an obstacle at which particles may start without a line, as a part of their
/// spacing. They are moved by so little that no body is thrown.
const DENT: f64 = 0.2;

/// A line on each body and obstacle of which it starts inside with particles that are free to move.
///
/// # Errors
/// An obstacle at whose surface a particle is outside the world.
pub(crate) fn started_inside(source: &Source<'_>, scene: &Scene) -> Result<Vec<String>, FileError> {
    let mut notes = Vec::new();
    let radii = radii_at_obstacles(scene);
    for (number, plane) in scene.planes.iter().enumerate() {
        let gap = |place: DVec3| plane.normal.dot(place) - plane.offset;
        let key = format!("world.planes[{number}]");
        notes.extend(inside(source, (scene, &radii), &key, (&gap, &|_| plane.normal))?);
    }
    for (number, solid) in scene.solids.iter().enumerate() {
        let placed = Placed::new(solid, 0.0);
        let gap = |place: DVec3| Obstacle::<f64>::gap(&placed, place, 0.0);
        let normal = |place: DVec3| Obstacle::<f64>::normal(&placed, place, 0.0);
        let key = format!("world.solids[{number}]");
        notes.extend(inside(source, (scene, &radii), &key, (&gap, &normal))?);
    }
    Ok(notes)
}

/// The thickness that each particle keeps from obstacles, metres; `None` where it is pinned.
fn radii_at_obstacles(scene: &Scene) -> Vec<Option<f64>> {
    let mut radii = vec![Some(0.0); scene.particles.len()];
    for shell in scene.shells.iter().filter(|shell| shell.obstacles) {
        shell.particles().for_each(|particle| radii[particle] = Some(shell.thickness));
    }
    scene.pins.iter().for_each(|pin| radii[pin.particle] = None);
    radii
}

/// The gap and the normal of an obstacle at a place.
type Surface<'s> = (&'s dyn Fn(DVec3) -> f64, &'s dyn Fn(DVec3) -> DVec3);

/// A line on each body that starts inside the obstacle at a key.
fn inside(
    source: &Source<'_>,
    (scene, radii): (&Scene, &[Option<f64>]),
    key: &str,
    (gap, normal): Surface<'_>,
) -> Result<Vec<String>, FileError> {
    let mut notes = Vec::new();
    for (row, body) in scene.bodies.iter().enumerate() {
        let (mut count, mut deepest) = (0, 0.0);
        for particle in body.particles.clone() {
            let Some(radius) = radii[particle] else { continue };
            let place = scene.particles[particle].position;
            let depth = radius - gap(place);
            if depth <= 0.0 {
                continue;
            }
            (count, deepest) = (count + 1, f64::max(deepest, depth));
            let outermost = (place + normal(place) * depth).abs().max_element();
            if scene.world.extent < outermost {
                let reason = format!(
                    "pushes particle {} of {} out of the world, to a coordinate of {} m: beyond \
                     `extent`, {} m",
                    particle - body.particles.start,
                    body.name,
                    short(outermost),
                    plain(scene.world.extent),
                );
                return Err(source.refuse(format_args!("{key}"), reason));
            }
        }
        let particles: Vec<usize> = body.particles.clone().collect();
        let dent = spacing_of(scene, row, &particles).map_or(0.0, |spacing| DENT * spacing);
        if dent < deepest {
            notes.push(format!(
                "{} starts inside {key} with {count} of its {} particles, up to {} m deep: a run \
                 begins with them at the surface",
                body.name,
                particles.len(),
                told(deepest),
            ));
        }
    }
    Ok(notes)
}

/// The overlap with which two particles of different bodies may start without a line, as a part of
/// the sum of their thicknesses.
const OVERLAP: f64 = 0.5;

/// The largest part of the particles of a body that may start inside another one without a line: a
/// corner, which contact pushes back.
const CORNER: f64 = 0.1;

/// A line on each pair of bodies that meet of which one starts in the other.
///
/// Particles count if they are inside its closed surface, or overlap one of its own far, and not
/// both are pinned. Particles with a link do not count: the author has put them there.
pub(crate) fn started_in_each_other(scene: &Scene) -> Vec<String> {
    let positions: Vec<DVec3> = scene.particles.iter().map(|row| row.position).collect();
    let shells = scene.shells.iter().map(|shell| Outside::new(scene, shell, &positions));
    let rows: Vec<Outside<'_>> = shells.collect();
    let pairs = meeting(scene, &rows);
    if pairs.is_empty() {
        return Vec::new();
    }
    let solids: Vec<Option<Inside<'_>>> = rows.iter().map(|row| row.inside(&positions)).collect();
    let trees: Vec<Nearest<'_>> = rows.iter().map(|row| Nearest::new(&row.places)).collect();
    let mut is_free = vec![true; positions.len()];
    scene.pins.iter().for_each(|pin| is_free[pin.particle] = false);
    let linked = linked(scene);
    // The overlap of a particle of a row with another; `None` where it is beside it.
    let overlap = |particle: usize, row: usize, reach: f64| {
        let may_push = |other: usize| is_free[particle] || is_free[rows[row].particles[other]];
        let place = positions[particle];
        let nearest = rows[row].places[trees[row].find(place, may_push)?];
        let is_inside = solids[row].as_ref().is_some_and(|inside| inside.contains(place));
        let gap = place.distance(nearest) * if is_inside { -1.0 } else { 1.0 };
        let overlap = Overlap { depth: reach - gap, is_inside, is_at_one_point: place == nearest };
        (gap < (1.0 - OVERLAP) * reach).then_some(overlap)
    };
    let mut notes = Vec::new();
    for pair @ [first, second] in pairs {
        let reach = rows[first].radius + rows[second].radius;
        // The later one is in the other, or holds it.
        for [outer, inner] in [pair, [second, first]] {
            let particles = &rows[inner].particles;
            let loose = particles.iter().filter(|particle| !linked.contains(particle));
            let found = loose.filter_map(|&particle| overlap(particle, outer, reach));
            let found: Vec<Overlap> = found.collect();
            if CORNER * (particles.len() as f64) < found.len() as f64 {
                notes.push(overlapping([&rows[inner], &rows[outer]], &found));
                break;
            }
        }
    }
    notes
}

/// The overlap of a particle of a body with another body.
struct Overlap {
    /// The length by which it is closer than the two stop each other, metres.
    depth: f64,
    /// Whether it is inside a closed surface.
    is_inside: bool,
    /// Whether it is exactly where one of the other is, so that contact has no direction.
    is_at_one_point: bool,
}

/// The line on a body of which particles overlap another one, and on the response of contact.
fn overlapping([inner, outer]: [&Outside<'_>; 2], found: &[Overlap]) -> String {
    let deepest = found.iter().map(|overlap| overlap.depth).fold(0.0, f64::max);
    let inside = found.iter().filter(|overlap| overlap.is_inside).count();
    let (verb, outcome) = if inside == inner.particles.len() {
        ("starts inside", "stays inside: move one of the two bodies")
    } else if 0 < inside {
        ("starts inside", "is pushed out slowly")
    } else if found.iter().any(|overlap| overlap.is_at_one_point) {
        ("overlaps", "stays where two particles are at one point: move one of the two bodies")
    } else if inner.has_triangles || outer.has_triangles {
        ("overlaps", "is pushed away where the two do not cross")
    } else {
        ("overlaps", "is pushed away, to nine tenths of the distance that the two keep")
    };
    format!(
        "{} {verb} {} with {} of its {} contact particles, up to about {} m deep, and {outcome}",
        inner.name,
        outer.name,
        found.len(),
        inner.particles.len(),
        told(deepest),
    )
}

/// The particles of a body that meet others.
struct Outside<'s> {
    particles: Vec<usize>,
    /// The thickness that they keep, metres.
    radius: f64,
    name: &'s str,
    places: Vec<DVec3>,
    has_triangles: bool,
    /// The triangles of its surface where that is closed, else none.
    closed: Vec<[u32; 3]>,
    /// The box around them and their thickness.
    low: DVec3,
    high: DVec3,
}

impl<'s> Outside<'s> {
    fn new(scene: &'s Scene, shell: &Shell, positions: &[DVec3]) -> Self {
        let particles: BTreeSet<usize> = shell.particles().collect();
        let (particles, radius) = (Vec::from_iter(particles), shell.thickness);
        let places: Vec<DVec3> = particles.iter().map(|&row| positions[row]).collect();
        let around = DVec3::splat(radius);
        let low = places.iter().copied().reduce(DVec3::min).unwrap_or_default() - around;
        let high = places.iter().copied().reduce(DVec3::max).unwrap_or_default() + around;
        let first = particles.first().copied().unwrap_or_default();
        let body = scene.bodies.partition_point(|body| body.particles.end <= first);
        let Body { name, surface, .. } = &scene.bodies[body];
        let closed = if surface.two_sided { Vec::new() } else { surface.particles().collect() };
        let has_triangles = !shell.triangles.is_empty();
        Outside { particles, radius, name, places, has_triangles, closed, low, high }
    }

    fn meets(&self, other: &Outside<'_>) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    fn inside<'a>(&'a self, positions: &'a [DVec3]) -> Option<Inside<'a>> {
        (!self.closed.is_empty()).then(|| Inside::new(positions, &self.closed))
    }
}

/// The pairs of rows that stop each other and whose boxes overlap, in order.
fn meeting(scene: &Scene, rows: &[Outside<'_>]) -> Vec<[usize; 2]> {
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|&a, &b| rows[a].low.x.total_cmp(&rows[b].low.x));
    let mut pairs = Vec::new();
    for (at, &row) in order.iter().enumerate() {
        let beside = order[at + 1..].iter();
        let beside = beside.take_while(|&&other| rows[other].low.x <= rows[row].high.x);
        let meeting = beside.filter(|&&other| rows[row].meets(&rows[other]));
        let pair = meeting.map(|&other| [row.min(other), row.max(other)]);
        pairs.extend(pair.filter(|&pair| do_meet(&scene.shells, pair)));
    }
    pairs.sort_unstable();
    pairs
}

/// The ends of the springs that belong to no body.
fn linked(scene: &Scene) -> BTreeSet<usize> {
    let own = scene.bodies.iter().map(|body| body.springs.end).max().unwrap_or(0);
    scene.springs[own..].iter().flat_map(|link| link.ends).collect()
}
