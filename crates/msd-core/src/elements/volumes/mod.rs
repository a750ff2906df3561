//! Volumes: cells of eight particles that resist a change of their volume.
//!
//! [`Volume`] is the law of one. They stand in the order in which they are evaluated, bundles
//! before single ones (see `bundles.rs`). One code computes one cell and sixteen, so that their
//! bits are the same.

mod shape;

use super::bundles::{self, record};
use super::{Element, Motion, Products, Torn, Vectors};
use crate::columns::slots::Slots;
use crate::columns::{LANES, RECORD, set_vector, vector};
use crate::number::{Real, Vector, at_level};
use crate::scene::Volume;
use alloc::vec::Vec;
use core::array::from_fn;
use fearless_simd::Level;
use glam::DVec3;
use shape::{CellShape, DIAGONALS, Six, Triple, VolumeLaw, bilinear, corners, dot, scaled, sum};

/// The volumes of a model.
#[derive(Clone, Debug)]
pub struct Volumes<R: Real> {
    /// In the order of evaluation.
    rows: Vec<HeldCell<R>>,
    bundles: Vec<CellBundle<R>>,
    /// How many of the rows are in bundles: the first ones.
    bundled: usize,
    /// Numbers of a column of vectors.
    numbers: usize,
    is_damped: bool,
}

/// A cell, and where the numbers of its corners are.
#[derive(Clone, Copy, Debug)]
struct HeldCell<R> {
    particles: [u32; 8],
    at: [u32; 8],
    law: VolumeLaw<R>,
}

/// Cells of one law, each in a lane of its own; `at` is where the numbers of their corners start.
#[derive(Clone, Debug)]
struct CellBundle<R> {
    at: [u32; 8],
    law: VolumeLaw<R>,
    is_there: [bool; LANES],
}

impl<R: Real> HeldCell<R> {
    /// The diagonals of what a function says of its corners.
    #[inline(always)]
    fn diagonals<S: Real>(&self, of: impl Fn(usize) -> S::Vec3) -> Six<S, 1> {
        DIAGONALS.map(|[from, to]| (of(to) - of(from)).components().map(|number| [number]))
    }

    /// The same of a column.
    #[inline(always)]
    fn diagonals_in(&self, column: &[R]) -> Six<R, 1> {
        self.diagonals::<R>(|corner| vector::<R>(column, self.at[corner] as usize))
    }

    /// Subtracts the parts of corners from a column.
    #[inline(always)]
    fn subtract(&self, rows: &Six<R, 1>, sums: &mut [R]) {
        for (&at, part) in self.at.iter().zip(corners(rows)) {
            let part = R::Vec3::from_components(part.map(|[number]| number));
            set_vector(sums, at as usize, vector::<R>(sums, at as usize) - part);
        }
    }

    /// Its shape in double precision.
    fn shape_f64(&self, motion: &Motion<'_, R>) -> CellShape<f64, 1> {
        let position = |corner: usize| motion.position(self.particles[corner] as usize).to_f64();
        CellShape::new(&self.law.to_f64(), self.diagonals::<f64>(position))
    }
}

impl<R: Real> CellBundle<R> {
    fn new(rows: &[HeldCell<R>]) -> Self {
        let lane = |row: &HeldCell<R>| row.at[0] as usize % RECORD;
        let first = &rows[0];
        let mut is_there = [false; LANES];
        rows.iter().for_each(|row| is_there[lane(row)] = true);
        CellBundle { at: first.at.map(|at| at - lane(first) as u32), law: first.law, is_there }
    }

    /// The diagonals of a column.
    #[inline(always)]
    fn diagonals_in(&self, column: &[R]) -> Six<R, LANES> {
        DIAGONALS.map(|[from, to]| {
            from_fn(|axis| {
                let [from, to] = [from, to].map(|corner| record(column, self.at[corner], axis));
                from_fn(|lane| to[lane] - from[lane])
            })
        })
    }

    /// Subtracts the parts of corners from a column.
    #[inline(always)]
    fn subtract(&self, rows: &Six<R, LANES>, sums: &mut [R]) {
        for (&at, part) in self.at.iter().zip(corners(rows)) {
            for (axis, part) in part.into_iter().enumerate() {
                let at = at as usize + axis * LANES;
                let record = sums[at..].first_chunk_mut::<LANES>().expect("a record");
                for lane in 0..LANES {
                    let less = record[lane] - part[lane];
                    record[lane] = if self.is_there[lane] { less } else { record[lane] };
                }
            }
        }
    }
}

