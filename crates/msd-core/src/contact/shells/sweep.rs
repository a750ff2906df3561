//! The sweep: impulses of rows, one after the other, each as if it were alone.

use super::row::{ContactRow, SLOP};
use crate::contact::Contacts;
use crate::number::{Real, Vector};

/// How long it takes to undo an overlap, seconds: by as much as is left of it in each such time.
const UNDOING: f64 = 0.05;

/// Adds the impulses that rows have given to velocities.
pub(super) fn give<R: Real>(
    rows: &[ContactRow<R>],
    velocities: &mut [R::Vec3],
    inverse_masses: &[R],
) {
    for row in rows.iter().filter(|row| row.push != R::ZERO) {
        row.give(velocities, inverse_masses, row.impulse());
    }
}

/// Corrects the impulses of all rows in their order, so that no gap closes in a drift of h seconds;
/// `turn` lets a face of a row that starts to give one take the couple of friction.
pub(super) fn sweep<R: Real>(
    rows: &mut [ContactRow<R>],
    velocities: &mut [R::Vec3],
    inverse_masses: &[R],
    h: R,
    turn: impl Fn(&mut ContactRow<R>),
) {
    for row in rows {
        let may_close = row.gap.max(R::ZERO) / h;
        if row.push == R::ZERO {
            if row.is_open(velocities, may_close) {
                continue;
            }
            turn(row);
        }
        row.correct(velocities, inverse_masses, may_close);
    }
}

/// Corrects the impulses of the rows that have given one, so that they do not close any more.
pub(super) fn hold<R: Real>(
    rows: &mut [ContactRow<R>],
    velocities: &mut [R::Vec3],
    inverse_masses: &[R],
) {
    for row in rows.iter_mut().filter(|row| row.push != R::ZERO) {
        row.correct(velocities, inverse_masses, R::ZERO);
    }
}

/// Books the work of impulses, each of which acted at mean velocities.
pub(super) fn work<R: Real>(rows: &[ContactRow<R>], means: &[R::Vec3]) -> Contacts {
    let mut contacts = Contacts::default();
    let acts = |row: &&ContactRow<R>| row.push != R::ZERO || row.booked != R::Vec3::ZERO;
    for row in rows.iter().filter(acts) {
        let impulse = row.impulse() - row.booked;
        let driven = impulse.dot(row.carried).to_f64();
        let taken = -impulse.dot(row.velocity(means)).to_f64();
        contacts += Contacts { count: 0, driven, ..Contacts::one(taken) };
    }
    contacts
}

/// Undoes a part of overlaps with which a scene started, by moving particles without giving them a
/// velocity; returns whether it moves any.
pub(super) fn part<R: Real>(
    rows: &[ContactRow<R>],
    points: &mut [R::Vec3],
    inverse_masses: &[R],
    h: R,
) -> bool {
    let mut moves = false;
    let fraction = (h * R::of(1.0 / UNDOING)).min(R::ONE);
    let allowed = |row: &ContactRow<R>| -row.stop * R::of(SLOP);
    for row in rows.iter().filter(|row| !row.is_of_obstacle() && row.gap < allowed(row)) {
        let way = row.relative(points).dot(row.normal) - row.stop - row.gap;
        let missing = (allowed(row) - row.gap) * fraction - way;
        if R::ZERO < missing {
            row.give(points, inverse_masses, row.normal * (missing * row.mass));
            moves = true;
        }
    }
    moves
}
