//! Springs with dampers, nearly all of the work of a step.
//!
//! [`law`] is what a spring does; [`plain`] sums it over all springs in one loop, and is the oracle
//! of `sweep`, which takes sixteen at a time in the order that `layout` has found.

pub(crate) mod gather;
pub mod law;
pub(crate) mod layout;
pub(crate) mod matrix;
#[doc(hidden)]
pub mod plain;
mod sweep;
mod table;

use crate::columns::slots::Slots;
use crate::columns::threads::{Split, are_several, for_each_share, join, merge_shares};
use crate::columns::{Aligned, LANES, RECORD};
use crate::elements::{Element, Motion, Products, Vectors};
use crate::number::{Real, Vector, at_level};
use crate::scene::Spring;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use fearless_simd::Level;
use gather::GATHERED;
use glam::DVec3;
use law::{Law, Tangent};
use layout::{Band, Layout, NOWHERE, POINT};
use sweep::{Input, Sums, add_column, add_extras, add_springs};
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

    fn collect(values: impl ExactSizeIterator<Item = R> + Clone) -> Self {
        let first = values.clone().next().unwrap_or(R::ZERO);
        if values.clone().all(|value| value == first) {
            Values::Same(first)
        } else {
            Values::Each(values.collect())
        }
    }

    /// Sets the values of a range of springs out of `count`; a column has one form only.
    fn set(&mut self, range: Range<usize>, count: usize, value: R) {
        let mut values: Vec<R> = (0..count).map(|spring| self.get(spring)).collect();
        values[range].fill(value);
        *self = Values::collect(values.iter().copied());
    }

    fn convert<S: Real>(&self, count: usize) -> Values<S> {
        match self {
            Values::Same(value) => Values::Same(S::of(value.to_f64())),
            Values::Each(_) => {
                let values: Vec<S> = (0..count).map(|row| S::of(self.get(row).to_f64())).collect();
                Values::collect(values.iter().copied())
            }
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
    /// Which springs are cut; empty where none is.
    cut: Vec<bool>,
    layout: Layout,
    /// The numbers of rows, in sixteens, those that are alike once.
    values: Aligned<R>,
}

/// What an evaluation of forces forgets.
#[derive(Clone, Debug)]
pub(crate) struct SpringWork<R: Real> {
    /// Power that elements of the caller's own took away at the last evaluation, watts.
    pub(crate) own_power: f64,
    power: Aligned<R>,
    points: Aligned<R>,
    /// For each group of pieces.
    groups: Vec<GroupWork<R>>,
}

/// What the evaluation of a group of pieces forgets; see [`Sums`].
#[derive(Clone, Debug)]
struct GroupWork<R: Real> {
    ahead: Aligned<R>,
    burnt: Aligned<R>,
    gathered: Aligned<R>,
    later: Aligned<R>,
}

impl<R: Real> SpringWork<R> {
    pub(crate) fn new(springs: &Springs<R>, slots: &Slots) -> Self {
        let (layout, records) = (&springs.layout, slots.record_count());
        let points = if layout.others.is_empty() { 0 } else { records * LANES * POINT };
        let (halo, gathered) = (layout.halo(), layout.most_gathered() * GATHERED);
        let group = |group: &Range<usize>| GroupWork {
            ahead: Aligned::new((halo + 2) * RECORD, 6),
            burnt: Aligned::new((halo + 2) * LANES + LANES, 7),
            gathered: Aligned::new(gathered, 10),
            later: Aligned::new(layout.kept_for_later(group) * RECORD, 11),
        };
        SpringWork {
            own_power: 0.0,
            power: Aligned::new(records * LANES, 5),
            points: Aligned::new(points, 8),
            groups: layout.groups.iter().map(group).collect(),
        }
    }
}

impl<R: Real> Springs<R> {
    /// Orders springs for particles of so many; `bodies` are the particles of each body.
    pub(crate) fn new(
        count: usize,
        rows: &[Spring],
        bodies: &[Range<usize>],
    ) -> (Slots, Springs<R>) {
        let ends: Vec<[u32; 2]> = rows.iter().map(|s| s.ends.map(|end| end as u32)).collect();
        let (slots, layout) = Layout::new(count, &ends, bodies);
        let springs = rows.iter();
        let mut springs = Springs {
            ends,
            rest_lengths: springs.clone().map(|s| R::of(s.rest_length)).collect(),
            stiffnesses: Values::collect(springs.clone().map(|s| R::of(s.stiffness))),
            dampings: Values::collect(springs.map(|s| R::of(s.damping))),
            cut: Vec::new(),
            layout,
            values: Aligned::default(),
        };
        springs.renew();
        (slots, springs)
    }

    /// Adds springs and orders all of them anew, as in [`Springs::new`].
    pub(crate) fn add(&mut self, count: usize, rows: &[Spring], bodies: &[Range<usize>]) -> Slots {
        let mut stiffnesses: Vec<R> = self.columns(|law| law.stiffness);
        let mut dampings: Vec<R> = self.columns(|law| law.damping);
        for spring in rows {
            self.ends.push(spring.ends.map(|end| end as u32));
            self.rest_lengths.push(R::of(spring.rest_length));
            stiffnesses.push(R::of(spring.stiffness));
            dampings.push(R::of(spring.damping));
        }
        self.stiffnesses = Values::collect(stiffnesses.iter().copied());
        self.dampings = Values::collect(dampings.iter().copied());
        let cut = core::mem::take(&mut self.cut);
        let slots;
        (slots, self.layout) = Layout::new(count, &self.ends, bodies);
        for spring in (0..cut.len()).filter(|&spring| cut[spring]) {
            self.cut(spring);
        }
        self.renew();
        slots
    }

    fn columns(&self, value: impl Fn(Law<R>) -> R) -> Vec<R> {
        (0..self.ends.len()).map(|spring| value(self.law(spring))).collect()
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

    /// Which springs are cut; empty where none is.
    pub(crate) fn cut_flags(&self) -> &[bool] {
        &self.cut
    }

    /// The springs that are there, with their numbers.
    pub fn present(&self) -> impl Iterator<Item = (usize, [usize; 2])> + '_ {
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

    /// Which sums of its lower and its higher end a spring is added to after others; see
    /// [`layout::Piece`].
    #[doc(hidden)]
    pub fn late_sums(&self) -> impl Fn(u32) -> (bool, Option<usize>) + '_ {
        let late = self.layout.late_sums();
        move |spring| match self.layout.places[spring as usize] {
            NOWHERE => (false, None),
            place => late[place as usize / LANES],
        }
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
    }

    pub(crate) fn set_stiffness(&mut self, springs: Range<usize>, value: R) {
        self.stiffnesses.set(springs, self.ends.len(), value);
    }

    pub(crate) fn set_damping(&mut self, springs: Range<usize>, value: R) {
        self.dampings.set(springs, self.ends.len(), value);
    }

    pub(crate) fn rest_lengths_mut(&mut self, springs: Range<usize>) -> &mut [R] {
        &mut self.rest_lengths[springs]
    }

    /// The same springs in another precision, each number rounded once.
    pub(crate) fn convert<S: Real>(&self) -> Springs<S> {
        let count = self.ends.len();
        let mut springs = Springs {
            ends: self.ends.clone(),
            rest_lengths: self.rest_lengths.iter().map(|rest| S::of(rest.to_f64())).collect(),
            stiffnesses: self.stiffnesses.convert(count),
            dampings: self.dampings.convert(count),
            cut: self.cut.clone(),
            layout: self.layout.clone(),
            values: Aligned::default(),
        };
        springs.renew();
        springs
    }

    /// Takes over numbers of springs that have changed into the rows.
    pub(crate) fn renew(&mut self) {
        let mut table = Table::new(&self.layout);
        let Springs { rest_lengths, stiffnesses, dampings, layout, .. } = self;
        table.add(layout, 0, |spring| rest_lengths[spring]);
        table.add(layout, 1, |spring| stiffnesses.get(spring));
        table.add(layout, 2, |spring| dampings.get(spring));
        let mut values = Aligned::new(table.values.len(), 9);
        values.copy_from_slice(&table.values);
        self.values = values;
    }

    /// Adds the pull of every spring, newtons, and returns the power that dampers take away, watts.
    pub(crate) fn add_all(
        &self,
        level: Level,
        motion: &Motion<'_, R>,
        work: &mut SpringWork<R>,
        forces: &mut [R],
    ) -> f64 {
        let Springs { layout, values, .. } = self;
        let (positions, velocities) = (motion.positions, motion.velocities);
        let SpringWork { power, points, groups, .. } = work;
        if !layout.others.is_empty() {
            for_each_share(
                Points { positions, velocities, points },
                |Points { positions, velocities, points }| {
                    at_level!(level, _simd => set_points(positions, velocities, points));
                },
            );
        }
        let input = Input { layout, values, positions, velocities, points };
        let sweep = Sweep { springs: self, level, damped: self.is_damped(), input };
        let (groups_of, work) = (&layout.groups, &mut groups[..]);
        let share = Share { groups: groups_of, work, first: 0, forces: &mut *forces, power };
        sweep.add_groups(share);
        sweep.add_late_sums(groups, (&mut *forces, &mut *power));
        sweep.add_extras((forces, power));
        if !sweep.damped {
            return 0.0;
        }
        let sum_share = |power: &[R]| at_level!(level, _simd => sum(power));
        merge_shares(&**power, &sum_share, &|low, high| low + high)
    }

    /// The derivative of the force of a spring.
    pub(crate) fn tangent(&self, motion: &Motion<'_, R>, spring: usize) -> Tangent {
        let [a, b] = self.ends[spring].map(|end| motion.position(end as usize).to_f64());
        Tangent::new(b - a, self.law(spring).to_f64())
    }
}

/// An evaluation of all springs.
#[derive(Clone, Copy)]
struct Sweep<'a, R: Real> {
    springs: &'a Springs<R>,
    level: Level,
    damped: bool,
    input: Input<'a, R>,
}

