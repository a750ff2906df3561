//! A grid of points, in which those near each other are found.
//!
//! Cells as wide as what counts as near, in a table by their hash (Teschner and others, 2003), each
//! with its points in a row (a counting sort).

use alloc::vec::Vec;
use glam::DVec3;

/// Points in cells. Its columns are allocated once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    /// The cell of each point.
    cells: Vec<[i64; 3]>,
    /// Where the points of each place of the table start, and where the last ones end.
    starts: Vec<u32>,
    /// The points, place by place.
    points: Vec<u32>,
}

impl Grid {
    /// Puts points into cells of this width, metres. A point that is no number is somewhere.
    pub(crate) fn fill(&mut self, width: f64, points: impl Iterator<Item = DVec3>) {
        // Saturates for numbers that no world holds.
        let cell = |x: f64| libm::floor(x / width) as i64;
        self.cells.clear();
        self.cells.extend(points.map(|point| point.to_array().map(cell)));
        let places = (2 * self.cells.len()).next_power_of_two();
        self.starts.clear();
        self.starts.resize(places + 1, 0);
        for &cell in &self.cells {
            self.starts[place(cell, places) + 1] += 1;
        }
        for at in 0..places {
            self.starts[at + 1] += self.starts[at];
        }
        self.points.clear();
        self.points.resize(self.cells.len(), 0);
        // Backwards, so that the points of a place stay in order; each start moves to its own.
        for (point, &cell) in self.cells.iter().enumerate().rev() {
            let end = &mut self.starts[place(cell, places) + 1];
            *end -= 1;
            self.points[*end as usize] = point as u32;
        }
        self.starts.rotate_left(1);
        self.starts[places] = self.cells.len() as u32;
    }

    /// Lists the points of a higher number than this one in its cell and those around it, in order;
    /// `is_near` sees each before it is listed.
    pub(crate) fn list_near(
        &self,
        point: usize,
        found: &mut Vec<u32>,
        mut is_near: impl FnMut(usize) -> bool,
    ) {
        found.clear();
        let places = self.starts.len() - 1;
        let [x, y, z] = self.cells[point];
        let around = |at: i64| [at.wrapping_sub(1), at, at.wrapping_add(1)];
        for cell in around(x).into_iter().flat_map(|x| {
            around(y).into_iter().flat_map(move |y| around(z).map(move |z| [x, y, z]))
        }) {
            let at = place(cell, places);
            let here = &self.points[self.starts[at] as usize..self.starts[at + 1] as usize];
            found.extend(
                here.iter().filter(|&&other| point < other as usize && is_near(other as usize)),
            );
        }
        found.sort_unstable();
        // Two cells may have one place.
        found.dedup();
    }
}

/// The place of a cell in a table.
fn place([x, y, z]: [i64; 3], places: usize) -> usize {
    let mixed =
        x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    let spread = (mixed as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (spread >> 32) as usize & (places - 1)
}
