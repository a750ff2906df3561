//! The rows of a model, and the moments at which methods ask them.

use super::find::{At, Finder};
use super::lists::{Candidates, diagonal};
use super::row::{ContactRow, RowImpulse};
use super::{Shells, sweep};
use crate::columns::vector;
use crate::contact::Contacts;
use crate::number::{Real, Vector};
use alloc::vec::Vec;

/// The rows of a model.
#[derive(Clone, Debug)]
pub(crate) struct ShellRows<R: Real> {
    rows: Vec<ContactRow<R>>,
    /// The rows of the substep before.
    last: Vec<ContactRow<R>>,
    lists: Candidates<R>,
    /// Vertices in rows.
    used: Vec<u32>,
}

impl<R: Real> Default for ShellRows<R> {
    fn default() -> Self {
        let (rows, last, used) = (Vec::new(), Vec::new(), Vec::new());
        ShellRows { rows, last, lists: Candidates::default(), used }
    }
}

impl<R: Real> ShellRows<R> {
    /// Discards the lists: features are other ones.
    pub(crate) fn forget(&mut self) {
        self.lists.forget();
    }

    /// The impulses from which the next substep starts.
    pub(crate) fn impulses(&self) -> Vec<RowImpulse> {
        let mut impulses = Vec::new();
        self.keep(&mut impulses);
        impulses
    }

    /// Overwrites `impulses` with those from which the next substep starts.
    pub(crate) fn keep(&self, impulses: &mut Vec<RowImpulse>) {
        impulses.clear();
        let given = self.rows.iter().filter(|row| row.push != R::ZERO);
        let impulse = |row: &ContactRow<R>| RowImpulse {
            key: row.key,
            push: row.push.to_f64(),
            rub: row.rub.to_f64(),
        };
        impulses.extend(given.map(impulse));
    }

    /// Scales these impulses to another substep.
    pub(crate) fn scale(&mut self, factor: f64) {
        let factor = R::of(factor);
        for row in &mut self.rows {
            (row.push, row.rub) = (row.push * factor, row.rub * factor);
        }
    }

    /// Replaces these impulses, in the order of their keys.
    pub(crate) fn set_impulses(&mut self, impulses: &[RowImpulse]) {
        let row = |impulse: &RowImpulse| ContactRow {
            key: impulse.key,
            push: R::of(impulse.push),
            rub: R::Vec3::of(impulse.rub),
            ..ContactRow::default()
        };
        self.rows.clear();
        self.rows.extend(impulses.iter().map(row));
    }

    /// Lets shells meet after a kick of `length` seconds by some forces, before a drift of `h`
    /// seconds, and returns whether particles are so fast that some may have crossed.
    pub(crate) fn meet(
        &mut self,
        at: &At<'_, R>,
        [positions, velocities]: [&mut [R]; 2],
        forces: &[R],
        (length, h): (R, R),
    ) -> (Contacts, bool) {
        let is_fast = self.find(at, [positions, velocities, &[]], h);
        let (rows, w) = (&mut self.rows, at.inverse_masses);
        sweep::note(rows, [velocities, forces, w], length);
        sweep::give(rows, velocities, w);
        sweep::sweep(rows, velocities, w, Some(h));
        sweep::part(rows, positions, w, h);
        (sweep::work(rows, velocities), is_fast)
    }

    /// Lets the rows of the substep hold after a kick that no drift follows, where their particles
    /// are now.
    pub(crate) fn hold(
        &mut self,
        at: &At<'_, R>,
        (positions, velocities): (&[R], &mut [R]),
        (forces, length): (&[R], R),
    ) -> Contacts {
        self.follow(at, positions);
        let (rows, w) = (&mut self.rows, at.inverse_masses);
        sweep::note(rows, [velocities, forces, w], length);
        sweep::give(rows, velocities, w);
        sweep::sweep(rows, velocities, w, None);
        sweep::work(rows, velocities)
    }

    /// Adds the impulses as forces that act for h seconds.
    pub(crate) fn add_forces(&self, forces: &mut [R], h: R) {
        sweep::add_forces(&self.rows, forces, R::ONE / h);
    }

