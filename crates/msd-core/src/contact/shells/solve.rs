//! Rows inside an implicit solve: their impulses, and the stiffness that finds them.
//!
//! A solve finds the minimum of a quadratic function of velocities, which the rows limit. It is an
//! augmented Lagrangian: a row that acts has an impulse and, in the matrix, the stiffness of its
//! particles. The amount by which a solve violates a limit, times the stiffness, corrects the
//! impulse; none of the stiffness remains at the end. The impulses are corrected only once solves
//! agree on which rows act and which slide. Before, the correction would be far too large, as a
//! body yields more than its particles do. A row that slides has a part of its stiffness across the
//! normal. A row that acts in one solve and not in the next keeps its stiffness. So each solve
//! minimises an upper bound that equals the function where the last solve ended: it never goes up.
//!
//! Sources: Hestenes, 1969, and Powell, 1969 (augmented Lagrangian); Alart and Curnier, 1991
//! (with Coulomb's law).

use super::Shells;
use super::features::At;
use super::find::Finder;
use super::patch::{gather, scatter};
use super::row::{ContactRow, InSolve, add_shares};
use super::rows::ShellRows;
use super::sweep;
use crate::columns::{Aligned, vector};
use crate::contact::Contacts;
use crate::number::{Real, Vector};

impl<R: Real> ShellRows<R> {
    /// Finds the rows that a drift of h seconds at some velocities may close, each with its
    /// impulse. Returns whether particles are so fast that some may cross.
    pub(crate) fn find_for_solve(&mut self, at: &At<'_, R>, motion: [&[R]; 2], h: R) -> bool {
        let [positions, velocities] = motion;
        let least = R::of(at.shells.reach() * LEAST_MARGIN);
        let columns = [positions, velocities, velocities];
        let is_fast = self.find(at, columns, (R::ZERO, h, least));
        // The solve itself holds particles that lie on an obstacle.
        self.rows.retain(|row| !row.is_of_obstacle());
        is_fast
    }

    /// Sets the speeds at which sides part that meet in this substep, by the velocities at its
    /// start.
    pub(crate) fn set_partings(&mut self, shells: &Shells, velocities: &[R]) {
        if 0.0 < shells.most_restitution {
            self.keep_starts(shells, velocities);
            let starts = &self.patch.before[..];
            sweep::set_partings(&mut self.rows, [starts, starts], R::ONE);
        }
    }

    /// Sets the stiffness of each row to that of its particles along the normal, by the inverses of
    /// their blocks of the matrix.
    pub(crate) fn set_stiffness(&mut self, shells: &Shells, [upper, lower]: &[Aligned<R>; 2]) {
        let of = |row: &ContactRow<R>| {
            let mut yielding = R::ZERO;
            for (&vertex, weight) in row.vertices.iter().zip(row.weights) {
                let at = shells.vertices[vertex as usize].at as usize;
                let [a, b] = [upper, lower].map(|column| vector::<R>(column, at).components());
                let columns = [a, [a[1], b[0], b[1]], [a[2], b[1], b[2]]];
                let part = columns.map(|column| R::Vec3::from_components(column).dot(row.normal));
                yielding += weight * weight * R::Vec3::from_components(part).dot(row.normal);
            }
            let (push, rub) = (row.push, row.rub);
            InSolve { stiffness: R::ONE / yielding, push, rub, ..InSolve::default() }
        };
        self.in_solve.clear();
        self.in_solve.extend(self.rows.iter().map(of));
    }

    /// Sets the impulses for the next solve by velocities and changes of them. Returns the largest
    /// velocity that these impulses are to take away, metres per second.
    pub(crate) fn press(&mut self, at: &At<'_, R>, motion: [&[R]; 2], h: R) -> R {
        self.answer(at, motion, h)[0]
    }

    /// Sets the impulses by the velocities that a solve left, and corrects those from which the
    /// next one starts if solves agree. Returns the largest velocity by which it missed, metres per
    /// second.
    pub(crate) fn correct(&mut self, at: &At<'_, R>, motion: [&[R]; 2], h: R) -> R {
        let [missed, off] = self.answer(at, motion, h);
        if off <= missed * R::HALF {
            for (row, solved) in self.rows.iter().zip(&mut self.in_solve) {
                (solved.push, solved.rub) = (row.push, row.rub);
            }
        }
        missed.max(off)
    }

    /// Takes back the impulses for a next solve.
    pub(crate) fn take_back(&mut self) {
        for (row, solved) in self.rows.iter_mut().zip(&self.in_solve) {
            (row.push, row.rub) = (solved.push, solved.rub);
        }
    }

