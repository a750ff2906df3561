//! The parts of a model that can be left out, and the rows of a scene that each of them is.

use msd_core::glam::DVec3;
use msd_core::scene::any_meet;
use msd_core::{Body, Scene, Spring};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::ops::Range;

/// The tolerance of a rest length about that of a lattice, as a fraction of the spacing.
const SLACK: f64 = 1e-3;

/// A part of a model that can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Part {
    /// The dampings of all springs.
    Damping,
    /// Gravity.
    Gravity,
    /// The springs along the diagonals of the faces of regular bodies.
    FaceDiagonals,
    /// The springs through the cells of regular bodies.
    SpaceDiagonals,
    /// The springs of shells that bridge the edge between two triangles.
    BendingSprings,
    /// The drag of the air.
    Drag,
    /// Contact with planes and solids, and of bodies with each other and themselves.
    Contact,
}

impl Part {
    /// All parts, in the order in which they are listed.
    pub const ALL: [Part; 7] = [
        Part::Damping,
        Part::Gravity,
        Part::FaceDiagonals,
        Part::SpaceDiagonals,
        Part::BendingSprings,
        Part::Drag,
        Part::Contact,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Part::Damping => "damping",
            Part::Gravity => "gravity",
            Part::FaceDiagonals => "face diagonals",
            Part::SpaceDiagonals => "space diagonals",
            Part::BendingSprings => "bending springs",
            Part::Drag => "drag",
            Part::Contact => "contact",
        }
    }

    /// The springs that it consists of, as ascending ranges of rows; empty for a part that is not a
    /// kind of spring. `None` where the scene does not have it, or has it with springs that do
    /// nothing.
    pub fn found_in(self, scene: &Scene) -> Option<Vec<Range<usize>>> {
        let springs = self.springs(scene);
        let is_there = match self {
            Part::Damping => {
                scene.springs.iter().any(|spring| spring.damping != 0.0)
                    || scene.bends.iter().any(|bend| bend.damping != 0.0)
                    || scene.volumes.iter().any(|volume| volume.damping != 0.0)
            }
            Part::Gravity => scene.world.gravity != DVec3::ZERO,
            Part::Drag => scene.world.drag != 0.0,
            Part::Contact => {
                let is_stopped = !scene.planes.is_empty() || !scene.solids.is_empty();
                is_stopped || any_meet(&scene.shells)
            }
            Part::FaceDiagonals | Part::SpaceDiagonals | Part::BendingSprings => {
                let mut found = springs.iter().flat_map(|rows| &scene.springs[rows.clone()]);
                found.any(|spring| spring.stiffness != 0.0 || spring.damping != 0.0)
            }
        };
        is_there.then_some(springs)
    }

    /// Switches it off in a scene, whose springs stay where they are.
    pub(crate) fn switch_off(self, scene: &mut Scene) {
        let Some(springs) = self.found_in(scene) else { return };
        if springs.is_empty() {
            *scene = self.without(scene).unwrap_or_default();
        }
        for spring in springs.into_iter().flatten() {
            (scene.springs[spring].stiffness, scene.springs[spring].damping) = (0.0, 0.0);
        }
    }

    fn springs(self, scene: &Scene) -> Vec<Range<usize>> {
        let rows = |is_of: &dyn Fn(usize) -> bool| {
            let mut found: Vec<Range<usize>> = Vec::new();
            for row in (0..scene.springs.len()).filter(|&row| is_of(row)) {
                match found.last_mut().filter(|last| last.end == row) {
                    Some(last) => last.end += 1,
                    None => found.push(row..row + 1),
                }
            }
            found
        };
        match self {
            Part::FaceDiagonals | Part::SpaceDiagonals => {
                let kind = if self == Part::FaceDiagonals { 2 } else { 3 };
                let kinds = diagonals(scene);
                rows(&|row| kinds[row] == kind)
            }
            Part::BendingSprings => {
                let bending = bending(scene);
                rows(&|row| bending.contains(&row))
            }
            Part::Damping | Part::Gravity | Part::Drag | Part::Contact => Vec::new(),
        }
    }

    /// The scene without it; `None` where it is not [found](Part::found_in).
    pub fn without(self, scene: &Scene) -> Option<Scene> {
        let springs = self.found_in(scene)?;
        let mut rest = scene.clone();
        match self {
            Part::Damping => {
                rest.springs.iter_mut().for_each(|spring| spring.damping = 0.0);
                rest.bends.iter_mut().for_each(|bend| bend.damping = 0.0);
                rest.volumes.iter_mut().for_each(|volume| volume.damping = 0.0);
            }
            Part::Gravity => rest.world.gravity = DVec3::ZERO,
            Part::Drag => rest.world.drag = 0.0,
            Part::Contact => {
                (rest.planes, rest.solids) = (Vec::new(), Vec::new());
                rest.shells.clear();
            }
            Part::FaceDiagonals | Part::SpaceDiagonals | Part::BendingSprings => {
                let rows: BTreeSet<usize> = springs.into_iter().flatten().collect();
                leave_out(&mut rest, &|spring| rows.contains(&spring));
            }
        }
        Some(rest)
    }
}

