//! Touches: particles with a radius, which push each other where they overlap.
//!
//! `law.rs` is the push of a pair. A force is the sum over pairs in ascending order of their
//! particles, and a pair that does not touch adds nothing at all: so its bits do not depend on
//! which pairs were looked at. `near` lists those that may touch. `faces` is what particles have
//! with triangles, by the same law.

pub(crate) mod tangent;
mod law;
mod faces;
pub(crate) mod near;

use super::{
    ColumnProducts, Derivatives, Element, Force, ForceWork, Joints, MatrixSums, Moment, Motion,
    Products, Projection, Stage,
};
use crate::columns::slots::Slots;
use crate::columns::{Aligned, LANES, add_vector, set_vector, single, vector};
use crate::number::{Real, Vector};
use crate::scene::{Between, Scene, Touch, do_touch};
use alloc::vec::Vec;
use glam::DVec3;
use law::PairLaw;
use near::{Listed, Near};
use tangent::TouchTangents;

/// The touches of a model.
#[derive(Clone, Debug, Default)]
pub struct Touches {
    /// As written, less particles that were removed.
    rows: Vec<Touch>,
    /// Pairs of particles that do not touch, beside those joined by springs, as written.
    exempt: Vec<[usize; 2]>,
    /// The particles with a radius, in order.
    beads: Vec<Bead>,
    /// The beads of a higher number that each bead does not touch, in order, bead by bead.
    spared: Vec<u32>,
    /// Where those of each bead start, and where the last ones end.
    spared_starts: Vec<u32>,
    /// The corners of all triangles, row by row, by their beads.
    triangles: Vec<[u32; 3]>,
}

/// A particle with a radius.
#[derive(Clone, Copy, Debug)]
struct Bead {
    particle: u32,
    /// Where its numbers are in a column of vectors.
    at: u32,
    row: u32,
    /// Whether it is a corner of a triangle.
    is_corner: bool,
}

impl Touches {
    fn order(&mut self, Joints { ends, slots }: Joints<'_>) {
        self.beads.clear();
        for (row, touch) in self.rows.iter().enumerate() {
            let bead = |&particle: &usize| Bead {
                particle: particle as u32,
                at: slots.at(particle) as u32,
                row: row as u32,
                is_corner: false,
            };
            self.beads.extend(touch.particles.iter().map(bead));
        }
        self.beads.sort_by_key(|bead| bead.particle);
        self.spare(ends);
        let place =
            |particle: usize| self.beads.partition_point(|bead| bead.particle < particle as u32);
        let triangles = self.rows.iter().flat_map(|row| &row.triangles);
        self.triangles =
            triangles.map(|corners| corners.map(|corner| place(corner) as u32)).collect();
        for &corner in self.triangles.as_flattened() {
            self.beads[corner as usize].is_corner = true;
        }
    }

    fn row_of(&self, bead: usize) -> usize {
        self.beads[bead].row as usize
    }

    /// Whether the rows of two beads touch each other.
    fn do_rows_touch(&self, a: usize, b: usize) -> bool {
        self.do_rows_meet(self.row_of(a), self.row_of(b))
    }

    fn do_rows_meet(&self, a: usize, b: usize) -> bool {
        do_touch(&self.rows, [a, b])
    }

    /// Whether two beads, the lower first, touch as a pair where they are close: a corner touches
    /// by its triangles.
    fn do_touch(&self, a: usize, b: usize) -> bool {
        let is_corner = self.beads[a].is_corner || self.beads[b].is_corner;
        !is_corner && self.do_rows_touch(a, b) && !self.spares(a, b)
    }

    /// Whether a bead touches a triangle where they are close, if their rows touch each other.
    fn do_face(&self, bead: usize, triangle: usize) -> bool {
        let corners = self.triangles[triangle].map(|corner| corner as usize);
        let spares = |corner: usize| self.spares(bead.min(corner), bead.max(corner));
        !corners.into_iter().any(|corner| corner == bead || spares(corner))
    }

    /// The law of a bead and a triangle. A corner of another triangle has half of it, as its own
    /// ones have the other half.
    fn law_of_facing<R: Real>(&self, bead: usize, triangle: usize) -> PairLaw<R> {
        let law = self.law_of::<R>(bead, self.triangles[triangle][0] as usize);
        let share = if self.beads[bead].is_corner { R::HALF } else { R::ONE };
        PairLaw { stiffness: law.stiffness * share, damping: law.damping * share, ..law }
    }

