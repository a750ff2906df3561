//! The motion of bodies as wholes, which no tolerance may lose.
//!
//! Springs push no body as a whole: of a translation c of particles that only springs among
//! themselves hold together, the matrix makes D c, with D the masses, drag and grabs. So the sum of
//! what a solve has to reach is known beforehand, Σ r = Σ D δu, and c = Σ (r − D δu) / Σ D is what
//! a δu lacks of it. Conjugate gradients find that last of all, at k τ²/m = 4e5 in single precision
//! never: the weight of a particle is a rounding beside the stiffness. Here it is put in before the
//! solve and put right after it. (In the words of solvers: a coarse space of translations.)
//!
//! A body that obstacles hold moves in the directions that are left to it, one that is pinned not
//! at all.

use super::conjugate::Solve;
use super::resting::Holds;
use crate::columns::{LANES, set_vector, single, vector};
use crate::number::{Real, Vector};
use crate::system::Model;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use glam::DVec3;

/// Particles that springs join to each other and to no others, two or more: one alone is solved by
/// its block.
#[derive(Clone, Debug, Default)]
struct Whole {
    /// Which of the places.
    members: Range<usize>,
    /// Whether nothing of it is pinned.
    is_free: bool,
    /// Σ r, newton seconds.
    asked: DVec3,
    /// Σ D, kilograms.
    weight: f64,
    /// Friction on what slides, newton seconds.
    friction: DVec3,
    /// Directions in which obstacles hold it, of length one, and how many.
    axes: [DVec3; 3],
    held: usize,
}

/// The bodies of a model.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wholes {
    rows: Vec<Whole>,
    /// The places of particles, body by body.
    places: Vec<u32>,
    /// The row of each particle, by the number of its slot.
    row_of: Vec<u32>,
    /// Springs that there were when bodies were sought.
    springs: Option<usize>,
}

/// The row of a particle alone.
const NONE: u32 = u32::MAX;

impl Wholes {
    /// Takes over what was cut and pinned since the step before.
    pub(crate) fn find<R: Real>(&mut self, model: &Model<R>) {
        let springs = Some(model.spring_count());
        if self.springs != springs {
            self.springs = springs;
            self.seek(model);
        }
        // What elements of the caller's own join is not known.
        let may_be_free = model.own.is_empty();
        let moves = |&at: &u32| model.inverse_mass_column[at as usize] != R::ZERO;
        for whole in &mut self.rows {
            whole.is_free = may_be_free && self.places[whole.members.clone()].iter().all(moves);
        }
    }

    /// Lists the bodies in the order of their first particles.
    fn seek<R: Real>(&mut self, model: &Model<R>) {
        let count = model.particle_count();
        // Of each particle one of lower number that it hangs together with, or itself.
        let mut lower: Vec<u32> = (0..count as u32).collect();
        for (spring, ends) in model.ends().iter().enumerate() {
            if !model.is_cut(spring) {
                let [a, b] = ends.map(|end| first_of(&mut lower, end));
                lower[a.max(b) as usize] = a.min(b);
            }
        }
        let mut sizes = vec![0; count];
        (0..count as u32).for_each(|i| sizes[first_of(&mut lower, i) as usize] += 1);
        self.rows.clear();
        self.row_of.clear();
        self.row_of.resize(model.slots.record_count() * LANES, NONE);
        let mut end = 0;
        for (particle, at) in model.slots.places().enumerate() {
            let first = lower[particle] as usize;
            if first == particle && 1 < sizes[particle] {
                self.row_of[single(at)] = self.rows.len() as u32;
                self.rows.push(Whole { members: end..end, ..Whole::default() });
                end += sizes[particle];
            } else {
                self.row_of[single(at)] = self.row_of[single(model.slots.at(first))];
            }
        }
        self.places.clear();
        self.places.resize(end, 0);
        for at in model.slots.places() {
            if let Some(whole) = self.rows.get_mut(self.row_of[single(at)] as usize) {
                self.places[whole.members.end] = at as u32;
                whole.members.end += 1;
            }
        }
    }

    /// Whether every body is pinned.
    pub(crate) fn is_empty(&self) -> bool {
        !self.rows.iter().any(|whole| whole.is_free)
    }

    /// Sums the residuals of all forces but those of springs, and the diagonal of the matrix.
    pub(crate) fn begin<R: Real>(&mut self, residuals: &[R], diagonals: &[R]) {
        for whole in self.rows.iter_mut().filter(|whole| whole.is_free) {
            (whole.asked, whole.weight) = (DVec3::ZERO, 0.0);
            for &at in &self.places[whole.members.clone()] {
                whole.asked += vector::<R>(residuals, at as usize).to_f64();
                whole.weight += diagonals[at as usize].to_f64();
            }
        }
    }

    /// Adds to the changes of velocity what they lack of the motion of each body as a whole.
    pub(crate) fn shift<R: Real>(
        &mut self,
        holds: &Holds<R>,
        diagonals: &[R],
        solve: &mut Solve<R>,
    ) {
        if self.is_empty() {
            return;
        }
        self.rows.iter_mut().for_each(|whole| (whole.held, whole.friction) = (0, DVec3::ZERO));
        for (at, axes, friction) in holds.directions() {
            if let Some(whole) = self.rows.get_mut(self.row_of[single(at)] as usize) {
                axes.into_iter().for_each(|axis| whole.hold(axis));
                whole.friction += friction;
            }
        }
        let Solve { changes, residuals, .. } = solve;
        for whole in self.rows.iter().filter(|whole| whole.is_free && whole.held < 3) {
            let members = || self.places[whole.members.clone()].iter().map(|&at| at as usize);
            let mut lacking = whole.asked + whole.friction;
            for at in members() {
                lacking -= vector::<R>(changes, at).to_f64() * diagonals[at].to_f64();
            }
            let shift = R::Vec3::of(whole.free(lacking) / whole.weight);
            for at in members() {
                let residual = vector::<R>(residuals, at) - shift * diagonals[at];
                set_vector(residuals, at, residual);
                let change = vector::<R>(changes, at) + shift;
                set_vector(changes, at, change);
            }
        }
    }
}

impl Whole {
    /// The part of a vector in the directions that are left.
    fn free(&self, vector: DVec3) -> DVec3 {
        self.axes[..self.held].iter().fold(vector, |rest, axis| rest - *axis * axis.dot(rest))
    }

    /// Holds a direction, unless it is a combination of those held.
    fn hold(&mut self, direction: DVec3) {
        let rest = self.free(direction);
        let length = Real::sqrt(rest.dot(rest));
        if self.held < 3 && SAME < length {
            self.axes[self.held] = rest * (1.0 / length);
            self.held += 1;
        }
    }
}

/// What rounding leaves of a direction beside its like.
const SAME: f64 = 1e-6;

/// The first of the particles that one hangs together with; shortens the way there.
fn first_of(lower: &mut [u32], particle: u32) -> u32 {
    let mut at = particle;
    while lower[at as usize] != at {
        let next = lower[at as usize];
        lower[at as usize] = lower[next as usize];
        at = lower[at as usize];
    }
    at
}
