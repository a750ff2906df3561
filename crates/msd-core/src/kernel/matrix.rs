//! Where does an implicit method keep its matrix and its solve? In columns of slots beside those of
//! the motion, made when they are first asked for.

use super::columns::Columns;
use super::dispatch::run_task;
use super::solve::{
    CHANGE, COLUMNS, DIAGONAL, DIRECTION, HELD, INVERSE, LINK, Matrix, PRODUCT, RESIDUAL, Task,
};
use super::sweep::{Job, MASS};
use super::{Kernel, spread, taken};
use crate::real::{Real, Vector};
use crate::system::{Model, Motion};
use crate::tangent::grab_weight;

/// The columns of a solve.
#[derive(Clone, Debug)]
pub(super) struct Solve<R> {
    columns: Columns<R>,
    links: Columns<R>,
    /// Whether contact holds any particle, so that the blocks are not all inverses.
    held: bool,
}

impl<R: Real> Solve<R> {
    /// No columns, which is all that an explicit method needs.
    pub(super) fn none(slices: usize) -> Self {
        Solve { columns: Columns::new(0, slices), links: Columns::new(0, 0), held: false }
    }
}

impl<R: Real> Kernel<R> {
    /// Makes the matrix of a stage of `tau` seconds about the motion of the last evaluation of
    /// forces; see [`crate::tangent::Tangent`].
    pub fn linearise(&mut self, model: &Model<R>, tau: R) {
        let slices = self.plan.slices();
        if !self.solve.columns.has(COLUMNS) {
            let links = Columns::new(1, LINK * self.plan.rows.len());
            self.solve = Solve { columns: Columns::new(COLUMNS, slices), links, held: false };
        }
        let diagonals = self.solve.columns.column_mut(DIAGONAL);
        for (diagonal, &mass) in diagonals.iter_mut().zip(self.fixed.column(MASS)) {
            *diagonal = mass + tau * model.drag;
        }
        for grab in &model.grabs {
            let (position, velocity) = self.brought(grab.particle);
            let slot = self.plan.slot(grab.particle);
            let diagonals = self.solve.columns.column_mut(DIAGONAL);
            diagonals[slot] += grab_weight(grab, (position, velocity), tau);
        }
        self.solve.held = false;
        self.run(model, Task::Linearise { tau });
    }

    /// Overwrites `product` with that of the matrix and `x`, and returns their scalar product.
    ///
    /// The same numbers as [`crate::tangent::Tangent::set_product`].
    pub fn set_product(&mut self, model: &Model<R>, x: &[R::Vec3], product: &mut [R::Vec3]) -> f64 {
        let columns = self.solve.columns.three_mut(DIRECTION);
        spread(self.plan.slots(), columns, x.iter().copied());
        if !self.plan.others.is_empty() {
            let [xs, ys, zs] = self.solve.columns.three_mut(DIRECTION);
            let records = self.records[1].flat_mut().as_chunks_mut::<{ super::RECORD }>().0;
            for (((record, &x), &y), &z) in records.iter_mut().zip(&*xs).zip(&*ys).zip(&*zs) {
                record[..3].copy_from_slice(&[x, y, z]);
            }
        }
        let sum = self.multiply(model);
        let columns = [0, 1, 2].map(|axis| self.solve.columns.column(PRODUCT + axis));
        taken(self.plan.slots(), columns, product, |to, from| *to = from);
        sum
    }

    /// The inverse of the block of a particle in the matrix, columns; zero where it is pinned.
    pub fn inverse(&self, particle: usize) -> [R::Vec3; 3] {
        let slot = self.plan.slot(particle as u32);
        let number = |number| self.solve.columns.column(INVERSE + number)[slot];
        let column = |numbers: [usize; 3]| R::Vec3::from_components(numbers.map(number));
        [column([0, 1, 2]), column([1, 3, 4]), column([2, 4, 5])]
    }

    /// Steers a particle by another block than its inverse until the next [`Kernel::release`].
    pub(crate) fn hold(&mut self, particle: usize, [a, b, c]: [R::Vec3; 3]) {
        let columns = &mut self.solve.columns;
        if !self.solve.held {
            self.solve.held = true;
            columns.copy(INVERSE..HELD, HELD);
        }
        let slot = self.plan.slot(particle as u32);
        let ([xx, xy, xz], [_, yy, yz], [_, _, zz]) =
            (a.components(), b.components(), c.components());
        for (number, value) in [xx, xy, xz, yy, yz, zz].into_iter().enumerate() {
            columns.column_mut(HELD + number)[slot] = value;
        }
    }