impl<R: Real> Volumes<R> {
    /// Puts volumes in order.
    pub(crate) fn new(rows: &[Volume], slots: &Slots) -> Self {
        let mut volumes = Volumes {
            rows: Vec::new(),
            bundles: Vec::new(),
            bundled: 0,
            numbers: 0,
            is_damped: false,
        };
        volumes.add(rows, slots);
        volumes
    }

    /// Adds volumes, and puts all in order anew: the slots may have changed.
    pub(crate) fn add(&mut self, rows: &[Volume], slots: &Slots) {
        self.rows.extend(rows.iter().map(|row| HeldCell {
            particles: row.particles.map(|particle| particle as u32),
            at: [0; 8],
            law: VolumeLaw::new(row),
        }));
        for row in &mut self.rows {
            row.at = row.particles.map(|particle| slots.at(particle as usize) as u32);
        }
        self.numbers = slots.record_count() * RECORD;
        self.bundle();
    }

    fn bundle(&mut self) {
        let is_alike = |a: &HeldCell<R>, b: &HeldCell<R>| a.law == b.law;
        let bundles = bundles::order(&mut self.rows, self.numbers, |row| row.at, is_alike);
        self.bundled = bundles.last().map_or(0, |last| last.end);
        self.bundles = bundles.into_iter().map(|rows| CellBundle::new(&self.rows[rows])).collect();
        self.is_damped = self.rows.iter().any(|row| row.law.damping != R::ZERO);
    }

    /// The number of volumes.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// Whether any volume has a damper.
    pub fn is_damped(&self) -> bool {
        self.is_damped
    }

