//! Triangles of surfaces that pass through each other, by an exact test.

use msd_core::glam::{DVec3, IVec3};
use robust::{Coord3D, orient3d};

/// A triangle of a surface: its particles, and the box around it.
#[derive(Clone, Debug)]
pub struct Triangle {
    particles: [usize; 3],
    corners: [DVec3; 3],
    low: DVec3,
    high: DVec3,
}

/// Sees each two triangles that have no particle in common and of which an edge of one passes
/// through the inside of the other, by their particles.
///
/// Signs of volumes are exact (Shewchuk, 1997): triangles that only touch do not cross.
pub fn each_crossing(triangles: Vec<Triangle>, mut see: impl FnMut([[usize; 3]; 2])) {
    for_each_beside(triangles, |triangle, other| {
        if triangle.meets(other) && triangle.crosses(other) {
            see([triangle.particles, other.particles]);
        }
    });
}

/// Calls with each pair of triangles that may meet, once, in an order that depends on them alone.
/// They are in the cells of their lowest corners, as wide as the widest of them.
fn for_each_beside(triangles: Vec<Triangle>, mut look: impl FnMut(&Triangle, &Triangle)) {
    let widths = triangles.iter().map(|triangle| (triangle.high - triangle.low).max_element());
    let width = widths.fold(f64::MIN_POSITIVE, f64::max);
    // Everything further out is in the last cell.
    let far = DVec3::splat(1e9);
    let place = |low: DVec3| (low / width).floor().clamp(-far, far).as_ivec3();
    let cell = |triangle: Triangle| (place(triangle.low), triangle);
    let mut cells: Vec<_> = triangles.into_iter().map(cell).collect();
    cells.sort_by_key(|(cell, _)| cell.to_array());
    // The columns of cells on one side, with where in them the last triangle met others.
    let columns = [[0, 1], [1, -1], [1, 0], [1, 1]];
    let mut firsts = [0; 4];
    for (row, (cell, triangle)) in cells.iter().enumerate() {
        let last = *cell + IVec3::Z;
        let above =
            cells[row + 1..].iter().take_while(|(other, _)| other.to_array() <= last.to_array());
        above.for_each(|(_, other)| look(triangle, other));
        for ([x, y], first) in columns.into_iter().zip(&mut firsts) {
            let [low, high] = [-1, 1].map(|z| (*cell + IVec3::new(x, y, z)).to_array());
            *first +=
                cells[*first..].iter().take_while(|(other, _)| other.to_array() < low).count();
            let beside = cells[*first..].iter().take_while(|(other, _)| other.to_array() <= high);
            beside.for_each(|(_, other)| look(triangle, other));
        }
    }
}

impl Triangle {
    /// A triangle by its particles, where they are.
    pub fn new(particles: [usize; 3], positions: &[DVec3]) -> Self {
        let corners = particles.map(|particle| positions[particle]);
        let [a, b, c] = corners;
        Triangle { particles, corners, low: a.min(b).min(c), high: a.max(b).max(c) }
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of many sizes at places that a recurrence makes.
    fn soup(count: u32) -> Vec<Triangle> {
        let mut state = 1u32;
        let mut next = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1u32 << 24)
        };
        let triangle = move |row: u32| {
            let size = [0.02, 0.3][usize::from(row.is_multiple_of(17))];
            let middle = DVec3::from_array([(); 3].map(|()| 2.0 * next() - 1.0));
            let corners =
                [(); 3].map(|()| middle + size * DVec3::from_array([(); 3].map(|()| next() - 0.5)));
            let particles = [0, 1, 2].map(|corner| 3 * row as usize + corner);
            Triangle { particles, ..Triangle::new([0, 1, 2], &corners) }
        };
        (0..count).map(triangle).collect()
    }

    #[test]
    fn all_that_meet_are_looked_at_once() {
        let triangles = soup(3000);
        let pair = |a: &Triangle, b: &Triangle| {
            let [a, b] = [a, b].map(|triangle| triangle.particles[0]);
            [a.min(b), a.max(b)]
        };
        let mut all = Vec::new();
        for (row, a) in triangles.iter().enumerate() {
            let meeting = triangles[row + 1..].iter().filter(|b| a.meets(b));
            all.extend(meeting.map(|b| pair(a, b)));
        }
        let mut found = Vec::new();
        for_each_beside(triangles, |a, b| {
            if a.meets(b) {
                found.push(pair(a, b));
            }
        });
        found.sort();
        all.sort();
        assert!(200 < all.len(), "{}", all.len());
        assert_eq!(found, all);
    }
}
