//! Springs as constraints of XPBD, projected sixteen at a time.
//!
//! A batch is up to sixteen springs no two of which share a particle. Of two springs that do share
//! one, that with the lower number is in an earlier batch. The result is therefore that of one
//! spring after the other, to the last bit, whatever the batches are.

use super::Springs;
use super::law::{Law, project};
use super::sweep::{motion, set_points};
use crate::columns::slots::Slots;
use crate::columns::{Aligned, LANES, RECORD, single, store};
use crate::elements::Projection;
use crate::number::{GATHERED, POINT, QUAD, Real};
use crate::pack::{Number, Pack, zip};
use alloc::vec;
use alloc::vec::Vec;
use fearless_simd::Simd;

/// A batch of fewer takes as long as its springs do one by one.
const FEWEST: usize = 3;

/// Constants of a spring: rest length, k h², b h and the reciprocal masses of its ends.
const CONSTANTS: usize = 5;

/// Up to sixteen springs and the slots of their ends; those that are missing join a slot of nobody.
#[derive(Clone, Debug)]
struct Sixteen {
    springs: Vec<u32>,
    ends: [[u32; LANES]; 2],
    /// Those that are not cut.
    mask: u16,
}

/// The batches of springs in order.
#[derive(Clone, Debug)]
pub(crate) struct Batches<R: Real> {
    all: Vec<Sixteen>,
    /// The constants of each batch, in sixteens.
    constants: Aligned<R>,
    /// Positions at the start and displacements, by slot.
    points: Aligned<R>,
}

impl<R: Real> Batches<R> {
    pub(crate) fn new(springs: &Springs<R>, slots: &Slots) -> Self {
        let blank = slots.record_count() * LANES;
        let batch = |numbers: Vec<u32>| {
            let mut ends = [[blank as u32; LANES]; 2];
            for (lane, &spring) in numbers.iter().enumerate() {
                for (ends, &end) in ends.iter_mut().zip(&springs.ends[spring as usize]) {
                    ends[lane] = single(slots.at(end as usize)) as u32;
                }
            }
            Sixteen { springs: numbers, ends, mask: 0 }
        };
        let batches = in_batches(&springs.ends, slots.particle_count());
        let all: Vec<Sixteen> = batches.into_iter().map(batch).collect();
        let constants = Aligned::new(all.len() * CONSTANTS * LANES, 23);
        Batches { all, constants, points: Aligned::new((blank + 1) * POINT, 24) }
    }

    /// The number of multipliers of springs.
    pub(crate) fn multiplier_count(&self) -> usize {
        self.all.len() * LANES
    }

    /// Takes over the constants of springs and particles for substeps of h seconds.
    pub(crate) fn renew(&mut self, springs: &Springs<R>, inverse_masses: &[R], h: R) {
        let constants = self.constants.as_chunks_mut().0.as_chunks_mut::<CONSTANTS>().0;
        for (batch, constants) in self.all.iter_mut().zip(constants) {
            batch.mask = 0;
            for (lane, &spring) in batch.springs.iter().enumerate() {
                let law = springs.law(spring as usize);
                let [a, b] = springs.ends[spring as usize].map(|end| inverse_masses[end as usize]);
                let all = [law.rest, law.stiffness * h * h, law.damping * h, a, b];
                for (sixteen, constant) in constants.iter_mut().zip(all) {
                    let sixteen: &mut [R; LANES] = sixteen;
                    sixteen[lane] = constant;
                }
                batch.mask |= u16::from(!springs.is_cut(spring as usize)) << lane;
            }
        }
    }
}

/// Springs in the order of their numbers, each in the first batch with room that is behind those of
/// all earlier springs at its ends.
fn in_batches(ends: &[[u32; 2]], particles: usize) -> Vec<Vec<u32>> {
    let mut batches: Vec<Vec<u32>> = Vec::new();
    // For each batch where to look for room, and for each particle the batch behind its last.
    let (mut open, mut behind) = (Vec::new(), vec![0; particles]);
    for (spring, ends) in ends.iter().enumerate() {
        let [a, b] = ends.map(|end| end as usize);
        let mut number: usize = behind[a].max(behind[b]);
        while number < open.len() && open[number] != number {
            // Halves the way of the springs to come.
            let next = open[number];
            open[number] = if next < open.len() { open[next] } else { next };
            number = next;
        }
        if number == batches.len() {
            batches.push(Vec::with_capacity(LANES));
            open.push(number);
        }
        batches[number].push(spring as u32);
        open[number] += usize::from(batches[number].len() == LANES);
        (behind[a], behind[b]) = (number + 1, number + 1);
    }
    batches
}

