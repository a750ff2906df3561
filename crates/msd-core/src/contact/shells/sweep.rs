//! The sweep: impulses of rows, one after the other, each as if it were alone.

use super::row::{ContactRow, SLOP};
use crate::contact::Contacts;
use crate::number::{Real, Vector};

/// Time constant with which an overlap is undone, seconds.
pub(super) const UNDOING: f64 = 0.05;

/// Adds a part of the impulses that are not booked yet to velocities, or to positions by the time
/// that they act.
pub(super) fn add<R: Real>(
    rows: &[ContactRow<R>],
    column: &mut [R::Vec3],
    inverse_masses: &[R],
    part: R,
) {
    for row in rows {
        let added = row.impulse() - row.booked;
        if added != R::Vec3::ZERO {
            row.give(column, inverse_masses, added * part);
        }
    }
}

/// Corrects the impulses of all rows in their order, so that no gap closes in a drift of h seconds.
///
/// A row that has given none and would close starts to if `starts` says so of it and its velocity.
/// That lets a face take the couple of friction.
pub(super) fn sweep<R: Real>(
    rows: &mut [ContactRow<R>],
    velocities: &mut [R::Vec3],
    inverse_masses: &[R],
    h: R,
    starts: impl Fn(&mut ContactRow<R>, R::Vec3) -> bool,
) {
    for row in rows {
        let may_close = row.gap.max(R::ZERO) / h;
        if row.push == R::ZERO
            && (row.is_open(velocities, may_close) || !starts(row, row.velocity(velocities)))
        {
            continue;
        }
        let is_bounce = R::ZERO < row.parting;
        row.correct(velocities, inverse_masses, if is_bounce { -row.parting } else { may_close });
    }
}

/// Sets the speeds at which sides part that meet in this substep, by their velocities before it and
/// after a kick that is so much shorter than the pull of the substep.
///
/// As on obstacles, those do not bounce whose approach is undone by the pull of two substeps.
pub(super) fn set_partings<R: Real>(
    rows: &mut [ContactRow<R>],
    [before, after]: [&[R::Vec3]; 2],
    shorter: R,
) {
    for row in rows.iter_mut().filter(|row| R::ZERO < row.restitution && row.push == R::ZERO) {
        let [before, after] = [before, after].map(|column| row.velocity(column).dot(row.normal));
        let pull = (after - before).abs() * shorter;
        let is_bounce = before < -(pull + pull);
        row.parting = if is_bounce { -before * row.restitution } else { R::ZERO };
    }
}

/// Corrects the impulses of the rows that have given one, so that they do not close any more, or
/// bounce.
pub(super) fn hold<R: Real>(
    rows: &mut [ContactRow<R>],
    velocities: &mut [R::Vec3],
    inverse_masses: &[R],
) {
    for row in rows.iter_mut().filter(|row| row.push != R::ZERO) {
        row.correct(velocities, inverse_masses, -row.parting);
    }
}

/// Books the work of the additions to impulses, each of which acted at mean velocities.
pub(super) fn work<R: Real>(rows: &[ContactRow<R>], means: &[R::Vec3]) -> Contacts {
    work_of(rows, means, |row| row.impulse() - row.booked)
}

/// Books the work of the impulses that acted in the stages of a substep, at its mean velocities.
pub(super) fn work_of_stages<R: Real>(rows: &[ContactRow<R>], means: &[R::Vec3]) -> Contacts {
    work_of(rows, means, |row| row.booked)
}

fn work_of<R: Real>(
    rows: &[ContactRow<R>],
    means: &[R::Vec3],
    impulse: impl Fn(&ContactRow<R>) -> R::Vec3,
) -> Contacts {
    let mut contacts = Contacts::default();
    for row in rows {
        let impulse = impulse(row);
        if impulse == R::Vec3::ZERO {
            continue;
        }
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
    for row in rows.iter().filter(|row| row.is_of_features() && row.gap < allowed(row)) {
        let way = row.relative(points).dot(row.normal) - row.stop - row.gap;
        let missing = (allowed(row) - row.gap) * fraction - way;
        if R::ZERO < missing {
            row.give(points, inverse_masses, row.normal * (missing * row.mass));
            moves = true;
        }
    }
    moves
}
