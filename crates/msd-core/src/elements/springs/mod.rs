//! Springs with dampers, nearly all of the work of a step.
//!
//! [`law`] is the force of one spring. `sweep` takes sixteen at a time in the order that `layout`
//! has found; `share` gives these to threads. `fused` moves the particles in the same sweep.

pub mod law;
mod unstructured;
pub(crate) mod layout;
mod table;
pub(crate) mod gather;
mod sweep;
mod stored;
mod share;
pub(crate) mod fused;
pub(crate) mod project;
pub(crate) mod matrix;

use crate::columns::slots::Slots;
use crate::columns::threads::merge_shares;
use crate::columns::{Aligned, LANES, single};
use crate::elements::{
    ColumnProducts, Derivatives, Element, Force, ForceWork, MatrixSums, Moment, Motion, Products,
    Projection, Stage, Vectors,
};
use crate::number::{Instructions, Real, Vector, at_level};
use crate::scene::{Scene, Spring};
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use glam::DVec3;
use law::{Law, Tangent};
pub use layout::Sum;
use layout::{Layout, Turn};
use project::Batches;
pub(crate) use share::SpringWork;
use share::{Share, Sweep, sum};
use sweep::Input;
use table::Table;

/// A value per spring, stored once if all springs share it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Values<R> {
    /// One value for every spring.
    Same(R),
    /// A value for each spring.
    Each(Vec<R>),
}

impl<R: Real> Values<R> {
    #[inline]
    pub(crate) fn get(&self, spring: usize) -> R {
        match self {
            Values::Same(value) => *value,
            Values::Each(values) => values[spring],
        }
    }

    pub(crate) fn is_zero(&self) -> bool {
        *self == Values::Same(R::ZERO)
    }

    /// A column has one form only.
    fn collect(values: impl Iterator<Item = R> + Clone) -> Self {
        let first = values.clone().next().unwrap_or(R::ZERO);
        if values.clone().all(|value| value == first) {
            Values::Same(first)
        } else {
            Values::Each(values.collect())
        }
    }
}

/// The springs of a model.
///
/// A spring keeps its number for good: one that is cut stays in the columns, out of all rows.
#[derive(Clone, Debug)]
pub struct Springs<R: Real> {
    ends: Vec<[u32; 2]>,
    rest_lengths: Vec<R>,
    stiffnesses: Values<R>,
    dampings: Values<R>,
    /// Flags of the springs that are cut; empty where none is.
    cut: Vec<bool>,
    layout: Layout,
    /// The numbers of rows, in sixteens, those that are alike once.
    values: Aligned<R>,
    /// See [`Springs::stiffness_sums`].
    stiffness_sums: Aligned<R>,
}

impl<R: Real> Springs<R> {
    /// Takes over springs, to be put in order.
    pub(crate) fn new(rows: &[Spring]) -> Self {
        let mut springs = Springs {
            ends: Vec::new(),
            rest_lengths: Vec::new(),
            stiffnesses: Values::Same(R::ZERO),
            dampings: Values::Same(R::ZERO),
            cut: Vec::new(),
            layout: Layout::default(),
            values: Aligned::default(),
            stiffness_sums: Aligned::default(),
        };
        springs.add(rows);
        springs
    }

    /// Adds springs, to be put in order.
    pub(crate) fn add(&mut self, rows: &[Spring]) {
        let count = self.ends.len();
        let column = |values: &Values<R>, number: fn(&Spring) -> f64| {
            let there = (0..count).map(|spring| values.get(spring));
            Values::collect(there.chain(rows.iter().map(|row| R::of(number(row)))))
        };
        self.stiffnesses = column(&self.stiffnesses, |row| row.stiffness);
        self.dampings = column(&self.dampings, |row| row.damping);
        self.ends.extend(rows.iter().map(|spring| spring.ends.map(|end| end as u32)));
        self.rest_lengths.extend(rows.iter().map(|spring| R::of(spring.rest_length)));
    }