    /// The volumes as rows of a scene, in the order in which they are evaluated.
    pub fn rows(&self) -> impl Iterator<Item = Volume> + '_ {
        self.rows.iter().map(|row| Volume {
            particles: row.particles.map(|particle| particle as usize),
            rest_volume: row.law.rest.to_f64(),
            modulus: row.law.modulus.to_f64(),
            damping: row.law.damping.to_f64(),
        })
    }

    /// Removes the volumes of which both ends of one of some springs are corners: a cell that is
    /// torn holds its volume no more.
    pub(crate) fn tear(&mut self, torn: &Torn) {
        self.retain(|row| !torn.crosses(&row.particles));
    }

    /// Removes the volumes of particles that were removed.
    pub(crate) fn remove(&mut self, is_removed: impl Fn(u32) -> bool) {
        self.retain(|row| !row.particles.into_iter().any(&is_removed));
    }

    fn retain(&mut self, is_left: impl Fn(&HeldCell<R>) -> bool) {
        let before = self.rows.len();
        self.rows.retain(is_left);
        if self.rows.len() < before {
            self.bundle();
        }
    }

    /// Changes modulus and damping of the volumes of some particles.
    pub(crate) fn change(
        &mut self,
        is_of: impl Fn(u32) -> bool,
        change: impl Fn([R; 2]) -> [R; 2],
    ) {
        for row in self.rows.iter_mut().filter(|row| is_of(row.particles[0])) {
            [row.law.modulus, row.law.damping] = change([row.law.modulus, row.law.damping]);
        }
        self.bundle();
    }

    /// The same volumes in another precision, each number rounded once.
    pub(crate) fn convert<S: Real>(&self, slots: &Slots) -> Volumes<S> {
        let rows: Vec<Volume> = self.rows().collect();
        Volumes::new(&rows, slots)
    }

    /// Adds the forces of all volumes, newtons, and returns the power that they dissipate, watts.
    pub(crate) fn add_all(&self, level: Level, motion: &Motion<'_, R>, forces: &mut [R]) -> f64 {
        if self.rows.is_empty() {
            return 0.0;
        }
        let Motion { positions, velocities, .. } = *motion;
        at_level!(level, _simd => add_forces(self, positions, velocities, forces))
    }

    /// Adds the products of τ (τ K + D) about positions with a direction, in columns; see
    /// [`CellShape::factors`].
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

    /// Adds the diagonal blocks of τ (τ K + D) about positions to those of particles. Without those
    /// of a negative Λ: what is left is as good for a solve, and positive for sure.
    pub(crate) fn add_blocks(&self, tau: R, positions: &[R], [upper, lower]: [&mut [R]; 2]) {
        for row in self.rows.iter().filter(|row| !row.law.is_negative()) {
            let shape = CellShape::new(&row.law, row.diagonals_in(positions));
            let [factor] = shape.factors(&row.law, tau);
            for (&at, part) in row.at.iter().zip(corners(&shape.gradient)) {
                let [x, y, z] = part.map(|[number]| number);
                let at = at as usize;
                for (column, row) in
                    [(&mut *upper, [x * x, x * y, x * z]), (&mut *lower, [y * y, y * z, z * z])]
                {
                    let block = R::Vec3::from_components(row) * factor;
                    set_vector(column, at, vector::<R>(column, at) + block);
                }
            }
        }
    }

    /// Moves the particles of each cell, in order, as XPBD moves those of a spring: a constraint
    /// V = V0 of compliance V0/Λ. A negative Λ, which is no constraint, pushes away from it by at
    /// most as much.
    pub(crate) fn project(
        &self,
        h: R,
        inverse_masses: &[R],
        starts: &[R::Vec3],
        ways: &mut [R::Vec3],
    ) {
        for row in &self.rows {
            let HeldCell { law, particles, .. } = row;
            let particle = |corner: usize| particles[corner] as usize;
            let moved = row.diagonals::<R>(|corner| ways[particle(corner)]);
            let began = row.diagonals::<R>(|corner| starts[particle(corner)]);
            let now: Six<R, 1> = from_fn(|diagonal| sum(&began[diagonal], &moved[diagonal]));
            let shape = CellShape::new(law, now);
            // Over a substep instead of a second: h² times the tension and h times the drag.
            let per_step = VolumeLaw { damping: law.damping * (R::ONE / h), ..*law };
            let ([pull], _) = shape.pull(&per_step, Some(&moved));
            let parts = corners(&shape.gradient).map(|part| part.map(|[number]| number));
            let parts = parts.map(R::Vec3::from_components);
            let square = |end: usize| parts[end].dot(parts[end]) * inverse_masses[particle(end)];
            let squares = (0..8).map(square).fold(R::ZERO, |sum, add| sum + add);
            let [factor] = shape.factors(law, h);
            // Of a negative one the magnitude, which bounds how far it pushes.
            let yielding = R::ONE + factor.abs() * squares;
            let pull = pull * (h * h) * (R::ONE / yielding);
            for (corner, part) in parts.into_iter().enumerate() {
                ways[particle(corner)] -= part * (pull * inverse_masses[particle(corner)]);
            }
        }
    }

    /// The energy of all volumes, joules; the sums of |Λ f' g| and of |Λ f''| g²/V0 over corners,
    /// by which rounding changes it.
    pub(crate) fn energy_and_pulls(&self, motion: &Motion<'_, R>) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for row in &self.rows {
            let (law, shape) = (row.law.to_f64(), row.shape_f64(motion));
            let [e] = shape.dilations;
            let slopes: f64 = corner_lengths(&shape).into_iter().sum();
            sums[0] += law.modulus * law.rest * (0.5 * e * e / law.reach(e));
            sums[1] += law.tension(e).abs() * slopes;
            sums[2] += law.slope(e).abs() * slopes * slopes / law.rest;
        }
        sums
    }

    /// The stiffness and the damping that each particle meets at most about a motion, by a
    /// function: row sums of magnitudes. No row of the second derivatives of the volume has more
    /// than about the longest diagonal of the cell. A negative Λ stiffens nothing at rest.
    pub(crate) fn row_sums(&self, motion: &Motion<'_, R>, mut add: impl FnMut(usize, [f64; 2])) {
        for row in &self.rows {
            let (law, shape) = (row.law.to_f64(), row.shape_f64(motion));
            let [e] = shape.dilations;
            let lengths = corner_lengths(&shape);
            let all: f64 = lengths.iter().sum();
            let squares = shape.diagonals.iter().map(|way| dot(way, way)[0]);
            let longest = Real::sqrt(squares.fold(0.0, f64::max));
            let turning = law.tension(e).abs() * longest;
            for (&particle, length) in row.particles.iter().zip(lengths) {
                let own = length * all / law.rest;
                let stiffness = law.slope(e).max(0.0) * own + turning;
                add(particle as usize, [stiffness, law.damping.max(0.0) * own]);
            }
        }
    }

    /// Pairs of particles that volumes join.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        let pairs = |row: &HeldCell<R>| {
            (1..8).map(|end| [row.particles[0], row.particles[end]]).collect::<Vec<_>>()
        };
        self.rows.iter().flat_map(pairs)
    }
}

