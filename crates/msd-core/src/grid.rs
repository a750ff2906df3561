//! A grid of points, in which those near each other are found.
//!
//! Cells as wide as what counts as near, in a table by their hash (Teschner and others, 2003), each
//! with its points in a row (a counting sort).

use crate::columns::LANES;
use crate::number::at_level;
use alloc::vec::Vec;
use core::ops::Range;
use fearless_simd::Level;
use glam::DVec3;

/// Where a cell is, in cells from the origin.
type Place = [i64; 3];

/// Points in cells. Its columns are allocated once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    /// The width of a cell, metres.
    width: f64,
    /// The cell of each point.
    cells: Vec<Place>,
    /// The points, cell by cell.
    points: Vec<u32>,
    /// The cells that have points, by their place in the table.
    rows: Vec<Occupied>,
    /// Where the points, and then the rows, of each place of the table start, and where the last
    /// ones end.
    starts: Vec<u32>,
    /// The points, metres, as they were given and cell by cell.
    given: Vec<DVec3>,
    sorted: Vec<DVec3>,
    /// The points of a cell and after them those around it.
    near: Nearby,
}

/// Points that are compared with each other, [`LANES`] at a time.
#[derive(Clone, Debug, Default)]
struct Nearby {
    points: Vec<u32>,
    /// Their coordinates, metres, up to a whole number of lanes: what is beyond the points is
    /// nowhere.
    coordinates: [Vec<f64>; 3],
}

impl Nearby {
    fn clear(&mut self) {
        self.points.clear();
        self.coordinates.iter_mut().for_each(Vec::clear);
    }

    fn add(&mut self, points: &[u32], places: &[DVec3]) {
        self.points.extend_from_slice(points);
        for (axis, column) in self.coordinates.iter_mut().enumerate() {
            column.extend(places.iter().map(|place| place[axis]));
        }
    }

    fn fill_up(&mut self) {
        let lanes = self.points.len().next_multiple_of(LANES);
        self.coordinates.iter_mut().for_each(|column| column.resize(lanes, f64::INFINITY));
    }

    /// Which of some lanes are within a distance of a point, by its square; a bit for each.
    #[inline(always)]
    fn within(&self, first: usize, point: usize, square: f64) -> u32 {
        let columns = self.coordinates.each_ref();
        let here = columns.map(|column| column[point]);
        let lanes: [&[f64; LANES]; 3] =
            columns.map(|column| column[first..].first_chunk().expect("whole lanes"));
        let mut bits = [0; LANES];
        for (lane, bit) in bits.iter_mut().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|axis| lanes[axis][lane] - here[axis]);
            *bit = u32::from(x * x + y * y + z * z <= square) << lane;
        }
        bits.iter().fold(0, |all, bit| all | bit)
    }
}

/// A cell and its points.
#[derive(Clone, Debug)]
struct Occupied {
    cell: Place,
    points: Range<u32>,
}

impl Grid {
    /// Puts points into cells of this width, metres. A point that is no number is somewhere.
    pub(crate) fn fill(&mut self, width: f64, points: impl Iterator<Item = DVec3>) {
        self.width = width;
        self.given.clear();
        self.given.extend(points);
        self.cells.clear();
        self.cells.extend(self.given.iter().map(|&point| cell(width, point)));
        let places = (2 * self.cells.len()).next_power_of_two();
        self.sort(places);
        self.group(places);
    }

    /// Sorts the points by the places of their cells.
    fn sort(&mut self, places: usize) {
        let Grid { cells, points, starts, .. } = self;
        starts.clear();
        starts.resize(places + 1, 0);
        for &cell in &*cells {
            starts[place(cell, places) + 1] += 1;
        }
        for at in 0..places {
            starts[at + 1] += starts[at];
        }
        points.clear();
        points.resize(cells.len(), 0);
        // Backwards, so that the points of a place stay in order; each end becomes a start.
        for (point, &cell) in cells.iter().enumerate().rev() {
            let end = &mut starts[place(cell, places) + 1];
            *end -= 1;
            points[*end as usize] = point as u32;
        }
        starts.rotate_left(1);
        starts[places] = cells.len() as u32;
    }

    /// Groups the points of each place by their cells.
    fn group(&mut self, places: usize) {
        let Grid { cells, points, rows, starts, .. } = self;
        rows.clear();
        let mut first = 0;
        for at in 0..places {
            let here = first as usize..starts[at + 1] as usize;
            first = starts[at + 1];
            starts[at] = rows.len() as u32;
            let mut start = here.start as u32;
            let group = &mut points[here];
            // Two cells seldom have one place; stable, as the points of a cell stay in order.
            group.sort_by_key(|&point| cells[point as usize]);
            for points in group.chunk_by(|&a, &b| cells[a as usize] == cells[b as usize]) {
                let end = start + points.len() as u32;
                rows.push(Occupied { cell: cells[points[0] as usize], points: start..end });
                start = end;
            }
        }
        starts[places] = rows.len() as u32;
    }

