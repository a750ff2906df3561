//! Points in cells: those near a place, and the nearest of each of many.

use glam::DVec3;

/// Points sorted into cubes.
pub(crate) struct Nearby<'a> {
    points: &'a [DVec3],
    /// The edge of a cube.
    cell: f64,
    /// The cube and the row of each point, sorted.
    rows: Vec<([i64; 3], u32)>,
}

impl<'a> Nearby<'a> {
    /// Sorts points into cubes of edge `cell`, which should be about the radius to be asked for.
    pub(crate) fn new(points: &'a [DVec3], cell: f64) -> Self {
        let row = |(row, &point): (usize, &DVec3)| (key(point, cell), row as u32);
        let mut rows: Vec<_> = points.iter().enumerate().map(row).collect();
        rows.sort_unstable();
        Self { points, cell, rows }
    }

    /// The points within `radius` of a place, nearest first, equal distances in order of index.
    pub(crate) fn within(&self, place: DVec3, radius: f64) -> Vec<usize> {
        let near = self.around(place, radius).map(|row| (self.points[row].distance(place), row));
        let mut found: Vec<_> = near.filter(|&(distance, _)| distance <= radius).collect();
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(_, row)| row).collect()
    }

    /// All points in the cubes that reach within `radius` of a place, and so those that near.
    fn around(&self, place: DVec3, radius: f64) -> impl Iterator<Item = usize> {
        let [x0, y0, z0] = key(place - radius, self.cell);
        let [x1, y1, z1] = key(place + radius, self.cell);
        let columns = (x0..=x1).flat_map(move |x| (y0..=y1).map(move |y| (x, y)));
        columns.flat_map(move |(x, y)| {
            let first = self.rows.partition_point(|row| row.0 < [x, y, z0]);
            let rest = &self.rows[first..];
            let count = rest.iter().take_while(|row| row.0 <= [x, y, z1]).count();
            rest[..count].iter().map(|&(_, row)| row as usize)
        })
    }

    /// Overwrites `found` with the `count` points nearest to one of them, all others if there are
    /// fewer, by the squares of their distances; equal ones in order of index.
    fn find_nearest(&self, row: usize, count: usize, found: &mut Vec<(f64, usize)>) {
        let (point, all) = (self.points[row], self.points.len() - 1);
        for reach in 2.. {
            let radius = f64::from(reach) * self.cell;
            let others = self.around(point, radius).filter(|&other| other != row);
            found.clear();
            found.extend(others.map(|other| (point.distance_squared(self.points[other]), other)));
            let is_all = found.len() == all;
            found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            found.truncate(count);
            // Whoever is no farther away than the radius is in one of the cubes looked at.
            let within = |&(square, _): &(f64, usize)| square <= radius * radius;
            if is_all || (found.len() == count && found.last().is_none_or(within)) {
                return;
            }
        }
    }
}

/// Finds the `count` nearest points of each, or all others if there are fewer, and returns the
/// pairs, each once and the lower row first, in their order.
///
/// About one point in each cube of edge 1 is expected: few cubes have to be looked at.
pub(crate) fn join_nearest(points: &[DVec3], count: usize) -> Vec<[u32; 2]> {
    let nearby = Nearby::new(points, 1.0);
    let mut pairs = Vec::with_capacity(points.len() * count);
    let mut found = Vec::new();
    for row in 0..points.len() {
        nearby.find_nearest(row, count, &mut found);
        let pair = |&(_, other): &(f64, usize)| [row.min(other) as u32, row.max(other) as u32];
        pairs.extend(found.iter().map(pair));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

fn key(point: DVec3, cell: f64) -> [i64; 3] {
    (point / cell).floor().to_array().map(|step| step as i64)
}
