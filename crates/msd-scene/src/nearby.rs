//! Which points are nearest to each of many?

use glam::DVec3;

/// Points in cells of a cube, the points of a cell side by side.
struct Cells<'a> {
    points: &'a [DVec3],
    /// Cells along a side of the cube, each a metre long.
    side: i64,
    /// The first place of each cell in `rows`, and the number of points.
    starts: Vec<u32>,
    rows: Vec<u32>,
}

/// Finds the `count` nearest points of each, or all others if there are fewer, and returns the
/// pairs, each once and the lower row first, in their order.
///
/// The points are in the cube from 0 to `side` along each axis, metres, about one in each cubic
/// metre: few cells have to be looked at.
pub(crate) fn join_nearest(points: &[DVec3], side: f64, count: usize) -> Vec<[u32; 2]> {
    let cells = Cells::new(points, side);
    let mut pairs = Vec::with_capacity(points.len() * count);
    let mut found = Vec::new();
    for row in 0..points.len() as u32 {
        cells.find_nearest(row, count, &mut found);
        pairs.extend(found.iter().map(|&(_, other)| [row.min(other), row.max(other)]));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

impl<'a> Cells<'a> {
    fn new(points: &'a [DVec3], side: f64) -> Self {
        let side = (side.ceil() as i64).max(1);
        let mut cells = Cells { points, side, starts: Vec::new(), rows: Vec::new() };
        let places: Vec<usize> =
            points.iter().map(|&point| cells.place(cells.cell_of(point))).collect();
        cells.starts = vec![0; (side * side * side) as usize + 1];
        for &place in &places {
            cells.starts[place + 1] += 1;
        }
        for place in 1..cells.starts.len() {
            cells.starts[place] += cells.starts[place - 1];
        }
        let mut next = cells.starts.clone();
        cells.rows = vec![0; points.len()];
        for (row, &place) in places.iter().enumerate() {
            cells.rows[next[place] as usize] = row as u32;
            next[place] += 1;
        }
        cells
    }

    fn cell_of(&self, point: DVec3) -> [i64; 3] {
        point.to_array().map(|coordinate| (coordinate as i64).clamp(0, self.side - 1))
    }

    fn place(&self, [x, y, z]: [i64; 3]) -> usize {
        ((x * self.side + y) * self.side + z) as usize
    }

    /// Overwrites `found` with the nearest points of one, by the squares of their distances.
    ///
    /// Whoever is no farther away than `reach` cells is in one of those looked at.
    fn find_nearest(&self, row: u32, count: usize, found: &mut Vec<(f64, u32)>) {
        for reach in 2.. {
            self.look_around(row, reach, found);
            found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            found.truncate(count);
            let within = |&(square, _): &(f64, u32)| square <= (reach * reach) as f64;
            if self.side <= reach || (found.len() == count && found.last().is_none_or(within)) {
                return;
            }
        }
    }

    /// Overwrites `found` with all points in the cells around one.
    fn look_around(&self, row: u32, reach: i64, found: &mut Vec<(f64, u32)>) {
        found.clear();
        let point = self.points[row as usize];
        let [x, y, z] =
            self.cell_of(point).map(|at| (at - reach).max(0)..=(at + reach).min(self.side - 1));
        for (x, y) in x.flat_map(|x| y.clone().map(move |y| (x, y))) {
            let (first, last) = (self.place([x, y, *z.start()]), self.place([x, y, *z.end()]));
            let rows = self.starts[first] as usize..self.starts[last + 1] as usize;
            let others = self.rows[rows].iter().filter(|&&other| other != row);
            found.extend(
                others.map(|&other| (point.distance_squared(self.points[other as usize]), other)),
            );
        }
    }
}
