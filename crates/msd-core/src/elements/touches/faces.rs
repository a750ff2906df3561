//! Particles with a radius against the triangles of a row.
//!
//! A bead is pushed by the nearest point of all triangles of a row, by the law of a pair: that
//! point is a particle at Σ wᵢ xᵢ with the velocity Σ wᵢ vᵢ and the reciprocal mass Σ wᵢ²/mᵢ, and
//! its force is shared out to the corners by the weights wᵢ. So an edge or a corner, in which many
//! triangles meet, counts once, the force is continuous from one triangle to the next, and so it is
//! as the nearest point comes to a corner: what lies on a corner is its pair, and pairs of beads of
//! which one is a corner are not counted beside it. A bead that is a corner itself is met by the
//! other's triangles as they are met by it: each of the two has half of the stiffness and of the
//! damping, so that two corners push each other as a pair does.
//!
//! Of a row that is folded inwards the nearest point jumps from one side to the other, and with it
//! the direction of the force; its energy does not.

use super::Touches;
use super::law::{Closed, PairLaw};
use super::tangent::Touching;
use crate::columns::{set_vector, vector};
use crate::elements::Motion;
use crate::grid::Grid;
use crate::number::{Real, Vector};
use crate::triangle::{Nearest, around, nearest};
use alloc::vec::Vec;
use core::convert::Infallible;
use glam::DVec3;

/// A bead and a triangle that may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facing<R: Real> {
    /// The bead, and the corners.
    particles: [u32; 4],
    /// Where the numbers of each are in a column of vectors.
    at: [u32; 4],
    /// The row of the triangle.
    row: u32,
    law: PairLaw<R>,
}

impl<R: Real> Facing<R> {
    /// The vectors of the bead in a column, less those of each corner.
    #[inline(always)]
    fn seen_by_corners(&self, column: &[R]) -> [R::Vec3; 3] {
        let [bead, corners @ ..] = self.at.map(|at| vector::<R>(column, at as usize));
        corners.map(|corner| bead - corner)
    }

    /// Whether the bead may pass through the triangle in a substep of h, seconds: it goes from one
    /// side of it to the other, or closes by more than the reach towards it and comes within it.
    /// What starts too far away for that does not, although it may be in the list.
    fn may_pass(&self, [positions, velocities]: [&[R]; 2], h: f64) -> bool {
        let way = FacingWay {
            starts: self.seen_by_corners(positions).map(Vector::to_f64),
            ways: self.seen_by_corners(velocities).map(|velocity| velocity.to_f64() * h),
        };
        let reach = self.law.reach.to_f64();
        let (length, start) = (way.length(), way.distance(0.0));
        if length <= reach {
            start < reach && way.may_cross(length)
        } else {
            start < reach + length && way.may_come_within(reach, length, start)
        }
    }
}

/// The way of a bead in a substep, as seen from each corner of a triangle, metres.
struct FacingWay {
    starts: [DVec3; 3],
    ways: [DVec3; 3],
}

impl FacingWay {
    /// The longest of the three.
    fn length(&self) -> f64 {
        let squares = self.ways.map(|way| way.dot(way));
        Real::sqrt(squares.into_iter().fold(0.0, f64::max))
    }

    /// Where the bead is after a part of the substep, as seen from each corner.
    fn after(&self, part: f64) -> [DVec3; 3] {
        [0, 1, 2].map(|corner| self.starts[corner] + self.ways[corner] * part)
    }

    fn distance(&self, part: f64) -> f64 {
        Real::sqrt(nearest::<f64>(self.after(part)).square)
    }

    /// Whether the bead may go from one side of the triangle to the other.
    fn may_cross(&self, length: f64) -> bool {
        let [before, behind] = [0.0, 1.0].map(|part| height(self.after(part)));
        // Where it is in the plane, as the heights say, it is no farther than its way from where it
        // crosses.
        before * behind <= 0.0 && self.distance(before / (before - behind)) <= length
    }

