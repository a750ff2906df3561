//! Signed distances from a closed surface, on a grid of points.

use crate::number::Real;
use alloc::vec::Vec;
use glam::DVec3;

/// The most points that a grid of distances may have: 32 MiB.
pub const MOST_POINTS: usize = 1 << 22;

/// Signed distances from a closed surface on a grid of points, as seen from the middle of a solid.
///
/// Between the points the distance is interpolated (trilinear), so the surface that particles meet
/// is off by [`DistanceGrid::error`]. With half the cell it is off by a quarter where the surface
/// is smooth, and by half at its edges. `msd_scene::mesh::distances` makes one of a mesh.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DistanceGrid {
    /// The point with the lowest coordinates, metres.
    pub low: DVec3,
    /// Edge of a cell, metres.
    pub cell: f64,
    /// The number of points along x, y and z, at least 2 each and at most [`MOST_POINTS`] in all.
    pub counts: [usize; 3],
    /// The distance of each point from the surface, metres; negative inside. Points along x stand
    /// together, then those along y.
    pub distances: Vec<f64>,
    /// The radius of a ball about the middle that holds the surface, metres.
    pub reach: f64,
    /// The largest distance found between the surface and the interpolated one, metres.
    pub error: f64,
    /// The corners of the surface, metres.
    pub corners: Vec<DVec3>,
    /// The triangles of the surface, three corners each, counter-clockwise seen from outside, for
    /// drawing.
    pub triangles: Vec<[u32; 3]>,
}

/// Steps of Newton's method from a point to the interpolated surface; two are enough within a cell.
const MOST_STEPS: usize = 8;
/// The least slope of distances, which have 1, at which a point still has a way to the surface.
/// About the middle of a part thinner than a cell there is none.
const LEAST_SLOPE: f64 = 0.25;

impl DistanceGrid {
    /// The distance of a point from the interpolated surface, metres; negative inside.
    ///
    /// Within a cell of the surface it is the way to it against the normal, exact up to rounding: a
    /// point that is moved by it lies on the surface.
    pub fn gap(&self, point: DVec3) -> f64 {
        let (value, slope) = self.sample(point);
        let steepness = length(slope);
        if self.cell < value.abs() || steepness < LEAST_SLOPE {
            return value;
        }
        let normal = slope / steepness;
        let mut way = value / steepness;
        for _ in 0..MOST_STEPS {
            let (left, slope) = self.sample(point - normal * way);
            let steepness = slope.dot(normal);
            if steepness < LEAST_SLOPE || 2.0 * self.cell < way.abs() {
                return value;
            }
            let step = left / steepness;
            way += step;
            if step.abs() <= f64::EPSILON * self.cell {
                break;
            }
        }
        way
    }

    /// The direction out of the solid at a point, length one: that in which the interpolated
    /// distance grows; up where it has none.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        let (_, slope) = self.sample(point);
        let steepness = length(slope);
        if 0.0 < steepness { slope / steepness } else { DVec3::Y }
    }

    /// The interpolated distance at a point, metres, and its derivative. Beyond the grid the way to
    /// it is added.
    pub fn sample(&self, point: DVec3) -> (f64, DVec3) {
        let last = DVec3::from_array(self.counts.map(|count| (count - 1) as f64));
        let inside = point.max(self.low).min(self.low + last * self.cell);
        let (value, slope) = self.interpolate((inside - self.low) / self.cell);
        let beyond = point - inside;
        if beyond == DVec3::ZERO {
            return (value, slope);
        }
        let away = length(beyond);
        let out = |axis: usize| if beyond[axis] == 0.0 { slope[axis] } else { beyond[axis] / away };
        (value + away, DVec3::new(out(0), out(1), out(2)))
    }

    /// The same at a place within the grid, in cells from its lowest point.
    fn interpolate(&self, place: DVec3) -> (f64, DVec3) {
        let [nx, ny, nz] = self.counts;
        let cell = |place: f64, count: usize| (place as usize).min(count - 2);
        let (x, y, z) = (cell(place.x, nx), cell(place.y, ny), cell(place.z, nz));
        let part = place - DVec3::new(x as f64, y as f64, z as f64);
        let first = (z * ny + y) * nx + x;
        // The values and slopes along x on the four edges of the cell, then along y, then z.
        let edge = |at: usize| {
            let (low, high) = (self.distances[at], self.distances[at + 1]);
            [low + (high - low) * part.x, high - low]
        };
        let face = |at: usize| {
            let ([low, low_x], [high, high_x]) = (edge(at), edge(at + nx));
            [low + (high - low) * part.y, low_x + (high_x - low_x) * part.y, high - low]
        };
        let (low, high) = (face(first), face(first + nx * ny));
        let mixed = |number: usize| low[number] + (high[number] - low[number]) * part.z;
        let slope = DVec3::new(mixed(1), mixed(2), high[0] - low[0]) / self.cell;
        (mixed(0), slope)
    }
}

fn length(vector: DVec3) -> f64 {
    Real::sqrt(vector.dot(vector))
}

/// Serialization of a grid: written once for each solid that shares it.
#[cfg(feature = "serde")]
pub(crate) mod shared {
    use super::DistanceGrid;
    use alloc::sync::Arc;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(
        grid: &Arc<DistanceGrid>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        grid.as_ref().serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Arc<DistanceGrid>, D::Error> {
        DistanceGrid::deserialize(deserializer).map(Arc::new)
    }
}