/// Leaves out some of the springs of a scene.
fn leave_out(scene: &mut Scene, is_out: &dyn Fn(usize) -> bool) {
    // The row that each spring will have, and the number of springs that will be left.
    let mut rows = vec![0];
    for spring in 0..scene.springs.len() {
        rows.push(rows[spring] + usize::from(!is_out(spring)));
    }
    let mut spring = 0..scene.springs.len();
    scene.springs.retain(|_| spring.next().is_none_or(|spring| !is_out(spring)));
    for body in &mut scene.bodies {
        body.springs = rows[body.springs.start]..rows[body.springs.end];
    }
}

/// Of each spring 2 for a face diagonal, 3 for a space diagonal, 1 for any other: the square of its
/// rest length over that of the shortest spring of its body, if that is 1, 2 or 3 for all of them.
fn diagonals(scene: &Scene) -> Vec<u8> {
    let mut kinds = vec![1; scene.springs.len()];
    for body in &scene.bodies {
        let springs = &scene.springs[body.springs.clone()];
        let spacing = springs.iter().map(|spring| spring.rest_length).fold(f64::MAX, f64::min);
        let kind = |spring: &Spring| {
            let length = spring.rest_length / spacing;
            (1..=3u8).find(|&kind| (length - f64::from(kind).sqrt()).abs() <= SLACK)
        };
        let found: Option<Vec<u8>> = springs.iter().map(kind).collect();
        if let Some(found) = found {
            kinds[body.springs.clone()].copy_from_slice(&found);
        }
    }
    kinds
}

/// The springs of shells that bridge the edge between two triangles.
fn bending(scene: &Scene) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let lattice = diagonals(scene);
    for body in &scene.bodies {
        // A regular sheet is a shell too, but both its diagonals lie in it.
        let regular = lattice[body.springs.clone()].iter().any(|&kind| kind != 1);
        if !body.surface.two_sided || regular {
            continue;
        }
        let (edges, bridges) = edges_and_bridges(body);
        for row in body.springs.clone() {
            let ends = sorted(scene.springs[row].ends);
            if bridges.contains(&ends) && !edges.contains(&ends) {
                found.insert(row);
            }
        }
    }
    found
}

/// Pairs of particles along the edges of triangles, and across them.
fn edges_and_bridges(body: &Body) -> (BTreeSet<[usize; 2]>, BTreeSet<[usize; 2]>) {
    let mut sides: Vec<([usize; 2], usize)> = Vec::new();
    for corners in body.surface.particles() {
        let [a, b, c] = corners.map(|particle| particle as usize);
        sides.extend([(sorted([a, b]), c), (sorted([b, c]), a), (sorted([c, a]), b)]);
    }
    sides.sort_unstable();
    let edges = sides.iter().map(|&(edge, _)| edge).collect();
    let mut bridges = BTreeSet::new();
    for group in sides.chunk_by(|a, b| a.0 == b.0) {
        for (row, &(_, a)) in group.iter().enumerate() {
            bridges.extend(group[row + 1..].iter().map(|&(_, b)| sorted([a, b])));
        }
    }
    (edges, bridges)
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}
