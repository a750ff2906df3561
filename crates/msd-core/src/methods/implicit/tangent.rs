//! The matrix of an implicit stage, A = M − τ ∂f/∂v − τ² ∂f/∂x, and the inverses of its blocks.

use crate::columns::{Aligned, LANES, RECORD, add_vector, vector};
use crate::elements::springs::matrix::SpringMatrix;
use crate::elements::{
    Block, Blocks, ColumnProducts, Element, MatrixSums, Products, Stage, column,
};
use crate::number::{Real, Vector, at_level};
use crate::system::Model;
use alloc::vec::Vec;
use glam::DVec3;

/// The matrix about a stage, kilograms.
///
/// For springs see [`SpringMatrix`]. Bends add their products, which depend on the stage by their
/// damping alone; volumes add theirs without the turn of their gradients. Drag adds its factor
/// times τ. A grab adds τ² k + τ b, but nothing at its largest force, which is taken as constant.
/// User-defined elements supply their products.
#[derive(Clone, Debug)]
pub(crate) struct Tangent<R: Real> {
    springs: SpringMatrix<R>,
    /// Mass, drag and grabs of each particle, kilograms, three times each.
    diagonals: Aligned<R>,
    /// Inverses of the blocks of particles, xx, xy and xz in one column, yy, yz and zz in another;
    /// zero where a particle is pinned.
    inverses: [Aligned<R>; 2],
    other: OtherWork,
}

/// Arguments and products of elements that know no columns, in scene order; empty where there are
/// none.
#[derive(Clone, Debug, Default)]
struct OtherWork {
    direction: Vec<DVec3>,
    products: [Vec<DVec3>; 2],
    blocks: [Vec<Block>; 2],
}

impl<R: Real> Tangent<R> {
    pub(crate) fn new(model: &Model<R>) -> Self {
        Tangent {
            springs: SpringMatrix::new(&model.springs, &model.slots),
            diagonals: column(&model.slots, 25),
            inverses: [26, 27].map(|place| column(&model.slots, place)),
            other: OtherWork::default(),
        }
    }

    /// Overwrites the matrix with that about a stage.
    pub(crate) fn linearise(&mut self, model: &Model<R>, stage: &Stage<'_, R>) {
        let Tangent { springs, diagonals, inverses: [upper, lower], other } = self;
        let level = stage.moment.level;
        let records = diagonals.as_chunks_mut::<RECORD>().0.iter_mut();
        for (diagonals, masses) in records.zip(model.mass_column.as_chunks::<LANES>().0) {
            diagonals.as_chunks_mut::<LANES>().0.fill(*masses);
        }
        model.single().into_iter().for_each(|kind| kind.add_diagonals(stage, diagonals));
        at_level!(level, _simd => set_blocks(diagonals, upper, lower));
        let mut sums = MatrixSums { springs, blocks: [&mut **upper, &mut **lower] };
        model.inner().into_iter().for_each(|kind| kind.linearise(stage, &mut sums));
        for element in model.other().into_iter().filter_map(|kind| kind.element()) {
            other.add_blocks(element, stage, [upper, lower]);
        }
        let inverse_masses = &model.inverse_mass_column;
        at_level!(level, _simd => invert_blocks::<R>(inverse_masses, upper, lower));
    }

    /// Mass, drag and grabs of each particle, kilograms, three times each: the product of the
    /// matrix with a translation of a whole body.
    pub(crate) fn diagonals(&self) -> &[R] {
        &self.diagonals
    }

    /// The inverses of the blocks of particles.
    pub(crate) fn inverses(&self) -> &[Aligned<R>; 2] {
        &self.inverses
    }