    /// Whether the bead may come within reach of the triangle and closer than it is, by looks no
    /// farther apart than half a reach.
    fn may_come_within(&self, reach: f64, length: f64, start: f64) -> bool {
        let looks = 2.0 * length / reach;
        if MOST_LOOKS < looks {
            return true;
        }
        let looks = looks as u32 + 1;
        let between = 0.5 * length / f64::from(looks);
        let mut distances =
            (1..=looks).map(|look| self.distance(f64::from(look) / f64::from(looks)));
        distances.any(|distance| distance < start && distance - between < reach)
    }
}

/// The most points of a way that are looked at.
const MOST_LOOKS: f64 = 64.0;

/// The height over a triangle, times twice its area, given by the ways from its corners.
fn height([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).dot(a)
}

/// The touch of a bead and the triangles of a row.
struct FaceTouch<'a, R: Real> {
    facing: &'a Facing<R>,
    nearest: Nearest<R>,
}

impl<'a, R: Real> FaceTouch<'a, R> {
    /// The nearest triangle of those that a bead may touch; of two, the first. `None` where none
    /// is within reach.
    #[inline(always)]
    fn of(group: &'a [Facing<R>], positions: &[R]) -> Option<Self> {
        let reach = group[0].law.reach;
        let (mut least, mut met) = (reach * reach, None);
        for facing in group {
            let ways = facing.seen_by_corners(positions);
            // Most are farther along one axis already, by more than what rounding is worth.
            if least < farthest_along_an_axis::<R>(ways) * R::of(0.999) {
                continue;
            }
            let nearest = nearest::<R>(ways);
            if nearest.square < least {
                (least, met) = (nearest.square, Some(FaceTouch { facing, nearest }));
            }
        }
        met
    }

    /// The sum of a number of each corner, by the weights.
    #[inline(always)]
    fn weigh(&self, vectors: [R::Vec3; 3]) -> R::Vec3 {
        let [a, b, c] = [0, 1, 2].map(|corner| vectors[corner] * self.nearest.weights[corner]);
        a + b + c
    }

    /// The reciprocal mass of the bead and the point together, with that of each of the four.
    #[inline(always)]
    fn inverse_mass(&self, [bead, corners @ ..]: [R; 4]) -> R {
        let [a, b, c] = self.nearest.weights;
        bead + (a * a * corners[0] + b * b * corners[1] + c * c * corners[2])
    }

    #[inline(always)]
    fn closed(&self, velocities: &[R], inverse_masses: &[R]) -> Option<Closed<R>> {
        let FaceTouch { facing, nearest } = self;
        let relative = self.weigh(facing.seen_by_corners(velocities));
        let masses = self.inverse_mass(facing.at.map(|at| inverse_masses[at as usize]));
        facing.law.close([nearest.point, relative], masses)
    }

    /// The parts of the bead and of the corners in the motion of one as seen from the other.
    #[inline(always)]
    fn shares(&self) -> [R; 4] {
        let [a, b, c] = self.nearest.weights;
        [R::ONE, -a, -b, -c]
    }

    fn tangent(&self, closed: &Closed<R>, positions: &[R]) -> Touching<4> {
        let FaceTouch { facing, nearest } = self;
        let mut touching = closed.tangent(&facing.law, facing.particles, facing.at, self.shares());
        // Where the point is free to move on the triangle, nothing turns with the bead.
        let is_held = nearest.weights.map(|weight| weight == R::ZERO);
        match is_held.iter().filter(|&&held| held).count() {
            0 => touching.across = 0.0,
            1 => {
                let opposite = is_held.iter().position(|&held| held).unwrap_or(0);
                let corners = facing.seen_by_corners(positions).map(Vector::to_f64);
                let edge = corners[(opposite + 1) % 3] - corners[(opposite + 2) % 3];
                touching.slide = edge / Real::sqrt(edge.dot(edge));
            }
            _ => {}
        }
        touching
    }
}

