//! Snapshots: borrowed, read-only views of one instant, for a renderer.

use super::model::Model;
use super::state::Columns;
use crate::columns::{self, slots::Slots};
use crate::elements::grabs::Grab;
use crate::elements::springs::{Springs, law};
use crate::number::{Real, Vector};
use crate::obstacles::PlaneColumn;
use crate::pack::{dot, zip};
use crate::scene::{Body, Shell, Solid};
use alloc::vec::Vec;
use glam::DVec3;

/// One instant of a system, borrowed; in the order of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Snapshot<'a, R: Real> {
    slots: &'a Slots,
    columns: &'a [R],
    velocities: &'a [R],
    springs: &'a Springs<R>,
    /// Positions that replace those of the system.
    other: Option<&'a [R::Vec3]>,
    cut: &'a [bool],
    /// Reciprocal masses, per kilogram; 0 for a pinned particle.
    pub inverse_masses: &'a [R],
    /// Masses, kilograms; 0 for a particle that was removed.
    pub masses: &'a [R],
    /// The two particles of each spring, cut or not.
    pub ends: &'a [[u32; 2]],
    /// Rest lengths, metres.
    pub rest_lengths: &'a [R],
    /// The planes.
    pub planes: &'a [PlaneColumn<R>],
    /// The solids; where they are follows from the time.
    pub solids: &'a [Solid],
    /// Simulated time, seconds.
    pub time: f64,
    /// The active grabs.
    pub grabs: &'a [Grab<R>],
    /// Named parts with their surfaces.
    pub bodies: &'a [Body],
    /// Surfaces, ropes and points of bodies that meet.
    pub shells: &'a [Shell],
}

impl<'a, R: Real> Snapshot<'a, R> {
    /// Borrows the columns that a renderer needs.
    pub(crate) fn new(model: &'a Model<R>, state: &'a Columns<R>, time: f64) -> Self {
        Snapshot {
            slots: &model.slots,
            columns: &state.positions,
            velocities: &state.velocities,
            springs: &model.springs,
            other: None,
            cut: model.springs.cut_flags(),
            inverse_masses: model.inverse_masses(),
            masses: model.masses(),
            ends: model.ends(),
            rest_lengths: model.rest_lengths(),
            planes: model.planes(),
            solids: model.solids(),
            time,
            grabs: model.grabs(),
            bodies: model.bodies(),
            shells: model.shells(),
        }
    }

    /// The same instant with other positions, metres, one of each particle: of a state that was
    /// kept, say. Velocities stay those of this instant.
    pub fn with_positions(self, positions: &'a [R::Vec3]) -> Self {
        Snapshot { other: Some(positions), ..self }
    }

    /// The number of particles, removed ones included.
    pub fn particle_count(&self) -> usize {
        self.other.map_or(self.masses.len(), <[R::Vec3]>::len)
    }

    /// The position of a particle, metres.
    ///
    /// # Panics
    /// If there is no such particle.
    #[inline]
    pub fn position(&self, particle: usize) -> R::Vec3 {
        match self.other {
            Some(positions) => positions[particle],
            None => columns::vector(self.columns, self.slots.at(particle)),
        }
    }

    /// The positions of all particles, metres.
    pub fn positions(&self) -> impl Iterator<Item = R::Vec3> + 'a {
        let columns = self.columns;
        let own = self.other.is_none().then(|| self.slots.places());
        let own = own.into_iter().flatten().map(move |at| columns::vector(columns, at));
        own.chain(self.other.into_iter().flatten().copied())
    }

    /// Overwrites `to` with all positions in single precision, metres.
    pub fn copy_positions<T: Clone + Default + From<[f32; 3]>>(&self, to: &mut Vec<T>) {
        let single = |position: R::Vec3| T::from(position.to_f32().to_array());
        if let Some(positions) = self.other {
            to.clear();
            to.extend(positions.iter().copied().map(single));
        } else {
            self.slots.collect(to, |at| single(columns::vector::<R>(self.columns, at)));
        }
    }

    /// Whether a spring is cut.
    #[inline]
    pub fn is_cut(&self, spring: usize) -> bool {
        self.cut.get(spring).is_some_and(|&cut| cut)
    }

    /// The speed of a particle, metres per second.
    ///
    /// # Panics
    /// If there is no such particle.
    pub fn speed(&self, particle: usize) -> f64 {
        let velocity = self.velocity(particle);
        Real::sqrt(velocity.dot(velocity))
    }

    /// The strain of a spring, (length − rest) / rest; its length in metres where the rest length
    /// is 0.
    ///
    /// # Panics
    /// If there is no such spring, or no position of one of its ends.
    pub fn strain(&self, spring: usize) -> f64 {
        let (length, rest) = (self.length(spring), self.springs.law(spring).rest.to_f64());
        if rest == 0.0 { length } else { (length - rest) / rest }
    }

    /// The force of a spring and its damper along it, newtons: positive where it pulls its ends
    /// together. 0 where it is cut, and where its ends coincide.
    ///
    /// # Panics
    /// If there is no such spring, or no position of one of its ends.
    pub fn tension(&self, spring: usize) -> f64 {
        let (length, law) = (self.length(spring), self.springs.law(spring).to_f64());
        if self.springs.is_cut(spring) || length == 0.0 {
            return 0.0;
        }
        let [a, b] = self.springs.ends()[spring].map(|end| {
            [self.position(end as usize).to_f64(), self.velocity(end as usize)]
                .map(Vector::components)
        });
        let (force, _) = law::pull::<_, true>(b, a, law, true);
        dot(force, zip(b[0], a[0], |b, a| b - a)) / length
    }

    /// The elastic energy of a spring, joules; 0 where it is cut.
    ///
    /// # Panics
    /// If there is no such spring, or no position of one of its ends.
    pub fn elastic_energy(&self, spring: usize) -> f64 {
        if self.springs.is_cut(spring) {
            return 0.0;
        }
        law::energy(self.length(spring), self.springs.law(spring).to_f64())
    }

    fn velocity(&self, particle: usize) -> DVec3 {
        columns::vector::<R>(self.velocities, self.slots.at(particle)).to_f64()
    }

    /// The length of a spring, metres.
    fn length(&self, spring: usize) -> f64 {
        let [a, b] = self.springs.ends()[spring].map(|end| self.position(end as usize).to_f64());
        let across = b - a;
        Real::sqrt(across.dot(across))
    }
}
