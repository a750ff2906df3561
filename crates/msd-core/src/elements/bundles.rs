//! Bundles: up to sixteen stencils at once, whose particles are in the same lane of records, as
//! most of a lattice are.

use crate::columns::{LANES, RECORD};
use crate::number::Real;
use alloc::vec::Vec;
use core::ops::Range;

/// A bundle of fewer would cost more than they do one by one.
const FEWEST: usize = 4;

/// Where the sixteen numbers of each end start, one of them that of its particle in the lane of the
/// first: at the start of a record, or one number on, where a particle is in the next lane. `None`
/// where they are in other lanes, would reach beyond the columns, or where two ends share a record
/// in different lanes: their forces would be added in another order.
pub(super) fn starts<const N: usize>(at: [u32; N], numbers: usize) -> Option<[u32; N]> {
    let lane = at[0] % RECORD as u32;
    let starts = at.map(|at| at.wrapping_sub(lane));
    let fits = |&start: &u32| {
        let start = start as usize;
        start % RECORD <= 1 && start + RECORD <= numbers
    };
    let shares = |a: u32, b: u32| a != b && a / RECORD as u32 == b / RECORD as u32;
    let overlap = (1..N).any(|a| (0..a).any(|b| shares(starts[a], starts[b])));
    (starts.iter().all(fits) && !overlap).then_some(starts)
}

/// Puts rows in the order in which they are evaluated, which depends on them and on where their
/// numbers are alone: first those that fit bundles, then the others. Returns the rows of each
/// bundle.
pub(super) fn order<T: Clone, const N: usize>(
    rows: &mut Vec<T>,
    numbers: usize,
    at: impl Fn(&T) -> [u32; N],
    is_alike: impl Fn(&T, &T) -> bool,
) -> Vec<Range<usize>> {
    let starts = |row: &T| starts(at(row), numbers);
    // Stable: what is equal keeps its order, so that a resumed run has the same sums.
    rows.sort_by_key(|row| (starts(row).is_none(), starts(row), at(row)[0]));
    let fit = |a: &T, b: &T| {
        let is_next = at(a)[0] < at(b)[0] && is_alike(a, b);
        is_next && starts(a).is_some() && starts(a) == starts(b)
    };
    let mut singles = Vec::new();
    let (mut bundled, mut bundles) = (Vec::with_capacity(rows.len()), Vec::new());
    for group in rows.chunk_by(fit) {
        if group.len() < FEWEST {
            singles.extend_from_slice(group);
            continue;
        }
        bundles.push(bundled.len()..bundled.len() + group.len());
        bundled.extend_from_slice(group);
    }
    bundled.append(&mut singles);
    *rows = bundled;
    bundles
}

/// Sixteen components of a record along an axis.
#[inline(always)]
pub(super) fn record<R: Real>(column: &[R], at: u32, axis: usize) -> &[R; LANES] {
    let at = at as usize + axis * LANES;
    column[at..].first_chunk().expect("a record of the column")
}