/// The square of the distance of the origin from the box around a triangle along the axis where
/// that is longest.
#[inline(always)]
fn farthest_along_an_axis<R: Real>(corners: [R::Vec3; 3]) -> R {
    let [a, b, c] = corners.map(Vector::components);
    let mut farthest = R::ZERO;
    for axis in 0..3 {
        let (low, high) = (a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis]));
        farthest = farthest.max(low).max(-high);
    }
    farthest * farthest
}

/// What each bead may touch of each row, in order.
fn groups<R: Real>(facings: &[Facing<R>]) -> impl Iterator<Item = &[Facing<R>]> {
    facings.chunk_by(|a, b| a.particles[0] == b.particles[0] && a.row == b.row)
}

/// What each bead touches of each row.
fn all_met<'a, R: Real>(
    facings: &'a [Facing<R>],
    positions: &'a [R],
) -> impl Iterator<Item = FaceTouch<'a, R>> {
    groups(facings).filter_map(|group| FaceTouch::of(group, positions))
}

/// Adds the forces in columns, newtons, and returns the power that they dissipate, watts.
pub(super) fn add_forces<R: Real>(
    facings: &[Facing<R>],
    motion: &Motion<'_, R>,
    inverse_masses: &[R],
    forces: &mut [R],
) -> f64 {
    let mut power = 0.0;
    for met in all_met(facings, motion.positions) {
        let closed = met.closed(motion.velocities, inverse_masses);
        let Some(closed) = closed else { continue };
        let (force, taken) = closed.pull(&met.facing.law);
        for (at, share) in met.facing.at.into_iter().zip(met.shares()) {
            let at = at as usize;
            set_vector(forces, at, vector::<R>(forces, at) + force * share);
        }
        power += taken.to_f64();
    }
    power
}

/// Adds the derivatives of what touches.
pub(super) fn add_tangents<R: Real>(
    facings: &[Facing<R>],
    motion: &Motion<'_, R>,
    inverse_masses: &[R],
    to: &mut Vec<Touching<4>>,
) {
    to.extend(all_met(facings, motion.positions).filter_map(|met| {
        let closed = met.closed(motion.velocities, inverse_masses)?;
        Some(met.tangent(&closed, motion.positions))
    }));
}

/// Moves the particles of each touch, in order, as XPBD moves those of a pair: the nearest triangle
/// is that at the positions given in a column, its nearest point that of the present ones.
pub(super) fn project<R: Real>(
    (facings, positions): (&[Facing<R>], &[R]),
    h: R,
    inverse_masses: &[R],
    (starts, ways): (&[R::Vec3], &mut [R::Vec3]),
) {
    for FaceTouch { facing, .. } in all_met(facings, positions) {
        let all = facing.particles.map(|particle| particle as usize);
        let [bead, corners @ ..] = all;
        let moved = corners.map(|corner| ways[bead] - ways[corner]);
        let apart = [0, 1, 2].map(|at| (starts[bead] - starts[corners[at]]) + moved[at]);
        let met = FaceTouch { facing, nearest: nearest::<R>(apart) };
        let masses = met.inverse_mass(all.map(|particle| inverse_masses[particle]));
        let both = [met.nearest.point, met.weigh(moved)];
        let Some(pull) = facing.law.project(both, masses, h) else { continue };
        for (particle, share) in all.into_iter().zip(met.shares()) {
            ways[particle] += pull * (share * inverse_masses[particle]);
        }
    }
}

/// Sees the law and the distance of what touches.
pub(super) fn each_distance<R: Real>(
    facings: &[Facing<R>],
    positions: &[R],
    mut see: impl FnMut(&PairLaw<R>, f64),
) {
    for met in all_met(facings, positions) {
        let point = met.nearest.point.to_f64();
        see(&met.facing.law, Real::sqrt(point.dot(point)));
    }
}

