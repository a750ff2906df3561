//! A grid of points, in which those near each other are found.
//!
//! Cells as wide as what counts as near, in a table by their hash (Teschner and others, 2003), each
//! with its points in a row (a counting sort).

use alloc::vec::Vec;
use core::ops::Range;
use glam::DVec3;

/// Where a cell is, in cells from the origin.
type Place = [i64; 3];

/// Points in cells. Its columns are allocated once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    /// The cell of each point.
    cells: Vec<Place>,
    /// The points, cell by cell.
    points: Vec<u32>,
    /// The cells that have points, by their place in the table.
    rows: Vec<Occupied>,
    /// Where the points, and then the rows, of each place of the table start, and where the last
    /// ones end.
    starts: Vec<u32>,
    /// Points near those of a row.
    near: Vec<u32>,
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
        // Saturates for numbers that no world holds.
        let cell = |x: f64| libm::floor(x / width) as i64;
        self.cells.clear();
        self.cells.extend(points.map(|point| point.to_array().map(cell)));
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

    /// Cells with points that are this one or around it, in the order of their rows.
    pub(crate) fn around(&self, row: usize) -> impl Iterator<Item = usize> {
        let [x, y, z] = self.rows[row].cell;
        let cells = (0..27).map(move |at: i64| {
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

    /// Sees every pair of points in one cell or in two that touch, once, the lower first, until
    /// there is an error.
    pub(crate) fn each_pair<E>(
        &mut self,
        mut see: impl FnMut(usize, usize) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut near = core::mem::take(&mut self.near);
        for row in 0..self.rows.len() {
            near.clear();
            for other in self.around(row).filter(|&other| row < other) {
                near.extend_from_slice(self.points_of(other));
            }
            let own = self.points_of(row);
            for (at, &a) in own.iter().enumerate() {
                for &b in own[at + 1..].iter().chain(&near) {
                    see(a.min(b) as usize, a.max(b) as usize)?;
                }
            }
        }
        self.near = near;
        Ok(())
    }
}

/// The place of a cell in a table.
fn place([x, y, z]: Place, places: usize) -> usize {
    let mixed =
        x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    let spread = (mixed as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (spread >> 32) as usize & (places - 1)
}