    /// Puts the springs between `count` particles in order; `bodies` are the particles of each
    /// body.
    pub(crate) fn order(&mut self, count: usize, bodies: &[Range<usize>]) -> Slots {
        let cut = core::mem::take(&mut self.cut);
        let slots;
        (slots, self.layout) = Layout::new(count, &self.ends, bodies);
        for spring in (0..cut.len()).filter(|&spring| cut[spring]) {
            self.cut(spring);
        }
        self.renew();
        slots
    }

    /// Stiffness and damping of each spring.
    fn constants(&self) -> Vec<[R; 2]> {
        let constants = |spring| [self.stiffnesses.get(spring), self.dampings.get(spring)];
        (0..self.ends.len()).map(constants).collect()
    }

    fn set_constants(&mut self, constants: &[[R; 2]]) {
        self.stiffnesses = Values::collect(constants.iter().map(|[stiffness, _]| *stiffness));
        self.dampings = Values::collect(constants.iter().map(|[_, damping]| *damping));
    }

    /// The two particles of each spring, cut or not.
    pub fn ends(&self) -> &[[u32; 2]] {
        &self.ends
    }

    /// Rest lengths, metres.
    pub fn rest_lengths(&self) -> &[R] {
        &self.rest_lengths
    }

    /// Rest length, stiffness and damping of a spring.
    #[inline]
    pub fn law(&self, spring: usize) -> Law<R> {
        Law {
            rest: self.rest_lengths[spring],
            stiffness: self.stiffnesses.get(spring),
            damping: self.dampings.get(spring),
        }
    }

    /// Whether a spring is cut.
    #[inline]
    pub fn is_cut(&self, spring: usize) -> bool {
        self.cut.get(spring).is_some_and(|&cut| cut)
    }

    /// Flags of the springs that are cut; empty where none is.
    pub(crate) fn cut_flags(&self) -> &[bool] {
        &self.cut
    }

