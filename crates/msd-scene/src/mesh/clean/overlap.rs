//! Closed parts of a mesh that overlap: the shared space counts twice in its volume.

use crate::crossing::{Triangle, each_crossing};
use crate::mesh::clean::inside::Inside;
use crate::mesh::clean::topology::volume6;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// The most triangles among which crossings are looked for: where one is as large as all others
/// together, each meets each.
const MOST: usize = 20_000;
/// The most parts of which each is compared with each.
const MOST_PARTS: usize = 100;

/// The number of closed parts that overlap another one, by the part of each vertex. They go through
/// it, or are inside it and turned the same way. A part that is turned the other way is a void.
pub(crate) fn overlapping(positions: &[DVec3], triangles: &[[u32; 3]], parts: &[u32]) -> usize {
    if MOST < triangles.len() || parts.iter().all(|&part| part == 0) {
        return 0;
    }
    let closed = closed_parts(triangles, parts);
    let mut found = BTreeSet::new();
    let corners = closed.values().flatten().map(|corners| corners.map(|corner| corner as usize));
    each_crossing(corners.map(|corners| Triangle::new(corners, positions)).collect(), |pair| {
        let [first, second] = pair.map(|corners| parts[corners[0]]);
        if first != second {
            found.extend([first, second]);
        }
    });
    if closed.len() <= MOST_PARTS {
        let turned = |faces: &[[u32; 3]]| {
            let from = positions[faces[0][0] as usize];
            let volume = |&face: &[u32; 3]| volume6(positions, face, from);
            0.0 < faces.iter().map(volume).sum::<f64>()
        };
        for (&part, faces) in &closed {
            let inside = Inside::new(positions, faces);
            let within = closed.iter().filter(|&(&other, others)| {
                other != part
                    && inside.contains(positions[others[0][0] as usize])
                    && turned(faces) == turned(others)
            });
            found.extend(within.flat_map(|(&other, _)| [part, other]));
        }
    }
    found.len()
}

/// The triangles of each part that is closed.
fn closed_parts(triangles: &[[u32; 3]], parts: &[u32]) -> BTreeMap<u32, Vec<[u32; 3]>> {
    let mut faces = BTreeMap::new();
    let mut closed: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for &[a, b, c] in triangles {
        closed.entry(parts[a as usize]).or_default().push([a, b, c]);
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *faces.entry((a.min(b), a.max(b))).or_insert(0) += 1;
        }
    }
    for (&(a, _), _) in faces.iter().filter(|&(_, &faces)| faces != 2) {
        closed.remove(&parts[a as usize]);
    }
    closed
}
