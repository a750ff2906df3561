//! Bends: stencils of particles that resist bending.
//!
//! [`Bend`] is the law of one. They stand in the order in which they are evaluated, which depends
//! on them and on the slots of particles alone: first those that fit bundles of up to sixteen,
//! whose particles are in the same lane of records, as most of a lattice are; then the others, one
//! by one. A bundle adds what its bends would add one after the other, to the bit. Those that are
//! curved at rest have a law of their own, in `curved.rs`, and are always evaluated one by one.

mod curved;
mod stencil;

use super::bundles::{self, record};
use super::{Element, Motion, Products, Torn, Vectors};
use crate::columns::slots::Slots;
use crate::columns::{LANES, RECORD, set_vector, vector};
use crate::number::{Real, Vector, at_level};
use crate::scene::Bend;
use alloc::vec::Vec;
use fearless_simd::Level;
use glam::DVec3;
use stencil::{Stencil, add_curved_blocks, dot_parts, is_straight, subtract, subtract_parts};

/// The bends of a model.
#[derive(Clone, Debug)]
pub struct Bends<R: Real> {
    /// In the order of evaluation.
    rows: Vec<Stencil<R>>,
    bundles: Vec<Bundle<R>>,
    /// How many of the rows are in bundles: the first ones.
    bundled: usize,
    /// Numbers of a column of vectors.
    numbers: usize,
    is_damped: bool,
}

/// Straight bends of the same weights, each in a lane of its own; `at` is where their numbers
/// start.
#[derive(Clone, Debug)]
struct Bundle<R> {
    at: [u32; 4],
    weights: [R; 4],
    stiffnesses: [R; LANES],
    dampings: [R; LANES],
    is_there: [bool; LANES],
    /// Whether all lanes have a bend.
    is_full: bool,
}

impl<R: Real> Bends<R> {
    /// Puts bends in order.
    pub(crate) fn new(rows: &[Bend], slots: &Slots) -> Self {
        let mut bends = Bends {
            rows: Vec::new(),
            bundles: Vec::new(),
            bundled: 0,
            numbers: 0,
            is_damped: false,
        };
        bends.add(rows, slots);
        bends
    }

    /// Adds bends, and puts all in order anew: the slots may have changed.
    pub(crate) fn add(&mut self, rows: &[Bend], slots: &Slots) {
        self.rows.extend(rows.iter().map(|bend| Stencil {
            particles: bend.particles.map(|particle| particle as u32),
            at: [0; 4],
            weights: bend.weights.map(R::of),
            rest: R::of(bend.rest),
            stiffness: R::of(bend.stiffness),
            damping: R::of(bend.damping),
        }));
        for row in &mut self.rows {
            row.at = row.particles.map(|particle| slots.at(particle as usize) as u32);
        }
        self.numbers = slots.record_count() * RECORD;
        self.bundle();
    }

    /// Puts bends in order and makes bundles of them.
    fn bundle(&mut self) {
        let is_straight = |row: &Stencil<R>| row.rest == R::ZERO;
        let is_alike = |a: &Stencil<R>, b: &Stencil<R>| {
            a.weights == b.weights && is_straight(a) && is_straight(b)
        };
        let bundles = bundles::order(&mut self.rows, self.numbers, |row| row.at, is_alike);
        self.bundled = bundles.last().map_or(0, |last| last.end);
        self.bundles = bundles.into_iter().map(|rows| Bundle::new(&self.rows[rows])).collect();
        self.is_damped = self.rows.iter().any(|row| row.damping != R::ZERO);
    }

    /// The number of bends.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// Whether any bend has a damper.
    pub fn is_damped(&self) -> bool {
        self.is_damped
    }

