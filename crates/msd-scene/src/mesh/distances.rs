//! Signed distances from a closed mesh, on a grid: the shape of a solid.

use crate::mesh::clean::inside::Inside;
use crate::mesh::error::MeshError;
use crate::mesh::fill::place;
use crate::mesh::import::Mesh;
use glam::DVec3;
use msd_core::DistanceGrid;
use msd_core::scene::MOST_POINTS;

/// Cells along the longest side of a mesh, unless their edge is given.
const CELLS: f64 = 64.0;
/// Cells around the mesh on each side, so that its surface lies within the grid.
const AROUND: f64 = 2.0;
/// Samples of the surface along the edge of a cell, at which its error is measured.
const SAMPLES: f64 = 2.0;

/// Makes the shape of a solid of a closed mesh. It has its signed distances on a grid of points,
/// the centre of its bounding box at the origin and its longest side `length`, metres. A cell has
/// the edge `cell`, metres, by default a 64th of that side.
///
/// A point is inside by the nonzero rule, so pieces that overlap are one solid. The error of the
/// interpolated surface is the largest found at points of the surface, half a cell apart, and at
/// the middles of the cells near it.
///
/// # Errors
/// A mesh that is not closed, with its open edges; more points than fit; a cell so large that no
/// point is inside.
pub fn distances(mesh: &Mesh, length: f64, cell: Option<f64>) -> Result<DistanceGrid, MeshError> {
    let file = || mesh.name.clone();
    if !mesh.is_closed() {
        let (open, crowded) = (mesh.report.open_edges, mesh.report.non_manifold_edges);
        return Err(MeshError::Open { file: file(), open, crowded });
    }
    let size = MeshError::Option { quantity: "size", value: length, expected: POSITIVE };
    in_domain(length).then_some(()).ok_or(size)?;
    let cell = cell.unwrap_or(length / CELLS);
    let edge = MeshError::Option { quantity: "cell", value: cell, expected: POSITIVE };
    in_domain(cell).then_some(()).ok_or(edge)?;
    let corners = place(&mesh.positions, Some(length));
    let high = corners.iter().copied().fold(DVec3::MIN, DVec3::max);
    let sides = (2.0 * high / cell).ceil() + (2.0 * AROUND + 1.0);
    let count = sides.x * sides.y * sides.z;
    let most = MOST_POINTS as f64;
    if most < count {
        let (what, limit) = ("the number of points of its grid of distances", MOST_POINTS as u128);
        return Err(MeshError::TooLarge { file: file(), what, count: count as u128, limit });
    }
    let counts = sides.to_array().map(|side| side as usize);
    let low = -high - AROUND * cell;
    let surface = Surface::new(&corners, &mesh.triangles);
    let distances = distances_at(&surface, (low, cell), counts);
    if distances.iter().all(|distance| 0.0 <= *distance) {
        return Err(MeshError::TooCoarse { file: file(), cell });
    }
    let reach = corners.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    let triangles = mesh.triangles.clone();
    let mut grid =
        DistanceGrid { low, cell, counts, distances, reach, error: 0.0, corners, triangles };
    let surface = Surface::new(&grid.corners, &grid.triangles);
    grid.error = error_on_surface(&grid).max(error_beside(&grid, &surface));
    Ok(grid)
}

const POSITIVE: &str = "positive and at most 1e12";

fn in_domain(length: f64) -> bool {
    0.0 < length && length <= 1e12
}

/// The signed distance of each point of a grid.
fn distances_at(surface: &Surface<'_>, (low, cell): (DVec3, f64), counts: [usize; 3]) -> Vec<f64> {
    let [nx, ny, nz] = counts;
    let mut distances = Vec::with_capacity(nx * ny * nz);
    // No point is farther from the surface than its neighbour and the way between them.
    let mut most = f64::INFINITY;
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let point = low + cell * DVec3::new(x as f64, y as f64, z as f64);
                let distance = surface.signed_distance(point, most);
                distances.push(distance);
                most = distance.abs() + cell;
            }
            most = f64::INFINITY;
        }
    }
    distances
}

/// The largest gap that points of the surface have, metres.
fn error_on_surface(grid: &DistanceGrid) -> f64 {
    let mut error = 0.0;
    for triangle in &grid.triangles {
        let [a, b, c] = triangle.map(|corner| grid.corners[corner as usize]);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        let parts = (SAMPLES * longest / grid.cell).ceil().max(1.0) as usize;
        for i in 0..=parts {
            for j in 0..=parts - i {
                let [u, v] = [i, j].map(|step| step as f64 / parts as f64);
                error = grid.gap(a + (b - a) * u + (c - a) * v).abs().max(error);
            }
        }
    }
    error
}

/// The largest error of the gap at the middles of cells that are not farther from the surface than
/// their edge, metres.
fn error_beside(grid: &DistanceGrid, surface: &Surface<'_>) -> f64 {
    let [nx, ny, nz] = grid.counts;
    let mut error: f64 = 0.0;
    for z in 0..nz - 1 {
        for y in 0..ny - 1 {
            for x in 0..nx - 1 {
                let steps = DVec3::new(x as f64, y as f64, z as f64) + 0.5;
                let middle = grid.low + grid.cell * steps;
                let gap = grid.gap(middle);
                if gap.abs() <= grid.cell {
                    let distance = surface.signed_distance(middle, f64::INFINITY);
                    error = error.max((gap - distance).abs());
                }
            }
        }
    }
    error
}

