//! The lattice of particles that fills a mesh, and the springs that join them.

use crate::mesh::clean::interior::Interior;
use crate::mesh::error::MeshError;
use glam::{DVec3, IVec3};
use msd_core::lattice::FAMILIES;

/// The most lattice points that are looked at: with 13 springs each they take some 4 GB.
const LARGEST: u128 = 1 << 21;

/// The least distance of a particle from the surface, in spacings. A lattice point nearer than that
/// would double the surface, at the price of one more particle.
const CLEARANCE: f64 = 0.4;

/// A cubic lattice cut to the inside of a mesh.
#[derive(Debug, Default)]
pub(crate) struct Lattice {
    pub(crate) points: Vec<DVec3>,
    /// Pairs of points.
    pub(crate) springs: Vec<[usize; 2]>,
}

/// Fills a mesh with a lattice centred in its bounding box.
///
/// # Errors
/// More than 2²¹ lattice points in the box.
pub(crate) fn fill(
    (positions, triangles): (&[DVec3], &[[u32; 3]]),
    inside: &Interior,
    spacing: f64,
    file: &str,
) -> Result<Lattice, MeshError> {
    let grid = Grid::new(positions, spacing, file)?;
    let blocked = grid.near_surface(positions, triangles);
    let mut numbers = vec![u32::MAX; blocked.len()];
    let mut lattice = Lattice::default();
    for cell in grid.cells() {
        let (index, point) = (grid.index(cell), grid.point(cell));
        if !blocked[index] && inside.contains(point) {
            numbers[index] = lattice.points.len() as u32;
            lattice.points.push(point);
        }
    }
    for cell in grid.cells() {
        let from = numbers[grid.index(cell)];
        if from == u32::MAX {
            continue;
        }
        let nexts =
            FAMILIES.iter().map(|family| cell + IVec3::from_array(family.map(|step| step as i32)));
        for next in nexts.filter(|&next| grid.has(next)) {
            let to = numbers[grid.index(next)];
            // Two limbs a step apart must not grow together across the gap between them.
            if to != u32::MAX && inside.contains((grid.point(cell) + grid.point(next)) / 2.0) {
                lattice.springs.push([from as usize, to as usize]);
            }
        }
    }
    Ok(lattice)
}

/// Checks that the lattice in the box around some points is not too fine.
///
/// # Errors
/// See [`fill`].
pub(crate) fn check_spacing(
    positions: &[DVec3],
    spacing: f64,
    file: &str,
) -> Result<(), MeshError> {
    Grid::new(positions, spacing, file).map(|_| ())
}

struct Grid {
    origin: DVec3,
    spacing: f64,
    size: IVec3,
}

impl Grid {
    fn new(positions: &[DVec3], spacing: f64, file: &str) -> Result<Self, MeshError> {
        let low = positions.iter().copied().fold(DVec3::MAX, DVec3::min);
        let high = positions.iter().copied().fold(DVec3::MIN, DVec3::max);
        let steps = ((high - low) / spacing).floor();
        let count = steps.to_array().map(|steps| (steps as u128).saturating_add(1));
        let count = count.iter().fold(1u128, |product, &n| product.saturating_mul(n));
        if LARGEST < count {
            let file = file.into();
            return Err(MeshError::TooFine { file, spacing, count, limit: LARGEST });
        }
        let origin = (low + high - steps * spacing) / 2.0;
        Ok(Self { origin, spacing, size: steps.as_ivec3() + 1 })
    }

    fn has(&self, cell: IVec3) -> bool {
        cell.cmpge(IVec3::ZERO).all() && cell.cmplt(self.size).all()
    }

    fn index(&self, cell: IVec3) -> usize {
        let [x, y, z] = cell.to_array().map(|step| step as usize);
        let [_, height, depth] = self.size.to_array().map(|step| step as usize);
        (x * height + y) * depth + z
    }

    fn point(&self, cell: IVec3) -> DVec3 {
        self.origin + self.spacing * cell.as_dvec3()
    }

    fn cells(&self) -> impl Iterator<Item = IVec3> + use<> {
        cells_between(IVec3::ZERO, self.size - 1)
    }

    /// The cells that stand too near to a triangle.
    fn near_surface(&self, positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<bool> {
        let clearance = CLEARANCE * self.spacing;
        let mut near = vec![false; self.cells().count()];
        for triangle in triangles {
            let corners = triangle.map(|corner| positions[corner as usize]);
            let [a, b, c] = corners;
            let low = (a.min(b).min(c) - clearance - self.origin) / self.spacing;
            let high = (a.max(b).max(c) + clearance - self.origin) / self.spacing;
            let low = low.ceil().as_ivec3().max(IVec3::ZERO);
            let high = high.floor().as_ivec3().min(self.size - 1);
            for cell in cells_between(low, high) {
                let distance = distance_squared(self.point(cell), corners);
                near[self.index(cell)] |= distance < clearance * clearance;
            }
        }
        near
    }
}

fn cells_between(low: IVec3, high: IVec3) -> impl Iterator<Item = IVec3> {
    (low.x..=high.x).flat_map(move |x| {
        (low.y..=high.y).flat_map(move |y| (low.z..=high.z).map(move |z| IVec3::new(x, y, z)))
    })
}

/// Squared distance from a point to a triangle: to its plane if the foot lies in it, else to the
/// nearest side.
fn distance_squared(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let beside = |from: DVec3, to: DVec3| (to - from).cross(point - from).dot(normal) < 0.0;
    if !beside(a, b) && !beside(b, c) && !beside(c, a) {
        let height = normal.dot(point - a);
        return height * height / normal.length_squared();
    }
    let side = |from: DVec3, to: DVec3| {
        let along = (to - from).dot(point - from) / (to - from).length_squared();
        point.distance_squared(from.lerp(to, along.clamp(0.0, 1.0)))
    };
    side(a, b).min(side(b, c)).min(side(c, a))
}