    /// The law of two beads that touch.
    fn law_of<R: Real>(&self, a: usize, b: usize) -> PairLaw<R> {
        let rows = [a, b].map(|bead| self.row_of(bead));
        let (first, last) = (rows[0].min(rows[1]), rows[0].max(rows[1]));
        let [low, high] = [first, last].map(|row| &self.rows[row]);
        PairLaw::new(low, high, high.between.iter().find(|between| between.row == first))
    }

    /// Lists the pairs that springs join or that are exempt.
    fn spare(&mut self, ends: &[[u32; 2]]) {
        let place =
            |particle: u32| self.beads.binary_search_by_key(&particle, |bead| bead.particle).ok();
        let exempt = self.exempt.iter().map(|pair| pair.map(|particle| particle as u32));
        let places = ends.iter().copied().chain(exempt).filter_map(|[a, b]| {
            let (a, b) = (place(a)?, place(b)?);
            Some([a.min(b) as u32, a.max(b) as u32])
        });
        let mut pairs: Vec<[u32; 2]> =
            if self.beads.is_empty() { Vec::new() } else { places.collect() };
        pairs.sort_unstable();
        pairs.dedup();
        self.spared_starts = (0..=self.beads.len() as u32)
            .map(|bead| pairs.partition_point(|pair| pair[0] < bead) as u32)
            .collect();
        self.spared = pairs.into_iter().map(|pair| pair[1]).collect();
    }

    /// Whether two particles have radii, and rows that touch each other; a spring between them may
    /// still keep them from it.
    pub fn may_touch(&self, particles: [u32; 2]) -> bool {
        let bead = |particle| self.beads.binary_search_by_key(&particle, |bead| bead.particle).ok();
        let [a, b] = particles.map(bead);
        a.zip(b).is_some_and(|(a, b)| self.do_rows_touch(a, b))
    }

    /// The number of particles that have a radius.
    pub fn count(&self) -> usize {
        self.beads.len()
    }

    /// The radii that count against obstacles, metres, a number for each slot, and the largest;
    /// none where no row's do.
    pub(crate) fn radii_at_obstacles<R: Real>(&self, slots: &Slots) -> (Aligned<R>, R) {
        let counts = |bead: &&Bead| self.rows[bead.row as usize].obstacles;
        let mut beads = self.beads.iter().filter(counts).peekable();
        if beads.peek().is_none() {
            return (Aligned::default(), R::ZERO);
        }
        let mut radii = Aligned::new(slots.record_count() * LANES, 28);
        let mut largest = R::ZERO;
        for bead in beads {
            let radius = R::of(self.rows[bead.row as usize].radius);
            radii[single(bead.at as usize)] = radius;
            largest = largest.max(radius);
        }
        (radii, largest)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.beads.is_empty()
    }

    /// The rows of a scene, and the pairs that do not touch.
    pub fn rows(&self) -> (&[Touch], &[[usize; 2]]) {
        (&self.rows, &self.exempt)
    }

    /// The smallest and the largest sum of two radii, metres.
    fn reaches(&self) -> [f64; 2] {
        let radii = self.rows.iter().map(|row| row.radius);
        let (least, most) = radii.fold((f64::INFINITY, 0.0), |(least, most), radius| {
            (f64::min(least, radius), f64::max(most, radius))
        });
        [2.0 * least, 2.0 * most]
    }

    /// The sum of the radii of a bead and a triangle, metres.
    fn reach_of(&self, bead: usize, triangle: usize) -> f64 {
        let both = [bead, self.triangles[triangle][0] as usize];
        let [a, b] = both.map(|bead| self.rows[self.row_of(bead)].radius);
        a + b
    }

    /// Whether two beads, the lower first, do not touch.
    fn spares(&self, a: usize, b: usize) -> bool {
        let range = self.spared_starts[a] as usize..self.spared_starts[a + 1] as usize;
        self.spared[range].contains(&(b as u32))
    }

    fn point<R: Real>(&self, positions: &[R], bead: usize) -> R::Vec3 {
        vector::<R>(positions, self.beads[bead].at as usize)
    }