    /// Overwrites products with those of the matrix and a direction.
    pub(crate) fn set_products(
        &mut self,
        model: &Model<R>,
        stage: &Stage<'_, R>,
        direction: &[R],
        products: &mut [R],
    ) {
        let Tangent { springs, diagonals, other, .. } = self;
        at_level!(stage.moment.level, _simd => multiply::<R>(diagonals, direction, products));
        let mut sums = ColumnProducts { springs, direction, products: &mut *products };
        model.inner().into_iter().for_each(|kind| kind.multiply(stage, &mut sums));
        for element in model.other().into_iter().filter_map(|kind| kind.element()) {
            other.add_products(element, stage, direction, products);
        }
    }
}

impl OtherWork {
    fn add_blocks<R: Real>(
        &mut self,
        element: &dyn Element<R>,
        stage: &Stage<'_, R>,
        [upper, lower]: [&mut [R]; 2],
    ) {
        let motion = &stage.moment.motion;
        let [stiffness, damping] = &mut self.blocks;
        for blocks in [&mut *stiffness, damping] {
            blocks.clear();
            blocks.resize(motion.particle_count(), Block::default());
        }
        element.add_blocks(motion, &mut Blocks { stiffness, damping });
        let tau = stage.tau.to_f64();
        for (at, (k, b)) in motion.slots.places().zip(stiffness.iter().zip(&*damping)) {
            let number = |i: usize| tau * (tau * k[i] + b[i]);
            let adds = [[0, 1, 2], [3, 4, 5]].map(|row| DVec3::from_array(row.map(number)));
            add_vector::<R>(upper, at, R::Vec3::of(adds[0]));
            add_vector::<R>(lower, at, R::Vec3::of(adds[1]));
        }
    }

    fn add_products<R: Real>(
        &mut self,
        element: &dyn Element<R>,
        stage: &Stage<'_, R>,
        direction: &[R],
        products: &mut [R],
    ) {
        let motion = &stage.moment.motion;
        let OtherWork { direction: asked, products: [stiffness, damping], .. } = self;
        asked.clear();
        asked.extend(motion.slots.places().map(|at| vector::<R>(direction, at).to_f64()));
        for column in [&mut *stiffness, damping] {
            column.clear();
            column.resize(asked.len(), DVec3::ZERO);
        }
        element.add_products(motion, asked, &mut Products { stiffness, damping });
        let tau = stage.tau.to_f64();
        for (at, (&k, &b)) in motion.slots.places().zip(stiffness.iter().zip(&*damping)) {
            add_vector::<R>(products, at, R::Vec3::of((k * tau + b) * tau));
        }
    }
}

#[inline(always)]
fn multiply<R: Real>(diagonals: &[R], direction: &[R], products: &mut [R]) {
    let n = products.len();
    let (diagonals, direction) = (&diagonals[..n], &direction[..n]);
    for i in 0..n {
        products[i] = diagonals[i] * direction[i];
    }
}

/// Starts blocks with their diagonals.
#[inline(always)]
fn set_blocks<R: Real>(diagonals: &[R], upper: &mut [R], lower: &mut [R]) {
    let rows = upper.as_chunks_mut::<RECORD>().0.iter_mut();
    let rows = rows.zip(lower.as_chunks_mut::<RECORD>().0);
    for ((upper, lower), diagonals) in rows.zip(diagonals.as_chunks::<RECORD>().0) {
        upper[..LANES].copy_from_slice(&diagonals[..LANES]);
        upper[LANES..].fill(R::ZERO);
        lower[LANES..2 * LANES].fill(R::ZERO);
        lower[..LANES].copy_from_slice(&diagonals[LANES..2 * LANES]);
        lower[2 * LANES..].copy_from_slice(&diagonals[2 * LANES..]);
    }
}

/// The numbers of sixteen blocks.
type Sixteen<R> = [[R; LANES]; 6];

