//! Stencils: rows of a few particles that pull together, in the order in which they are evaluated.
//!
//! That order depends on them and on the slots of particles alone. Bundles come first: up to
//! sixteen whose particles are in the same lane of records, as most of a lattice are, evaluated at
//! once. The others follow one by one. One code computes one and sixteen, so that their bits are
//! the same. A new kind is a law, in a file of its own.

use super::springs::project::Batches;
use super::{
    ColumnProducts, Derivatives, Element, Force, ForceWork, MatrixSums, Moment, Motion, Products,
    Projection, Resists, Rows, Stage, Torn, Vectors,
};
use crate::columns::slots::Slots;
use crate::columns::{LANES, RECORD, add_vector, vector};
use crate::number::{Real, Vector, at_level};
use crate::scene::Scene;
use alloc::vec::Vec;
use core::fmt::Debug;
use glam::DVec3;

/// A bundle of fewer would cost more than they do one by one.
const FEWEST: usize = 4;

/// The law of a stencil of N particles, with its stiffness and its damping.
pub(crate) trait StencilLaw<R: Real, const N: usize>: Copy + Debug + Send + Sync {
    /// The deformation that it resists.
    const RESISTS: Resists;

    /// The rows of a scene.
    fn rows(scene: &Scene) -> Vec<Stencil<Self, N>>;
    /// Adds a row to a scene.
    fn write(row: &Stencil<Self, N>, scene: &mut Scene);
    /// Stiffness and damping.
    fn constants(&mut self) -> [&mut R; 2];
    /// Whether two stencils may be in one bundle, whatever their constants.
    fn is_alike(&self, other: &Self) -> bool;
    /// Whether a particle of a stencil takes part.
    fn takes_part(&self, end: usize) -> bool;