    /// The bends as rows of a scene, in the order in which they are evaluated.
    pub fn rows(&self) -> impl Iterator<Item = Bend> + '_ {
        self.rows.iter().map(|row| Bend {
            particles: row.particles.map(|particle| particle as usize),
            weights: row.weights.map(R::to_f64),
            rest: row.rest.to_f64(),
            stiffness: row.stiffness.to_f64(),
            damping: row.damping.to_f64(),
        })
    }

    /// Removes the bends of which both ends of a spring that was cut are a part: what is torn does
    /// not go on bending.
    pub(crate) fn tear(&mut self, torn: &Torn) {
        self.retain(|row| !torn.crosses(&row.particles));
    }

    /// Removes the bends of particles that were removed.
    pub(crate) fn remove(&mut self, is_removed: impl Fn(u32) -> bool) {
        self.retain(|row| !row.terms().any(|(particle, _)| is_removed(particle as u32)));
    }

    fn retain(&mut self, is_left: impl Fn(&Stencil<R>) -> bool) {
        let before = self.rows.len();
        self.rows.retain(is_left);
        if self.rows.len() < before {
            self.bundle();
        }
    }

    /// Changes stiffness and damping of the bends of some particles.
    pub(crate) fn change(
        &mut self,
        is_of: impl Fn(u32) -> bool,
        change: impl Fn([R; 2]) -> [R; 2],
    ) {
        for row in self.rows.iter_mut().filter(|row| is_of(row.particles[0])) {
            [row.stiffness, row.damping] = change([row.stiffness, row.damping]);
        }
        self.bundle();
    }

    /// The same bends in another precision, each number rounded once.
    pub(crate) fn convert<S: Real>(&self, slots: &Slots) -> Bends<S> {
        let rows: Vec<Bend> = self.rows().collect();
        Bends::new(&rows, slots)
    }

    /// Adds the forces of all bends, newtons, and returns the power that they dissipate, watts.
    pub(crate) fn add_all(&self, level: Level, motion: &Motion<'_, R>, forces: &mut [R]) -> f64 {
        if self.rows.is_empty() {
            return 0.0;
        }
        let Motion { positions, velocities, .. } = *motion;
        at_level!(level, _simd => add_forces(self, positions, velocities, forces))
    }

    /// Adds the products of τ (τ k + b) about positions with a direction, in columns.
    pub(crate) fn add_column_products(
        &self,
        (level, tau): (Level, R),
        positions: &[R],
        direction: &[R],
        products: &mut [R],
    ) {
        if !self.rows.is_empty() {
            at_level!(level, _simd => add_products(self, tau, (positions, direction), products));
        }
    }

    /// Adds the diagonal blocks of τ (τ k + b) about positions to those of particles.
    pub(crate) fn add_blocks(&self, tau: R, positions: &[R], [upper, lower]: [&mut [R]; 2]) {
        for row in &self.rows {
            let position = |end: usize| vector::<R>(positions, row.at[end] as usize);
            if let Some(curved) = row.curved(position) {
                add_curved_blocks(row, &curved, tau, [&mut *upper, &mut *lower]);
                continue;
            }
            let bent = row.bent(position);
            let axis = |row: [R; 3]| R::Vec3::from_components(row);
            let [zero, one] = [R::ZERO, R::ONE];
            let [x, y, z] = [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
                .map(|unit| row.product(tau, bent, axis(unit)).components());
            for (&at, &weight) in row.at.iter().zip(&row.weights) {
                let (at, square) = (at as usize, weight * weight);
                for (column, numbers) in [(&mut *upper, x), (&mut *lower, [y[1], y[2], z[2]])] {
                    let sum = vector::<R>(column, at) + axis(numbers) * square;
                    set_vector(column, at, sum);
                }
            }
        }
    }

    /// Moves the particles of each bend, in order, as XPBD moves those of a spring: a bend is a
    /// constraint |s| = 0 of compliance 1/k, of one that is curved |d| = 0.
    pub(crate) fn project(
        &self,
        h: R,
        inverse_masses: &[R],
        starts: &[R::Vec3],
        ways: &mut [R::Vec3],
    ) {
        for row in &self.rows {
            let [stiff, damp] = [row.stiffness * h * h, row.damping * h];
            let particle = |end: usize| row.particles[end] as usize;
            if let Some(curved) = row.curved(|end| starts[particle(end)] + ways[particle(end)]) {
                row.project_curved(&curved, [stiff, damp], inverse_masses, ways);
                continue;
            }
            let moved = row.sum(|end| ways[particle(end)]);
            let bent = row.sum(|end| starts[particle(end)]) + moved;
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

    /// The energy of all bends, joules; the sums of |k s| and of k, each times the weights, by
    /// which rounding changes it.
    pub(crate) fn energy_and_pulls(&self, motion: &Motion<'_, R>) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for row in &self.rows {
            let position = |end: usize| motion.position(row.particles[end] as usize).to_f64();
            let curved = row.curved_f64(position);
            let bent = curved.map_or_else(|| row.sum_f64(position), |curved| curved.off);
            let weight: f64 = row.weights.iter().map(|weight| weight.abs().to_f64()).sum();
            let (stiffness, square) = (row.stiffness.to_f64(), bent.dot(bent));
            sums[0] += 0.5 * stiffness * square;
            sums[1] += stiffness * weight * Real::sqrt(square);
            sums[2] += stiffness * weight * weight;
        }
        sums
    }

    /// The stiffness and the damping that each particle meets at most about a motion, by a
    /// function: the row sums of magnitudes of their matrices.
    pub(crate) fn row_sums(&self, motion: &Motion<'_, R>, mut add: impl FnMut(usize, [f64; 2])) {
        for row in &self.rows {
            let position = |end: usize| motion.position(row.particles[end] as usize).to_f64();
            if let Some(curved) = row.curved_f64(position) {
                let [stiffness, damping] = [row.stiffness, row.damping].map(R::to_f64);
                let (bounds, along) = (curved.bounds(), curved.gradient());
                let lengths = along.map(|part| Real::sqrt(part.dot(part)));
                let all: f64 = bounds.iter().map(|bound| bound[0]).sum();
                let total: f64 = lengths.iter().sum();
                let pull = stiffness * Real::sqrt(curved.off.dot(curved.off));
                for (end, [own, turning]) in bounds.into_iter().enumerate() {
                    let met = stiffness * own * all + pull * turning;
                    let damped = damping * lengths[end] * total;
                    add(row.particles[end] as usize, [met, damped]);
                }
                continue;
            }
            let all: f64 = row.weights.iter().map(|weight| weight.abs().to_f64()).sum();
            for (particle, weight) in row.terms() {
                let weight = weight.abs().to_f64() * all;
                add(particle, [row.stiffness, row.damping].map(|value| value.to_f64() * weight));
            }
        }
    }

    /// Pairs of particles that bends join.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.rows.iter().flat_map(|row| {
            let (ahead, behind) = (row.terms(), row.terms().skip(1));
            ahead.zip(behind).map(|((a, _), (b, _))| [a as u32, b as u32])
        })
    }
}

