//! The state of a system: positions and velocities, as a caller holds them and as columns.

use crate::columns::slots::Slots;
use crate::columns::threads::for_each_share;
use crate::columns::{self, Aligned};
use crate::elements::{Motion, collected, column, spread};
use crate::error::Error;
use crate::number::{Real, Vector};
use crate::scene::check::check;
use alloc::vec::Vec;

/// Positions and velocities in the order of the scene, to be copied out, kept and put back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State<R: Real> {
    /// Positions, metres.
    pub positions: Vec<R::Vec3>,
    /// Velocities, metres per second.
    pub velocities: Vec<R::Vec3>,
}

impl<R: Real> State<R> {
    /// Checks that every position is inside a world of this extent and every velocity finite;
    /// `inside` says so in words.
    pub(crate) fn check(&self, extent: R, inside: &'static str) -> Result<(), Error> {
        let rows = self.positions.iter().zip(&self.velocities);
        check_motions(rows.map(|(&position, &velocity)| (position, velocity)), extent, inside)
    }

    /// The same state in another precision, each number rounded once.
    pub fn convert<S: Real>(&self) -> State<S> {
        let vectors =
            |column: &[R::Vec3]| column.iter().map(|value| S::Vec3::of(value.to_f64())).collect();
        State { positions: vectors(&self.positions), velocities: vectors(&self.velocities) }
    }
}

/// Checks positions and velocities, see [`State::check`].
pub(crate) fn check_motions<R: Real>(
    motions: impl Iterator<Item = (R::Vec3, R::Vec3)>,
    extent: R,
    inside: &'static str,
) -> Result<(), Error> {
    for (row, (position, velocity)) in motions.enumerate() {
        let (at, reach) = (("particle", row), position.extent());
        check(reach <= extent, "position", at, reach.to_f64(), inside)?;
        let speed = velocity.extent().to_f64();
        check(speed.is_finite(), "velocity", at, speed, "finite")?;
    }
    Ok(())
}

/// Positions and velocities as the passes of a step read and write them.
#[derive(Clone, Debug, Default)]
pub struct Columns<R: Real> {
    /// Positions, metres.
    pub positions: Aligned<R>,
    /// Velocities, metres per second.
    pub velocities: Aligned<R>,
}

impl<R: Real> Columns<R> {
    /// Makes columns with a place for each particle; columns used together differ in `place`.
    pub(crate) fn new(slots: &Slots, place: usize) -> Self {
        Columns { positions: column(slots, place), velocities: column(slots, place + 1) }
    }

    /// Takes over a state.
    pub(crate) fn of(slots: &Slots, state: &State<R>, place: usize) -> Self {
        let mut columns = Columns::new(slots, place);
        columns.set(slots, state);
        columns
    }

    /// Overwrites the columns with a state.
    pub(crate) fn set(&mut self, slots: &Slots, state: &State<R>) {
        spread::<R>(slots, &state.positions, &mut self.positions);
        spread::<R>(slots, &state.velocities, &mut self.velocities);
    }

    /// Overwrites these columns with others.
    pub(crate) fn copy_from(&mut self, other: &Columns<R>) {
        let copy = |(to, from): (&mut [R], &[R])| to.copy_from_slice(from);
        for_each_share((&mut *self.positions, &*other.positions), copy);
        for_each_share((&mut *self.velocities, &*other.velocities), copy);
    }

    /// The state in the order of the scene.
    pub(crate) fn state(&self, slots: &Slots) -> State<R> {
        State {
            positions: collected(slots, &self.positions),
            velocities: collected(slots, &self.velocities),
        }
    }

    /// The motion at a time.
    pub(crate) fn motion<'a>(&'a self, slots: &'a Slots, time: f64) -> Motion<'a, R> {
        Motion { slots, positions: &self.positions, velocities: &self.velocities, time }
    }

    /// Position and velocity at a place.
    #[inline]
    pub(crate) fn get(&self, at: usize) -> (R::Vec3, R::Vec3) {
        (columns::vector(&self.positions, at), columns::vector(&self.velocities, at))
    }

    /// Overwrites position and velocity at a place.
    #[inline]
    pub(crate) fn put(&mut self, at: usize, (position, velocity): (R::Vec3, R::Vec3)) {
        columns::set_vector(&mut self.positions, at, position);
        columns::set_vector(&mut self.velocities, at, velocity);
    }
}