    /// Steers all particles by the inverses of their blocks.
    pub(crate) fn release(&mut self) {
        self.solve.held = false;
    }

    /// Starts a solve without any change, with the momentum that each particle still misses.
    pub(crate) fn set_residuals(&mut self, residuals: impl Iterator<Item = R::Vec3>) {
        let columns = &mut self.solve.columns;
        columns.three_mut(CHANGE).into_iter().for_each(|column| column.fill(R::ZERO));
        spread(self.plan.slots(), columns.three_mut(RESIDUAL), residuals);
    }

    /// The momentum that a particle still misses, kilogram metres per second.
    pub(crate) fn residual(&self, particle: usize) -> R::Vec3 {
        self.vector(RESIDUAL, particle)
    }

    /// Adds to the momentum that a particle still misses.
    pub(crate) fn add_residual(&mut self, particle: usize, momentum: R::Vec3) {
        let slot = self.plan.slot(particle as u32);
        let columns = self.solve.columns.three_mut(RESIDUAL);
        for (column, add) in columns.into_iter().zip(momentum.components()) {
            column[slot] += add;
        }
    }

    /// The change of velocity found for a particle, metres per second.
    pub(crate) fn change(&self, particle: usize) -> R::Vec3 {
        self.vector(CHANGE, particle)
    }

    /// Adds the changes found to velocities, metres per second.
    pub(crate) fn add_changes(&self, velocities: &mut [R::Vec3]) {
        let columns = [0, 1, 2].map(|axis| self.solve.columns.column(CHANGE + axis));
        taken(self.plan.slots(), columns, velocities, |velocity, change| *velocity += change);
    }

    /// Takes the direction of the residual, and measures it in the norm of the blocks, squared.
    pub(crate) fn aim(&mut self, model: &Model<R>) -> f64 {
        self.run(model, Task::Aim)
    }

    /// Multiplies the direction with the matrix, and returns the scalar product of both.
    pub(crate) fn multiply(&mut self, model: &Model<R>) -> f64 {
        self.run(model, Task::Multiply)
    }

    /// Goes along the direction, and measures the residual left as [`Kernel::aim`] does.
    pub(crate) fn descend(&mut self, model: &Model<R>, distance: R) -> f64 {
        self.run(model, Task::Descend { distance })
    }

    /// Takes the direction of the residual and so much of the one before.
    pub(crate) fn turn_from(&mut self, model: &Model<R>, keep: R) {
        self.run(model, Task::Turn { keep });
    }

    /// Measures the power that the dampers take away at a motion, watts.
    pub(crate) fn damper_power(&mut self, model: &Model<R>, motion: Motion<'_, R>) -> f64 {
        if !self.plan.damped {
            return 0.0;
        }
        self.bring(motion);
        // Each damper is met from both ends.
        0.5 * self.run(model, Task::Damp)
    }

    fn vector(&self, column: usize, particle: usize) -> R::Vec3 {
        let slot = self.plan.slot(particle as u32);
        let axes = [0, 1, 2].map(|axis| self.solve.columns.column(column + axis)[slot]);
        R::Vec3::from_components(axes)
    }

    fn run(&mut self, model: &Model<R>, task: Task<R>) -> f64 {
        let Solve { columns, links, held } = &mut self.solve;
        let [motion, _] = &mut self.motions;
        let own = columns.start();
        let far = super::NEAR_BYTES < self.records[1].bytes();
        let records = self.records.each_mut().map(|records| records.flat_mut().as_mut_ptr());
        let (from, records) = match task {
            Task::Linearise { .. } | Task::Damp => (motion.start(), records),
            _ => (own.from(DIRECTION), [records[1]; 2]),
        };
        let job = Job {
            plan: &self.plan,
            fixed: self.fixed.start(),
            from,
            to: own,
            own,
            records,
            fields: [model.gravity, model.force],
            drag: model.drag,
            far,
            pushes: &[],
            planes: &[],
        };
        let blocks = if *held { HELD } else { INVERSE };
        let matrix = Matrix { job, links: links.start(), blocks };
        // SAFETY: the instructions were made to be within reach, and the columns are borrowed.
        unsafe { run_task(self.instructions, &matrix, task) }
    }
}