/// The lengths of the gradient of the volume at the corners, square metres.
fn corner_lengths(shape: &CellShape<f64, 1>) -> [f64; 8] {
    corners(&shape.gradient).map(|part| Real::sqrt(dot(&part, &part)[0]))
}

/// Adds the forces of all volumes and returns the power that they dissipate.
#[inline(always)]
fn add_forces<R: Real>(volumes: &Volumes<R>, x: &[R], v: &[R], forces: &mut [R]) -> f64 {
    let mut power = 0.0;
    for bundle in &volumes.bundles {
        let shape = CellShape::new(&bundle.law, bundle.diagonals_in(x));
        let rates = volumes.is_damped.then(|| bundle.diagonals_in(v));
        let (pulls, powers) = shape.pull(&bundle.law, rates.as_ref());
        bundle.subtract(&shape.gradient.map(|row| scaled(row, &pulls)), forces);
        for (power_of, is_there) in powers.into_iter().zip(bundle.is_there) {
            power += if is_there { power_of.to_f64() } else { 0.0 };
        }
    }
    for row in &volumes.rows[volumes.bundled..] {
        let shape = CellShape::new(&row.law, row.diagonals_in(x));
        let rates = volumes.is_damped.then(|| row.diagonals_in(v));
        let (pulls, [taken]) = shape.pull(&row.law, rates.as_ref());
        row.subtract(&shape.gradient.map(|row| scaled(row, &pulls)), forces);
        power += taken.to_f64();
    }
    power
}

/// Adds the products of the matrix of an implicit stage.
#[inline(always)]
fn add_products<R: Real>(
    volumes: &Volumes<R>,
    tau: R,
    (x, direction): (&[R], &[R]),
    products: &mut [R],
) {
    for bundle in &volumes.bundles {
        let shape = CellShape::new(&bundle.law, bundle.diagonals_in(x));
        let rates = shape.rate(&bundle.diagonals_in(direction));
        let factors = shape.factors(&bundle.law, tau);
        // What is subtracted is the opposite.
        let pulls = from_fn(|lane| -(rates[lane] * factors[lane]));
        bundle.subtract(&shape.gradient.map(|row| scaled(row, &pulls)), products);
    }
    for row in &volumes.rows[volumes.bundled..] {
        let shape = CellShape::new(&row.law, row.diagonals_in(x));
        let ([rate], [factor]) =
            (shape.rate(&row.diagonals_in(direction)), shape.factors(&row.law, tau));
        row.subtract(&shape.gradient.map(|row| scaled(row, &[-(rate * factor)])), products);
    }
}

impl<R: Real> Element<R> for Volumes<R> {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let mut power = 0.0;
        for row in &self.rows {
            let particle = |corner: usize| row.particles[corner] as usize;
            let position = |corner: usize| motion.position(particle(corner));
            let velocity = |corner: usize| motion.velocity(particle(corner));
            let shape = CellShape::new(&row.law, row.diagonals::<R>(position));
            let (pulls, [taken]) = shape.pull(&row.law, Some(&row.diagonals::<R>(velocity)));
            let parts = corners(&shape.gradient.map(|row| scaled(row, &pulls)));
            for (corner, part) in parts.into_iter().enumerate() {
                let force = R::Vec3::from_components(part.map(|[number]| number));
                forces.add(particle(corner), R::Vec3::ZERO - force);
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
            let (law, shape) = (row.law.to_f64(), row.shape_f64(motion));
            let [e] = shape.dilations;
            let particle = |corner: usize| row.particles[corner] as usize;
            let changes = row.diagonals::<f64>(|corner| direction[particle(corner)]);
            let [rate] = shape.rate(&changes).map(|rate| rate / law.rest);
            let [share] = shape.shares(&law);
            let turned = law.tension(e) / 12.0;
            let (ahead, behind) =
                (bilinear(&shape.diagonals, &changes), bilinear(&changes, &shape.diagonals));
            let turns: Six<f64, 1> =
                from_fn(|row| scaled(sum(&ahead[row], &behind[row]), &[turned]));
            let along = |factor: f64| shape.gradient.map(|row| scaled(row, &[factor]));
            let elastic = along(law.slope(e) * rate);
            let elastic = corners(&from_fn(|row| sum(&elastic[row], &turns[row])));
            let damped = corners(&along(law.damping * share * rate));
            for corner in 0..8 {
                let of =
                    |parts: &[Triple<f64, 1>; 8]| DVec3::from_array(parts[corner].map(|[x]| x));
                products.add(particle(corner), [of(&elastic), of(&damped)]);
            }
        }
    }
}
