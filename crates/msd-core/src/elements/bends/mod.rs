//! Bends: stencils of particles that resist bending.
//!
//! [`Bend`] is the law of one. A bundle adds what its bends would add one after the other, to the
//! bit. Those that are curved at rest have a law of their own, in `curved.rs`, and are always
//! evaluated one by one.

mod curved;
mod law;

use super::stencils::{Stencil, StencilLaw, Stencils, lane, record, subtract_record};
use super::{
    Derivatives, Element, Force, ForceWork, Joints, MatrixWork, Moment, Motion, Products,
    Projection, Resists, Rows, Stage, Torn, Vectors,
};
use crate::columns::{LANES, add_vector};
use crate::elements::touches::near::Near;
use crate::number::{Real, Vector, at_level};
use crate::scene::{Bend, Scene};
use glam::DVec3;
use law::{BendLaw, BendRow, add_curved_blocks, dot_parts, is_straight};

/// The bends of a model.
pub type Bends<R> = Stencils<BendLaw<R>, 4>;

/// Straight bends of the same weights, each in a lane of its own; `at` is where their numbers
/// start.
#[derive(Clone, Debug)]
pub struct BendBundle<R> {
    at: [u32; 4],
    weights: [R; 4],
    stiffnesses: [R; LANES],
    dampings: [R; LANES],
    is_there: [bool; LANES],
    /// Whether all lanes have a bend.
    is_full: bool,
}

impl<R: Real> StencilLaw<4> for BendLaw<R> {
    type Number = R;
    type Bundle = BendBundle<R>;

    fn bundle(rows: &[Stencil<Self, 4>]) -> BendBundle<R> {
        let first = &rows[0];
        let mut bundle = BendBundle {
            at: first.at.map(|at| at - lane(first.at) as u32),
            weights: first.law.weights,
            stiffnesses: [R::ZERO; LANES],
            dampings: [R::ZERO; LANES],
            is_there: [false; LANES],
            is_full: rows.len() == LANES,
        };
        for row in rows {
            let lane = lane(row.at);
            bundle.stiffnesses[lane] = row.law.stiffness;
            bundle.dampings[lane] = row.law.damping;
            bundle.is_there[lane] = true;
        }
        bundle
    }

    fn is_alike(&self, other: &Self) -> bool {
        self.weights == other.weights && self.rest == R::ZERO && other.rest == R::ZERO
    }

    fn constants(&mut self) -> [&mut R; 2] {
        [&mut self.stiffness, &mut self.damping]
    }
}

impl<R: Real> BendBundle<R> {
    /// The weighted sums along an axis.
    #[inline(always)]
    fn sums(&self, column: &[R], axis: usize) -> [R; LANES] {
        let first = record(column, self.at[0], axis);
        let mut sums = [R::ZERO; LANES];
        for end in (1..4).filter(|&end| self.weights[end] != R::ZERO) {
            let (other, weight) = (record(column, self.at[end], axis), self.weights[end]);
            for lane in 0..LANES {
                sums[lane] += (other[lane] - first[lane]) * weight;
            }
        }
        sums
    }

    /// The components of first edges along an axis.
    #[inline(always)]
    fn edges(&self, column: &[R], axis: usize) -> [R; LANES] {
        let [first, second] = [0, 1].map(|end| record(column, self.at[end], axis));
        let mut edges = [R::ZERO; LANES];
        for lane in 0..LANES {
            edges[lane] = second[lane] - first[lane];
        }
        edges
    }

    /// Subtracts pulls along an axis, each times the weights, from what is summed.
    #[inline(always)]
    fn subtract(&self, pulls: [R; LANES], axis: usize, sums: &mut [R]) {
        for end in (0..4).filter(|&end| self.weights[end] != R::ZERO) {
            let weight = self.weights[end];
            let is_there = |lane: usize| self.is_full | self.is_there[lane];
            let less = |lane: usize| pulls[lane] * weight;
            subtract_record((&mut *sums, self.at[end], axis), less, is_there);
        }
    }
}

impl<R: Real> Bends<R> {
    /// The bends as rows of a scene, in the order in which they are evaluated.
    pub fn rows(&self) -> impl Iterator<Item = Bend> + '_ {
        self.all.iter().map(|row| Bend {
            particles: row.particles.map(|particle| particle as usize),
            weights: row.law.weights.map(R::to_f64),
            rest: row.law.rest.to_f64(),
            stiffness: row.law.stiffness.to_f64(),
            damping: row.law.damping.to_f64(),
        })
    }
}

