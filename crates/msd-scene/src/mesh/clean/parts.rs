//! Closed parts of a file that touch each other: they stay bodies of their own.
//!
//! Welded to its neighbours, a part loses the face that it shares with them, and a stack of boxes
//! becomes one hollow shell.

use crate::mesh::clean::topology::volume6;
use crate::mesh::polygon::is_face;
use crate::mesh::raw::Raw;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The fewest faces of a closed part.
const FEWEST: usize = 4;

/// The owner of faces and vertices that no closed part owns.
const OPEN: u32 = 0;

/// The smallest volume of a part, as a share of the cube of its reach: a sheet closes too where
/// each of its faces is there twice.
const LEAST_VOLUME: f64 = 1e-9;

/// Gives vertices of their own to closed parts that share some with another closed part. Returns
/// the number of vertices that this made, and the number of parts that touch another.
///
/// A part is a run of faces, in the order of the file, every edge of which has two of them. Files
/// write one object after the other; where an object is not closed, its faces stay with the rest.
pub(crate) fn separate(raw: &mut Raw) -> (usize, usize) {
    let parts = closed_parts(raw);
    let mut owners = vec![None; raw.positions.len()];
    let rest = (0..raw.triangles.len()).filter(|&face| parts[face].is_none());
    for vertex in rest.flat_map(|face| raw.triangles[face]) {
        owners[vertex as usize] = Some(OPEN);
    }
    // The number of a vertex for a part that is not the first at its place.
    let mut copies = BTreeMap::new();
    let mut touching = BTreeSet::new();
    for (triangle, part) in raw.triangles.iter_mut().zip(&parts) {
        let Some(part) = *part else { continue };
        for vertex in triangle {
            let owner = *owners[*vertex as usize].get_or_insert(part);
            // An open part, such as a ribbon on a box, stays welded to the part that it is on.
            if owner != part && owner != OPEN {
                touching.extend([owner, part]);
                *vertex = *copies.entry((*vertex, part)).or_insert_with(|| {
                    raw.positions.push(raw.positions[*vertex as usize]);
                    raw.positions.len() as u32 - 1
                });
            }
        }
    }
    (copies.len(), touching.len())
}

/// The closed part of each face, from 1; faces without an area are passed over.
fn closed_parts(raw: &Raw) -> Vec<Option<u32>> {
    let mut parts = vec![None; raw.triangles.len()];
    let mut found = 0;
    let ends = raw.starts.iter().copied().skip(1).chain([raw.triangles.len()]);
    let objects: Vec<Range<usize>> =
        raw.starts.iter().copied().zip(ends).map(|(a, b)| a..b).collect();
    // Within the objects of the file, and then among the remaining faces: one part may be in
    // several groups.
    for faces in objects.into_iter().chain(std::iter::once(0..raw.triangles.len())) {
        let mut run = Vec::new();
        let mut open = BTreeSet::new();
        for face in faces {
            if parts[face].is_some() || !is_face(raw.triangles[face], &raw.positions) {
                continue;
            }
            let [a, b, c] = raw.triangles[face];
            for (a, b) in [(a, b), (b, c), (c, a)] {
                let edge = (a.min(b), a.max(b));
                if !open.remove(&edge) {
                    open.insert(edge);
                }
            }
            run.push(face);
            if open.is_empty() && FEWEST <= run.len() {
                if has_volume(raw, &run) {
                    found += 1;
                    run.iter().for_each(|&face| parts[face] = Some(found));
                }
                run.clear();
            }
        }
    }
    one_for_each(raw, &mut parts, found);
    parts
}

/// Takes closed parts with the same faces for one: the faces are then there twice.
fn one_for_each(raw: &Raw, parts: &mut [Option<u32>], found: u32) {
    let mut faces = vec![Vec::new(); found as usize + 1];
    for (triangle, part) in raw.triangles.iter().zip(&*parts) {
        let mut corners = *triangle;
        corners.sort_unstable();
        faces[part.unwrap_or(OPEN) as usize].push(corners);
    }
    let mut firsts = BTreeMap::new();
    let mut same: Vec<u32> = (0..=found).collect();
    for (part, mut faces) in (1..=found).zip(faces.into_iter().skip(1)) {
        faces.sort_unstable();
        same[part as usize] = *firsts.entry(faces).or_insert(part);
    }
    for part in parts.iter_mut().flatten() {
        *part = same[*part as usize];
    }
}

/// Whether the faces of a closed part enclose something, and not only each other.
fn has_volume(raw: &Raw, faces: &[usize]) -> bool {
    let from = raw.positions[raw.triangles[faces[0]][0] as usize];
    let corners = || faces.iter().flat_map(|&face| raw.triangles[face]);
    let away = |corner: u32| raw.positions[corner as usize].distance(from);
    let reach = corners().map(away).fold(0.0, f64::max);
    let volume = |&face: &usize| volume6(&raw.positions, raw.triangles[face], from);
    LEAST_VOLUME * reach * reach * reach < faces.iter().map(volume).sum::<f64>().abs()
}
