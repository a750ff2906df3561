//! The sweep: impulses of rows, one after the other, each as if it were alone.

use super::row::ContactRow;
use crate::columns::vector;
use crate::contact::Contacts;
use crate::number::{Real, Vector};

/// How long it takes to undo an overlap, seconds: by as much as is left of it in each such time.
const UNDOING: f64 = 0.05;

/// Adds the impulses that rows have given to velocities.
pub(super) fn give<R: Real>(rows: &[ContactRow<R>], velocities: &mut [R], inverse_masses: &[R]) {
    for row in rows.iter().filter(|row| row.push != R::ZERO) {
        row.give(velocities, inverse_masses, row.impulse());
    }
}

/// Adds the impulses that rows have given to forces, times a number per second.
pub(super) fn add_forces<R: Real>(rows: &[ContactRow<R>], forces: &mut [R], per_second: R) {
    for row in rows.iter().filter(|row| row.push != R::ZERO) {
        row.share(forces, row.impulse() * per_second, |_| R::ONE);
    }
}

/// Notes the velocities before a kick by some forces of so many seconds.
pub(super) fn note<R: Real>(
    rows: &mut [ContactRow<R>],
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
    rows: &mut [ContactRow<R>],
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
pub(super) fn work<R: Real>(rows: &[ContactRow<R>], velocities: &[R]) -> Contacts {
    let mut contacts = Contacts::default();
    let acts = |row: &&ContactRow<R>| row.push != R::ZERO || row.booked != R::Vec3::ZERO;
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
    rows: &mut [ContactRow<R>],
    positions: &mut [R],
    inverse_masses: &[R],
    h: R,
) {
    let fraction = (h * R::of(1.0 / UNDOING)).min(R::ONE);
    let allowed = |row: &ContactRow<R>| -row.stop * R::of(SLOP);
    for row in rows.iter().filter(|row| 1 < row.count && row.gap < allowed(row)) {
        let way = row.relative(positions).dot(row.normal) - row.stop - row.gap;
        let missing = (allowed(row) - row.gap) * fraction - way;
        if R::ZERO < missing {
            row.give(positions, inverse_masses, row.normal * (missing * row.mass));
        }
    }
}