/// Adds the forces of all bends and returns the power that they dissipate.
#[inline(always)]
fn add_forces<R: Real>(bends: &Bends<R>, [x, v]: [&[R]; 2], forces: &mut [R]) -> f64 {
    let mut powers = [0.0; LANES];
    for bundle in &bends.bundles {
        let sums = [0, 1, 2].map(|axis| bundle.sums(x, axis));
        let mut factors = bundle.stiffnesses;
        if bends.is_damped {
            let rates = [0, 1, 2].map(|axis| bundle.sums(v, axis));
            let (squares, alongs) = (dots(&sums, &sums), dots(&sums, &rates));
            for lane in 0..LANES {
                let drag = alongs[lane] * bundle.dampings[lane] * (R::ONE / squares[lane]);
                // A select: without a direction the quotient is NaN.
                let drag = if R::SHORTEST_SQUARED <= squares[lane] { drag } else { R::ZERO };
                factors[lane] += drag;
                powers[lane] += (alongs[lane] * drag).to_f64();
            }
        }
        for (axis, sums) in sums.into_iter().enumerate() {
            bundle.subtract(product(sums, factors), axis, forces);
        }
    }
    let power: f64 = powers.iter().sum();
    bends.singles().iter().fold(power, |power, row| power + add_force(row, [x, v], forces))
}

/// Adds the forces of one bend and returns the power that it dissipates.
#[inline(always)]
fn add_force<R: Real>(row: &BendRow<R>, [x, v]: [&[R]; 2], forces: &mut [R]) -> f64 {
    if let Some(curved) = row.law.curved(row.of(x)) {
        let (parts, taken) = row.law.curved_pull(&curved, row.of(v));
        row.subtract_parts(parts, forces);
        return taken.to_f64();
    }
    let (pull, taken) = row.law.pull(row.law.sum(row.of(x)), row.law.sum(row.of(v)));
    row.subtract(pull, forces);
    taken.to_f64()
}

/// Adds the products of τ (τ k + b) about positions with a direction.
#[inline(always)]
fn add_products<R: Real>(
    bends: &Bends<R>,
    tau: R,
    (x, direction): (&[R], &[R]),
    products: &mut [R],
) {
    // Subtracts: what is summed is the opposite of a force.
    for bundle in &bends.bundles {
        let sums = [0, 1, 2].map(|axis| bundle.sums(direction, axis));
        let mut pulls = sums.map(|sums| product(sums, bundle.stiffnesses.map(|k| tau * tau * k)));
        if bends.is_damped {
            let bent = [0, 1, 2].map(|axis| bundle.sums(x, axis));
            let edges = [0, 1, 2].map(|axis| bundle.edges(x, axis));
            let (squares, lengths) = (dots(&bent, &bent), dots(&edges, &edges));
            let alongs = dots(&bent, &sums);
            for lane in 0..LANES {
                let damping = tau * bundle.dampings[lane];
                let straight = is_straight::<R>(squares[lane], lengths[lane]);
                let along = damping * alongs[lane] * (R::ONE / squares[lane]);
                for axis in 0..3 {
                    let (all, one) = (sums[axis][lane] * damping, bent[axis][lane] * along);
                    pulls[axis][lane] += if straight { all } else { one };
                }
            }
        }
        for (axis, pulls) in pulls.into_iter().enumerate() {
            bundle.subtract(pulls.map(|pull| -pull), axis, products);
        }
    }
    for row in bends.singles() {
        let (law, of) = (&row.law, row.of(direction));
        if let Some(curved) = law.curved(row.of(x)) {
            let pull = curved.change(&of) * (tau * tau * law.stiffness);
            row.subtract_parts(curved.parts(-pull), products);
            if law.damping != R::ZERO {
                let along = curved.gradient();
                let drag = dot_parts::<R>(&along, of) * (tau * law.damping);
                row.subtract_parts(along.map(|part| part * -drag), products);
            }
            continue;
        }
        row.subtract(-law.product(tau, law.bent(row.of(x)), law.sum(of)), products);
    }
}

/// The scalar products of vectors in lanes.
#[inline(always)]
fn dots<R: Real>(a: &[[R; LANES]; 3], b: &[[R; LANES]; 3]) -> [R; LANES] {
    let mut dots = [R::ZERO; LANES];
    for lane in 0..LANES {
        dots[lane] = a[0][lane] * b[0][lane] + a[1][lane] * b[1][lane] + a[2][lane] * b[2][lane];
    }
    dots
}

