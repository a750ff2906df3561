//! Touches: particles with a radius, which push each other apart.

use super::check::check_count;
use super::{Body, Scene};
use crate::error::Error;
use crate::grid::Grid;
use crate::triangle::{Nearest, around, nearest};
use alloc::vec::Vec;
use fearless_simd::Level;
use glam::DVec3;

/// Particles of a radius. Two that are closer than the sum of their radii push each other.
///
/// With δ by how much, n the direction from one to the other and v their relative velocity, the
/// push is N = k δ − c n·v, and never a pull; friction is min(g |v'|, μ N) against the velocity v'
/// across n, with g = √(k m) and m the reduced mass of the two (Coulomb's law, in which what sticks
/// creeps at the speed F/g under a load F). k and c of a pair are those of its particles one after
/// the other, a b / (a + b), and μ is √(a b).
///
/// A particle is in one row at most. Particles that a spring joins do not touch, cut or not.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Touch {
    /// The particles, in order.
    pub particles: Vec<usize>,
    /// Radius of each, metres; positive.
    pub radius: f64,
    /// Stiffness k of each, newtons per metre; positive.
    pub stiffness: f64,
    /// Damping c of each, newton seconds per metre; not negative.
    pub damping: f64,
    /// Coulomb's factor μ, not negative.
    pub friction: f64,
    /// Triangles of a surface by their corners, particles of the row. A particle with a radius is
    /// pushed by the point that is nearest to it of all those it does not belong to: as by a
    /// particle at that point, which shares out what it gets to the corners by its weights. A
    /// corner touches by its triangles alone: two that are both corners push each other from both
    /// sides, by half of k and c each. None joins in that has a corner that the particle does not
    /// touch.
    pub triangles: Vec<[usize; 3]>,
    /// Whether they touch each other, beside those of other rows.
    pub itself: bool,
    /// Whether the radius counts against obstacles too; otherwise these meet points.
    pub obstacles: bool,
    /// Rows before this one that they pass through.
    pub ignored: Vec<usize>,
    /// How they touch those of rows before this one, where not as both rows say; each row once.
    pub between: Vec<Between>,
}

/// How particles of a row touch those of another, in place of what follows from both rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Between {
    /// The other row, before the one that says so.
    pub row: usize,
    /// Stiffness k of a pair, newtons per metre; positive. Default that of both rows one after the
    /// other.
    pub stiffness: Option<f64>,
    /// Damping c of a pair, newton seconds per metre; not negative. Default that of both rows one
    /// after the other, in proportion to k.
    pub damping: Option<f64>,
    /// Coulomb's factor μ of a pair, not negative. Default √(a b).
    pub friction: Option<f64>,
}

impl Between {
    /// Stiffness of a pair of particles of two rows, the lower first, newtons per metre.
    pub(crate) fn stiffness_of(&self, [a, b]: [&Touch; 2]) -> f64 {
        self.stiffness.unwrap_or_else(|| in_turn(a.stiffness, b.stiffness))
    }

    /// Damping of a pair of particles of two rows, the lower first, newton seconds per metre.
    pub(crate) fn damping_of(&self, [a, b]: [&Touch; 2]) -> f64 {
        self.damping.unwrap_or_else(|| {
            let damping = in_turn(a.damping, b.damping);
            match self.stiffness {
                Some(stiffness) => damping * (stiffness / in_turn(a.stiffness, b.stiffness)),
                None => damping,
            }
        })
    }
}

/// Whether the particles of two rows touch each other, or those of one among themselves.
pub fn do_touch(rows: &[Touch], [a, b]: [usize; 2]) -> bool {
    let (first, last) = (a.min(b), a.max(b));
    if first == last { rows[first].itself } else { !rows[last].ignored.contains(&first) }
}

/// Two springs, or two dampers, one after the other.
fn in_turn(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a / (a / b + 1.0) }
}

/// The most pairs for each particle with a radius.
const MOST_PAIRS: usize = 256;

impl Scene {
    /// Adds a row of touches, and exempts what is closer than its radii among its particles now, at
    /// rest: pairs, and of a particle and a triangle the pair with the nearest corner.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for a radius within which particles have hundreds of others.
    pub fn add_touch(&mut self, touch: Touch) -> Result<(), Error> {
        if touch.itself {
            self.exempt.extend(close(self, &touch)?);
        }
        self.touches.push(touch);
        Ok(())
    }

    /// The row that begins in a body; `None` where its particles have no radius.
    pub fn touch_of(&self, body: &Body) -> Option<&Touch> {
        let begins =
            |touch: &&Touch| touch.particles.first().is_some_and(|at| body.particles.contains(at));
        self.touches.iter().find(begins)
    }
}

/// Refuses more pairs than particles that do not overlap can have.
pub(crate) fn check_pairs(pairs: usize, particles: usize) -> Result<(), Error> {
    let most = particles.saturating_mul(MOST_PAIRS);
    check_count("the number of pairs of particles closer than their radii", pairs, most)
}

/// The pairs of a row that are closer than twice their radius and not joined by a spring, those of
/// the corners of triangles last.
fn close(scene: &Scene, touch: &Touch) -> Result<Vec<[usize; 2]>, Error> {
    let points: Vec<DVec3> = touch
        .particles
        .iter()
        .filter_map(|&particle| scene.particles.get(particle))
        .map(|particle| particle.position)
        .collect();
    let reach = 2.0 * touch.radius;
    let is_usable = points.len() == touch.particles.len() && 0.0 < reach;
    if !is_usable {
        return Ok(Vec::new());
    }
    let mut joined: Vec<_> = scene.springs.iter().map(|spring| sorted(spring.ends)).collect();
    joined.sort_unstable();
    let (mut grid, mut pairs) = (Grid::default(), Vec::new());
    grid.fill(reach, points.iter().copied());
    grid.each_pair(Level::baseline(), reach, |a, b| {
        let is_close = (points[b] - points[a]).length_squared() <= reach * reach;
        let pair = sorted([a, b].map(|at| touch.particles[at]));
        if is_close && joined.binary_search(&pair).is_err() {
            pairs.push(pair);
        }
        check_pairs(pairs.len(), points.len())
    })?;
    joined.extend(&pairs);
    joined.sort_unstable();
    for &triangle in &touch.triangles {
        let Some(corners) = places(scene, triangle) else { continue };
        grid.each_in(around(corners, reach), |at| {
            let own = triangle.map(|corner| sorted([touch.particles[at], corner]));
            let is_spared = |&[a, b]: &[usize; 2]| a == b || joined.binary_search(&[a, b]).is_ok();
            let Nearest { weights, square, .. } =
                nearest::<f64>(corners.map(|corner| points[at] - corner));
            if square <= reach * reach && !own.iter().any(is_spared) {
                let later = |a: usize, b: usize| if weights[a] < weights[b] { b } else { a };
                pairs.push(own[later(later(0, 1), 2)]);
            }
            check_pairs(pairs.len(), points.len())
        })?;
    }
    Ok(pairs)
}

/// A pair, the lower particle first.
fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Where the corners of a triangle are, metres, if there are such particles.
fn places(scene: &Scene, [a, b, c]: [usize; 3]) -> Option<[DVec3; 3]> {
    let place = |at: usize| scene.particles.get(at).map(|particle| particle.position);
    Some([place(a)?, place(b)?, place(c)?])
}