/// The most triangles of a leaf of the tree.
const LEAF: usize = 4;

/// Some triangles that lie near each other, in a box.
struct Branch {
    low: DVec3,
    high: DVec3,
    first: usize,
    count: usize,
    /// Its two parts are the next branch and this one; none in a leaf.
    second: Option<usize>,
}

impl Branch {
    /// The square of the distance of a point from the box.
    fn squared(&self, point: DVec3) -> f64 {
        point.distance_squared(point.clamp(self.low, self.high))
    }
}

/// A closed surface, to be asked for distances.
struct Surface<'a> {
    inside: Inside<'a>,
    branches: Vec<Branch>,
    triangles: Vec<[DVec3; 3]>,
}

impl<'a> Surface<'a> {
    fn new(corners: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Self {
        let inside = Inside::new(corners, triangles);
        let triangles = triangles.iter().map(|t| t.map(|corner| corners[corner as usize]));
        let mut surface = Surface { inside, branches: Vec::new(), triangles: triangles.collect() };
        surface.grow(0, surface.triangles.len());
        surface
    }

    fn grow(&mut self, first: usize, count: usize) {
        let triangles = &mut self.triangles[first..first + count];
        let corners = || triangles.iter().flatten().copied();
        let (low, high) =
            (corners().fold(DVec3::MAX, DVec3::min), corners().fold(DVec3::MIN, DVec3::max));
        let index = self.branches.len();
        self.branches.push(Branch { low, high, first, count, second: None });
        if count <= LEAF {
            return;
        }
        let axis = (high - low).max_position();
        let place = |[a, b, c]: &[DVec3; 3]| a[axis] + b[axis] + c[axis];
        triangles.sort_by(|a, b| place(a).total_cmp(&place(b)));
        self.grow(first, count / 2);
        self.branches[index].second = Some(self.branches.len());
        self.grow(first + count / 2, count - count / 2);
    }

    /// The distance of a point from the surface, negative inside; it is known to be at most `most`.
    fn signed_distance(&self, point: DVec3, most: f64) -> f64 {
        // A little more than that, against rounding.
        let mut best = most * most * (1.0 + 1e-9);
        self.search(0, point, &mut best);
        let distance = best.sqrt();
        if self.inside.contains(point) { -distance } else { distance }
    }

    /// Looks for a nearer triangle in a branch; `best` is the square of a distance.
    fn search(&self, index: usize, point: DVec3, best: &mut f64) {
        let branch = &self.branches[index];
        let Some(second) = branch.second else {
            for triangle in &self.triangles[branch.first..branch.first + branch.count] {
                *best = point.distance_squared(nearest(*triangle, point)).min(*best);
            }
            return;
        };
        let mut parts = [index + 1, second].map(|part| (self.branches[part].squared(point), part));
        if parts[1].0 < parts[0].0 {
            parts.swap(0, 1);
        }
        for (squared, part) in parts {
            if squared < *best {
                self.search(part, point, best);
            }
        }
    }
}

/// The point of a triangle that is nearest to a point (Ericson, Real-Time Collision Detection,
/// 2005, section 5.1.5).
fn nearest([a, b, c]: [DVec3; 3], point: DVec3) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let [from_a, from_b, from_c] = [a, b, c].map(|corner| point - corner);
    let (d1, d2) = (ab.dot(from_a), ac.dot(from_a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let (d3, d4) = (ab.dot(from_b), ac.dot(from_b));
    if 0.0 <= d3 && d4 <= d3 {
        return b;
    }
    let (d5, d6) = (ab.dot(from_c), ac.dot(from_c));
    if 0.0 <= d6 && d5 <= d6 {
        return c;
    }
    let of_c = d1 * d4 - d3 * d2;
    if of_c <= 0.0 && 0.0 <= d1 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let of_b = d5 * d2 - d1 * d6;
    if of_b <= 0.0 && 0.0 <= d2 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let of_a = d3 * d6 - d5 * d4;
    if of_a <= 0.0 && 0.0 <= d4 - d3 && 0.0 <= d5 - d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    a + (ab * of_b + ac * of_c) / (of_a + of_b + of_c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_pcg::Pcg64Mcg;
    use rand_pcg::rand_core::{Rng, SeedableRng};

    /// The nearest point of a triangle by brute force: no point of a fine sampling is nearer.
    #[test]
    fn no_sample_of_a_triangle_is_nearer_than_its_nearest_point() {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let mut unit = || random.next_u32() as f64 / u32::MAX as f64 * 2.0 - 1.0;
        let mut vector = || DVec3::new(unit(), unit(), unit());
        for _ in 0..300 {
            let corners @ [a, b, c] = [vector(), vector(), vector()];
            let point = 2.0 * vector();
            let found = nearest(corners, point);
            // It is on the triangle: its barycentric coordinates are not negative and sum to one.
            let normal = (b - a).cross(c - a);
            let part =
                |p: DVec3, q: DVec3| (q - p).cross(found - p).dot(normal) / normal.length_squared();
            let parts = [part(a, b), part(b, c), part(c, a)];
            assert!(parts.iter().all(|&part| -1e-12 < part), "{parts:?}");
            assert!((parts.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let distance = found.distance(point);
            for i in 0..=30 {
                for j in 0..=30 - i {
                    let [u, v] = [i, j].map(|step| f64::from(step) / 30.0);
                    let sample = a + (b - a) * u + (c - a) * v;
                    assert!(distance <= sample.distance(point) + 1e-12);
                }
            }
        }
    }
}