/// Projects all springs in order, or backwards.
#[inline(always)]
pub(super) fn project_all<S: Simd, R: Real>(simd: S, to: &mut Projection<'_, R>) {
    let Batches { all, constants, points } = &mut *to.batches;
    let slots = points.len() / POINT - 1;
    let points = points.as_chunks_mut::<POINT>().0;
    if !to.has_springs_alone || !to.is_back {
        let seen = &mut points[..slots];
        set_points(simd, [to.positions, &*to.ways], seen.as_flattened_mut());
    }
    let constants = constants.as_chunks().0.as_chunks::<CONSTANTS>().0;
    let applied = to.multipliers[to.first..].as_chunks_mut::<LANES>().0;
    let batches = all.iter().zip(constants).zip(applied);
    if to.is_back {
        for (batch, applied) in batches.rev() {
            project_batch::<_, R, true>(simd, batch, points, applied);
        }
    } else {
        for (batch, applied) in batches {
            project_batch::<_, R, false>(simd, batch, points, applied);
        }
    }
    if !to.has_springs_alone || to.is_back {
        let records = to.ways.as_chunks_mut::<RECORD>().0;
        for (record, points) in records.iter_mut().zip(points.as_chunks::<LANES>().0) {
            let mut quads = [[R::ZERO; QUAD]; LANES];
            for (quad, point) in quads.iter_mut().zip(points) {
                quad.copy_from_slice(&point[QUAD..]);
            }
            *record = R::to_columns(simd, &quads);
        }
    }
}

/// Projects a batch. See [`project`].
#[inline(always)]
fn project_batch<S: Simd, R: Real, const BACK: bool>(
    simd: S,
    (batch, constants): (&Sixteen, &[[R; LANES]; CONSTANTS]),
    points: &mut [[R; POINT]],
    applied: &mut [R; LANES],
) {
    if batch.springs.len() < FEWEST {
        project_each::<R, BACK>((batch, constants), points, applied);
        return;
    }
    let lanes = Pack::<S, R>::LEN;
    let [ends_here, ends_there] = &batch.ends;
    let mut moved = [[R::ZERO; RECORD]; 2];
    for part in (0..LANES).step_by(lanes) {
        let (mut here, mut there) = ([R::ZERO; GATHERED], [R::ZERO; GATHERED]);
        R::gather(simd, points, &ends_here[part..part + lanes], &mut here);
        R::gather(simd, points, &ends_there[part..part + lanes], &mut there);
        let here = motion::<S, R, true>(simd, &here, &here[RECORD..], 0, 0);
        let there = motion::<S, R, true>(simd, &there, &there[RECORD..], 0, 0);
        let [rest, stiffness, damping, weight, weight_there] = constants;
        let law = Law {
            rest: lanes_of::<S, R>(simd, rest, part),
            stiffness: lanes_of(simd, stiffness, part),
            damping: lanes_of(simd, damping, part),
        };
        let weight = lanes_of(simd, weight, part);
        let weight_there = lanes_of(simd, weight_there, part);
        let own = &mut applied[part..part + lanes];
        let sum = if BACK { Pack::from_slice(simd, own) } else { weight.zero() };
        let is_there = Pack::<S, R>::mask(simd, u64::from(batch.mask >> part));
        let (pull, sum) = project([here, there], law, [weight, weight_there], (sum, is_there));
        sum.store_slice(own);
        store(zip(here[1], pull, |way, pull| way + pull * weight), &mut moved[0], part);
        store(zip(there[1], pull, |way, pull| way - pull * weight_there), &mut moved[1], part);
    }
    set_ways(simd, ends_here, &moved[0], points);
    set_ways(simd, ends_there, &moved[1], points);
}

/// Overwrites the displacements at some slots by those of a record.
#[inline(always)]
fn set_ways<S: Simd, R: Real>(
    simd: S,
    slots: &[u32; LANES],
    ways: &[R; RECORD],
    points: &mut [[R; POINT]],
) {
    let quads = R::to_quads(simd, ways);
    for lane in 0..LANES {
        let point: &mut [R; POINT] = &mut points[slots[lane] as usize];
        [point[QUAD], point[QUAD + 1], point[QUAD + 2], point[QUAD + 3]] = quads[lane];
    }
}

/// A constant of some lanes.
#[inline(always)]
fn lanes_of<S: Simd, R: Real>(simd: S, constants: &[R; LANES], part: usize) -> Pack<S, R> {
    Pack::from_slice(simd, &constants[part..part + Pack::<S, R>::LEN])
}

/// Projects the springs of a batch one by one.
#[inline(always)]
fn project_each<R: Real, const BACK: bool>(
    (batch, constants): (&Sixteen, &[[R; LANES]; CONSTANTS]),
    points: &mut [[R; POINT]],
    applied: &mut [R; LANES],
) {
    for lane in 0..batch.springs.len() {
        let [a, b] = [batch.ends[0][lane] as usize, batch.ends[1][lane] as usize];
        let [[x, y, z, _, u, v, w, _], [xb, yb, zb, _, ub, vb, wb, _]] = [points[a], points[b]];
        let motions = [[[x, y, z], [u, v, w]], [[xb, yb, zb], [ub, vb, wb]]];
        let [rest, stiffness, damping, weight, weight_there] =
            [0, 1, 2, 3, 4].map(|constant: usize| constants[constant][lane]);
        let law = Law { rest, stiffness, damping };
        let sum = if BACK { applied[lane] } else { R::ZERO };
        let is_there = batch.mask >> lane & 1 == 1;
        let (pull, sum) = project(motions, law, [weight, weight_there], (sum, is_there));
        applied[lane] = sum;
        for axis in 0..3 {
            points[a][QUAD + axis] += pull[axis] * weight;
            points[b][QUAD + axis] -= pull[axis] * weight_there;
        }
    }
}