    /// The springs that are there, with their numbers.
    pub fn present(&self) -> impl DoubleEndedIterator<Item = (usize, [usize; 2])> + '_ {
        let rows = self.ends.iter().enumerate();
        rows.filter(|&(spring, _)| !self.is_cut(spring))
            .map(|(spring, ends)| (spring, ends.map(|end| end as usize)))
    }

    /// The number of springs that are there.
    pub fn count(&self) -> usize {
        self.ends.len() - self.cut.iter().filter(|&&cut| cut).count()
    }

    /// Whether there are enough springs for several threads.
    pub(crate) fn is_shared(&self) -> bool {
        1 < self.layout.groups.len()
    }

    /// Whether any spring has a damper.
    pub fn is_damped(&self) -> bool {
        !self.dampings.is_zero()
    }

    /// The springs that fit no row, in the order in which they are added.
    #[doc(hidden)]
    pub fn extras(&self) -> impl Iterator<Item = u32> + '_ {
        self.layout.extras.iter().map(|extra| extra.spring)
    }

    /// The springs of rows in the order in which they are evaluated: each with its ends and the
    /// sums to which the pulls on these are added.
    #[doc(hidden)]
    pub fn turns(&self, slots: &Slots) -> impl Iterator<Item = (u32, [u32; 2], [Sum; 2])> {
        let turn = |turn: Turn| {
            let [a, b] = self.ends[turn.spring as usize];
            let is_turned = match turn.here {
                Some(at) => slots.at(b as usize) == at,
                None => b < a,
            };
            let ends = if is_turned { [b, a] } else { [a, b] };
            (turn.spring, ends, turn.sums)
        };
        self.layout.turns().into_iter().map(turn)
    }

    /// Cuts a spring.
    pub(crate) fn cut(&mut self, spring: usize) {
        if self.is_cut(spring) {
            return;
        }
        if self.cut.is_empty() {
            self.cut = vec![false; self.ends.len()];
        }
        self.cut[spring] = true;
        self.layout.cut(spring);
        self.stiffness_sums = Aligned::default();
    }

    /// Changes stiffness and damping of a range of springs.
    pub(crate) fn change(&mut self, springs: Range<usize>, change: impl Fn([R; 2]) -> [R; 2]) {
        let mut all = self.constants();
        all[springs].iter_mut().for_each(|constants| *constants = change(*constants));
        self.set_constants(&all);
    }

    pub(crate) fn rest_lengths_mut(&mut self, springs: Range<usize>) -> &mut [R] {
        &mut self.rest_lengths[springs]
    }

    /// Takes over numbers of springs that have changed into the rows.
    pub(crate) fn renew(&mut self) {
        let mut table = Table::new(&self.layout);
        let Springs { rest_lengths, stiffnesses, dampings, layout, .. } = self;
        table.add(layout, 0, |spring| rest_lengths[spring]);
        for (column, values) in [(1, stiffnesses), (2, dampings)] {
            match values {
                Values::Same(value) => table.add_alike(layout, column, *value),
                Values::Each(values) => table.add(layout, column, |spring| values[spring]),
            }
        }
        let mut values = Aligned::new(table.values.len(), 9);
        values.copy_from_slice(&table.values);
        self.values = values;
        self.stiffness_sums = Aligned::default();
    }

    /// The stiffness of all springs at each slot, newtons per metre; empty unless it was asked for
    /// since the springs have changed.
    pub(crate) fn stiffness_sums(&self) -> &[R] {
        &self.stiffness_sums
    }

    pub(crate) fn sum_stiffnesses(&mut self, slots: &Slots) {
        if !self.stiffness_sums.is_empty() {
            return;
        }
        let mut sums = Aligned::new(slots.record_count() * LANES, 15);
        for (spring, ends) in self.present() {
            for end in ends {
                sums[single(slots.at(end))] += self.stiffnesses.get(spring);
            }
        }
        self.stiffness_sums = sums;
    }

    /// The derivative of the force of a spring.
    fn tangent(&self, motion: &Motion<'_, R>, spring: usize) -> Tangent<f64> {
        let [a, b] = self.ends[spring].map(|end| motion.position(end as usize).to_f64());
        Tangent::new([b - a, DVec3::ZERO], self.law(spring).to_f64())
    }

    /// Adds the products of the derivatives of all springs that are there.
    fn add_products_of(
        &self,
        tangents: impl Iterator<Item = Tangent<f64>>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        let is_damped = self.is_damped();
        for ((_, [a, b]), tangent) in self.present().zip(tangents) {
            let [pull, drag] = tangent.products(direction[b] - direction[a]);
            products.stiffness[a] -= pull;
            products.stiffness[b] += pull;
            if is_damped {
                products.damping[a] -= drag;
                products.damping[b] += drag;
            }
        }
    }

    /// The energy of some springs, joules; the sums of |k stretch| and of k, by which rounding
    /// changes it. The fast twin is in `stored.rs`.
    fn stored_in(&self, motion: &Motion<'_, R>, springs: impl Iterator<Item = usize>) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for spring in springs {
            let law = self.law(spring).to_f64();
            let [a, b] = self.ends[spring].map(|end| motion.position(end as usize).to_f64());
            let length = Real::sqrt((b - a).dot(b - a));
            sums[0] += law::energy(length, law);
            sums[1] += law.stiffness * (length - law.rest).abs();
            sums[2] += law.stiffness;
        }
        sums
    }
}

impl<R: Real> Element<R> for Springs<R> {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let mut work = ForceWork::new(self, motion.slots);
        let level = Instructions::best().level();
        let moment = Moment { level, motion: *motion };
        Force::add_forces(self, &moment, &mut work, forces.numbers)
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        self.stored_in(motion, self.present().map(|(spring, _)| spring))[0]
    }

    fn add_products(
        &self,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        let tangents = self.present().map(|(spring, _)| self.tangent(motion, spring));
        self.add_products_of(tangents, direction, products);
    }
}

/// A spring that pushes sideways more than so many times its stiffness, being crushed to less than
/// an eleventh of its rest length, counts as one that pushes so much. The prediction sets buckling
/// motions aside, and where ends almost coincide their rounding would be all it sees.
const CRUSHED: f64 = 10.0;

