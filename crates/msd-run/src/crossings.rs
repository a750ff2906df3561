//! Crossings: triangles of surfaces that pass through each other, by an exact test.

use msd_core::Body;
use msd_core::elements::touches::Touches;
use msd_core::glam::DVec3;
use robust::{Coord3D, orient3d};

/// A triangle of a surface: its particles, and the box around it.
struct Triangle {
    particles: [u32; 3],
    corners: [DVec3; 3],
    low: DVec3,
    high: DVec3,
}

/// Counts the pairs of triangles that have no particle in common and of which an edge of one passes
/// through the inside of the other: of two bodies that touch, or of one that touches itself.
///
/// Signs of volumes are exact (Shewchuk, 1997): what only touches does not cross.
pub fn crossings(positions: &[DVec3], bodies: &[Body], touches: &Touches) -> u64 {
    // All of a body touch alike.
    let may_touch = |[a, _, _]: [u32; 3], [b, _, _]: [u32; 3]| touches.may_touch([a, b]);
    let mut triangles: Vec<Triangle> = bodies.iter().flat_map(|body| of(positions, body)).collect();
    triangles.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    let mut count = 0;
    for (row, triangle) in triangles.iter().enumerate() {
        let beside = triangles[row + 1..].iter();
        let beside = beside.take_while(|other| other.low.x <= triangle.high.x);
        let meeting = beside.filter(|other| {
            triangle.meets(other) && may_touch(triangle.particles, other.particles)
        });
        count += meeting.filter(|other| triangle.crosses(other)).count();
    }
    count as u64
}

/// The triangles of a body.
fn of<'a>(positions: &'a [DVec3], body: &'a Body) -> impl Iterator<Item = Triangle> + 'a {
    body.surface.particles().map(|particles| {
        let corners = particles.map(|particle| positions[particle as usize]);
        let [a, b, c] = corners;
        Triangle { particles, corners, low: a.min(b).min(c), high: a.max(b).max(c) }
    })
}

impl Triangle {
    /// Whether the boxes overlap, and no particle is in both.
    fn meets(&self, other: &Triangle) -> bool {
        let overlap = self.low.cmple(other.high).all() && other.low.cmple(self.high).all();
        overlap && !self.particles.iter().any(|particle| other.particles.contains(particle))
    }

    fn crosses(&self, other: &Triangle) -> bool {
        self.is_pierced(other) || other.is_pierced(self)
    }

    /// Whether an edge of another triangle passes through the inside.
    fn is_pierced(&self, other: &Triangle) -> bool {
        let [a, b, c] = self.corners;
        let sides = other.corners.map(|corner| side([a, b, c], corner));
        let edges = [[0, 1], [1, 2], [2, 0]];
        edges.into_iter().filter(|[p, q]| sides[*p] * sides[*q] < 0.0).any(|[p, q]| {
            let [p, q] = [other.corners[p], other.corners[q]];
            let turns = [[a, b], [b, c], [c, a]].map(|[from, to]| side([p, q, from], to));
            turns.iter().all(|&turn| 0.0 < turn) || turns.iter().all(|&turn| turn < 0.0)
        })
    }
}

/// The sign of the volume of a tetrahedron: on which side of a triangle a point is.
fn side(triangle: [DVec3; 3], point: DVec3) -> f64 {
    let coordinates = |DVec3 { x, y, z }| Coord3D { x, y, z };
    let [a, b, c] = triangle.map(coordinates);
    let volume = orient3d(a, b, c, coordinates(point));
    if volume == 0.0 { 0.0 } else { volume.signum() }
}
