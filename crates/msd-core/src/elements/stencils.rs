//! Stencils: rows of a few particles that pull together, in the order in which they are evaluated.
//!
//! That order depends on them and on the slots of particles alone: first bundles of up to sixteen
//! whose particles are in the same lane of records, as most of a lattice are, which are evaluated
//! at once; then the others, one by one.

use super::Torn;
use crate::columns::slots::Slots;
use crate::columns::{LANES, RECORD};
use crate::number::Real;
use alloc::vec::Vec;
use core::fmt::Debug;
use core::ops::Range;

/// A bundle of fewer would cost more than they do one by one.
const FEWEST: usize = 4;

/// The law of a stencil of N particles.
pub trait StencilLaw<const N: usize>: Copy + Debug {
    /// Its numbers.
    type Number: Real;
    /// Stencils that are evaluated at once, each in a lane of its own.
    type Bundle: Clone + Debug + Send + Sync;
    /// Makes a bundle of stencils that are alike.
    fn bundle(rows: &[Stencil<Self, N>]) -> Self::Bundle;
    /// Whether two may be in one bundle.
    fn is_alike(&self, other: &Self) -> bool;
    /// Stiffness and damping.
    fn constants(&mut self) -> [&mut Self::Number; 2];
}

/// Some particles, where their numbers are in a column of vectors, and the law between them.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<L, const N: usize> {
    pub(super) particles: [u32; N],
    pub(super) at: [u32; N],
    pub(super) law: L,
}

impl<L: Copy, const N: usize> Stencil<L, N> {
    pub(super) fn new(particles: [usize; N], law: L) -> Self {
        Stencil { particles: particles.map(|particle| particle as u32), at: [0; N], law }
    }

    /// The same stencil where these slots put its particles.
    pub(super) fn placed(&self, slots: &Slots) -> Self {
        Stencil { at: self.particles.map(|particle| slots.at(particle as usize) as u32), ..*self }
    }
}

/// The stencils of one law.
#[derive(Clone, Debug)]
pub struct Stencils<L: StencilLaw<N>, const N: usize> {
    /// In the order of evaluation.
    pub(super) all: Vec<Stencil<L, N>>,
    pub(super) bundles: Vec<L::Bundle>,
    /// How many are in bundles: the first ones.
    bundled: usize,
    /// Numbers of a column of vectors.
    numbers: usize,
    pub(super) is_damped: bool,
}

impl<L: StencilLaw<N>, const N: usize> Default for Stencils<L, N> {
    fn default() -> Self {
        let (all, bundles) = (Vec::new(), Vec::new());
        Stencils { all, bundles, bundled: 0, numbers: 0, is_damped: false }
    }
}

impl<L: StencilLaw<N>, const N: usize> Stencils<L, N> {
    /// The number of stencils.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// Whether any has a damper.
    pub fn is_damped(&self) -> bool {
        self.is_damped
    }

    /// Those that are in no bundle.
    pub(super) fn singles(&self) -> &[Stencil<L, N>] {
        &self.all[self.bundled..]
    }

    /// Adds stencils, and puts all in order anew: the slots may have changed.
    pub(super) fn extend(&mut self, rows: impl Iterator<Item = Stencil<L, N>>, slots: &Slots) {
        self.all.extend(rows);
        self.all.iter_mut().for_each(|row| *row = row.placed(slots));
        self.numbers = slots.record_count() * RECORD;
        self.order();
    }

    /// Removes those of which both ends of a spring that was cut are a part: what is torn does not
    /// go on resisting.
    pub(super) fn tear(&mut self, torn: &Torn) {
        self.retain(|row| !torn.crosses(&row.particles));
    }

    pub(super) fn retain(&mut self, is_left: impl Fn(&Stencil<L, N>) -> bool) {
        let before = self.all.len();
        self.all.retain(is_left);
        if self.all.len() < before {
            self.order();
        }
    }

    /// Changes stiffness and damping of the stencils of some particles.
    pub(super) fn change(
        &mut self,
        of: &Range<usize>,
        change: impl Fn([L::Number; 2]) -> [L::Number; 2],
    ) {
        for row in self.all.iter_mut().filter(|row| of.contains(&(row.particles[0] as usize))) {
            let constants = row.law.constants();
            let changed = change([*constants[0], *constants[1]]);
            constants.into_iter().zip(changed).for_each(|(constant, value)| *constant = value);
        }
        self.order();
    }

    /// Puts them in the order in which they are evaluated, and makes bundles.
    fn order(&mut self) {
        let Stencils { all, bundles, numbers, .. } = self;
        let starts = |row: &Stencil<L, N>| starts(row.at, *numbers);
        // Stable: what is equal keeps its order, so that a resumed run has the same sums.
        all.sort_by_key(|row| (starts(row).is_none(), starts(row), row.at[0]));
        let fit = |a: &Stencil<L, N>, b: &Stencil<L, N>| {
            let is_next = a.at[0] < b.at[0] && a.law.is_alike(&b.law);
            is_next && starts(a).is_some() && starts(a) == starts(b)
        };
        let (mut bundled, mut singles) = (Vec::with_capacity(all.len()), Vec::new());
        bundles.clear();
        for group in all.chunk_by(fit) {
            if group.len() < FEWEST {
                singles.extend_from_slice(group);
                continue;
            }
            bundles.push(L::bundle(group));
            bundled.extend_from_slice(group);
        }
        self.bundled = bundled.len();
        bundled.append(&mut singles);
        *all = bundled;
        self.is_damped = all.iter_mut().any(|row| *row.law.constants()[1] != L::Number::ZERO);
    }
}

/// Where the sixteen numbers of each end start, one of them that of its particle in the lane of the
/// first: at the start of a record, or one number on, where a particle is in the next lane. `None`
/// where they are in other lanes, would reach beyond the columns, or where two ends share a record
/// in different lanes: their forces would be added in another order.
fn starts<const N: usize>(at: [u32; N], numbers: usize) -> Option<[u32; N]> {
    let starts = at.map(|place| place.wrapping_sub(lane(at) as u32));
    let fits = |&start: &u32| {
        let start = start as usize;
        start % RECORD <= 1 && start + RECORD <= numbers
    };
    let shares = |a: u32, b: u32| a != b && a / RECORD as u32 == b / RECORD as u32;
    let overlap = (1..N).any(|a| (0..a).any(|b| shares(starts[a], starts[b])));
    (starts.iter().all(fits) && !overlap).then_some(starts)
}

/// The lane of a stencil in a bundle.
pub(super) fn lane<const N: usize>(at: [u32; N]) -> usize {
    at[0] as usize % RECORD
}

/// Sixteen components of a record along an axis.
#[inline(always)]
pub(super) fn record<R: Real>(column: &[R], at: u32, axis: usize) -> &[R; LANES] {
    let at = at as usize + axis * LANES;
    column[at..].first_chunk().expect("a record of the column")
}

/// Subtracts sixteen numbers along an axis of a record, in those lanes that are there.
#[inline(always)]
pub(super) fn subtract_record<R: Real>(
    (sums, at, axis): (&mut [R], u32, usize),
    less: impl Fn(usize) -> R,
    is_there: impl Fn(usize) -> bool,
) {
    let at = at as usize + axis * LANES;
    let record = sums[at..].first_chunk_mut::<LANES>().expect("a record of the column");
    for lane in 0..LANES {
        let left = record[lane] - less(lane);
        record[lane] = if is_there(lane) { left } else { record[lane] };
    }
}
