//! What may a renderer see? A borrowed, read-only picture of one instant.

use crate::real::Real;
use crate::scene::Body;
use crate::system::{Grab, Model, PlaneColumn, State};

/// One instant of a system, borrowed.
#[derive(Clone, Copy, Debug)]
pub struct Snapshot<'a, R: Real> {
    positions: &'a [R::Vec3],
    /// Reciprocal masses, per kilogram; 0 for a pinned particle.
    pub inverse_masses: &'a [R],
    /// The two particles of each spring.
    pub ends: &'a [[u32; 2]],
    /// Rest lengths, metres.
    pub rest_lengths: &'a [R],
    /// The planes.
    pub planes: &'a [PlaneColumn<R>],
    /// The grabs that hold now.
    pub grabs: &'a [Grab<R>],
    /// Named parts with their surfaces.
    pub bodies: &'a [Body],
}

impl<'a, R: Real> Snapshot<'a, R> {
    /// Borrows what a renderer needs.
    pub fn new(model: &'a Model<R>, state: &'a State<R>) -> Self {
        Snapshot {
            positions: &state.positions,
            inverse_masses: &model.inverse_masses,
            ends: &model.ends,
            rest_lengths: &model.rest_lengths,
            planes: &model.planes,
            grabs: &model.grabs,
            bodies: &model.bodies,
        }
    }

    /// The same system with its particles elsewhere, metres: any numbers, and any number of them.
    pub fn with_positions(self, positions: &'a [R::Vec3]) -> Self {
        Snapshot { positions, ..self }
    }

    /// The number of particles.
    pub fn particle_count(&self) -> usize {
        self.positions.len()
    }

    /// Where a particle is, metres.
    pub fn position(&self, particle: usize) -> R::Vec3 {
        self.positions[particle]
    }

    /// Where the particles are, metres.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = R::Vec3> + '_ {
        self.positions.iter().copied()
    }

    /// Whether a spring has been cut: its row stays, but it is not there.
    pub fn is_cut(&self, spring: usize) -> bool {
        let _ = spring;
        false
    }
}
