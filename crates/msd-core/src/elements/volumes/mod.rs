//! Volumes: cells of eight particles that resist a change of their volume.
//!
//! [`Volume`] is the law of one. One code computes one cell and sixteen, so that their bits are the
//! same.

mod shape;

use super::stencils::{Stencil, StencilLaw, Stencils, lane, record, subtract_record};
use super::{
    Derivatives, Element, Force, ForceWork, Joints, MatrixWork, Moment, Motion, Products,
    Projection, Resists, Rows, Stage, Torn, Vectors,
};
use crate::columns::{LANES, add_vector, set_vector, vector};
use crate::elements::touches::near::Near;
use crate::number::{Real, Vector, at_level};
use crate::scene::{Scene, Volume};
use core::array::from_fn;
use glam::DVec3;
use shape::{CellShape, DIAGONALS, Six, Triple, VolumeLaw, bilinear, corners, dot, scaled, sum};

/// The volumes of a model.
pub type Volumes<R> = Stencils<VolumeLaw<R>, 8>;

/// A cell, and where the numbers of its corners are.
type Cell<R> = Stencil<VolumeLaw<R>, 8>;

/// Cells of one law, each in a lane of its own; `at` is where the numbers of their corners start.
#[derive(Clone, Debug)]
pub struct CellBundle<R> {
    at: [u32; 8],
    law: VolumeLaw<R>,
    is_there: [bool; LANES],
}

impl<R: Real> StencilLaw<8> for VolumeLaw<R> {
    type Number = R;
    type Bundle = CellBundle<R>;

    fn bundle(rows: &[Cell<R>]) -> CellBundle<R> {
        let Stencil { at, law, .. } = rows[0];
        let mut is_there = [false; LANES];
        rows.iter().for_each(|row| is_there[lane(row.at)] = true);
        CellBundle { at: at.map(|place| place - lane(at) as u32), law, is_there }
    }

    fn is_alike(&self, other: &Self) -> bool {
        self == other
    }

    fn constants(&mut self) -> [&mut R; 2] {
        [&mut self.modulus, &mut self.damping]
    }
}

impl<R: Real> Cell<R> {
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
                let to = (&mut *sums, at, axis);
                subtract_record(to, |lane| part[lane], |lane| self.is_there[lane]);
            }
        }
    }
}

impl<R: Real> Volumes<R> {
    /// The volumes as rows of a scene, in the order in which they are evaluated.
    pub fn rows(&self) -> impl Iterator<Item = Volume> + '_ {
        self.all.iter().map(|row| Volume {
            particles: row.particles.map(|particle| particle as usize),
            rest_volume: row.law.rest.to_f64(),
            modulus: row.law.modulus.to_f64(),
            damping: row.law.damping.to_f64(),
        })
    }

    /// The energy of all volumes, joules; the sums of |Λ f' g| and of |Λ f''| g²/V0 over corners,
    /// by which rounding changes it.
    fn stored(&self, motion: &Motion<'_, R>) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for row in &self.all {
            let (law, shape) = (row.law.to_f64(), row.shape_f64(motion));
            let [e] = shape.dilations;
            let slopes: f64 = corner_lengths(&shape).into_iter().sum();
            sums[0] += law.modulus * law.rest * (0.5 * e * e / law.reach(e));
            sums[1] += law.tension(e).abs() * slopes;
            sums[2] += law.slope(e).abs() * slopes * slopes / law.rest;
        }
        sums
    }
}

/// The lengths of the gradient of the volume at the corners, square metres.
fn corner_lengths(shape: &CellShape<f64, 1>) -> [f64; 8] {
    corners(&shape.gradient).map(|part| Real::sqrt(dot(&part, &part)[0]))
}

/// Adds the forces of all volumes and returns the power that they dissipate.
#[inline(always)]
fn add_forces<R: Real>(volumes: &Volumes<R>, [x, v]: [&[R]; 2], forces: &mut [R]) -> f64 {
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
    let singles = volumes.singles().iter();
    singles.fold(power, |power, row| power + add_force(row, volumes.is_damped, [x, v], forces))
}

