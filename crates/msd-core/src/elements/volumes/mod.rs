//! Volumes: cells of eight particles that resist a change of their volume.
//!
//! [`Volume`] is the law of one.

mod shape;

use super::stencils::{Group, MULTIPLIERS, Stencil, StencilLaw, StencilSums, Stencils};
use super::{Motion, Products, Projection, Resists};
use crate::number::{Real, Vector};
use crate::scene::{Scene, Volume};
use alloc::vec::Vec;
use core::array::from_fn;
use glam::DVec3;
use shape::{CellShape, DIAGONALS, Six, Triple, VolumeLaw, bilinear, corners, dot, scaled, sum};

/// The volumes of a model.
pub type Volumes<R> = Stencils<R, VolumeLaw<R>, 8>;

/// A cell, and M of them of one law at once.
type CellRow<R> = Stencil<VolumeLaw<R>, 8>;
type Cells<R, const M: usize> = Group<R, VolumeLaw<R>, 8, M>;

impl<R: Real> Volumes<R> {
    /// The volumes as rows of a scene, in the order in which they are evaluated.
    pub fn rows(&self) -> impl Iterator<Item = Volume> + '_ {
        self.all.iter().map(to_scene)
    }
}

fn to_scene<R: Real>(row: &CellRow<R>) -> Volume {
    Volume {
        particles: from_fn(|corner| row.particle(corner)),
        rest_volume: row.law.rest.to_f64(),
        modulus: row.law.modulus.to_f64(),
        damping: row.law.damping.to_f64(),
    }
}

/// The diagonals of the vectors that a function gives for corners.
fn diagonals<R: Real>(of: impl Fn(usize) -> R::Vec3) -> Six<R, 1> {
    DIAGONALS.map(|[from, to]| (of(to) - of(from)).components().map(|number| [number]))
}

impl<R: Real> CellRow<R> {
    /// Its law and its shape in double precision.
    fn shape_f64(&self, motion: &Motion<'_, R>) -> (VolumeLaw<f64>, CellShape<f64, 1>) {
        let law = self.law.to_f64();
        let position = |corner: usize| motion.position(self.particle(corner)).to_f64();
        (law, CellShape::new(&law, diagonals::<f64>(position)))
    }
}

impl<R: Real, const M: usize> Cells<R, M> {
    /// The diagonals of a column.
    #[inline(always)]
    fn diagonals(&self, column: &[R]) -> Six<R, M> {
        DIAGONALS.map(|ends| {
            from_fn(|axis| {
                let [from, to] = ends.map(|corner| self.numbers(column, corner, axis));
                from_fn(|lane| to[lane] - from[lane])
            })
        })
    }

    /// Subtracts the parts of corners of vectors along diagonals, times a number for each cell.
    #[inline(always)]
    fn subtract_parts(&self, along: &Six<R, M>, times: &[R; M], sums: &mut [R]) {
        let parts = corners(&along.map(|row| scaled(row, times)));
        for (corner, part) in parts.into_iter().enumerate() {
            for (axis, part) in part.into_iter().enumerate() {
                self.subtract((corner, axis), |lane| part[lane], sums);
            }
        }
    }
}

impl<R: Real> StencilLaw<R, 8> for VolumeLaw<R> {
    const RESISTS: Resists = Resists::Stretching;

    fn rows(scene: &Scene) -> Vec<CellRow<R>> {
        scene.volumes.iter().map(|row| Stencil::new(row.particles, VolumeLaw::new(row))).collect()
    }

    fn write(row: &CellRow<R>, scene: &mut Scene) {
        scene.volumes.push(to_scene(row));
    }

    fn constants(&mut self) -> [&mut R; 2] {
        [&mut self.modulus, &mut self.damping]
    }

    fn is_alike(&self, other: &Self) -> bool {
        self == other
    }

    fn takes_part(&self, _: usize) -> bool {
        true
    }

    #[inline(always)]
    fn pull<const M: usize>(cells: &Cells<R, M>, to: &mut StencilSums<'_, R>) -> [R; M] {
        let shape = CellShape::new(&cells.law, cells.diagonals(to.positions));
        let rates = to.is_damped.then(|| cells.diagonals(to.ways));
        let (pulls, powers) = shape.pull(&cells.law, rates.as_ref());
        cells.subtract_parts(&shape.gradient, &pulls, to.sums);
        powers
    }

    /// See [`CellShape::factors`].
    #[inline(always)]
    fn multiply<const M: usize>(cells: &Cells<R, M>, tau: R, to: &mut StencilSums<'_, R>) {
        let shape = CellShape::new(&cells.law, cells.diagonals(to.positions));
        let rates = shape.rate(&cells.diagonals(to.ways));
        let factors = shape.factors(&cells.law, tau);
        // The opposite is subtracted.
        let pulls = from_fn(|lane| -(rates[lane] * factors[lane]));
        cells.subtract_parts(&shape.gradient, &pulls, to.sums);
    }

    /// Without those of a negative Λ: the rest is as good for a solve, and positive for sure.
    fn add_blocks(cell: &Cells<R, 1>, (tau, positions): (R, &[R]), blocks: &mut [&mut [R]; 2]) {
        if cell.law.is_negative() {
            return;
        }
        let shape = CellShape::new(&cell.law, cell.diagonals(positions));
        let [factor] = shape.factors(&cell.law, tau);
        for (corner, part) in corners(&shape.gradient).into_iter().enumerate() {
            let [x, y, z] = part.map(|[number]| number);
            let block = [[x * x, x * y, x * z], [y * y, y * z, z * z]];
            cell.add_block(corner, block.map(|row| row.map(|number| number * factor)), blocks);
        }
    }

