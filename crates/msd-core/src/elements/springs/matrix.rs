//! Spring terms of the matrix of an implicit method, in the order of the layout.
//!
//! For a stage of length τ the matrix is A = M − τ ∂f/∂v − τ² ∂f/∂x. It is never written down: it
//! is a direction and two weights for each spring of a row, in sixteens as everything else of a
//! row.

use super::Springs;
use super::law::{Law, Tangent};
use super::layout::{Band, Layout, Row};
use super::sweep::{add_column, add_to_quads, columns_of, laws, motion, set_points};
use crate::columns::slots::Slots;
use crate::columns::{Aligned, LANES, RECORD, add_vector, load, store, vector};
use crate::elements::{Motion, Stage};
use crate::number::{GATHERED, POINT, QUAD, Real, Vector, at_level};
use crate::pack::{Number, Pack, zip};
use alloc::vec::Vec;
use fearless_simd::{Level, Simd};

/// The terms of springs in the matrix, kilograms.
///
/// A spring at length L and tension t = k (L − rest) + b u·(v_b − v_a) adds, between its ends,
/// (τ² k + τ b) u uᵀ + τ² max(0, t / L) (1 − u uᵀ): the exact derivative but for two things.
///
/// - A spring that pushes is unstable sideways, t < 0, and would make A indefinite; there it adds
///   nothing (Choi and Ko, 2002).
/// - The force of a damper also turns with the spring by b u (w − u (u·w))ᵀ / L, which is not
///   symmetric and is left out.
///
/// Only the matrix is approximate, never the force: the omitted part changes a velocity by a term
/// of third order in τ, and Newton iterations remove it.
#[derive(Clone, Debug)]
pub(crate) struct SpringMatrix<R: Real> {
    /// [`WEIGHTS`] sixteens for each row: direction x, y and z, weight along and weight across.
    rows: Aligned<R>,
    /// The same of each extra.
    extras: Vec<SpringProduct<R>>,
    /// Sums at the ends of segments, kept until their turn in their own lane.
    ahead: [Aligned<R>; 2],
    /// Numbers by particle, and sums at the ends that are named, where a block has no segments.
    points: Aligned<R>,
    named: [Aligned<R>; 2],
}

/// Sixteens for each row.
const WEIGHTS: usize = 5;

/// The product of one spring with a relative motion d: `across` d + `along` u (u·d).
#[derive(Clone, Copy, Debug)]
struct SpringProduct<R: Real> {
    direction: R::Vec3,
    /// Weight along the spring beyond that in every direction, kilograms.
    along: R,
    /// Weight in every direction, kilograms.
    across: R,
}

impl<R: Real> SpringMatrix<R> {
    pub(crate) fn new(springs: &Springs<R>, slots: &Slots) -> Self {
        let (layout, records) = (&springs.layout, slots.record_count());
        let slots = (records + 2 * layout.reach()) * LANES;
        let slots = if layout.others.is_empty() { 0 } else { slots };
        let ahead = |place| Aligned::new((layout.halo() + 2) * RECORD, place);
        let named = |place| Aligned::new(slots * QUAD, place);
        SpringMatrix {
            rows: Aligned::new(layout.rows.len() * WEIGHTS * LANES, 21),
            extras: Vec::with_capacity(layout.extras.len()),
            ahead: [ahead(22), ahead(23)],
            points: Aligned::new(slots * POINT, 24),
            named: [named(25), named(26)],
        }
    }

    /// Overwrites the weights with those about a stage, and adds to the diagonal blocks of all
    /// particles. Their numbers xx, xy and xz are in one column, yy, yz and zz in another.
    pub(crate) fn linearise(
        &mut self,
        springs: &Springs<R>,
        stage: &Stage<'_, R>,
        blocks: &mut [&mut [R]; 2],
    ) {
        let Springs { layout, values, .. } = springs;
        let (tau, level) = (stage.tau, stage.moment.level);
        let Motion { positions, velocities, .. } = stage.moment.motion;
        if !layout.others.is_empty() {
            let points = &mut self.points[layout.reach() * LANES * POINT..];
            at_level!(level, simd => set_points(simd, [positions, velocities], points));
        }
        let SpringMatrix { rows, extras, ahead, points, named } = self;
        let mut sweep = Linearise { positions, velocities, points, table: values, tau, rows };
        let mut sums = RowSums {
            columns: blocks.each_mut().map(|block| &mut **block),
            ahead: ahead.each_mut().map(|a| &mut **a),
            named,
        };
        at_level!(level, simd => walk(simd, layout, &mut sweep, &mut sums));
        extras.clear();
        let [upper, lower] = sums.columns;
        for extra in &layout.extras {
            let ends = extra.at.map(|at| at as usize);
            let [d, v] = [positions, velocities].map(|column| {
                let [here, there] = ends.map(|at| vector::<R>(column, at));
                here - there
            });
            let law = springs.law(extra.spring as usize);
            let weights = SpringProduct::new(Tangent::new([d, v], law), tau);
            for at in ends {
                let [a, b] = weights.block();
                add_vector::<R>(upper, at, a);
                add_vector::<R>(lower, at, b);
            }
            extras.push(weights);
        }
    }