impl<R: Real> Bundle<R> {
    fn new(rows: &[Stencil<R>]) -> Self {
        let lane = |at: u32| at as usize % RECORD;
        let first = &rows[0];
        let mut bundle = Bundle {
            at: first.at.map(|at| at - lane(first.at[0]) as u32),
            weights: first.weights,
            stiffnesses: [R::ZERO; LANES],
            dampings: [R::ZERO; LANES],
            is_there: [false; LANES],
            is_full: rows.len() == LANES,
        };
        for row in rows {
            let lane = lane(row.at[0]);
            bundle.stiffnesses[lane] = row.stiffness;
            bundle.dampings[lane] = row.damping;
            bundle.is_there[lane] = true;
        }
        bundle
    }

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
            let (at, weight) = (self.at[end] as usize + axis * LANES, self.weights[end]);
            let record = sums[at..].first_chunk_mut::<LANES>().expect("a record of the column");
            for lane in 0..LANES {
                let less = record[lane] - pulls[lane] * weight;
                let is_there = self.is_full | self.is_there[lane];
                record[lane] = if is_there { less } else { record[lane] };
            }
        }
    }
}

/// Adds the forces of all bends and returns the power that they dissipate.
#[inline(always)]
fn add_forces<R: Real>(bends: &Bends<R>, x: &[R], v: &[R], forces: &mut [R]) -> f64 {
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
    let mut power: f64 = powers.iter().sum();
    for row in &bends.rows[bends.bundled..] {
        let in_x = |end: usize| vector::<R>(x, row.at[end] as usize);
        if let Some(curved) = row.curved(in_x) {
            let in_v = |end: usize| vector::<R>(v, row.at[end] as usize);
            let (parts, taken) = row.curved_pull(&curved, in_v);
            subtract_parts(row, parts, forces);
            power += taken.to_f64();
            continue;
        }
        let of = |column: &[R]| row.sum(|end| vector::<R>(column, row.at[end] as usize));
        let (pull, taken) = row.pull(of(x), of(v));
        subtract(row, pull, forces);
        power += taken.to_f64();
    }
    power
}