    /// Adds the forces of a group, and returns the power that each dissipates.
    fn pull<const M: usize>(group: &Group<R, Self, N, M>, to: &mut StencilSums<'_, R>) -> [R; M];
    /// Adds the products of its matrix in a stage, τ (τ K + D), with a direction.
    fn multiply<const M: usize>(group: &Group<R, Self, N, M>, tau: R, to: &mut StencilSums<'_, R>);
    /// Adds the diagonal blocks of that matrix.
    fn add_blocks(single: &Group<R, Self, N, 1>, about: (R, &[R]), blocks: &mut [&mut [R]; 2]);
    /// Moves the particles of a group as XPBD does. See [`Force::project`]; `applied` holds the
    /// multipliers that each has applied in the substep.
    fn project<const M: usize>(
        group: &Group<R, Self, N, M>,
        applied: &mut [[R; M]; MULTIPLIERS],
        projection: &mut Projection<'_, R>,
    );
    /// See [`Force::energy_and_pulls`].
    fn energy_and_pulls(row: &Stencil<Self, N>, motion: &Motion<'_, R>) -> [f64; 3];
    /// See [`Force::add_row_sums`].
    fn add_row_sums(row: &Stencil<Self, N>, motion: &Motion<'_, R>, sums: &mut [[f64; 2]]);
    /// See [`Element::add_products`].
    fn add_products(
        row: &Stencil<Self, N>,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    );
}

/// Multipliers of a stencil in XPBD: a vector.
pub(super) const MULTIPLIERS: usize = 3;

/// The columns that stencils read, and those that they add to.
pub(crate) struct StencilSums<'a, R> {
    pub(super) positions: &'a [R],
    /// Velocities, or a direction.
    pub(super) ways: &'a [R],
    /// Whether any stencil has a damper.
    pub(super) is_damped: bool,
    pub(super) sums: &'a mut [R],
}

/// Some particles, where their numbers are in a column of vectors, and the law between them.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<L, const N: usize> {
    pub(super) particles: [u32; N],
    pub(super) at: [u32; N],
    pub(super) law: L,
}

/// Up to M stencils of one law, each in a lane of its own.
#[derive(Clone, Debug)]
pub struct Group<R, L, const N: usize, const M: usize> {
    /// Where the numbers of each end start.
    pub(super) at: [u32; N],
    /// That of the first.
    pub(super) law: L,
    /// Stiffness and damping of each.
    pub(super) constants: [[R; M]; 2],
    /// Other than 0 where there is one: numbers, as compilers vectorise no choice by a flag.
    is_there: [R; M],
}

/// The stencils of one law.
#[derive(Clone, Debug)]
pub struct Stencils<R, L, const N: usize> {
    /// In the order of evaluation.
    pub(super) all: Vec<Stencil<L, N>>,
    bundles: Vec<Group<R, L, N, LANES>>,
    /// Number of rows in bundles: the first ones.
    bundled: usize,
    /// Numbers of a column of vectors.
    numbers: usize,
    is_damped: bool,
}

impl<R, L, const N: usize> Default for Stencils<R, L, N> {
    fn default() -> Self {
        let (all, bundles) = (Vec::new(), Vec::new());
        Stencils { all, bundles, bundled: 0, numbers: 0, is_damped: false }
    }
}

impl<R, L, const N: usize> Stencils<R, L, N> {
    /// The number of stencils.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// Whether any has a damper.
    pub fn is_damped(&self) -> bool {
        self.is_damped
    }
}

impl<L: Copy, const N: usize> Stencil<L, N> {
    pub(super) fn new(particles: [usize; N], law: L) -> Self {
        Stencil { particles: particles.map(|particle| particle as u32), at: [0; N], law }
    }

    /// The same stencil where these slots put its particles.
    fn placed(&self, slots: &Slots) -> Self {
        Stencil { at: self.particles.map(|particle| slots.at(particle as usize) as u32), ..*self }
    }

    /// One of its particles.
    #[inline(always)]
    pub(super) fn particle(&self, end: usize) -> usize {
        self.particles[end] as usize
    }

    /// The lane of its first particle.
    fn lane(&self) -> usize {
        self.at[0] as usize % RECORD
    }
}

impl<R: Real, L: StencilLaw<R, N>, const N: usize, const M: usize> Group<R, L, N, M> {
    /// Those of some rows that lane 0 of which starts at some places.
    #[inline(always)]
    pub(super) fn new(rows: &[Stencil<L, N>], at: [u32; N]) -> Self {
        let (mut constants, mut is_there) = ([[R::ZERO; M]; 2], [R::ZERO; M]);
        for row in rows {
            let lane = (row.at[0] - at[0]) as usize;
            let mut law = row.law;
            let [stiffness, damping] = law.constants();
            (constants[0][lane], constants[1][lane]) = (*stiffness, *damping);
            is_there[lane] = R::ONE;
        }
        Group { at, law: rows[0].law, constants, is_there }
    }

    /// Projects them, whose multipliers come after those of `rows` rows.
    #[inline(always)]
    fn project(&self, rows: usize, projection: &mut Projection<'_, R>) {
        let own = projection.first + MULTIPLIERS * rows;
        let mut applied = [[R::ZERO; M]; MULTIPLIERS];
        if projection.is_back {
            let kept = &projection.multipliers[own..][..MULTIPLIERS * M];
            applied.as_flattened_mut().copy_from_slice(kept);
        }
        L::project(self, &mut applied, projection);
        let kept = &mut projection.multipliers[own..][..MULTIPLIERS * M];
        kept.copy_from_slice(applied.as_flattened());
    }

    /// A function that gives the vectors of a column at the ends of the first.
    #[inline(always)]
    pub(super) fn first<'a>(&'a self, column: &'a [R]) -> impl Fn(usize) -> R::Vec3 + 'a {
        |end| vector::<R>(column, self.at[end] as usize)
    }

    /// The numbers of a column for one end of each along an axis.
    #[inline(always)]
    pub(super) fn numbers<'a>(&self, column: &'a [R], end: usize, axis: usize) -> &'a [R; M] {
        let at = self.at[end] as usize + axis * LANES;
        column[at..].first_chunk().expect("numbers of the column")
    }

    /// Adds a block to those of one end of the first: xx, xy and xz, and yy, yz and zz.
    pub(super) fn add_block(
        &self,
        end: usize,
        block: [[R; 3]; 2],
        [upper, lower]: &mut [&mut [R]; 2],
    ) {
        let at = self.at[end] as usize;
        let [above, below] = block.map(R::Vec3::from_components);
        add_vector::<R>(upper, at, above);
        add_vector::<R>(lower, at, below);
    }

    /// Subtracts numbers of one end of each along an axis from the sums.
    #[inline(always)]
    pub(super) fn subtract(
        &self,
        (end, axis): (usize, usize),
        less: impl Fn(usize) -> R,
        sums: &mut [R],
    ) {
        let at = self.at[end] as usize + axis * LANES;
        let numbers = sums[at..].first_chunk_mut::<M>().expect("numbers of the column");
        for (lane, number) in numbers.iter_mut().enumerate() {
            let left = *number - less(lane);
            *number = if self.is_there[lane] != R::ZERO { left } else { *number };
        }
    }
}