    /// Adds the product with a direction.
    pub(crate) fn add_products(
        &mut self,
        level: Level,
        springs: &Springs<R>,
        direction: &[R],
        products: &mut [R],
    ) {
        let layout = &springs.layout;
        if !layout.others.is_empty() {
            let points = &mut self.points[layout.reach() * LANES * POINT..];
            at_level!(level, simd => set_directions(simd, direction, points));
        }
        let SpringMatrix { rows, extras, ahead: [ahead, _], points, named } = self;
        let mut sweep = Multiply { direction, points, rows };
        let mut sums = RowSums { columns: [products], ahead: [ahead], named };
        at_level!(level, simd => walk(simd, layout, &mut sweep, &mut sums));
        let [products] = sums.columns;
        for (extra, weights) in layout.extras.iter().zip(extras) {
            let [here, there] = extra.at.map(|at| at as usize);
            let d = vector::<R>(direction, here) - vector::<R>(direction, there);
            let along = weights.along * weights.direction.dot(d);
            let product = d * weights.across + weights.direction * along;
            add_vector::<R>(products, here, product);
            add_vector::<R>(products, there, -product);
        }
    }
}

impl<R: Real> SpringProduct<R> {
    /// The weights of a derivative.
    fn new(tangent: Tangent<R>, tau: R) -> Self {
        let across = tau * tau * Real::max(tangent.across, R::ZERO);
        let along = tau * (tau * tangent.along + tangent.damping) - across;
        SpringProduct { direction: tangent.direction, along, across }
    }

    /// Its term in the block of either end: xx, xy and xz, and yy, yz and zz.
    fn block(&self) -> [R::Vec3; 2] {
        let [x, y, z] = self.direction.components();
        let w = self.along;
        let upper = [w * x * x + self.across, w * x * y, w * x * z];
        let lower = [w * y * y + self.across, w * y * z, w * z * z + self.across];
        [upper, lower].map(R::Vec3::from_components)
    }
}

/// Copies directions to points, where positions are else.
#[inline(always)]
fn set_directions<S: Simd, R: Real>(simd: S, directions: &[R], points: &mut [R]) {
    let points = points.as_chunks_mut::<POINT>().0.as_chunks_mut::<LANES>().0;
    for (direction, points) in directions.as_chunks::<RECORD>().0.iter().zip(points) {
        for (point, quad) in points.iter_mut().zip(R::to_quads(simd, direction)) {
            point[..QUAD].copy_from_slice(&quad);
        }
    }
}

/// A sweep over rows that adds N vectors to both ends of each spring.
trait RowPass<S: Simd, R: Real, const N: usize> {
    /// The data that it reads of some particles.
    type End: Copy;
    /// Whether the vectors added at `there` are the opposites of those at `here`.
    const OPPOSITE: bool;
    /// Reads from a record.
    fn end(&self, simd: S, at: usize, part: usize) -> Self::End;
    /// Numbers by particle.
    fn points(&self) -> &[R];
    /// Reads the first lanes of particles that were gathered.
    fn gathered(&self, simd: S, columns: &[R; GATHERED]) -> Self::End;
    /// The vectors to add to the ends `here`; `place` is the number of the row and the lane in it.
    fn add(
        &mut self,
        simd: S,
        row: &Row,
        place: (usize, usize),
        ends: [Self::End; 2],
    ) -> [[Pack<S, R>; 3]; N];
}

