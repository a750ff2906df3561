//! Table of spring constants in the order of the rows, in sixteens.

use super::layout::{Layout, NOWHERE};
use crate::columns::LANES;
use crate::number::Real;
use alloc::vec;
use alloc::vec::Vec;

/// The numbers of rows in sixteens, those that are alike in all lanes once.
pub(super) struct Table<R> {
    pub(super) values: Vec<R>,
    /// Numbers that are alike in all lanes, and where.
    uniform: Vec<(R, u32)>,
    rows: usize,
}

/// Uniform sixteens that are searched before a new one is added.
const MOST_UNIFORM: usize = 16;

impl<R: Real> Table<R> {
    pub(super) fn new(layout: &Layout) -> Self {
        Table { values: Vec::new(), uniform: Vec::new(), rows: layout.rows.len() }
    }

    /// Adds a number that all springs share.
    pub(super) fn add_alike(&mut self, layout: &mut Layout, column: usize, value: R) {
        for row in &mut layout.rows {
            row.values[column] = self.place(value, true);
        }
    }

    /// Adds one number of every spring and notes in each row where it is.
    pub(super) fn add(&mut self, layout: &mut Layout, column: usize, value: impl Fn(usize) -> R) {
        let mut first: Vec<Option<R>> = vec![None; self.rows];
        let mut alike = vec![true; self.rows];
        let places = layout.places.iter().enumerate().filter(|row| *row.1 != NOWHERE);
        for (spring, &place) in places.clone() {
            let row = place as usize / LANES;
            let value = value(spring);
            let first = *first[row].get_or_insert(value);
            // By their bits: minus zero is not zero.
            alike[row] &= same(value, first);
        }
        for (row, first) in first.into_iter().enumerate() {
            let first = first.unwrap_or(R::ZERO);
            layout.rows[row].values[column] = self.place(first, alike[row]);
        }
        for (spring, &place) in places {
            let (row, lane) = (place as usize / LANES, place as usize % LANES);
            if !alike[row] {
                let sixteen = layout.rows[row].values[column] as usize;
                self.values[sixteen * LANES + lane] = value(spring);
            }
        }
    }

    /// The place of sixteen numbers, known ones if they are alike.
    fn place(&mut self, first: R, alike: bool) -> u32 {
        let known = self.uniform.iter().find(|&&(value, _)| same(value, first));
        if let (true, Some(&(_, place))) = (alike, known) {
            return place;
        }
        let place = (self.values.len() / LANES) as u32;
        self.values.extend([first; LANES]);
        if alike && self.uniform.len() < MOST_UNIFORM {
            self.uniform.push((first, place));
        }
        place
    }
}

fn same<R: Real>(a: R, b: R) -> bool {
    a.to_le_bytes().into_iter().eq(b.to_le_bytes())
}