/// Groups of pieces, with what they write: numbers that are theirs alone.
struct Share<'a, R: Real> {
    groups: &'a [Range<usize>],
    work: &'a mut [GroupWork<R>],
    /// The first number in the columns of vectors.
    first: usize,
    forces: &'a mut [R],
    power: &'a mut [R],
}

impl<R: Real> Sweep<'_, R> {
    /// Adds the pull of all springs of a share that fit rows, half of the groups at a time.
    fn add_groups(&self, share: Share<'_, R>) {
        let Share { groups, work, first, forces, power } = share;
        let half = groups.len() / 2;
        if half == 0 || !are_several() {
            for (group, work) in groups.iter().zip(work) {
                self.add_group(group.clone(), work, first, (&mut *forces, &mut *power));
            }
            return;
        }
        let (low, high) = groups.split_at(half);
        let cut = self.input.layout.pieces[high[0].start].numbers.start;
        let (low_work, high_work) = work.split_at_mut(half);
        let (low_forces, high_forces) = forces.split_at_mut(cut - first);
        let (low_power, high_power) = power.split_at_mut((cut - first) / 3);
        let (forces, power) = (low_forces, low_power);
        let low = Share { groups: low, work: low_work, first, forces, power };
        let (forces, power) = (high_forces, high_power);
        let high = Share { groups: high, work: high_work, first: cut, forces, power };
        join(|| self.add_groups(low), || self.add_groups(high));
    }

    /// Adds the pull of the springs of a group to columns that start at a number.
    fn add_group(
        &self,
        group: Range<usize>,
        work: &mut GroupWork<R>,
        first: usize,
        (forces, power): (&mut [R], &mut [R]),
    ) {
        let Sweep { level, input, .. } = *self;
        for piece in &input.layout.pieces[group] {
            let numbers = piece.numbers.start - first..piece.numbers.end - first;
            let power = &mut power[numbers.start / 3..numbers.end / 3];
            let forces = &mut forces[numbers];
            let GroupWork { ahead, burnt, gathered, later } = &mut *work;
            let sums = Sums { forces, power, ahead, burnt, gathered, later };
            if piece.rows.is_empty() {
                sums.power.fill(R::ZERO);
            } else if self.damped {
                at_level!(level, simd => add_springs::<_, R, true>(simd, piece, input, sums));
            } else {
                at_level!(level, simd => add_springs::<_, R, false>(simd, piece, input, sums));
            }
        }
    }

    /// Adds what parts have kept: forces on later parts, then those on the ends of segments.
    fn add_late_sums(&self, work: &[GroupWork<R>], (forces, power): (&mut [R], &mut [R])) {
        let layout = self.input.layout;
        let parts = || {
            let groups = layout.groups.iter().zip(work);
            let pieces = groups.map(|(group, work)| (&layout.pieces[group.start], work));
            pieces.filter(|(piece, _)| piece.is_part)
        };
        for (piece, work) in parts() {
            let end = layout.bands[piece.band].numbers.end;
            let later = &work.later[..work.later.len().min(end - piece.numbers.end)];
            self.add_column(later, &mut forces[piece.numbers.end..][..later.len()]);
        }
        for (piece, work) in parts() {
            let Band { numbers, halo, .. } = &layout.bands[piece.band];
            let halo = halo.unwrap_or(0);
            let steps = piece.first.min(halo)..(piece.first + piece.steps.len()).min(halo);
            // The ends of segments, seen from the next lane.
            let (to, from) = (numbers.end - (halo - steps.start) * RECORD, 1 + steps.start);
            let (ahead, burnt) =
                (&work.ahead[from * RECORD + 1..], &work.burnt[from * LANES + 1..]);
            let (count, singles) = (steps.len() * RECORD, steps.len() * LANES);
            self.add_column(&ahead[..count], &mut forces[to..][..count]);
            if self.damped {
                self.add_column(&burnt[..singles], &mut power[to / 3..][..singles]);
            }
        }
    }

    /// Adds one column to another of its length.
    fn add_column(&self, column: &[R], to: &mut [R]) {
        for_each_share((to, column), |(to, column)| {
            at_level!(self.level, _simd => add_column(column, to));
        });
    }

    /// Adds the pull of the springs that fit no row.
    fn add_extras(&self, sums: (&mut [R], &mut [R])) {
        let Sweep { level, input, springs, .. } = *self;
        if input.layout.extras.is_empty() {
            return;
        }
        let extras = (&input.layout.extras[..], |spring| springs.law(spring));
        if self.damped {
            at_level!(level, simd => add_extras::<_, R, true>(simd, extras, input, sums));
        } else {
            at_level!(level, simd => add_extras::<_, R, false>(simd, extras, input, sums));
        }
    }
}