#[expect(private_bounds, reason = "none of these is public")]
impl<R: Real, L: StencilLaw<R, N>, const N: usize> Stencils<R, L, N> {
    /// Those that are in no bundle, each a group of its own.
    #[inline(always)]
    fn singles(&self) -> impl Iterator<Item = Group<R, L, N, 1>> {
        let rows = self.all[self.bundled..].iter();
        rows.map(|row| Group::new(core::slice::from_ref(row), row.at))
    }

    fn retain(&mut self, is_left: impl Fn(&Stencil<L, N>) -> bool) {
        let before = self.all.len();
        self.all.retain(is_left);
        if self.all.len() < before {
            self.order();
        }
    }

    /// Puts them in the order in which they are evaluated, and makes bundles.
    fn order(&mut self) {
        let Stencils { all, bundles, numbers, .. } = self;
        let starts = |row: &Stencil<L, N>| starts(row, *numbers);
        // Stable: equal rows keep their order, so that a resumed run has the same sums.
        all.sort_by_key(|row| (starts(row).is_none(), starts(row), row.at[0]));
        let fit = |a: &Stencil<L, N>, b: &Stencil<L, N>| {
            let is_next = a.at[0] < b.at[0] && a.law.is_alike(&b.law);
            is_next && starts(a).is_some() && starts(a) == starts(b)
        };
        let (mut bundled, mut singles) = (Vec::with_capacity(all.len()), Vec::new());
        bundles.clear();
        for rows in all.chunk_by(fit) {
            match starts(&rows[0]).filter(|_| FEWEST <= rows.len()) {
                Some(at) => {
                    bundles.push(Group::new(rows, at));
                    bundled.extend_from_slice(rows);
                }
                None => singles.extend_from_slice(rows),
            }
        }
        self.bundled = bundled.len();
        bundled.append(&mut singles);
        *all = bundled;
        self.is_damped = all.iter_mut().any(|row| *row.law.constants()[1] != R::ZERO);
    }

    #[inline(always)]
    fn pull(&self, mut to: StencilSums<'_, R>) -> f64 {
        let mut powers = [0.0; LANES];
        for bundle in &self.bundles {
            let taken = L::pull(bundle, &mut to);
            for lane in 0..LANES {
                let is_there = bundle.is_there[lane] != R::ZERO;
                powers[lane] += if is_there { taken[lane].to_f64() } else { 0.0 };
            }
        }
        let power: f64 = powers.iter().sum();
        self.singles().fold(power, |power, single| power + L::pull(&single, &mut to)[0].to_f64())
    }

    #[inline(always)]
    fn multiply(&self, tau: R, mut to: StencilSums<'_, R>) {
        self.bundles.iter().for_each(|bundle| L::multiply(bundle, tau, &mut to));
        self.singles().for_each(|single| L::multiply(&single, tau, &mut to));
    }

    /// Projects bundles and singles in order, or backwards.
    #[inline(always)]
    fn project_groups(&self, projection: &mut Projection<'_, R>) {
        let (bundles, singles) = (self.bundles.len(), self.all.len() - self.bundled);
        let count = bundles + singles;
        for turn in 0..count {
            let number = if projection.is_back { count - 1 - turn } else { turn };
            if let Some(bundle) = self.bundles.get(number) {
                bundle.project(LANES * number, projection);
            } else {
                let row = &self.all[self.bundled + number - bundles];
                let single: Group<R, L, N, 1> = Group::new(core::slice::from_ref(row), row.at);
                single.project(LANES * bundles + number - bundles, projection);
            }
        }
    }

    fn stored(&self, motion: &Motion<'_, R>) -> [f64; 3] {
        self.all.iter().fold([0.0; 3], |sums, row| {
            let stored = L::energy_and_pulls(row, motion);
            core::array::from_fn(|i| sums[i] + stored[i])
        })
    }
}

impl<R: Real, L: StencilLaw<R, N>, const N: usize> Element<R> for Stencils<R, L, N> {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let (positions, ways) = (motion.positions, motion.velocities);
        let power = self.all.iter().map(|row| {
            let row = row.placed(motion.slots);
            let single: Group<R, L, N, 1> = Group::new(&[row], row.at);
            let sums = &mut *forces.numbers;
            L::pull(&single, &mut StencilSums { positions, ways, is_damped: true, sums })[0]
                .to_f64()
        });
        power.sum()
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        self.stored(motion)[0]
    }

    fn add_products(
        &self,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        self.all.iter().for_each(|row| L::add_products(row, motion, direction, products));
    }
}

impl<R: Real, L: StencilLaw<R, N>, const N: usize> Force<R> for Stencils<R, L, N> {
    fn element(&self) -> Option<&dyn Element<R>> {
        Some(self)
    }