/// Counts the beads that may pass through triangles of a row in a substep of h, seconds.
pub(super) fn count_passes<R: Real>(facings: &[Facing<R>], columns: [&[R]; 2], h: f64) -> usize {
    let passes = |group: &&[Facing<R>]| group.iter().any(|facing| facing.may_pass(columns, h));
    groups(facings).filter(passes).count()
}

/// Overwrites `facings` with the beads and triangles closer than their reach and a skin, metres, in
/// order. The grid is full of the beads, and `keys` is scratch.
pub(super) fn list<R: Real>(
    touches: &Touches,
    (grid, positions): (&Grid, &[R]),
    skin: f64,
    keys: &mut Vec<u64>,
    facings: &mut Vec<Facing<R>>,
) {
    keys.clear();
    let never: Result<(), Infallible> =
        each_near(touches, (grid, positions), skin, |bead, triangle| {
            keys.push((bead as u64) << 32 | triangle as u64);
            Ok(())
        });
    let Ok(()) = never;
    // Triangles are in the order of their rows.
    keys.sort_unstable();
    facings.clear();
    facings.extend(keys.iter().map(|key| {
        let [bead, triangle] = [key >> 32, key & u64::from(u32::MAX)].map(|number| number as usize);
        let [a, b, c] = touches.triangles[triangle].map(|corner| touches.beads[corner as usize]);
        let all = [touches.beads[bead], a, b, c];
        Facing {
            particles: all.map(|bead| bead.particle),
            at: all.map(|bead| bead.at),
            row: a.row,
            law: touches.law_of_facing(bead, triangle),
        }
    }));
}

/// Sees every bead and triangle that do touch where they are closer than their reach, and are
/// closer than that and a skin, metres, until there is an error.
pub(super) fn each_near<R: Real, E>(
    touches: &Touches,
    (grid, positions): (&Grid, &[R]),
    skin: f64,
    mut see: impl FnMut(usize, usize) -> Result<(), E>,
) -> Result<(), E> {
    let [_, widest] = touches.reaches();
    let boxes = touches.boxes(positions);
    for (triangle, corners) in touches.triangles.iter().enumerate() {
        let corners = corners.map(|corner| touches.point(positions, corner as usize));
        let [low, high] = around(corners.map(Vector::to_f64), widest + skin);
        let first = touches.triangles[triangle][0] as usize;
        let is_met = |&(row, from, to): &(usize, DVec3, DVec3)| {
            touches.do_rows_meet(row, touches.row_of(first))
                && low.cmple(to).all()
                && from.cmple(high).all()
        };
        // Most triangles are far from all bodies but their own.
        if !boxes.iter().any(is_met) {
            continue;
        }
        grid.each_in([low, high], |bead| {
            let here = touches.point(positions, bead);
            let place = here.to_f64();
            let is_in = low.cmple(place).all() && place.cmple(high).all();
            // Most are in other corners of the cells, or of bodies that do not touch.
            if !is_in || !touches.do_rows_touch(bead, first) {
                return Ok(());
            }
            let square = nearest::<R>(corners.map(|corner| here - corner)).square;
            let most = R::of(touches.reach_of(bead, triangle) + skin);
            let is_near = square < most * most && touches.do_face(bead, triangle);
            if is_near { see(bead, triangle) } else { Ok(()) }
        })?;
    }
    Ok(())
}

/// The longest edge of all triangles, metres.
pub(super) fn longest_edge<R: Real>(touches: &Touches, positions: &[R]) -> f64 {
    let mut longest = R::ZERO;
    for corners in &touches.triangles {
        let [a, b, c] = corners.map(|corner| touches.point(positions, corner as usize));
        for edge in [b - a, c - b, a - c] {
            longest = longest.max(edge.dot(edge));
        }
    }
    Real::sqrt(longest.to_f64())
}
