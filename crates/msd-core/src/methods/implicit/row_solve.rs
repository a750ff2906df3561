//! Rows of shells inside the solve of an implicit substep.
//!
//! Rows limit the mean velocity of the substep, which is that of the stage: both methods move
//! positions by h u. Each pass solves with the stiffness of the rows that act, and corrects their
//! impulses (see `contact/shells/solve.rs`). The velocities at the end may ask for rows that those
//! at the start did not: once the passes have settled, rows are found again.

use super::conjugate::Solve;
use super::resting::Holds;
use super::tangent::Tangent;
use crate::columns::Aligned;
use crate::contact::shells::{At, ShellRows};
use crate::elements::Stage;
use crate::number::Real;
use crate::system::Model;

/// The rows of a Newton iteration.
pub(super) struct RowSolve<'a, R: Real> {
    pub(super) rows: &'a mut ShellRows<R>,
    pub(super) at: At<'a, R>,
    /// Length of the substep, seconds.
    pub(super) h: R,
    /// Gravity, metres per second squared.
    pub(super) gravity: R,
    /// The positions at the start of the substep, and the velocities of the stage before the solve.
    pub(super) positions: &'a [R],
    pub(super) velocities: &'a [R],
    /// The momentum missing before the solve, without impulses of rows, kilogram metres per second.
    pub(super) missing: &'a mut Aligned<R>,
    /// The speed by which a row may miss, metres per second.
    pub(super) least: R,
    /// Whether particles are too fast for shells to be known to stop them.
    pub(super) is_fast: bool,
}

/// The speed by which a row may miss, as a fraction of the speed that gravity adds in a substep, or
/// of the miss of the first pass. The next substep starts from the impulses of this one, so at rest
/// nothing of it is left. A tenth of it takes twice the iterations and changes no figure in
/// `docs/explanation/contact.md`.
const TOLERANCE: f64 = 1e-2;

/// The way by which a row may miss in a substep before particles count as too fast, as a part of
/// the largest distance at which two shells stop each other.
const MOST_MISSED: f64 = 0.5;

impl<R: Real> RowSolve<'_, R> {
    pub(super) fn has_shells(&self) -> bool {
        self.at.shells.do_meet()
    }

    /// Adds the impulses for the first pass to the residuals.
    pub(super) fn begin(&mut self, inverses: &[Aligned<R>; 2], solve: &mut Solve<R>) {
        if self.has_shells() {
            self.missing.copy_from_slice(&solve.residuals);
            self.rows.set_stiffness(self.at.shells, inverses);
            self.rows.press(&self.at, [self.velocities, &solve.changes], self.h);
            self.rows.add_forces(self.at.shells, &mut solve.residuals, R::ONE);
        }
    }

    /// Corrects impulses after a pass; returns whether the solve has to go on. Leaves the impulses
    /// that the pass has found in the products.
    pub(super) fn review(
        &mut self,
        inverses: &[Aligned<R>; 2],
        solve: &mut Solve<R>,
        (pass, is_last): (usize, bool),
    ) -> bool {
        let motion = [self.velocities, &*solve.changes];
        let missed = self.rows.correct(&self.at, motion, self.h);
        if pass == 1 {
            self.least = R::of(TOLERANCE) * missed.max(self.h * self.gravity);
        }
        let misses = self.least < missed;
        solve.products.fill(R::ZERO);
        self.rows.add_found(self.at.shells, &mut solve.products);
        if is_last {
            self.is_fast |= self.at.shells.reach() * MOST_MISSED < (missed * self.h).to_f64();
            return misses;
        }
        if misses {
            self.rows.press(&self.at, motion, self.h);
            return true;
        }
        self.finds_others(inverses, solve)
    }

    /// Sets the residuals from which the solve goes on.
    pub(super) fn renew(
        &mut self,
        (model, stage, tangent): (&Model<R>, &Stage<'_, R>, &mut Tangent<R>),
        (solve, holds): (&mut Solve<R>, &mut Holds<R>),
    ) {
        let Solve { residuals, changes, products, .. } = solve;
        tangent.set_products(model, stage, changes, products);
        for ((residual, missing), product) in
            residuals.iter_mut().zip(&**self.missing).zip(&**products)
        {
            *residual = *missing - *product;
        }
        self.rows.add_forces(self.at.shells, residuals, R::ONE);
        holds.renew(residuals);
    }

    /// Finds the rows at the velocities that a solve left; returns whether new ones miss. All then
    /// have the impulses for the next pass.
    fn finds_others(&mut self, inverses: &[Aligned<R>; 2], solve: &mut Solve<R>) -> bool {
        let Solve { changes, directions, .. } = solve;
        for ((sum, velocity), change) in directions.iter_mut().zip(self.velocities).zip(&**changes)
        {
            *sum = *velocity + *change;
        }
        self.is_fast = self.rows.find_for_solve(&self.at, [self.positions, directions], self.h);
        self.rows.set_stiffness(self.at.shells, inverses);
        let misses = self.least < self.rows.press(&self.at, [self.velocities, changes], self.h);
        if !misses {
            self.rows.take_back();
        }
        misses
    }
}
