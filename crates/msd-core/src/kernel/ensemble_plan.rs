//! In which order are the springs of an ensemble evaluated, and where are their numbers?

use super::LANES;
use super::columns::{Columns, Slice};
use crate::forces::Incidence;
use crate::real::Real;
use crate::system::{Column, Model};
use alloc::vec;
use alloc::vec::Vec;

/// A spring of every copy: the particles at its ends, and the rows of the numbers of its lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pull {
    pub(super) ends: [u32; 2],
    pub(super) rest_length: u32,
    pub(super) stiffness: u32,
    pub(super) damping: u32,
}

/// Springs in an order in which each particle meets its own as in the model, hence with the same
/// bits, but soon after one another, so that what they read is still near.
///
/// A spring may come when it is the next of both its ends. Of those, the one that came up last goes
/// first: what has just been read is read again.
pub(crate) fn order<R: Real>(model: &Model<R>) -> Vec<u32> {
    let incidence = Incidence::new(model);
    let mut met = vec![0usize; model.particle_count()];
    let next = |met: &[usize], particle: u32| {
        let row = incidence.of(particle as usize).get(met[particle as usize]);
        row.map(|&[spring, _]| spring)
    };
    let (mut order, mut ready) = (Vec::with_capacity(model.spring_count()), Vec::new());
    for (first, ends) in model.ends.iter().enumerate() {
        let is_next = |met: &[usize], spring: u32| {
            model.ends[spring as usize].iter().all(|&end| next(met, end) == Some(spring))
        };
        let first = first as u32;
        if ends.iter().all(|&end| next(&met, end) == Some(first)) {
            ready.push(first);
        }
        while let Some(spring) = ready.pop() {
            order.push(spring);
            let [a, b] = model.ends[spring as usize];
            met[a as usize] += 1;
            met[b as usize] += 1;
            let after = [next(&met, b), next(&met, a)];
            let same = after[0] == after[1];
            let after = after.into_iter().skip(usize::from(same)).flatten();
            ready.extend(after.filter(|&spring| is_next(&met, spring)));
        }
    }
    order
}

/// Rows of numbers, one per lane; rows alike are there once.
pub(super) struct Table<R> {
    rows: Vec<[R; LANES]>,
}

/// Rows that are looked up before another is made.
const MOST_KNOWN: usize = 16;

impl<R: Real> Table<R> {
    pub(super) fn new() -> Self {
        Table { rows: Vec::new() }
    }

    /// The place of a row.
    fn place(&mut self, row: [R; LANES]) -> u32 {
        let bits = |row: &[R; LANES]| row.map(|number| number.to_f64().to_bits());
        let known = self.rows.iter().take(MOST_KNOWN).position(|other| bits(other) == bits(&row));
        let place = known.unwrap_or(self.rows.len());
        if place == self.rows.len() {
            self.rows.push(row);
        }
        place as u32
    }

    /// The springs of models, in an order.
    pub(super) fn pulls(&mut self, models: [&Model<R>; LANES], order: &[u32]) -> Vec<Pull> {
        let pull = |&spring: &u32| {
            let spring = spring as usize;
            let each =
                |column: fn(&Model<R>) -> &Column<R>| models.map(|model| column(model).get(spring));
            Pull {
                ends: models[0].ends[spring],
                rest_length: self.place(models.map(|model| model.rest_lengths[spring])),
                stiffness: self.place(each(|model| &model.stiffnesses)),
                damping: self.place(each(|model| &model.dampings)),
            }
        };
        order.iter().map(pull).collect()
    }

    /// The rows as a column.
    pub(super) fn column(self) -> Columns<R> {
        let mut columns = Columns::new(1, self.rows.len());
        let slots = columns.column_mut(0).as_chunks_mut::<LANES>().0;
        slots.copy_from_slice(&self.rows);
        columns
    }
}

/// A number of each model.
pub(super) fn lanes<R: Real>(
    models: [&Model<R>; LANES],
    number: impl Fn(&Model<R>) -> R,
) -> Slice<R> {
    Slice(models.map(number))
}