/// The sums of a sweep.
struct RowSums<'a, R, const N: usize> {
    columns: [&'a mut [R]; N],
    ahead: [&'a mut [R]; N],
    /// A quad for each slot.
    named: &'a mut [Aligned<R>; 2],
}

#[inline(always)]
fn walk<S: Simd, R: Real, W: RowPass<S, R, N>, const N: usize>(
    simd: S,
    layout: &Layout,
    sweep: &mut W,
    sums: &mut RowSums<'_, R, N>,
) {
    for band in layout.bands.iter().filter(|band| !band.rows.is_empty()) {
        match band.halo {
            Some(halo) => walk_segments(simd, (layout, band, halo), sweep, sums),
            None => walk_named(simd, (layout, band), sweep, sums),
        }
    }
}

/// Walks along springs between records, each of which is met once.
#[inline(always)]
fn walk_segments<S: Simd, R: Real, W: RowPass<S, R, N>, const N: usize>(
    simd: S,
    (layout, band, halo): (&Layout, &Band, usize),
    sweep: &mut W,
    RowSums { columns, ahead, .. }: &mut RowSums<'_, R, N>,
) {
    let lanes = Pack::<S, R>::LEN;
    let (first, rows) = (band.numbers.start, &layout.rows[band.rows.clone()]);
    let mut next = 0;
    for (number, step) in layout.steps[band.steps.clone()].iter().enumerate() {
        let (at, carry) = (first + step.at as usize, step.carry as usize);
        let start = next;
        next += step.rows as usize;
        for part in (0..LANES).step_by(lanes) {
            let here = sweep.end(simd, at, part);
            let mut sums = [[Pack::new(simd, R::ZERO); 3]; N];
            for (sum, ahead) in sums.iter_mut().zip(&*ahead) {
                *sum = load(simd, &ahead[carry..], part);
            }
            for (row, number) in rows[start..next].iter().zip(band.rows.start + start..) {
                let other = first + row.other as usize;
                let there = sweep.end(simd, other, part);
                let adds = sweep.add(simd, row, (number, part), [here, there]);
                for ((sum, column), add) in sums.iter_mut().zip(columns.iter_mut()).zip(adds) {
                    let far: [Pack<S, R>; 3] = load(simd, &column[other..], part);
                    let far = zip(far, add, |f, a| if W::OPPOSITE { f - a } else { f + a });
                    store(far, &mut column[other..], part);
                    *sum = zip(*sum, add, |s, a| s + a);
                }
            }
            if number < halo {
                for (sum, ahead) in sums.into_iter().zip(ahead.iter_mut()) {
                    store(sum, &mut ahead[(1 + number) * RECORD..], part);
                }
            } else {
                add_to(simd, (columns, at, part), sums);
            }
        }
    }
}

/// Walks along springs whose other ends are named one by one, each of which is met once.
#[inline(always)]
fn walk_named<S: Simd, R: Real, W: RowPass<S, R, N>, const N: usize>(
    simd: S,
    (layout, band): (&Layout, &Band),
    sweep: &mut W,
    RowSums { columns, named, .. }: &mut RowSums<'_, R, N>,
) {
    let lanes = Pack::<S, R>::LEN;
    // Where the record of the first number is in the tables.
    let (first, records) =
        (layout.reach() + band.numbers.start / RECORD, band.numbers.len() / RECORD);
    for named in &mut named[..N] {
        let seen = first - band.reach..first + records + band.reach;
        named[seen.start * LANES * QUAD..seen.end * LANES * QUAD].fill(R::ZERO);
    }
    let mut rows = band.rows.clone();
    for step in &layout.steps[band.steps.clone()] {
        let at = band.numbers.start + step.at as usize;
        let mut own = [[R::ZERO; RECORD]; N];
        let seen = (first - band.reach + step.at as usize / RECORD) * LANES;
        let seen = seen..seen + (1 + 2 * band.reach) * LANES;
        for number in rows.by_ref().take(step.rows as usize) {
            let row = &layout.rows[number];
            let others = &layout.others[row.other as usize];
            let mut added = [[R::ZERO; RECORD]; N];
            for part in (0..LANES).step_by(lanes) {
                let here = sweep.end(simd, at, part);
                let mut there = [R::ZERO; GATHERED];
                let points = &sweep.points().as_chunks::<POINT>().0[seen.clone()];
                R::gather(simd, points, &others[part..part + lanes], &mut there);
                let there = sweep.gathered(simd, &there);
                let adds = sweep.add(simd, row, (number, part), [here, there]);
                for (add, (own, added)) in adds.into_iter().zip(own.iter_mut().zip(&mut added)) {
                    let sum: [Pack<S, R>; 3] = load(simd, own, part);
                    store(zip(sum, add, |s, a| s + a), own, part);
                    store(add, added, part);
                }
            }
            for (named, added) in named.iter_mut().zip(&added) {
                let quads = &mut named.as_chunks_mut::<QUAD>().0[seen.clone()];
                add_to_quads(simd, others, added, quads);
            }
        }
        for (own, column) in own.iter().zip(columns.iter_mut()) {
            add_column(own, &mut column[at..at + RECORD]);
        }
    }
    for (named, column) in named.iter().zip(columns) {
        let records = column[band.numbers.clone()].as_chunks_mut::<RECORD>().0;
        for (record, number) in records.iter_mut().zip(first..) {
            for (to, add) in record.iter_mut().zip(columns_of(simd, named, number)) {
                *to = if W::OPPOSITE { *to - add } else { *to + add };
            }
        }
    }
}

#[inline(always)]
fn add_to<S: Simd, R: Real, const N: usize>(
    simd: S,
    (columns, at, part): (&mut [&mut [R]; N], usize, usize),
    sums: [[Pack<S, R>; 3]; N],
) {
    for (sum, column) in sums.into_iter().zip(columns) {
        let own: [Pack<S, R>; 3] = load(simd, &column[at..], part);
        store(zip(own, sum, |o, s| o + s), &mut column[at..], part);
    }
}

/// Makes the weights of rows, and adds them to the blocks of both ends.
struct Linearise<'a, R> {
    positions: &'a [R],
    velocities: &'a [R],
    points: &'a [R],
    /// The numbers of rows in sixteens.
    table: &'a [R],
    tau: R,
    rows: &'a mut [R],
}

