//! A substep that ends: the state as contact needs it.

use super::found::Found;
use super::{Evaluated, Radii};
use crate::columns::RECORD;
use crate::columns::threads::{Split, split_singles};
use crate::number::Real;

/// The state at the end of a substep, as contact needs it.
#[derive(Debug)]
pub(crate) struct Bodies<'a, R: Real> {
    /// Masses, a number for each slot, and their reciprocals, three for each.
    pub(crate) masses: &'a [R],
    pub(crate) inverse_masses: &'a [R],
    /// Stiffness of all springs at each slot, newtons per metre; empty where that does not matter.
    pub(crate) stiffnesses: &'a [R],
    pub(crate) radii: Radii<'a, R>,
    /// Forces of the last evaluation, newtons.
    pub(crate) forces: &'a [R],
    pub(crate) positions: &'a mut [R],
    pub(crate) velocities: &'a mut [R],
    pub(crate) substep: Substep<'a, R>,
    /// Their contacts at its end.
    pub(crate) found: Found<'a>,
}

/// A substep that ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Substep<'a, R> {
    /// Its length, seconds.
    pub(crate) h: R,
    /// Simulated time at its end, seconds.
    pub(crate) time: f64,
    /// Time by which velocities are ahead of those that made the displacement, seconds: under an
    /// acceleration a it was h (v − lag a).
    pub(crate) lag: R,
    /// A way that no particle has gone beyond in it, metres.
    pub(crate) reach: R,
    /// Positions at its start, metres, where the displacement was another.
    pub(crate) starts: Option<&'a [R]>,
    /// Accelerations at its start, metres per second squared, where the method keeps them.
    pub(crate) before: Option<&'a [R]>,
    /// Where the last forces were evaluated.
    pub(crate) evaluated: Evaluated,
}

impl<R: Real> Substep<'_, R> {
    /// A substep that takes no time.
    pub(crate) fn instant(time: f64) -> Self {
        let [h, lag, reach] = [R::ZERO; 3];
        let evaluated = Evaluated::Nowhere;
        Substep { h, time, lag, reach, starts: None, before: None, evaluated }
    }

    /// Where the particles of a record were at its start, metres, by their positions, velocities
    /// and accelerations; where those positions are not known.
    #[inline(always)]
    pub(crate) fn start(
        &self,
        mut x: [R; RECORD],
        v: &[R; RECORD],
        pulls: &[R; RECORD],
    ) -> [R; RECORD] {
        for i in 0..RECORD {
            x[i] -= (v[i] - pulls[i] * self.lag) * self.h;
        }
        x
    }
}

impl<R: Real> Bodies<'_, R> {
    /// Where the particles of a record were at the start of the substep, metres.
    #[inline(always)]
    pub(crate) fn starts_of(&self, record: usize) -> [R; RECORD] {
        let of =
            |column: &[R]| *column[record * RECORD..].first_chunk::<RECORD>().expect("a record");
        if let Some(starts) = self.substep.starts {
            return of(starts);
        }
        let (mut pulls, w) = (of(self.forces), of(self.inverse_masses));
        for i in 0..RECORD {
            pulls[i] *= w[i];
        }
        self.substep.start(of(self.positions), &of(self.velocities), &pulls)
    }
}

impl<R: Real> Split for Bodies<'_, R> {
    fn numbers(&self) -> usize {
        self.positions.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let (low_masses, masses) = split_singles(self.masses, numbers);
        let (low_inverse_masses, inverse_masses) = self.inverse_masses.split_at(numbers);
        let (low_stiffnesses, stiffnesses) = split_singles(self.stiffnesses, numbers);
        let (low_radii, radii) = self.radii.split(numbers);
        let (low_forces, forces) = self.forces.split_at(numbers);
        let (low_positions, positions) = self.positions.split_at_mut(numbers);
        let (low_velocities, velocities) = self.velocities.split_at_mut(numbers);
        let (low_found, found) = self.found.split(numbers);
        let (low_starts, starts) =
            self.substep.starts.map(|column| column.split_at(numbers)).unzip();
        let (low_before, before) =
            self.substep.before.map(|column| column.split_at(numbers)).unzip();
        let low_substep = Substep { starts: low_starts, before: low_before, ..self.substep };
        let substep = Substep { starts, before, ..self.substep };
        let low = Bodies {
            masses: low_masses,
            inverse_masses: low_inverse_masses,
            stiffnesses: low_stiffnesses,
            radii: low_radii,
            forces: low_forces,
            positions: low_positions,
            velocities: low_velocities,
            substep: low_substep,
            found: low_found,
        };
        let high = Bodies {
            masses,
            inverse_masses,
            stiffnesses,
            radii,
            forces,
            positions,
            velocities,
            substep,
            found,
        };
        (low, high)
    }
}