    /// The rows with beads, and the lowest and the highest corner of the box around those of each,
    /// metres.
    fn boxes<R: Real>(&self, positions: &[R]) -> Vec<(usize, DVec3, DVec3)> {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut boxes: Vec<_> = (0..self.rows.len()).map(|row| (row, none.0, none.1)).collect();
        for (bead, point) in self.points(positions).enumerate() {
            let (_, low, high) = &mut boxes[self.row_of(bead)];
            (*low, *high) = (low.min(point), high.max(point));
        }
        boxes
    }

    fn points<'a, R: Real>(&'a self, positions: &'a [R]) -> impl Iterator<Item = DVec3> + 'a {
        (0..self.beads.len()).map(|bead| self.point(positions, bead).to_f64())
    }
}

impl<R: Real> Force<R> for Touches {
    /// What touches depends on masses, which an element does not see.
    fn element(&self) -> Option<&dyn Element<R>> {
        None
    }

    fn count(&self) -> usize {
        self.beads.len()
    }

    /// Whether any pair may dissipate energy.
    fn is_damped(&self) -> bool {
        let takes = |number: Option<f64>| number.is_some_and(|number| number != 0.0);
        let is_taking = |between: &Between| takes(between.damping) || takes(between.friction);
        let is_damped = |row: &Touch| row.damping != 0.0 || row.friction != 0.0;
        self.rows.iter().any(|row| is_damped(row) || row.between.iter().any(is_taking))
    }

    fn add_forces(&self, moment: &Moment<'_, R>, work: &mut ForceWork<R>, forces: &mut [R]) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let listed = work.near.nearby(moment.level, self, moment.motion.positions);
        add_forces(listed, moment, forces)
    }

    fn energy_and_pulls(&self, moment: &Moment<'_, R>, near: &Near<R>) -> [f64; 3] {
        let positions = moment.motion.positions;
        near.see(moment.level, self, positions, |near| energy_and_pulls(near, positions))
    }

    fn differentiate(&self, moment: &Moment<'_, R>, near: &mut Near<R>, to: &mut Derivatives) {
        self.set_tangents(moment, near, &mut to.touching);
    }

