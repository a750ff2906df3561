//! The energy of all springs in rows, sixteen at a time, in double precision.

use super::law::{Law, energy};
use super::layout::{Band, Row};
use super::sweep::Input;
use crate::columns::{LANES, RECORD};
use crate::number::Real;

/// Sums over springs, lane by lane: their energy, joules, |k stretch|, newtons, and k, newtons per
/// metre.
pub(super) type Sums = [[f64; LANES]; 3];

/// Adds the springs of all rows.
#[inline(always)]
pub(super) fn add_rows<R: Real>(input: Input<'_, R>, sums: &mut Sums) {
    for band in &input.layout.bands {
        let x = &input.positions[band.numbers.clone()];
        let mut rows = input.layout.rows[band.rows.clone()].iter();
        for step in &input.layout.steps[band.steps.clone()] {
            let at = step.at as usize;
            let here = record(x, at);
            for row in rows.by_ref().take(step.rows as usize) {
                match band.halo {
                    Some(_) => add(sums, here, record(x, row.other as usize), (row, input.values)),
                    None => {
                        let others = &input.layout.others[row.other as usize];
                        let there = gathered(x, band, at, others);
                        add(sums, here, &there, (row, input.values));
                    }
                }
            }
        }
    }
}

/// Sixteen x, y and z from a place on.
#[inline(always)]
fn record<R>(column: &[R], at: usize) -> &[R; RECORD] {
    &column[at..].as_chunks().0[0]
}

/// The positions of ends that are named, counted as [`super::layout::Layout::others`] are.
#[inline(always)]
fn gathered<R: Real>(x: &[R], band: &Band, at: usize, others: &[u32; LANES]) -> [R; RECORD] {
    let mut there = [R::ZERO; RECORD];
    for (lane, &other) in others.iter().enumerate() {
        let (record, slot) = (other as usize / LANES, other as usize % LANES);
        let from = at + record * RECORD - band.reach * RECORD + slot;
        for axis in (0..RECORD).step_by(LANES) {
            there[axis + lane] = x[from + axis];
        }
    }
    there
}

/// Adds the springs of a row.
#[inline(always)]
fn add<R: Real>(
    sums: &mut Sums,
    here: &[R; RECORD],
    there: &[R; RECORD],
    (row, values): (&Row, &[R]),
) {
    let sixteens = values.as_chunks::<LANES>().0;
    let [rests, stiffnesses, _] = row.values.map(|place| &sixteens[place as usize]);
    for lane in 0..LANES {
        let along =
            |axis: usize| there[axis * LANES + lane].to_f64() - here[axis * LANES + lane].to_f64();
        let [x, y, z] = [along(0), along(1), along(2)];
        // The lane of a missing spring may hold any value.
        let is_there = row.mask >> lane & 1 != 0;
        let rest = rests[lane].to_f64();
        let length = if is_there { Real::sqrt(x * x + y * y + z * z) } else { rest };
        let stiffness = if is_there { stiffnesses[lane].to_f64() } else { 0.0 };
        sums[0][lane] += energy(length, Law { rest, stiffness, damping: 0.0 });
        sums[1][lane] += stiffness * (length - rest).abs();
        sums[2][lane] += stiffness;
    }
}