/// Adds the forces of one volume and returns the power that it dissipates.
#[inline(always)]
fn add_force<R: Real>(row: &Cell<R>, is_damped: bool, [x, v]: [&[R]; 2], forces: &mut [R]) -> f64 {
    let shape = CellShape::new(&row.law, row.diagonals_in(x));
    let rates = is_damped.then(|| row.diagonals_in(v));
    let (pulls, [taken]) = shape.pull(&row.law, rates.as_ref());
    row.subtract(&shape.gradient.map(|row| scaled(row, &pulls)), forces);
    taken.to_f64()
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
    for row in volumes.singles() {
        let shape = CellShape::new(&row.law, row.diagonals_in(x));
        let ([rate], [factor]) =
            (shape.rate(&row.diagonals_in(direction)), shape.factors(&row.law, tau));
        row.subtract(&shape.gradient.map(|row| scaled(row, &[-(rate * factor)])), products);
    }
}

impl<R: Real> Element<R> for Volumes<R> {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let columns = [motion.positions, motion.velocities];
        let rows = self.all.iter().map(|row| row.placed(motion.slots));
        rows.map(|row| add_force(&row, true, columns, forces.numbers)).sum()
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

impl<R: Real> Force<R> for Volumes<R> {
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

    /// No row of the second derivatives of the volume has more than about the longest diagonal of
    /// the cell. A negative Λ stiffens nothing at rest.
    fn add_row_sums(&self, motion: &Motion<'_, R>, _: &Derivatives, sums: &mut [[f64; 2]]) {
        for row in &self.all {
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
                sums[particle as usize][0] += stiffness;
                sums[particle as usize][1] += law.damping.max(0.0) * own;
            }
        }
    }

    /// See [`CellShape::factors`]. Without the blocks of a negative Λ: what is left is as good for
    /// a solve, and positive for sure.
    fn linearise(
        &self,
        stage: &Stage<'_, R>,
        _: &mut MatrixWork<R>,
        _: &mut Near<R>,
        [upper, lower]: [&mut [R]; 2],
    ) {
        let (tau, positions) = (stage.tau, stage.moment.motion.positions);
        for row in self.all.iter().filter(|row| !row.law.is_negative()) {
            let shape = CellShape::new(&row.law, row.diagonals_in(positions));
            let [factor] = shape.factors(&row.law, tau);
            for (&at, part) in row.at.iter().zip(corners(&shape.gradient)) {
                let [x, y, z] = part.map(|[number]| number);
                let at = at as usize;
                let block = |row: [R; 3]| R::Vec3::from_components(row) * factor;
                add_vector::<R>(upper, at, block([x * x, x * y, x * z]));
                add_vector::<R>(lower, at, block([y * y, y * z, z * z]));
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

    /// A constraint V = V0 of compliance V0/Λ. A negative Λ, which is no constraint, pushes away
    /// from it by at most as much.
    fn project(&self, projection: &mut Projection<'_, R>) {
        let Projection { h, inverse_masses, starts, ways, .. } = projection;
        let h = *h;
        for row in &self.all {
            let Stencil { law, particles, .. } = row;
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

    fn each_pair(&self, join: &mut dyn FnMut([u32; 2])) {
        for Stencil { particles: [first, others @ ..], .. } in &self.all {
            others.iter().for_each(|&other| join([*first, other]));
        }
    }

    fn add(&mut self, rows: &Scene, joints: Joints<'_>) {
        let rows = rows.volumes.iter().map(|row| Stencil::new(row.particles, VolumeLaw::new(row)));
        self.extend(rows, joints.slots);
    }

    fn write(&self, rows: &mut Scene) {
        rows.volumes.extend(self.rows());
    }

    fn tear(&mut self, torn: &Torn) {
        Stencils::tear(self, torn);
    }

    fn remove(&mut self, is_removed: &dyn Fn(u32) -> bool, _: Joints<'_>) {
        self.retain(|row| !row.particles.into_iter().any(is_removed));
    }

    fn change(&mut self, (particles, _): &Rows, change: &dyn Fn(Resists, [R; 2]) -> [R; 2]) {
        Stencils::change(self, particles, |constants| change(Resists::Stretching, constants));
    }
}
