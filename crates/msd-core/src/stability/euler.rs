//! The limit of explicit Euler where dampers do not go with the stiffness of their springs.
//!
//! A motion v, fast or slow, stays bounded up to h = vᵀDv / vᵀKv. Where damping goes with stiffness
//! that is the same for all. Elsewhere any motion may be the first to grow, and the fastest ones do
//! not show it. So the method itself is run, about the state, from a rough motion. The one that
//! grows first takes over (power iteration; von Mises and Pollaczek-Geiringer, 1929), and its
//! quotient is the limit.

use super::spectrum::{Basis, OperatingPoint, Rough, dot, norm};
use crate::number::Real;
use alloc::vec::Vec;
use glam::DVec3;

/// Runs at most, each at the limit that the one before it found,
const MOST_RUNS: usize = 8;
/// and the substeps of each.
const SUBSTEPS: usize = 2000;
/// Products of springs in all: a third of a second. Runs of large systems are shorter, and find
/// less.
const MOST_PRODUCTS: usize = 20_000_000;
/// Two limits as close as this are one.
const CLOSE: f64 = 1e-3;
/// Substeps between two divisions by the length: a stable motion does not grow much in them.
const AT_ONCE: usize = 16;

/// The search for the limit of all motions, in pieces. Its columns are allocated once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Search {
    /// A motion about a state: velocities, and K times the displacements, divided by roots of
    /// masses.
    velocities: Vec<DVec3>,
    pulls: Vec<DVec3>,
    /// The limit of the fastest motion, and that found so far, seconds.
    fastest: f64,
    limit: f64,
    /// Runs that were made, and of the current one the substeps taken and their total.
    runs: usize,
    taken: usize,
    substeps: usize,
    /// vᵀKv and vᵀDv of its second half.
    sums: [f64; 2],
}

impl Search {
    /// Begins, from the limit of the fastest motion, seconds. The basis is of the same state.
    pub(crate) fn begin<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        basis: &Basis,
        fastest: f64,
    ) {
        let rows = basis.roots().len() + point.model.springs.count();
        self.substeps = (MOST_PRODUCTS / MOST_RUNS / rows).clamp(2 * AT_ONCE, SUBSTEPS);
        let rough = Rough(2).zip(basis.roots());
        let rough = rough.map(|(way, &root)| if root == 0.0 { DVec3::ZERO } else { way });
        self.velocities.clear();
        self.velocities.extend(rough);
        self.pulls.clear();
        self.pulls.resize(self.velocities.len(), DVec3::ZERO);
        (self.fastest, self.limit) = (fastest, fastest);
        (self.runs, self.taken, self.sums) = (0, 0, [0.0; 2]);
    }

    /// Does a piece, some substeps; returns the limit at the end, seconds.
    pub(crate) fn advance<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        basis: &mut Basis,
    ) -> Option<f64> {
        for _ in 0..AT_ONCE {
            if self.taken < self.substeps {
                self.take_substep(point, basis);
            }
        }
        if self.taken < self.substeps {
            return None;
        }
        let found = self.sums[1] / self.sums[0];
        (self.taken, self.sums) = (0, [0.0; 2]);
        // A motion that buckles, or is driven by its velocity, grows at any step: that is not a
        // limit.
        let is_limit = 0.0 < found && found.is_finite();
        if !is_limit {
            return Some(self.limit);
        }
        let before = self.limit;
        self.limit = found.min(self.fastest);
        self.runs += 1;
        let is_over = (found - before).abs() <= CLOSE * before || self.runs == MOST_RUNS;
        is_over.then_some(self.limit)
    }

    fn take_substep<R: Real>(&mut self, point: &OperatingPoint<'_, R>, basis: &mut Basis) {
        let [stiff, damp] = basis.products_of(point, &self.velocities);
        if self.substeps / 2 <= self.taken {
            self.sums[0] += dot(&self.velocities, stiff);
            self.sums[1] += dot(&self.velocities, damp);
        }
        let h = self.limit;
        let rows = self.velocities.iter_mut().zip(&mut self.pulls);
        for ((velocity, pull), (&stiff, &damp)) in rows.zip(stiff.iter().zip(damp)) {
            *velocity -= (*pull + damp) * h;
            *pull += stiff * h;
        }
        if self.taken.is_multiple_of(AT_ONCE) {
            let scale = 1.0 / norm(&self.velocities);
            self.velocities.iter_mut().for_each(|value| *value *= scale);
            self.pulls.iter_mut().for_each(|value| *value *= scale);
            self.sums = self.sums.map(|sum| sum * scale * scale);
        }
        self.taken += 1;
    }
}