impl<R: Real> Force<R> for Springs<R> {
    fn element(&self) -> Option<&dyn Element<R>> {
        Some(self)
    }

    fn count(&self) -> usize {
        self.count()
    }

    fn is_damped(&self) -> bool {
        self.is_damped()
    }

    fn add_forces(&self, moment: &Moment<'_, R>, work: &mut ForceWork<R>, forces: &mut [R]) -> f64 {
        let Springs { layout, values, .. } = self;
        let Motion { positions, velocities, .. } = moment.motion;
        let input = Input { layout, values, positions, velocities };
        let (level, damped) = (moment.level, self.is_damped());
        let sweep = Sweep { springs: self, level, damped, input };
        let SpringWork { power, groups: work, .. } = &mut work.springs;
        let sums = (&mut *forces, &mut **power);
        let groups = &layout.groups[..];
        sweep.add_groups(Share { groups, work, first: 0, forces: sums.0, power: sums.1 });
        sweep.add_late_sums(work, (&mut *forces, &mut *power));
        sweep.add_extras((forces, power));
        if !damped {
            return 0.0;
        }
        let sum_share = |power: &[R]| at_level!(level, _simd => sum(power));
        merge_shares(&**power, &sum_share, &|low, high| low + high)
    }

    fn energy_and_pulls(&self, moment: &Moment<'_, R>) -> [f64; 3] {
        let Springs { layout, values, .. } = self;
        let Motion { positions, velocities, .. } = moment.motion;
        let input = Input { layout, values, positions, velocities };
        let mut lanes = [[0.0; LANES]; 3];
        at_level!(moment.level, _simd => stored::add_rows(input, &mut lanes));
        let extras = self.extras().map(|spring| spring as usize);
        let extras = self.stored_in(&moment.motion, extras);
        core::array::from_fn(|i| lanes[i].iter().sum::<f64>() + extras[i])
    }

    fn differentiate(&self, moment: &Moment<'_, R>, to: &mut Derivatives) {
        let springs = self.present();
        to.springs.clear();
        to.springs.extend(springs.map(|(spring, _)| {
            let tangent = self.tangent(&moment.motion, spring);
            Tangent { across: tangent.across.max(-CRUSHED * tangent.along), ..tangent }
        }));
    }

    fn add_products(
        &self,
        (_, derivatives): (&Motion<'_, R>, &Derivatives),
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        self.add_products_of(derivatives.springs.iter().copied(), direction, products);
    }

    fn add_row_sums(&self, _: &Motion<'_, R>, _: &Derivatives, sums: &mut [[f64; 2]]) {
        for (spring, ends) in self.present() {
            let law = self.law(spring);
            for end in ends {
                sums[end][0] += law.stiffness.to_f64();
                sums[end][1] += law.damping.to_f64();
            }
        }
    }

    fn linearise(&self, stage: &Stage<'_, R>, to: &mut MatrixSums<'_, R>) {
        to.springs.linearise(self, stage, &mut to.blocks);
    }

    fn multiply(&self, stage: &Stage<'_, R>, to: &mut ColumnProducts<'_, R>) {
        let ColumnProducts { springs, direction, products } = to;
        springs.add_products(stage.moment.level, self, direction, products);
    }

    /// A spring is a constraint of compliance 1/k.
    fn project(&self, projection: &mut Projection<'_, R>) {
        at_level!(projection.level, simd => project::project_all(simd, projection));
    }

    fn multiplier_count(&self, batches: &Batches<R>) -> usize {
        batches.multiplier_count()
    }

    fn each_pair(&self, join: &mut dyn FnMut([u32; 2])) {
        self.present().for_each(|(_, ends)| join(ends.map(|end| end as u32)));
    }

    fn write(&self, rows: &mut Scene) {
        rows.springs.extend(self.ends.iter().enumerate().map(|(row, ends)| {
            let law = self.law(row).to_f64();
            Spring {
                ends: ends.map(|end| end as usize),
                rest_length: law.rest,
                stiffness: law.stiffness,
                damping: law.damping,
            }
        }));
    }
}