    /// The row of a cell, if it has points.
    fn row_of(&self, cell: Place) -> Option<usize> {
        let at = place(cell, self.starts.len() - 1);
        let rows = self.starts[at] as usize..self.starts[at + 1] as usize;
        rows.into_iter().find(|&row| self.rows[row].cell == cell)
    }

    /// Cells with points that touch this one, half of them: of two that touch each other one finds
    /// the other.
    pub(crate) fn beside(&self, row: usize) -> impl Iterator<Item = usize> {
        let [x, y, z] = self.rows[row].cell;
        let cells = (14..27).map(move |at: i64| {
            let by = |at: i64, way: i64| at.wrapping_add(way - 1);
            [by(x, at / 9), by(y, at / 3 % 3), by(z, at % 3)]
        });
        cells.filter_map(|cell| self.row_of(cell))
    }

    /// The number of cells with points.
    pub(crate) fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// The points of a cell.
    pub(crate) fn points_of(&self, row: usize) -> &[u32] {
        let points = &self.rows[row].points;
        &self.points[points.start as usize..points.end as usize]
    }

    /// Sees every pair of points within a distance of each other, metres, at most the width of a
    /// cell, once, the lower first, until there is an error. Some that are farther apart by
    /// rounding are seen too.
    pub(crate) fn each_pair<E>(
        &mut self,
        level: Level,
        distance: f64,
        mut see: impl FnMut(usize, usize) -> Result<(), E>,
    ) -> Result<(), E> {
        self.sorted.clear();
        self.sorted.extend(self.points.iter().map(|&point| self.given[point as usize]));
        let square = distance * distance * (1.0 + ROUNDING);
        let mut near = core::mem::take(&mut self.near);
        for row in 0..self.rows.len() {
            near.clear();
            self.add_row(row, &mut near);
            let own = near.points.len();
            for other in self.beside(row) {
                self.add_row(other, &mut near);
            }
            near.fill_up();
            at_level!(level, _simd => each_pair_of(own, &near, square, &mut see))?;
        }
        self.near = near;
        Ok(())
    }

    /// Sees every point in the cells that a box touches, given by its lowest and its highest
    /// corner, metres, until there is an error.
    pub(crate) fn each_in<E>(
        &self,
        corners: [DVec3; 2],
        mut see: impl FnMut(usize) -> Result<(), E>,
    ) -> Result<(), E> {
        let [low, high] = corners.map(|corner| cell(self.width, corner));
        let is_in = |cell: Place| (0..3).all(|axis| (low[axis]..=high[axis]).contains(&cell[axis]));
        let sides = [0, 1, 2].map(|axis| high[axis].saturating_sub(low[axis]) as f64 + 1.0);
        let mut see_row = |row: usize| -> Result<(), E> {
            self.points_of(row).iter().try_for_each(|&point| see(point as usize))
        };
        // A large box has more cells than there are with points.
        if self.rows.len() as f64 <= sides[0] * sides[1] * sides[2] {
            let mut rows = (0..self.rows.len()).filter(|&row| is_in(self.rows[row].cell));
            return rows.try_for_each(see_row);
        }
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    self.row_of([x, y, z]).map_or(Ok(()), &mut see_row)?;
                }
            }
        }
        Ok(())
    }

    /// Adds the points of a row.
    fn add_row(&self, row: usize, near: &mut Nearby) {
        let range = &self.rows[row].points;
        let places = &self.sorted[range.start as usize..range.end as usize];
        near.add(self.points_of(row), places);
    }
}

/// Sees the pairs of each of the first points and one after it.
#[inline(always)]
fn each_pair_of<E>(
    own: usize,
    near: &Nearby,
    square: f64,
    see: &mut impl FnMut(usize, usize) -> Result<(), E>,
) -> Result<(), E> {
    for at in 0..own {
        let a = near.points[at];
        let start = (at + 1) / LANES * LANES;
        for first in (start..near.points.len()).step_by(LANES) {
            let mut bits = near.within(first, at, square);
            if first <= at {
                bits &= u32::MAX << (at + 1 - first);
            }
            while bits != 0 {
                let b = near.points[first + bits.trailing_zeros() as usize];
                see(a.min(b) as usize, a.max(b) as usize)?;
                bits &= bits - 1;
            }
        }
    }
    Ok(())
}

/// More than the part by which rounding changes a distance.
const ROUNDING: f64 = 1e-5;

/// The cell of this width that a point is in.
fn cell(width: f64, point: DVec3) -> Place {
    point.to_array().map(|x| floor(x / width))
}

/// The largest whole number that is no more; saturates for numbers that no world holds.
fn floor(x: f64) -> i64 {
    let whole = x as i64;
    whole.saturating_sub(i64::from(x < whole as f64))
}

/// The place of a cell in a table.
fn place([x, y, z]: Place, places: usize) -> usize {
    let mixed =
        x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    let spread = (mixed as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (spread >> 32) as usize & (places - 1)
}