    /// A constraint V = V0 of compliance V0/Λ. A negative Λ, which is not a constraint, pushes away
    /// from it by at most as much.
    #[inline(always)]
    fn project<const M: usize>(
        cells: &Cells<R, M>,
        [applied, ..]: &mut [[R; M]; MULTIPLIERS],
        projection: &mut Projection<'_, R>,
    ) {
        let Projection { h, inverse_masses, positions, ways, .. } = projection;
        let (h, law) = (*h, &cells.law);
        let (moved, began) = (cells.diagonals(ways), cells.diagonals(positions));
        let now: Six<R, M> = from_fn(|diagonal| sum(&began[diagonal], &moved[diagonal]));
        let shape = CellShape::new(law, now);
        // Over a substep instead of a second: h² times the tension and h times the drag.
        let per_step = VolumeLaw { damping: law.damping * (R::ONE / h), ..*law };
        let (mut pulls, _) = shape.pull(&per_step, Some(&moved));
        let (parts, factors) = (corners(&shape.gradient), shape.factors(law, h));
        let mass = |corner: usize| cells.numbers(inverse_masses, corner, 0);
        let mut squares = [R::ZERO; M];
        for (corner, part) in parts.iter().enumerate() {
            let (square, mass) = (dot(part, part), mass(corner));
            (0..M).for_each(|lane| squares[lane] += square[lane] * mass[lane]);
        }
        for lane in 0..M {
            // Of a negative one the magnitude, which bounds how far it pushes.
            let yielding = R::ONE + factors[lane].abs() * squares[lane];
            pulls[lane] = (pulls[lane] * (h * h) - applied[lane]) * (R::ONE / yielding);
            applied[lane] += pulls[lane];
        }
        for (corner, part) in parts.iter().enumerate() {
            let mass = mass(corner);
            for (axis, part) in part.iter().enumerate() {
                cells.subtract(
                    (corner, axis),
                    |lane| part[lane] * (pulls[lane] * mass[lane]),
                    ways,
                );
            }
        }
    }

    /// Rounding changes it by |Λ f' g| and |Λ f''| g²/V0, g being sums over corners.
    fn energy_and_pulls(row: &CellRow<R>, motion: &Motion<'_, R>) -> [f64; 3] {
        let (law, shape) = row.shape_f64(motion);
        let [e] = shape.dilations;
        let slopes: f64 = corner_lengths(&shape).into_iter().sum();
        let energy = law.modulus * law.rest * law.stored(e);
        [energy, law.tension(e).abs() * slopes, law.slope(e).abs() * slopes * slopes / law.rest]
    }

    /// No row of the second derivatives of the volume has more than about the longest diagonal of
    /// the cell. A negative Λ stiffens nothing at rest.
    fn add_row_sums(row: &CellRow<R>, motion: &Motion<'_, R>, sums: &mut [[f64; 2]]) {
        let (law, shape) = row.shape_f64(motion);
        let [e] = shape.dilations;
        let lengths = corner_lengths(&shape);
        let all: f64 = lengths.iter().sum();
        let squares = shape.diagonals.iter().map(|way| dot(way, way)[0]);
        let longest = Real::sqrt(squares.fold(0.0, f64::max));
        let turning = law.tension(e).abs() * longest;
        for (corner, length) in lengths.into_iter().enumerate() {
            let (own, sum) = (length * all / law.rest, &mut sums[row.particle(corner)]);
            sum[0] += law.slope(e).max(0.0) * own + turning;
            sum[1] += law.damping.max(0.0) * own;
        }
    }

    fn add_products(
        row: &CellRow<R>,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        let (law, shape) = row.shape_f64(motion);
        let [e] = shape.dilations;
        let changes = diagonals::<f64>(|corner| direction[row.particle(corner)]);
        let [rate] = shape.rate(&changes).map(|rate| rate / law.rest);
        let [share] = shape.shares(&law);
        let turned = law.tension(e) / 12.0;
        let (ahead, behind) =
            (bilinear(&shape.diagonals, &changes), bilinear(&changes, &shape.diagonals));
        let turns: Six<f64, 1> = from_fn(|row| scaled(sum(&ahead[row], &behind[row]), &[turned]));
        let along = |factor: f64| shape.gradient.map(|row| scaled(row, &[factor]));
        let elastic = along(law.slope(e) * rate);
        let elastic = corners(&from_fn(|row| sum(&elastic[row], &turns[row])));
        let damped = corners(&along(law.damping * share * rate));
        for corner in 0..8 {
            let of = |parts: &[Triple<f64, 1>; 8]| DVec3::from_array(parts[corner].map(|[x]| x));
            products.add(row.particle(corner), [of(&elastic), of(&damped)]);
        }
    }
}

/// The lengths of the gradient of the volume at the corners, square metres.
fn corner_lengths(shape: &CellShape<f64, 1>) -> [f64; 8] {
    corners(&shape.gradient).map(|part| Real::sqrt(dot(&part, &part)[0]))
}