/// Subtracts from products: what is summed is the opposite of a force.
#[inline(always)]
fn add_products<R: Real>(
    bends: &Bends<R>,
    tau: R,
    (x, direction): (&[R], &[R]),
    products: &mut [R],
) {
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
    for row in &bends.rows[bends.bundled..] {
        let in_x = |end: usize| vector::<R>(x, row.at[end] as usize);
        let in_direction = |end: usize| vector::<R>(direction, row.at[end] as usize);
        if let Some(curved) = row.curved(in_x) {
            let pull = curved.change(in_direction) * (tau * tau * row.stiffness);
            subtract_parts(row, curved.parts(-pull), products);
            if row.damping != R::ZERO {
                let along = curved.gradient();
                let drag = dot_parts::<R>(&along, in_direction) * (tau * row.damping);
                subtract_parts(row, along.map(|part| part * -drag), products);
            }
            continue;
        }
        let bent = row.bent(in_x);
        let of = row.sum(in_direction);
        subtract(row, -row.product(tau, bent, of), products);
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
        let mut power = 0.0;
        for row in &self.rows {
            let particle = |end: usize| row.particles[end] as usize;
            if let Some(curved) = row.curved(|end| motion.position(particle(end))) {
                let (parts, taken) = row.curved_pull(&curved, |end| motion.velocity(particle(end)));
                for (end, part) in parts.into_iter().enumerate() {
                    forces.add(particle(end), R::Vec3::ZERO - part);
                }
                power += taken.to_f64();
                continue;
            }
            let sum = row.sum(|end| motion.position(particle(end)));
            let (pull, taken) = row.pull(sum, row.sum(|end| motion.velocity(particle(end))));
            for (end, weight) in row.terms() {
                forces.add(end, R::Vec3::ZERO - pull * weight);
            }
            power += taken.to_f64();
        }
        power
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        self.energy_and_pulls(motion)[0]
    }

    fn add_products(
        &self,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        for row in &self.rows {
            let particle = |end: usize| row.particles[end] as usize;
            let position = |end: usize| motion.position(particle(end)).to_f64();
            let way = |end: usize| direction[particle(end)];
            if let Some(curved) = row.curved_f64(position) {
                let elastic = curved.product(row.stiffness.to_f64(), way);
                let along = curved.gradient();
                let drag = dot_parts::<f64>(&along, way) * row.damping.to_f64();
                let damped = along.map(|part| part * drag);
                for (end, (elastic, damped)) in elastic.into_iter().zip(damped).enumerate() {
                    products.add(particle(end), [elastic, damped]);
                }
                continue;
            }
            let of = row.sum_f64(way);
            let bent = row.sum_f64(position);
            let edge = (motion.position(particle(1)) - motion.position(particle(0))).to_f64();
            let square = bent.dot(bent);
            let along = match is_straight::<f64>(square, edge.dot(edge)) {
                true => of,
                false => bent * (bent.dot(of) / square),
            };
            for (end, weight) in row.terms() {
                let by = [row.stiffness, row.damping].map(|value| (value * weight).to_f64());
                products.add(end, [of * by[0], along * by[1]]);
            }
        }
    }
}