    /// Sets the impulse with which each row answers velocities. Returns, over the stiffness, the
    /// largest difference from the impulses as last corrected, and from those that the solve found.
    fn answer(&mut self, at: &At<'_, R>, [velocities, changes]: [&[R]; 2], h: R) -> [R; 2] {
        let mut now = core::mem::take(&mut self.patch.velocities);
        for &vertex in &self.lists.vertices {
            let place = at.shells.vertices[vertex as usize].at as usize;
            now[vertex as usize] = vector::<R>(velocities, place) + vector::<R>(changes, place);
        }
        let finder = Finder::new(at, &self.patch, R::ZERO);
        let mut most = [R::ZERO; 2];
        for (row, solved) in self.rows.iter_mut().zip(&mut self.in_solve) {
            let (velocity, may_close) = (row.velocity(&now), row.gap.max(R::ZERO) / h);
            let least = if R::ZERO < row.parting { -row.parting } else { may_close };
            solved.found = row.impulse();
            if solved.is_stiff {
                solved.found -= solved.resist(row.normal, velocity - solved.velocity);
            } else if solved.push == R::ZERO
                && (row.is_open(&now, may_close) || finder.passes(row, velocity, h))
            {
                continue;
            }
            if !row.turns {
                finder.turn(row);
            }
            let velocity = row.velocity(&now);
            (row.push, row.rub) = (solved.push, solved.rub);
            let before = [row.impulse(), solved.found];
            let (push, rub, grip) = row.answer(velocity, least, solved.stiffness);
            (row.push, row.rub, solved.velocity) = (push, rub, velocity);
            for (most, before) in most.iter_mut().zip(before) {
                let change = row.impulse() - before;
                *most = most.max(change.dot(change).sqrt() / solved.stiffness);
            }
            let acts = push != R::ZERO;
            solved.changes += u32::from(acts != solved.is_stiff);
            solved.is_stiff = acts || MOST_CHANGES < solved.changes;
            solved.grip = if acts { grip } else { R::ZERO };
        }
        self.patch.velocities = now;
        most
    }

    /// Adds the impulses that the last solve found to a column.
    pub(crate) fn add_found(&self, shells: &Shells, column: &mut [R]) {
        for (row, solved) in self.rows.iter().zip(&self.in_solve) {
            add_shares(row, shells, solved.found, column);
        }
    }

    /// Adds the products of the stiffness of the rows and a direction.
    pub(crate) fn add_products(&mut self, shells: &Shells, direction: &[R], products: &mut [R]) {
        let ShellRows { rows, in_solve, lists, patch, .. } = self;
        if rows.is_empty() {
            return;
        }
        gather((shells, &lists.vertices), direction, &mut patch.velocities);
        for (row, solved) in rows.iter().zip(in_solve).filter(|(_, solved)| solved.is_stiff) {
            let product = solved.resist(row.normal, row.relative(&patch.velocities));
            add_shares(row, shells, product, products);
        }
    }

    /// Keeps the velocities at the start of the substep.
    pub(crate) fn keep_starts(&mut self, shells: &Shells, velocities: &[R]) {
        gather((shells, &self.lists.vertices), velocities, &mut self.patch.before);
    }

    /// Ends a substep of these mean velocities, in the solve of which the impulses acted. Where it
    /// `mirrors` velocities, the rows hold those at its end: a particle that came would leave as
    /// fast.
    ///
    /// They hold along the normals that the solve had. At the end of a long substep the features of
    /// a row need not be the nearest ones any more.
    pub(crate) fn end_solved(
        &mut self,
        at: &At<'_, R>,
        ([positions, velocities], means): ([&mut [R]; 2], &[R]),
        (h, mirrors): (R, bool),
    ) -> Contacts {
        let ShellRows { rows, lists, patch, .. } = self;
        let vertices = (at.shells, &lists.vertices[..]);
        gather(vertices, means, &mut patch.velocities);
        let contacts = match mirrors {
            true => sweep::work(rows, &patch.velocities),
            false => sweep::work(rows, patch.means(vertices.1)),
        };
        gather(vertices, positions, &mut patch.points);
        if sweep::part(rows, &mut patch.points, &patch.inverse_masses, h) {
            scatter(vertices, &patch.points, positions);
        }
        if !mirrors {
            rows.iter_mut().for_each(|row| row.parting = R::ZERO);
            return contacts;
        }
        gather(vertices, velocities, &mut patch.velocities);
        contacts + self.hold_last(at.shells, velocities)
    }
}

/// The least margin of a row, in reaches: a resting contact has no velocities by which to find it.
const LEAST_MARGIN: f64 = 0.1;
/// Number of times that a row may begin or cease to act before it keeps its stiffness.
const MOST_CHANGES: u32 = 3;