#[inline(always)]
fn invert_blocks<R: Real>(inverse_masses: &[R], upper: &mut [R], lower: &mut [R]) {
    let rows = upper.as_chunks_mut::<RECORD>().0.iter_mut();
    let rows = rows.zip(lower.as_chunks_mut::<RECORD>().0);
    for ((upper, lower), w) in rows.zip(inverse_masses.as_chunks::<RECORD>().0) {
        let mut inverses: Sixteen<R> = [[R::ZERO; LANES]; 6];
        let mut sound = [true; LANES];
        for lane in 0..LANES {
            let [xx, xy, xz] = [0, 1, 2].map(|row| upper[row * LANES + lane].to_f64());
            let [yy, yz, zz] = [0, 1, 2].map(|row| lower[row * LANES + lane].to_f64());
            let (found, is_sound) = inverse::<R>([xx, xy, xz, yy, yz, zz]);
            let is_pinned = w[lane] == R::ZERO;
            for (column, found) in inverses.iter_mut().zip(found) {
                column[lane] = if is_pinned { R::ZERO } else { R::of(found) };
            }
            sound[lane] = is_sound | is_pinned;
        }
        if sound != [true; LANES] {
            invert_steadily([upper, lower], sound, &mut inverses);
        }
        for row in 0..3 {
            upper[row * LANES..][..LANES].copy_from_slice(&inverses[row]);
            lower[row * LANES..][..LANES].copy_from_slice(&inverses[3 + row]);
        }
    }
}

/// Inverts the blocks that rounding made singular.
#[cold]
fn invert_steadily<R: Real>(
    blocks: [&[R; RECORD]; 2],
    sound: [bool; LANES],
    inverses: &mut Sixteen<R>,
) {
    for lane in (0..LANES).filter(|&lane| !sound[lane]) {
        let number = |i: usize| blocks[i / 3][i % 3 * LANES + lane].to_f64();
        let found = steady_inverse::<R>([0, 1, 2, 3, 4, 5].map(number));
        for (column, found) in inverses.iter_mut().zip(found) {
            column[lane] = R::of(found);
        }
    }
}

/// The inverse of a symmetric positive matrix by cofactors, and whether it is sound: the numbers
/// xx, xy, xz, yy, yz and zz of both. Where it is not, there is [`steady_inverse`].
///
/// In double precision: a stiff spring and a light particle differ by more than 2^24.
#[inline(always)]
fn inverse<R: Real>(block: Block) -> (Block, bool) {
    let scale = 1.0 / (block[0] + block[3] + block[5]);
    let (found, determinant) = cofactors(block.map(|number| number * scale));
    // About the smallest eigenvalue: the determinant over the sum of products of two.
    let minors = found[0] + found[3] + found[5];
    let rounding = rounding::<R>();
    let sound = (rounding * minors < determinant) & (rounding < minors);
    let factor = scale / determinant;
    (found.map(|cofactor| cofactor * factor), sound)
}

/// The inverse of a matrix that rounding made singular or indefinite, which would end a solve
/// before it begins: a mass was rounded away beside a stiff spring.
///
/// Enough is added to the diagonal that rounding cannot matter: the inverse only preconditions the
/// solve.
fn steady_inverse<R: Real>(block: Block) -> Block {
    let scale = 1.0 / (block[0] + block[3] + block[5]);
    let mut block = block.map(|number| number * scale);
    [0, 3, 5].into_iter().for_each(|number| block[number] += rounding::<R>());
    let (found, determinant) = cofactors(block);
    found.map(|cofactor| cofactor * (scale / determinant))
}

/// The rounding of an eigenvalue, as a fraction of the trace.
#[inline(always)]
fn rounding<R: Real>() -> f64 {
    8.0 * R::EPSILON.to_f64()
}

/// The cofactors of a symmetric matrix, and its determinant.
#[inline(always)]
fn cofactors([xx, xy, xz, yy, yz, zz]: Block) -> (Block, f64) {
    let (a, b, c) = (yy * zz - yz * yz, yz * xz - xy * zz, xy * yz - yy * xz);
    let (d, e, f) = (zz * xx - xz * xz, xz * xy - yz * xx, xx * yy - xy * xy);
    ([a, b, c, d, e, f], xx * a + xy * b + xz * c)
}