impl<R: Real> Element<R> for Springs<R> {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let mut work = SpringWork::new(self, motion.slots);
        self.add_all(crate::number::Instructions::best().level(), motion, &mut work, forces.numbers)
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        let energy = |(spring, ends): (usize, [usize; 2])| {
            let [a, b] = ends.map(|end| motion.position(end).to_f64());
            law::energy(Real::sqrt((b - a).dot(b - a)), self.law(spring).to_f64())
        };
        self.present().map(energy).sum()
    }

    fn add_products(
        &self,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        for (spring, [a, b]) in self.present() {
            let tangent = self.tangent(motion, spring);
            products.add_between([a, b], tangent.products(direction[b] - direction[a]));
        }
    }
}

/// A motion, and the points that it is copied to.
struct Points<'a, R> {
    positions: &'a [R],
    velocities: &'a [R],
    points: &'a mut [R],
}

impl<R: Real> Split for Points<'_, R> {
    fn numbers(&self) -> usize {
        self.positions.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let (low_positions, positions) = self.positions.split_at(numbers);
        let (low_velocities, velocities) = self.velocities.split_at(numbers);
        let (low, points) = self.points.split_at_mut(numbers / RECORD * LANES * POINT);
        let low = Points { positions: low_positions, velocities: low_velocities, points: low };
        (low, Points { positions, velocities, points })
    }
}

/// Copies a motion to points, particle by particle.
#[inline(always)]
fn set_points<R: Real>(positions: &[R], velocities: &[R], points: &mut [R]) {
    let records = positions.as_chunks::<RECORD>().0.iter().zip(velocities.as_chunks::<RECORD>().0);
    let points = points.as_chunks_mut::<POINT>().0.as_chunks_mut::<LANES>().0;
    for ((x, v), points) in records.zip(points) {
        for (lane, point) in points.iter_mut().enumerate() {
            for axis in 0..3 {
                point[axis] = x[axis * LANES + lane];
                point[4 + axis] = v[axis * LANES + lane];
            }
        }
    }
}

/// The sum of a column of numbers: one sum for each lane, then theirs.
#[inline(always)]
fn sum<R: Real>(column: &[R]) -> f64 {
    let mut sums = [0.0; LANES];
    for record in column.as_chunks::<LANES>().0 {
        for (sum, number) in sums.iter_mut().zip(record) {
            *sum += number.to_f64();
        }
    }
    sums.iter().sum()
}