/// The products of numbers, lane by lane.
#[inline(always)]
fn product<R: Real>(a: [R; LANES], b: [R; LANES]) -> [R; LANES] {
    let mut products = [R::ZERO; LANES];
    for lane in 0..LANES {
        products[lane] = a[lane] * b[lane];
    }
    products
}

impl<R: Real> Element<R> for Bends<R> {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let columns = [motion.positions, motion.velocities];
        let rows = self.all.iter().map(|row| row.placed(motion.slots));
        rows.map(|row| add_force(&row, columns, forces.numbers)).sum()
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
        for row in &self.all {
            let (law, particle) = (&row.law, |end: usize| row.particles[end] as usize);
            let position = |end: usize| motion.position(particle(end)).to_f64();
            let way = |end: usize| direction[particle(end)];
            if let Some(curved) = law.curved_f64(position) {
                let elastic = curved.product(law.stiffness.to_f64(), way);
                let along = curved.gradient();
                let drag = dot_parts::<f64>(&along, way) * law.damping.to_f64();
                for (end, elastic) in elastic.into_iter().enumerate() {
                    products.add(particle(end), [elastic, along[end] * drag]);
                }
                continue;
            }
            let (of, bent) = (law.sum_f64(way), law.sum_f64(position));
            let edge = (motion.position(particle(1)) - motion.position(particle(0))).to_f64();
            let square = bent.dot(bent);
            let along = match is_straight::<f64>(square, edge.dot(edge)) {
                true => of,
                false => bent * (bent.dot(of) / square),
            };
            for (end, weight) in row.terms() {
                let by = [law.stiffness, law.damping].map(|value| (value * weight).to_f64());
                products.add(end, [of * by[0], along * by[1]]);
            }
        }
    }
}