    /// Corrects the outcome of a substep in the stages of which these forces acted, by its mean
    /// velocities, and then its last ones.
    pub(crate) fn end(
        &mut self,
        at: &At<'_, R>,
        [positions, velocities, means]: [&mut [R]; 3],
        h: R,
    ) -> Contacts {
        let (rows, w) = (&mut self.rows, at.inverse_masses);
        rows.iter_mut().for_each(|row| row.booked = row.impulse());
        sweep::sweep(rows, means, w, Some(h));
        for row in rows.iter_mut() {
            let change = row.impulse() - row.booked;
            if change != R::Vec3::ZERO {
                row.give(velocities, w, change);
                row.give(positions, w, change * h);
            }
            (row.before, row.booked) = (row.velocity(means), R::Vec3::ZERO);
        }
        let contacts = sweep::work(rows, means);
        sweep::part(rows, positions, w, h);
        self.follow(at, positions);
        let rows = &mut self.rows;
        for row in rows.iter_mut().filter(|row| row.push != R::ZERO) {
            (row.before, row.booked) = (row.velocity(velocities), row.impulse());
        }
        sweep::sweep(rows, velocities, w, None);
        contacts + sweep::work(rows, velocities)
    }

    /// Lets the rows of the substep hold velocities that are predicted for its end; they keep their
    /// impulses.
    pub(crate) fn hold_predicted(&mut self, velocities: &mut [R], inverse_masses: &[R]) {
        self.last.clear();
        self.last.extend_from_slice(&self.rows);
        sweep::give(&self.last, velocities, inverse_masses);
        sweep::sweep(&mut self.last, velocities, inverse_masses, None);
    }

    /// Finds the rows at a state that drifts for h seconds, each with the impulse that it gave
    /// last, and returns whether particles are so fast that some may cross.
    ///
    /// Forces count where the drift is faster than the velocities by them; empty where they do not.
    pub(crate) fn find(
        &mut self,
        at: &At<'_, R>,
        [positions, velocities, forces]: [&[R]; 3],
        h: R,
    ) -> bool {
        let shells = at.shells;
        let mut margin = self.margin(shells, velocities, h);
        if !forces.is_empty() {
            let kick = |place: usize| vector::<R>(forces, place) * (at.inverse_masses[place] * h);
            let kicks = shells.vertices.iter().map(|vertex| kick(vertex.at as usize));
            margin += diagonal::<R>(kicks.chain([R::Vec3::ZERO])) * h;
        }
        let most = R::of(MOST_MARGIN * shells.reach());
        core::mem::swap(&mut self.rows, &mut self.last);
        self.rows.clear();
        // In a run that diverges nothing is near anything.
        if !margin.to_f64().is_finite() {
            return true;
        }
        let is_fast = most < margin;
        let margin = margin.min(most);
        let are_all = self.lists.serve(shells, positions, margin);
        let mut found = Finder {
            at,
            positions,
            margin,
            rows: core::mem::take(&mut self.rows),
            used: core::mem::take(&mut self.used),
        };
        found.used.clear();
        self.lists.close.facing.iter().for_each(|&pair| found.face(pair));
        self.lists.close.ending.iter().for_each(|&pair| found.end(pair));
        self.lists.close.crossing.iter().for_each(|&pair| found.edges(pair));
        found.rows.sort_unstable_by_key(|row| row.key);
        found.rows.dedup_by_key(|row| row.key);
        found.obstacles();
        (self.rows, self.used) = (found.rows, found.used);
        self.warm();
        is_fast || !are_all
    }

    /// Lets the rows that have given an impulse follow their features to where these are now.
    fn follow(&mut self, at: &At<'_, R>, positions: &[R]) {
        let found = Finder {
            at,
            positions,
            margin: R::LARGEST.sqrt() * R::HALF,
            rows: Vec::new(),
            used: Vec::new(),
        };
        for row in self.rows.iter_mut().filter(|row| 1 < row.count && row.push != R::ZERO) {
            if let Some((new, _)) = found.row(row.key) {
                *row = ContactRow { push: row.push, rub: row.rub, ..new };
                row.rub -= row.normal * row.normal.dot(row.rub);
            }
        }
    }

    /// Gives each row the impulse of that of the substep before between the same features.
    fn warm(&mut self) {
        let mut last = self.last.iter().peekable();
        for row in &mut self.rows {
            while last.next_if(|before| before.key < row.key).is_some() {}
            if let Some(before) = last.next_if(|before| before.key == row.key) {
                row.push = before.push;
                row.rub = before.rub - row.normal * row.normal.dot(before.rub);
            }
        }
    }

    /// How much closer two particles of shells, or one and an obstacle that stands still, can come
    /// in h seconds, metres.
    fn margin(&self, shells: &Shells, velocities: &[R], h: R) -> R {
        let each = shells.vertices.iter().map(|vertex| vector::<R>(velocities, vertex.at as usize));
        diagonal::<R>(each.chain([R::Vec3::ZERO])) * h * R::of(SPARE)
    }
}

/// More than the part by which particles get faster in a sweep.
const SPARE: f64 = 1.1;
/// The largest margin of a row, in reaches: beyond it lists would be of no use.
const MOST_MARGIN: f64 = 20.0;
