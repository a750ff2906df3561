//! Clean triangles from raw ones: one vertex per place, one face per triangle of places.

use crate::mesh::clean::parts::separate;
use crate::mesh::clean::topology::orient;
use crate::mesh::error::MeshError;
use crate::mesh::polygon::is_face;
use crate::mesh::raw::{CornerUvs, Group, Raw};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Vertices closer than this fraction of the diagonal of the bounding box become one.
pub(crate) const WELD_FRACTION: f64 = 1e-6;

/// Clean triangles and counts of the cleaning.
#[derive(Debug, Default)]
pub(crate) struct Clean {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) uvs: Option<Vec<CornerUvs>>,
    pub(crate) groups: Vec<Group>,
    pub(crate) welded: usize,
    pub(crate) unused: usize,
    pub(crate) degenerate: usize,
    pub(crate) duplicate: usize,
    pub(crate) turned: usize,
    pub(crate) touching: usize,
}

/// Welds vertices, drops faces without area and faces that are there twice, numbers the vertices
/// in order of their first use, and turns the faces outward. Closed parts that touch are not welded
/// to each other. Corners of `raw` become those of welded vertices.
///
/// # Errors
/// A coordinate outside its domain, or no face left.
pub(crate) fn clean(raw: &mut Raw, file: &str) -> Result<Clean, MeshError> {
    raw.check(file)?;
    let places = places(&raw.positions);
    let distinct = places.iter().enumerate().filter(|&(i, &place)| i == place as usize).count();
    let has_uvs = raw.uvs.len() == raw.triangles.len();
    let welded = raw.positions.len() - distinct;
    for triangle in &mut raw.triangles {
        *triangle = triangle.map(|corner| places[corner as usize]);
    }
    let (apart, touching) = separate(raw);
    // A vertex that several parts use is there once for each.
    let welded = welded.saturating_sub(apart);
    let mut clean = Clean { welded, touching, ..Clean::default() };
    let (mut uvs, mut kept) = (Vec::new(), Vec::new());
    let mut seen = BTreeSet::new();
    let mut numbers = vec![u32::MAX; raw.positions.len()];
    for (face, &corners) in raw.triangles.iter().enumerate() {
        if !is_face(corners, &raw.positions) {
            clean.degenerate += 1;
            continue;
        }
        let mut sorted = corners;
        sorted.sort_unstable();
        if !seen.insert(sorted) {
            clean.duplicate += 1;
            continue;
        }
        if !raw.groups.is_empty() {
            kept.push(face);
        }
        clean.triangles.push(corners.map(|corner| {
            let number = &mut numbers[corner as usize];
            if *number == u32::MAX {
                *number = clean.positions.len() as u32;
                clean.positions.push(raw.positions[corner as usize]);
            }
            *number
        }));
        if has_uvs {
            uvs.push(raw.uvs[face]);
        }
    }
    clean.groups = groups(std::mem::take(&mut raw.groups), &kept);
    if clean.triangles.is_empty() {
        return Err(MeshError::Empty { file: file.into(), faces: raw.triangles.len() });
    }
    clean.unused = (raw.vertices_read - clean.welded).saturating_sub(clean.positions.len());
    let turned = orient(&clean.positions, &mut clean.triangles);
    for (uvs, _) in uvs.iter_mut().zip(&turned).filter(|(_, turned)| **turned) {
        uvs.swap(1, 2);
    }
    clean.turned = turned.iter().filter(|turned| **turned).count();
    clean.uvs = has_uvs.then(|| into_square(uvs)).flatten();
    Ok(clean)
}

/// Groups of the faces that are kept, which are in ascending order.
fn groups(groups: Vec<Group>, kept: &[usize]) -> Vec<Group> {
    let number = |face: usize| kept.partition_point(|&kept| kept < face);
    let left = groups.into_iter().map(|Group { name, triangles }| {
        let triangles = number(triangles.start)..number(triangles.end);
        Group { name, triangles }
    });
    left.filter(|group| !group.triangles.is_empty()).collect()
}

/// For each vertex the first vertex at the same place.
fn places(positions: &[DVec3]) -> Vec<u32> {
    let low = positions.iter().copied().fold(DVec3::MAX, DVec3::min);
    let high = positions.iter().copied().fold(DVec3::MIN, DVec3::max);
    let tolerance = WELD_FRACTION * (high - low).length();
    // Four tolerances wide: most vertices then have a single cell within reach.
    let cell = 4.0 * tolerance;
    let cell_of = |position: DVec3| {
        let steps = if 0.0 < cell { ((position - low) / cell).floor() } else { DVec3::ZERO };
        steps.to_array().map(|step| step as i64)
    };
    let mut firsts: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    let mut places = Vec::with_capacity(positions.len());
    for (vertex, &position) in positions.iter().enumerate() {
        let [x0, y0, z0] = cell_of(position - tolerance);
        let [x1, y1, z1] = cell_of(position + tolerance);
        let near = (x0..=x1)
            .flat_map(|x| (y0..=y1).flat_map(move |y| (z0..=z1).map(move |z| [x, y, z])))
            .filter_map(|key| firsts.get(&key))
            .flatten()
            .copied()
            .filter(|&first| positions[first as usize].distance(position) <= tolerance)
            .min();
        if near.is_none() {
            firsts.entry(cell_of(position)).or_default().push(vertex as u32);
        }
        places.push(near.unwrap_or(vertex as u32));
    }
    places
}

/// Fits texture coordinates into the unit square if any lies outside; `None` if one is NaN.
fn into_square(mut uvs: Vec<CornerUvs>) -> Option<Vec<CornerUvs>> {
    for axis in 0..2 {
        let values = || uvs.iter().flatten().map(|uv| uv[axis]);
        if !values().all(|value| value.abs() <= 1e6) {
            return None;
        }
        let (low, high) = (values().fold(0.0, f32::min), values().fold(1.0, f32::max));
        for uv in uvs.iter_mut().flatten() {
            uv[axis] = (uv[axis] - low) / (high - low);
        }
    }
    Some(uvs)
}