impl<S: Simd, R: Real> RowPass<S, R, 2> for Linearise<'_, R> {
    type End = [[Pack<S, R>; 3]; 2];
    const OPPOSITE: bool = false;

    #[inline(always)]
    fn end(&self, simd: S, at: usize, part: usize) -> Self::End {
        motion::<S, R, true>(simd, self.positions, self.velocities, at, part)
    }

    #[inline(always)]
    fn points(&self) -> &[R] {
        self.points
    }

    #[inline(always)]
    fn gathered(&self, simd: S, columns: &[R; GATHERED]) -> Self::End {
        motion::<S, R, true>(simd, columns, &columns[RECORD..], 0, 0)
    }

    #[inline(always)]
    fn add(
        &mut self,
        simd: S,
        row: &Row,
        (number, part): (usize, usize),
        [[x, v], [x_there, v_there]]: [Self::End; 2],
    ) -> [[Pack<S, R>; 3]; 2] {
        let splat = |value| Pack::<S, R>::new(simd, value);
        let (zero, tau) = (splat(R::ZERO), splat(self.tau));
        let (Law { rest, stiffness, damping }, is_there) = laws(simd, self.table, row, part);
        let (d, w) = (zip(x, x_there, |a, b| a - b), zip(v, v_there, |a, b| a - b));
        let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        let length = square.sqrt();
        let inverse = splat(R::ONE) / length;
        let u = d.map(|d| d * inverse);
        let rate = u[0] * w[0] + u[1] * w[1] + u[2] * w[2];
        let tension = (stiffness * (length - rest) + damping * rate) * inverse;
        let across = tau * tau * tension.max(zero);
        let along = tau * (tau * stiffness + damping) - across;
        let on = splat(R::SHORTEST_SQUARED).is_at_most(square) & is_there;
        let or_zero = |number| Number::select(on, number, zero);
        let ([x, y, z], along, across) = (u.map(or_zero), or_zero(along), or_zero(across));
        let numbers = &mut self.rows[number * WEIGHTS * LANES..][..WEIGHTS * LANES];
        let sixteens = numbers.as_chunks_mut::<LANES>().0;
        let lanes = part..part + Pack::<S, R>::LEN;
        for (sixteen, value) in sixteens.iter_mut().zip([x, y, z, along, across]) {
            value.store_slice(&mut sixteen[lanes.clone()]);
        }
        let [wx, wy, wz] = [x * along, y * along, z * along];
        [[wx * x + across, wx * y, wx * z], [wy * y + across, wy * z, wz * z + across]]
    }
}

/// Multiplies a direction.
struct Multiply<'a, R> {
    direction: &'a [R],
    points: &'a [R],
    rows: &'a [R],
}

impl<S: Simd, R: Real> RowPass<S, R, 1> for Multiply<'_, R> {
    type End = [Pack<S, R>; 3];
    const OPPOSITE: bool = true;

    #[inline(always)]
    fn end(&self, simd: S, at: usize, part: usize) -> Self::End {
        load(simd, &self.direction[at..], part)
    }

    #[inline(always)]
    fn points(&self) -> &[R] {
        self.points
    }

    #[inline(always)]
    fn gathered(&self, simd: S, columns: &[R; GATHERED]) -> Self::End {
        load(simd, columns, 0)
    }

    /// A missing spring has weights of zero.
    #[inline(always)]
    fn add(
        &mut self,
        simd: S,
        _: &Row,
        (number, part): (usize, usize),
        [here, there]: [Self::End; 2],
    ) -> [[Pack<S, R>; 3]; 1] {
        let numbers = &self.rows[number * WEIGHTS * LANES..][..WEIGHTS * LANES];
        let u: [Pack<S, R>; 3] = load(simd, numbers, part);
        let weights = &numbers[RECORD + part..];
        let lanes = Pack::<S, R>::LEN;
        let along = Pack::from_slice(simd, &weights[..lanes]);
        let across = Pack::from_slice(simd, &weights[LANES..LANES + lanes]);
        let d = zip(here, there, |a, b| a - b);
        let along = along * (u[0] * d[0] + u[1] * d[1] + u[2] * d[2]);
        [zip(d, u, |d, u| d * across + u * along)]
    }
}
