//! Shells: surfaces, ropes and points with a thickness, which do not cross each other.

use super::{Body, Scene};
use crate::number::Real;
use alloc::vec::Vec;

/// Triangles, edges and points that keep a distance from those of other shells.
///
/// Two shells stop each other where the distance of their middle surfaces is the sum of their
/// thicknesses. They do so by impulses, without a stiffness: a shell does not limit the substep.
/// Friction is Coulomb's, with the factor √(a b) of the two. The larger coefficient of restitution
/// counts.
///
/// A particle is in one shell at most. Triangles and edges with a common particle do not meet.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Shell {
    /// Triangles by their corners.
    pub triangles: Vec<[usize; 3]>,
    /// Edges that belong to no triangle, as those of a rope, by their ends.
    pub edges: Vec<[usize; 2]>,
    /// Particles that belong to no triangle and no edge: balls whose radius is the thickness.
    pub points: Vec<usize>,
    /// Distance that it keeps on each side of its middle surface, metres; positive. A tenth of the
    /// length of its edges is a good choice. Shells of half of that may cross at long substeps.
    pub thickness: f64,
    /// Coulomb's factor μ, not negative.
    pub friction: f64,
    /// Coefficient of restitution, from 0 to 1: the speed at which particles separate over that at
    /// which they approached. A soft body bounces by its own springs and needs none.
    pub restitution: f64,
    /// Whether it stops itself, beside other shells. Its features that share no particle should be
    /// farther apart at rest than twice its thickness.
    pub itself: bool,
    /// Whether it keeps its thickness from obstacles too; otherwise these meet its particles as
    /// points.
    pub obstacles: bool,
    /// Pairs of its own particles; no triangle, edge or point at one meets those at the other. For
    /// parts of the shell that are closer at rest than it stops itself at, twice its thickness.
    pub exempt: Vec<[usize; 2]>,
    /// Shells before this one that it passes through.
    pub ignored: Vec<usize>,
    /// Rules of contact with shells before this one, which replace those of both; each pair once.
    pub between: Vec<Between>,
}

/// Rules of contact of a shell with another, which replace those of both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Between {
    /// The other shell, before the one that has this row.
    pub shell: usize,
    /// Coulomb's factor μ, not negative. Default √(a b).
    pub friction: Option<f64>,
    /// Coefficient of restitution, from 0 to 1. Default the larger of the two.
    pub restitution: Option<f64>,
}

impl Shell {
    /// The surface of a body as a shell of a thickness, metres, without friction.
    pub fn of(body: &Body, thickness: f64) -> Self {
        let all = body.surface.particles().map(|corners| corners.map(|corner| corner as usize));
        let triangles = all.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        Shell { triangles, thickness, ..Shell::default() }
    }

    /// Whether it is that of a body.
    pub fn is_of(&self, body: &Body) -> bool {
        self.particles().next().is_some_and(|particle| body.particles.contains(&particle))
    }

    /// Its particles; one that several triangles or edges share comes once for each.
    pub fn particles(&self) -> impl Iterator<Item = usize> + '_ {
        let corners = self.triangles.as_flattened().iter().chain(self.edges.as_flattened());
        corners.chain(&self.points).copied()
    }
}

/// Whether any of some shells meets another or itself.
pub fn any_meet(shells: &[Shell]) -> bool {
    let others = |last: usize| (0..last).any(|first| do_meet(shells, [first, last]));
    (0..shells.len()).any(|row| shells[row].itself || others(row))
}

impl Scene {
    /// The shell of a body; `None` for a body that passes through all others.
    pub fn shell_of(&self, body: &Body) -> Option<&Shell> {
        self.shells.iter().find(|shell| shell.is_of(body))
    }
}

/// Whether two shells stop each other; of one given twice, whether it stops itself.
pub fn do_meet(shells: &[Shell], [a, b]: [usize; 2]) -> bool {
    let (first, last) = (a.min(b), a.max(b));
    if first == last { shells[first].itself } else { !shells[last].ignored.contains(&first) }
}

/// The rules of contact between two shells, where they are given for the two.
pub fn between(shells: &[Shell], [a, b]: [usize; 2]) -> Option<&Between> {
    shells[a.max(b)].between.iter().find(|between| between.shell == a.min(b))
}

/// Coulomb's factor and the coefficient of restitution with which two shells meet.
pub fn law_between(shells: &[Shell], pair: [usize; 2]) -> [f64; 2] {
    let [a, b] = pair.map(|row| &shells[row]);
    let said = between(shells, pair).copied().unwrap_or_default();
    let friction = said.friction.unwrap_or_else(|| Real::sqrt(a.friction * b.friction));
    [friction, said.restitution.unwrap_or(a.restitution.max(b.restitution))]
}
