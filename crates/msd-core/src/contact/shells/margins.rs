//! Bounds on the approach of features to each other in a substep.

use super::clusters::{Cluster, Clusters};
use super::features::{At, Shells};
use super::row::{ContactRow, EDGE, FACE, VERTEX, features};
use crate::columns::extent::Extent;
use crate::columns::vector;
use crate::number::Real;
use alloc::vec::Vec;

/// The velocities that the particles of each cluster may have in a substep. Impulses leave them
/// between their velocities after the kick and those of the surfaces that they touch.
#[derive(Clone, Debug, Default)]
pub(super) struct Margins<R: Real> {
    /// Those after the kick.
    free: Vec<Extent<R>>,
    /// Those, and those of the surfaces that touched the cluster in the last substep and of the
    /// obstacles that it may reach.
    met: Vec<Extent<R>>,
    /// The margin that holds for all, metres, and the factor of a speed, seconds.
    most: R,
    seconds: R,
    /// Margin that is added to all others, metres.
    least: R,
}

impl<R: Real> Margins<R> {
    /// Sets the margins of a substep before a kick of `length` seconds, from the corners and the
    /// rows of the last one. `most` holds for all clusters, and `seconds` is the substep and a bit.
    pub(super) fn set(
        &mut self,
        (at, clusters, corners): (&At<'_, R>, &Clusters, &[R::Vec3]),
        [velocities, forces]: [&[R]; 2],
        (length, seconds, least): (R, R, R),
        (last, most): (&[ContactRow<R>], R),
    ) {
        (self.most, self.seconds, self.least) = (most, seconds, least);
        let after = |&vertex: &u32| {
            let place = at.shells.vertices[vertex as usize].at as usize;
            let kick = vector::<R>(forces, place) * (at.inverse_masses[place] * length);
            vector::<R>(velocities, place) + kick
        };
        let extent =
            |of: &Cluster| Extent::around(clusters.corners[of.corners.clone()].iter().map(after));
        self.free.clear();
        self.free.extend(clusters.rows.iter().map(extent));
        self.met.clear();
        self.met.extend_from_slice(&self.free);
        if !at.obstacles.is_empty() {
            for (number, cluster) in clusters.rows.iter().enumerate() {
                self.meet_obstacles((at, cluster), number, cluster.extent(corners));
            }
        }
        for row in last.iter().filter(|row| row.push != R::ZERO && row.is_of_features()) {
            let [own, other] = vertices_of(at.shells, row.key)
                .map(|vertex| clusters.of_vertex[vertex as usize] as usize);
            let both = self.free[own].with(self.free[other]);
            for cluster in [own, other] {
                self.met[cluster] = self.met[cluster].with(both);
            }
        }
    }

    /// Adds the velocities of the obstacles that a cluster may reach.
    fn meet_obstacles(
        &mut self,
        (at, cluster): (&At<'_, R>, &Cluster),
        number: usize,
        around: Extent<R>,
    ) {
        let At { obstacles, time, .. } = *at;
        let middle = around.middle();
        let first = cluster.vertices[0].number;
        let size = around.diagonal().sqrt() * R::HALF + at.shells.radius_of::<R>(first);
        for index in 0..obstacles.count() {
            let obstacle = obstacles.get(index);
            let velocity = obstacle.velocity(middle, time);
            let mut both = self.free[number];
            both.add(velocity);
            let way = both.diagonal().sqrt() * self.seconds;
            if obstacle.gap(middle, time) < size + way {
                self.met[number].add(velocity);
            }
        }
    }

    /// The most by which two clusters, or the features of one, may come closer to each other,
    /// metres.
    pub(super) fn between(&self, clusters: [u32; 2]) -> R {
        let [own, other] = clusters.map(|cluster| self.met[cluster as usize]);
        (own.with(other).diagonal().sqrt() * self.seconds + self.least).min(self.most)
    }
}

/// The first vertex of each feature of a row.
pub(super) fn vertices_of(shells: &Shells, key: u64) -> [u32; 2] {
    let [a, b] = features(key);
    let edge = |edge: u32| shells.edges[edge as usize].ends[0];
    match key >> 62 {
        FACE => [a, shells.faces[b as usize].corners[0]],
        EDGE => [a, edge(b)],
        VERTEX => [a, b],
        _ => [edge(a), edge(b)],
    }
}
