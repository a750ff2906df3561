//! Shells: surfaces and ropes with a thickness, which do not cross each other.

use alloc::vec::Vec;

/// Triangles and edges between particles that keep a distance from those of other shells.
///
/// Two shells stop each other where their middle surfaces are as close as the sum of their
/// thicknesses. They do so by impulses, without a stiffness: a shell does not limit the substep.
/// Friction along them is Coulomb's, with the factor √(a b) of the two.
///
/// A particle is in one shell at most. Triangles and edges with a common particle do not meet.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Shell {
    /// Triangles by their corners.
    pub triangles: Vec<[usize; 3]>,
    /// Edges that belong to no triangle, as those of a rope, by their ends.
    pub edges: Vec<[usize; 2]>,
    /// Distance that it keeps on each side of its middle surface, metres; positive. A tenth of its
    /// edges is a good choice; those of half of that may cross at long substeps.
    pub thickness: f64,
    /// Coulomb's factor μ, not negative.
    pub friction: f64,
    /// Whether it stops itself, beside other shells. Its features that share no particle should be
    /// farther apart at rest than twice its thickness.
    pub itself: bool,
    /// Shells before this one that it passes through.
    pub ignored: Vec<usize>,
}

/// Whether two shells stop each other, or one itself.
pub fn do_meet(shells: &[Shell], [a, b]: [usize; 2]) -> bool {
    let (first, last) = (a.min(b), a.max(b));
    if first == last { shells[first].itself } else { !shells[last].ignored.contains(&first) }
}
