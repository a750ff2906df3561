//! Points in cells: those near a place, and the nearest of each of many; points in a tree: the
//! nearest to a place, however far.

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
    /// fewer, by the squares of their distances. Equal ones are in order of index.
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
            // Every point within the radius is in one of the cubes looked at.
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

/// Points in a tree, halved along its longest side again and again.
pub(crate) struct Nearest<'a> {
    points: &'a [DVec3],
    /// The rows of points: of a range the one in its middle divides the others.
    rows: Vec<usize>,
    /// The axis along which the row at an index divides others.
    axes: Vec<usize>,
}

/// The longest range that is searched point by point.
const LEAF: usize = 8;

impl<'a> Nearest<'a> {
    /// Sorts points.
    pub(crate) fn new(points: &'a [DVec3]) -> Self {
        let (mut rows, mut axes) = ((0..points.len()).collect::<Vec<_>>(), vec![0; points.len()]);
        divide(points, &mut rows, &mut axes);
        Self { points, rows, axes }
    }

    /// The point nearest to a place among those that may be taken, the first of several as near.
    pub(crate) fn find(&self, place: DVec3, may_take: impl Fn(usize) -> bool) -> Option<usize> {
        let mut best = (f64::INFINITY, usize::MAX);
        self.search((0, self.rows.len()), place, &may_take, &mut best);
        (best.1 != usize::MAX).then_some(best.1)
    }

    /// Looks for a nearer point in a range of rows; `best` is the square of a distance, and a row.
    fn search(
        &self,
        (start, end): (usize, usize),
        place: DVec3,
        may_take: &impl Fn(usize) -> bool,
        best: &mut (f64, usize),
    ) {
        let look = |row: usize, best: &mut (f64, usize)| {
            let found = (place.distance_squared(self.points[row]), row);
            if found < *best && may_take(row) {
                *best = found;
            }
        };
        if end - start <= LEAF {
            return self.rows[start..end].iter().for_each(|&row| look(row, best));
        }
        let middle = start.midpoint(end);
        look(self.rows[middle], best);
        let axis = self.axes[middle];
        let off = place[axis] - self.points[self.rows[middle]][axis];
        let [below, above] = [(start, middle), (middle + 1, end)];
        let [near, far] = if off < 0.0 { [below, above] } else { [above, below] };
        self.search(near, place, may_take, best);
        // One as near may stand earlier.
        if off * off <= best.0 {
            self.search(far, place, may_take, best);
        }
    }
}

/// Sorts rows of points so that the one in the middle divides the others along the longest side.
fn divide(points: &[DVec3], rows: &mut [usize], axes: &mut [usize]) {
    if rows.len() <= LEAF {
        return;
    }
    let places = rows.iter().map(|&row| points[row]);
    let first = points[rows[0]];
    let (low, high) = places.fold((first, first), |(low, high), x| (low.min(x), high.max(x)));
    let axis = (high - low).max_position();
    let middle = rows.len() / 2;
    // By row where coordinates are equal, so that the tree is one on every machine.
    let order = |a: &usize, b: &usize| points[*a][axis].total_cmp(&points[*b][axis]).then(a.cmp(b));
    rows.select_nth_unstable_by(middle, order);
    axes[middle] = axis;
    let ([below, rest], [axes_below, axes_rest]) = (split(rows, middle), split(axes, middle));
    divide(points, below, axes_below);
    divide(points, &mut rest[1..], &mut axes_rest[1..]);
}

fn split(values: &mut [usize], middle: usize) -> [&mut [usize]; 2] {
    values.split_at_mut(middle).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_in_a_tree_is_the_nearest_of_all_and_the_first_of_equals() {
        let mut state = 1u64;
        let mut number = |most: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 33) % most) as f64
        };
        // On a coarse grid, so that many are equally far.
        let points: Vec<DVec3> =
            (0..500).map(|_| DVec3::new(number(9), number(7), number(3))).collect();
        let tree = Nearest::new(&points);
        for _ in 0..500 {
            let place = DVec3::new(number(20) - 4.0, number(9), number(3)) * 0.5;
            let even = |row: usize| row.is_multiple_of(2);
            let all = (0..points.len()).filter(|&row| even(row));
            let nearest = all.min_by(|&a, &b| {
                let of = |row: usize| place.distance_squared(points[row]);
                of(a).total_cmp(&of(b))
            });
            assert_eq!(tree.find(place, even), nearest);
        }
        assert_eq!(Nearest::new(&[]).find(DVec3::ZERO, |_| true), None);
        assert_eq!(Nearest::new(&points).find(DVec3::ZERO, |_| false), None);
    }
}
