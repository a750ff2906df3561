//! The sweep: impulses of rows, one after the other, each as if it were alone.

use super::find::Row;
use crate::columns::{add_vector, vector};
use crate::contact::Contacts;
use crate::contact::law::coulomb;
use crate::number::{Real, Vector};

/// How long it takes to undo an overlap, seconds: by as much as is left of it in each such time.
const UNDOING: f64 = 0.05;

impl<R: Real> Row<R> {
    /// A vector of one side as seen from the other.
    #[inline(always)]
    pub(super) fn relative(&self, column: &[R]) -> R::Vec3 {
        self.sum(|at| vector::<R>(column, at))
    }

    /// The sum of a vector of each particle, by the weights, and of what the turning face adds
    /// across the normal.
    #[inline(always)]
    fn sum(&self, of: impl Fn(usize) -> R::Vec3) -> R::Vec3 {
        let each = self.at.iter().zip(self.weights).take(self.count);
        let sum = each.fold(R::Vec3::ZERO, |sum, (&at, weight)| sum + of(at as usize) * weight);
        if !self.turns {
            return sum;
        }
        let each = self.turning.iter().zip(self.turns_by);
        each.fold(sum, |sum, (&at, by)| sum + by * self.normal.dot(of(at as usize)))
    }

    /// The velocity of one side as seen from the other, metres per second.
    #[inline(always)]
    pub(super) fn velocity(&self, velocities: &[R]) -> R::Vec3 {
        self.relative(velocities) - self.carried
    }

    /// Gives both sides an impulse, newton seconds; or, of a column of positions, a way of theirs
    /// times the mass.
    ///
    /// Friction acts on both sides at the same place, half way between them or not: a face takes
    /// the couple of the two forces, which are some distance apart.
    #[inline(always)]
    pub(super) fn give(&self, column: &mut [R], inverse_masses: &[R], impulse: R::Vec3) {
        self.share(column, impulse, |at| inverse_masses[at]);
    }

    /// Adds a vector to both sides, by the weights and a number of each particle.
    #[inline(always)]
    fn share(&self, column: &mut [R], vector: R::Vec3, by: impl Fn(usize) -> R) {
        for (&at, weight) in self.at.iter().zip(self.weights).take(self.count) {
            let at = at as usize;
            add_vector::<R>(column, at, vector * (weight * by(at)));
        }
        if self.turns {
            for (&at, turn) in self.turning.iter().zip(self.turns_by) {
                let at = at as usize;
                let part = vector.dot(turn) * by(at);
                add_vector::<R>(column, at, self.normal * part);
            }
        }
    }

    /// The impulse that it has given, newton seconds.
    pub(super) fn impulse(&self) -> R::Vec3 {
        self.normal * self.push + self.rub
    }

    /// Corrects its impulse so that the sides do not come closer than they may at a speed, metres
    /// per second, and Coulomb's law holds.
    #[inline(always)]
    fn correct(&mut self, velocities: &mut [R], inverse_masses: &[R], may_close: R) {
        let velocity = self.velocity(velocities);
        let speed = velocity.dot(self.normal);
        let push = (self.push - (speed + may_close) * self.mass).max(R::ZERO);
        if push == R::ZERO && self.push == R::ZERO {
            return;
        }
        let slip = velocity - self.normal * speed;
        let wanted = self.rub - slip * self.mass;
        let (_, per_size) = coulomb(wanted.dot(wanted).sqrt(), self.friction * push);
        let kept = if per_size == R::ZERO { R::ONE } else { self.friction * push * per_size };
        let rub = wanted * kept;
        let change = self.normal * (push - self.push) + (rub - self.rub);
        (self.push, self.rub) = (push, rub);
        self.give(velocities, inverse_masses, change);
    }
}

/// Adds the impulses that rows have given to velocities.
pub(super) fn give<R: Real>(rows: &[Row<R>], velocities: &mut [R], inverse_masses: &[R]) {
    for row in rows.iter().filter(|row| row.push != R::ZERO) {
        row.give(velocities, inverse_masses, row.impulse());
    }
}

/// Adds the impulses that rows have given to forces, times a number per second.
pub(super) fn add_forces<R: Real>(rows: &[Row<R>], forces: &mut [R], per_second: R) {
    for row in rows.iter().filter(|row| row.push != R::ZERO) {
        row.share(forces, row.impulse() * per_second, |_| R::ONE);
    }
}

/// Notes the velocities before a kick by some forces of so many seconds.
pub(super) fn note<R: Real>(
    rows: &mut [Row<R>],
    [velocities, forces, inverse_masses]: [&[R]; 3],
    length: R,
) {
    for row in rows {
        let kicked = row.sum(|at| vector::<R>(forces, at) * inverse_masses[at]);
        row.before = row.velocity(velocities) - kicked * length;
        row.booked = R::Vec3::ZERO;
    }
}

/// Corrects the impulses of all rows in their order. For a drift of h seconds a gap may close; with
/// none, those that have given an impulse alone do not close any more.
pub(super) fn sweep<R: Real>(
    rows: &mut [Row<R>],
    velocities: &mut [R],
    inverse_masses: &[R],
    drift: Option<R>,
) {
    for row in rows {
        match drift {
            Some(h) => {
                row.correct(velocities, inverse_masses, row.gap.max(R::ZERO) / h);
            }
            None if row.push != R::ZERO => row.correct(velocities, inverse_masses, R::ZERO),
            None => {}
        }
    }
}

/// Books the work of impulses: each acted at the mean of the velocities before the kick and now.
pub(super) fn work<R: Real>(rows: &[Row<R>], velocities: &[R]) -> Contacts {
    let mut contacts = Contacts::default();
    let acts = |row: &&Row<R>| row.push != R::ZERO || row.booked != R::Vec3::ZERO;
    for row in rows.iter().filter(acts) {
        let mean = (row.before + row.velocity(velocities)) * R::HALF;
        let impulse = row.impulse() - row.booked;
        let driven = impulse.dot(row.carried).to_f64();
        let taken = -impulse.dot(mean).to_f64();
        contacts += Contacts { count: 0, driven, ..Contacts::one(taken) };
    }
    contacts
}

/// The part of a distance by which an overlap is left as it is: all that a run makes by itself.
const SLOP: f64 = 0.1;

/// Undoes a part of overlaps with which a scene started, by moving particles without giving them a
/// velocity.
pub(super) fn part<R: Real>(
    rows: &mut [Row<R>],
    positions: &mut [R],
    inverse_masses: &[R],
    h: R,
) {
    let fraction = (h * R::of(1.0 / UNDOING)).min(R::ONE);
    let allowed = |row: &Row<R>| -row.stop * R::of(SLOP);
    for row in rows.iter().filter(|row| 1 < row.count && row.gap < allowed(row)) {
        let way = row.relative(positions).dot(row.normal) - row.stop - row.gap;
        let missing = (allowed(row) - row.gap) * fraction - way;
        if R::ZERO < missing {
            row.give(positions, inverse_masses, row.normal * (missing * row.mass));
        }
    }
}
