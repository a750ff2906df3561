//! Columns of the vertices that are near others, side by side: a sweep reads each many times.

use super::Shells;
use crate::columns::{set_vector, vector};
use crate::number::{Real, Vector};
use alloc::vec::Vec;

/// Numbers of vertices; those of the vertices in lists are kept up to date.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch<R: Real> {
    /// Positions, metres.
    pub(super) points: Vec<R::Vec3>,
    /// Velocities, and those before a kick, metres per second.
    pub(super) velocities: Vec<R::Vec3>,
    pub(super) before: Vec<R::Vec3>,
    pub(super) inverse_masses: Vec<R>,
}

impl<R: Real> Patch<R> {
    /// Makes room for the vertices of some shells.
    pub(super) fn fit(&mut self, shells: &Shells) {
        let count = shells.vertices.len();
        for column in [&mut self.points, &mut self.velocities, &mut self.before] {
            column.resize(count, R::Vec3::ZERO);
        }
        self.inverse_masses.resize(count, R::ZERO);
    }

    /// Sets the velocities before to those that differ from the mean ones, which are set, by a part
    /// of the difference of those at the end.
    pub(super) fn set_before(
        &mut self,
        (shells, vertices): (&Shells, &[u32]),
        ends: &[R],
        part: R,
    ) {
        gather((shells, vertices), ends, &mut self.before);
        for &vertex in vertices {
            let (end, mean) = (&mut self.before[vertex as usize], self.velocities[vertex as usize]);
            *end = mean + (*end - mean) * part;
        }
    }

    /// The means of the velocities of some vertices before a kick and their current ones.
    pub(super) fn means(&mut self, vertices: &[u32]) -> &[R::Vec3] {
        for &vertex in vertices {
            let (mean, now) = (&mut self.before[vertex as usize], self.velocities[vertex as usize]);
            *mean = (*mean + now) * R::HALF;
        }
        &self.before
    }
}

/// Reads the vectors of some vertices from a column.
pub(super) fn gather<R: Real>(
    (shells, vertices): (&Shells, &[u32]),
    column: &[R],
    to: &mut [R::Vec3],
) {
    for &vertex in vertices {
        let at = shells.vertices[vertex as usize].at as usize;
        to[vertex as usize] = vector::<R>(column, at);
    }
}

/// Writes the vectors of some vertices to a column.
pub(super) fn scatter<R: Real>(
    (shells, vertices): (&Shells, &[u32]),
    from: &[R::Vec3],
    column: &mut [R],
) {
    for &vertex in vertices {
        let at = shells.vertices[vertex as usize].at as usize;
        set_vector(column, at, from[vertex as usize]);
    }
}
