//! Edges that go through triangles.

use msd_core::glam::DVec3;
use msd_core::{Real, Simulation, Vector};
use std::collections::BTreeSet;

/// The number of edges of shells that go through a triangle without a common corner.
pub fn crossings<R: Real>(simulation: &Simulation<R>) -> usize {
    let shells = simulation.model().shells();
    let triangles: Vec<[usize; 3]> =
        shells.iter().flat_map(|shell| shell.triangles.iter().copied()).collect();
    let mut edges = BTreeSet::new();
    for &[a, b, c] in &triangles {
        edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
    }
    edges.extend(shells.iter().flat_map(|shell| shell.edges.iter().copied()));
    let place = |particle: usize| simulation.position(particle).to_f64();
    let mut count = 0;
    for corners in &triangles {
        let [a, b, c] = corners.map(place);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        for ends in edges.iter().filter(|ends| !ends.iter().any(|end| corners.contains(end))) {
            let [p, q] = ends.map(place);
            let is_near = low.cmple(p.max(q)).all() && p.min(q).cmple(high).all();
            count += usize::from(is_near && crosses([p, q], [a, b, c]));
        }
    }
    count
}

fn crosses([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    let sides = [p, q].map(|end| volume(a, b, c, end));
    let around = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    sides[0] * sides[1] < 0.0
        && (around.iter().all(|side| 0.0 < *side) || around.iter().all(|side| *side < 0.0))
}
