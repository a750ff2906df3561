//! Which points lie near a place?

use glam::DVec3;
use std::collections::BTreeMap;

/// Points sorted into cubes.
pub(crate) struct Nearby<'a> {
    points: &'a [DVec3],
    cell: f64,
    cells: BTreeMap<[i64; 3], Vec<u32>>,
}

impl<'a> Nearby<'a> {
    /// Sorts points into cubes of edge `cell`, which should be about the radius to be asked for.
    pub(crate) fn new(points: &'a [DVec3], cell: f64) -> Self {
        let mut cells: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
        for (i, &point) in points.iter().enumerate() {
            cells.entry(key(point, cell)).or_default().push(i as u32);
        }
        Self { points, cell, cells }
    }

    /// The points within `radius` of a place, nearest first, equal distances in order of index.
    pub(crate) fn within(&self, place: DVec3, radius: f64) -> Vec<usize> {
        let [x0, y0, z0] = key(place - radius, self.cell);
        let [x1, y1, z1] = key(place + radius, self.cell);
        let mut found = Vec::new();
        for (x, y) in (x0..=x1).flat_map(|x| (y0..=y1).map(move |y| (x, y))) {
            for points in self.cells.range([x, y, z0]..=[x, y, z1]).map(|(_, points)| points) {
                let near = points.iter().map(|&i| i as usize);
                let near = near.map(|i| (self.points[i].distance(place), i));
                found.extend(near.filter(|&(distance, _)| distance <= radius));
            }
        }
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(_, i)| i).collect()
    }
}

fn key(point: DVec3, cell: f64) -> [i64; 3] {
    (point / cell).floor().to_array().map(|step| step as i64)
}