    fn count(&self) -> usize {
        self.all.len()
    }

    fn is_damped(&self) -> bool {
        self.is_damped
    }

    fn add_forces(&self, moment: &Moment<'_, R>, _: &mut ForceWork<R>, forces: &mut [R]) -> f64 {
        if self.all.is_empty() {
            return 0.0;
        }
        let Motion { positions, velocities: ways, .. } = moment.motion;
        let to = StencilSums { positions, ways, is_damped: self.is_damped, sums: forces };
        at_level!(moment.level, _simd => self.pull(to))
    }

    fn energy_and_pulls(&self, moment: &Moment<'_, R>) -> [f64; 3] {
        self.stored(&moment.motion)
    }

    fn add_row_sums(&self, motion: &Motion<'_, R>, _: &Derivatives, sums: &mut [[f64; 2]]) {
        self.all.iter().for_each(|row| L::add_row_sums(row, motion, sums));
    }

    fn linearise(&self, stage: &Stage<'_, R>, to: &mut MatrixSums<'_, R>) {
        let about = (stage.tau, stage.moment.motion.positions);
        for row in &self.all {
            let single = Group::new(core::slice::from_ref(row), row.at);
            L::add_blocks(&single, about, &mut to.blocks);
        }
    }

    fn multiply(&self, stage: &Stage<'_, R>, to: &mut ColumnProducts<'_, R>) {
        if !self.all.is_empty() {
            let (positions, is_damped) = (stage.moment.motion.positions, self.is_damped);
            let (ways, sums) = (to.direction, &mut *to.products);
            let to = StencilSums { positions, ways, is_damped, sums };
            at_level!(stage.moment.level, _simd => self.multiply(stage.tau, to));
        }
    }

    fn project(&self, projection: &mut Projection<'_, R>) {
        if !self.all.is_empty() {
            at_level!(projection.level, _simd => self.project_groups(projection));
        }
    }

    fn multiplier_count(&self, _: &Batches<R>) -> usize {
        MULTIPLIERS * (LANES * self.bundles.len() + self.all.len() - self.bundled)
    }

    fn each_pair(&self, join: &mut dyn FnMut([u32; 2])) {
        for row in &self.all {
            let mut ends = (0..N).filter(|&end| row.law.takes_part(end));
            let first = ends.next().map_or(0, |end| row.particles[end]);
            ends.for_each(|end| join([first, row.particles[end]]));
        }
    }

    fn add(&mut self, rows: &Scene, slots: &Slots) {
        self.all.extend(L::rows(rows));
        self.all.iter_mut().for_each(|row| *row = row.placed(slots));
        self.numbers = slots.record_count() * RECORD;
        self.order();
    }

    fn write(&self, rows: &mut Scene) {
        self.all.iter().for_each(|row| L::write(row, rows));
    }

    /// A torn stencil stops resisting.
    fn tear(&mut self, torn: &Torn) {
        self.retain(|row| !torn.crosses(&row.particles));
    }

    fn remove(&mut self, is_removed: &dyn Fn(u32) -> bool) {
        let is_gone = |row: &Stencil<L, N>, end: usize| {
            row.law.takes_part(end) && is_removed(row.particles[end])
        };
        self.retain(|row| !(0..N).any(|end| is_gone(row, end)));
    }

    fn change(&mut self, (particles, _): &Rows, change: &dyn Fn(Resists, [R; 2]) -> [R; 2]) {
        for row in self.all.iter_mut().filter(|row| particles.contains(&row.particle(0))) {
            let [stiffness, damping] = row.law.constants();
            [*stiffness, *damping] = change(L::RESISTS, [*stiffness, *damping]);
        }
        self.order();
    }
}

/// Where the sixteen numbers of each end start, one of them that of its particle in the lane of the
/// first. It is the start of a record, or one number on where a particle is in the next lane.
/// `None` where they are in other lanes, would reach beyond the columns, or where two ends share a
/// record in different lanes. Their forces would be added in another order.
fn starts<L: Copy, const N: usize>(row: &Stencil<L, N>, numbers: usize) -> Option<[u32; N]> {
    let starts = row.at.map(|at| at.wrapping_sub(row.lane() as u32));
    let fits = |&start: &u32| {
        let start = start as usize;
        start % RECORD <= 1 && start + RECORD <= numbers
    };
    let shares = |a: u32, b: u32| a != b && a / RECORD as u32 == b / RECORD as u32;
    let overlap = (1..N).any(|a| (0..a).any(|b| shares(starts[a], starts[b])));
    (starts.iter().all(fits) && !overlap).then_some(starts)
}