    fn add_products(
        &self,
        (_, derivatives): (&Motion<'_, R>, &Derivatives),
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        derivatives.touching.add_products(direction, products);
    }

    fn add_row_sums(&self, _: &Motion<'_, R>, of: &Derivatives, sums: &mut [[f64; 2]]) {
        of.touching.add_row_sums(sums);
    }

    fn linearise(&self, stage: &Stage<'_, R>, to: &mut MatrixSums<'_, R>) {
        let MatrixSums { work, near, blocks } = to;
        self.set_tangents(&stage.moment, near, &mut work.touching);
        work.touching.add_blocks(stage.tau, blocks);
    }

    fn multiply(&self, stage: &Stage<'_, R>, to: &mut ColumnProducts<'_, R>) {
        let ColumnProducts { work, direction, products } = to;
        work.touching.add_column_products(stage.tau, direction, products);
    }

    /// Those may touch that are near where the others have moved them; once, between the others.
    fn project(&self, projection: &mut Projection<'_, R>) {
        if self.is_empty() || projection.is_back {
            return;
        }
        let Projection { level, slots, h, inverse_masses, starts, ways, column, near, .. } =
            projection;
        for (at, (start, way)) in slots.places().zip(starts.iter().zip(&**ways)) {
            set_vector(column, at, *start + *way);
        }
        let near = near.nearby(*level, self, column);
        project((near, column), *h, inverse_masses, (starts, ways));
    }

    /// What may touch hangs together: which pairs do is not known before a solve.
    fn each_pair(&self, join: &mut dyn FnMut([u32; 2])) {
        self.beads.windows(2).for_each(|pair| join([pair[0].particle, pair[1].particle]));
    }

    fn add(&mut self, rows: &Scene, joints: Joints<'_>) {
        self.rows.extend_from_slice(&rows.touches);
        self.exempt.extend_from_slice(&rows.exempt);
        self.order(joints);
    }

    fn write(&self, rows: &mut Scene) {
        rows.touches.extend_from_slice(&self.rows);
        rows.exempt.extend_from_slice(&self.exempt);
    }

    fn remove(&mut self, is_removed: &dyn Fn(u32) -> bool, joints: Joints<'_>) {
        if !self.beads.iter().any(|bead| is_removed(bead.particle)) {
            return;
        }
        for row in &mut self.rows {
            row.particles.retain(|&particle| !is_removed(particle as u32));
            row.triangles
                .retain(|corners| !corners.iter().any(|&corner| is_removed(corner as u32)));
        }
        self.order(joints);
    }
}

impl Touches {
    /// Overwrites the derivatives of what touches.
    fn set_tangents<R: Real>(
        &self,
        moment: &Moment<'_, R>,
        near: &mut Near<R>,
        to: &mut TouchTangents,
    ) {
        to.clear();
        if !self.is_empty() {
            let listed = near.nearby(moment.level, self, moment.motion.positions);
            add_tangents(listed, moment, to);
        }
    }
}

/// Adds the forces of what is near each other in columns, newtons, and returns the power that they
/// dissipate, watts.
fn add_forces<R: Real>(near: Listed<'_, R>, moment: &Moment<'_, R>, forces: &mut [R]) -> f64 {
    let Moment { motion, inverse_masses, .. } = moment;
    let Motion { positions, velocities, .. } = *motion;
    let mut power = 0.0;
    for pair in near.pairs {
        let closed = pair.closed([positions, velocities], inverse_masses);
        let Some(closed) = closed else { continue };
        let (force, taken) = closed.pull(&pair.law);
        let [a, b] = pair.at.map(|at| at as usize);
        set_vector(forces, a, vector::<R>(forces, a) - force);
        add_vector::<R>(forces, b, force);
        power += taken.to_f64();
    }
    if near.facings.is_empty() {
        return power;
    }
    power + faces::add_forces(near.facings, motion, inverse_masses, forces)
}

/// Adds the derivatives of what touches.
fn add_tangents<R: Real>(near: Listed<'_, R>, moment: &Moment<'_, R>, to: &mut TouchTangents) {
    let Moment { motion, inverse_masses, .. } = moment;
    let Motion { positions, velocities, .. } = *motion;
    to.pairs.extend(near.pairs.iter().filter_map(|pair| {
        let closed = pair.closed([positions, velocities], inverse_masses)?;
        Some(closed.tangent(&pair.law, pair.particles, pair.at, [-R::ONE, R::ONE]))
    }));
    faces::add_tangents(near.facings, motion, inverse_masses, &mut to.faces);
}

/// Moves the particles of each pair, in order, as XPBD moves those of a spring: a touch is a
/// constraint of compliance 1/k, which only pushes, with friction along its surface. Those take
/// part that touch at the positions given in a column, before any of them is moved.
fn project<R: Real>(
    (near, positions): (Listed<'_, R>, &[R]),
    h: R,
    inverse_masses: &[R],
    (starts, ways): (&[R::Vec3], &mut [R::Vec3]),
) {
    for pair in near.pairs {
        let law = &pair.law;
        let [from, to] = pair.at.map(|at| vector::<R>(positions, at as usize));
        let before = to - from;
        // Others may be in the list or not.
        if law.reach * law.reach <= before.dot(before) {
            continue;
        }
        let [a, b] = pair.particles.map(|particle| particle as usize);
        let w = inverse_masses[a] + inverse_masses[b];
        let moved = ways[b] - ways[a];
        let apart = (starts[b] - starts[a]) + moved;
        let Some(pull) = law.project([apart, moved], w, h) else { continue };
        ways[a] -= pull * inverse_masses[a];
        ways[b] += pull * inverse_masses[b];
    }
    faces::project((near.facings, positions), h, inverse_masses, (starts, ways));
}

/// The energy of what touches, joules; the sums of k δ and of k, by which rounding changes it.
fn energy_and_pulls<R: Real>(near: Listed<'_, R>, positions: &[R]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    let mut add = |law: &PairLaw<R>, distance: f64| {
        let overlap = law.reach.to_f64() - distance;
        if 0.0 < overlap {
            let stiffness = law.stiffness.to_f64();
            sums[0] += 0.5 * stiffness * overlap * overlap;
            sums[1] += stiffness * overlap;
            sums[2] += stiffness;
        }
    };
    for pair in near.pairs {
        let [a, b] = pair.at.map(|at| vector::<R>(positions, at as usize).to_f64());
        let (apart, reach) = (b - a, pair.law.reach.to_f64());
        let square = apart.dot(apart);
        // Most pairs of the list do not touch.
        if square < reach * reach {
            add(&pair.law, Real::sqrt(square));
        }
    }
    faces::each_distance(near.facings, positions, add);
    sums
}