impl<R: Real> Force<R> for Bends<R> {
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
        let Motion { positions, velocities, .. } = moment.motion;
        at_level!(moment.level, _simd => add_forces(self, [positions, velocities], forces))
    }

    fn energy_and_pulls(&self, moment: &Moment<'_, R>, _: &Near<R>) -> [f64; 3] {
        self.stored(&moment.motion)
    }

    fn add_row_sums(&self, motion: &Motion<'_, R>, _: &Derivatives, sums: &mut [[f64; 2]]) {
        for row in &self.all {
            let (law, particle) = (&row.law, |end: usize| row.particles[end] as usize);
            let position = |end: usize| motion.position(particle(end)).to_f64();
            if let Some(curved) = law.curved_f64(position) {
                let [stiffness, damping] = [law.stiffness, law.damping].map(R::to_f64);
                let (bounds, along) = (curved.bounds(), curved.gradient());
                let lengths = along.map(|part| Real::sqrt(part.dot(part)));
                let all: f64 = bounds.iter().map(|bound| bound[0]).sum();
                let total: f64 = lengths.iter().sum();
                let pull = stiffness * Real::sqrt(curved.off.dot(curved.off));
                for (end, [own, turning]) in bounds.into_iter().enumerate() {
                    let sum = &mut sums[particle(end)];
                    sum[0] += stiffness * own * all + pull * turning;
                    sum[1] += damping * lengths[end] * total;
                }
                continue;
            }
            let all: f64 = law.weights.iter().map(|weight| weight.abs().to_f64()).sum();
            for (particle, weight) in row.terms() {
                let weight = weight.abs().to_f64() * all;
                sums[particle][0] += law.stiffness.to_f64() * weight;
                sums[particle][1] += law.damping.to_f64() * weight;
            }
        }
    }

    fn linearise(
        &self,
        stage: &Stage<'_, R>,
        _: &mut MatrixWork<R>,
        _: &mut Near<R>,
        [upper, lower]: [&mut [R]; 2],
    ) {
        let (tau, positions) = (stage.tau, stage.moment.motion.positions);
        for row in &self.all {
            if let Some(curved) = row.law.curved(row.of(positions)) {
                add_curved_blocks(row, &curved, tau, [&mut *upper, &mut *lower]);
                continue;
            }
            let bent = row.law.bent(row.of(positions));
            let axis = |row: [R; 3]| R::Vec3::from_components(row);
            let [zero, one] = [R::ZERO, R::ONE];
            let [x, y, z] = [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
                .map(|unit| row.law.product(tau, bent, axis(unit)).components());
            for (&at, &weight) in row.at.iter().zip(&row.law.weights) {
                let (at, square) = (at as usize, weight * weight);
                add_vector::<R>(upper, at, axis(x) * square);
                add_vector::<R>(lower, at, axis([y[1], y[2], z[2]]) * square);
            }
        }
    }

    fn add_column_products(
        &self,
        stage: &Stage<'_, R>,
        _: &mut MatrixWork<R>,
        direction: &[R],
        products: &mut [R],
    ) {
        if !self.all.is_empty() {
            let (tau, of) = (stage.tau, (stage.moment.motion.positions, direction));
            at_level!(stage.moment.level, _simd => add_products(self, tau, of, products));
        }
    }

    /// A bend is a constraint |s| = 0 of compliance 1/k, of one that is curved |d| = 0.
    fn project(&self, projection: &mut Projection<'_, R>) {
        let Projection { h, inverse_masses, starts, ways, .. } = projection;
        let h = *h;
        for row in &self.all {
            let law = &row.law;
            let [stiff, damp] = [law.stiffness * h * h, law.damping * h];
            let particle = |end: usize| row.particles[end] as usize;
            if let Some(curved) = law.curved(|end| starts[particle(end)] + ways[particle(end)]) {
                row.project_curved(&curved, [stiff, damp], inverse_masses, ways);
                continue;
            }
            let moved = law.sum(|end| ways[particle(end)]);
            let bent = law.sum(|end| starts[particle(end)]) + moved;
            let square = bent.dot(bent);
            if square < R::SHORTEST_SQUARED {
                continue;
            }
            let squares = row.terms().map(|(end, weight)| weight * weight * inverse_masses[end]);
            let yielding = R::ONE + (stiff + damp) * squares.fold(R::ZERO, |sum, add| sum + add);
            let drag = damp * bent.dot(moved) * (R::ONE / square);
            let pull = bent * ((stiff + drag) * (R::ONE / yielding));
            for (end, weight) in row.terms() {
                ways[end] -= pull * (weight * inverse_masses[end]);
            }
        }
    }

    fn each_pair(&self, join: &mut dyn FnMut([u32; 2])) {
        for row in &self.all {
            let ends = row.terms().zip(row.terms().skip(1));
            ends.for_each(|((a, _), (b, _))| join([a as u32, b as u32]));
        }
    }

    fn add(&mut self, rows: &Scene, joints: Joints<'_>) {
        let law = |bend: &Bend| BendLaw {
            weights: bend.weights.map(R::of),
            rest: R::of(bend.rest),
            stiffness: R::of(bend.stiffness),
            damping: R::of(bend.damping),
        };
        let rows = rows.bends.iter().map(|bend| Stencil::new(bend.particles, law(bend)));
        self.extend(rows, joints.slots);
    }

    fn write(&self, rows: &mut Scene) {
        rows.bends.extend(self.rows());
    }

    fn tear(&mut self, torn: &Torn) {
        Stencils::tear(self, torn);
    }

    fn remove(&mut self, is_removed: &dyn Fn(u32) -> bool, _: Joints<'_>) {
        self.retain(|row| !row.terms().any(|(particle, _)| is_removed(particle as u32)));
    }

    fn change(&mut self, (particles, _): &Rows, change: &dyn Fn(Resists, [R; 2]) -> [R; 2]) {
        Stencils::change(self, particles, |constants| change(Resists::Bending, constants));
    }
}

impl<R: Real> Bends<R> {
    /// The energy of all bends, joules; the sums of |k s| and of k, each times the weights, by
    /// which rounding changes it.
    fn stored(&self, motion: &Motion<'_, R>) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for row in &self.all {
            let position = |end: usize| motion.position(row.particles[end] as usize).to_f64();
            let curved = row.law.curved_f64(position);
            let bent = curved.map_or_else(|| row.law.sum_f64(position), |curved| curved.off);
            let weight: f64 = row.law.weights.iter().map(|weight| weight.abs().to_f64()).sum();
            let (stiffness, square) = (row.law.stiffness.to_f64(), bent.dot(bent));
            sums[0] += 0.5 * stiffness * square;
            sums[1] += stiffness * weight * Real::sqrt(square);
            sums[2] += stiffness * weight * weight;
        }
        sums
    }
}
