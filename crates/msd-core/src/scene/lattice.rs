//! Regular lattices: the ends of each spring and the triangles of the surface, in closed form.
//!
//! Nothing is searched and nothing is stored per spring.

use crate::error::Error;
use crate::scene::check::{MAX_PARTICLES, MAX_SPRINGS, check};
use crate::scene::surface::Corner;

/// Steps from a particle to its neighbour as (row, column, stack), ordered by length: 3 axes,
/// 6 face diagonals, 4 space diagonals. The first component that is not zero is positive, so that
/// each pair of neighbours belongs to exactly one family.
pub const FAMILIES: [[isize; 3]; 13] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [1, -1, 0],
    [1, 0, 1],
    [1, 0, -1],
    [0, 1, 1],
    [0, 1, -1],
    [1, 1, 1],
    [1, 1, -1],
    [1, -1, 1],
    [1, -1, -1],
];

/// The first families, those along the axes.
const AXES: usize = 3;

/// The neighbours that a particle of a lattice is joined to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Neighbours {
    /// Along the axes only: 2 in a rope, 4 in a sheet, 6 in a block. Collapses under shear.
    Axes,
    /// Diagonals too: 2 in a rope, 8 in a sheet, 26 in a block.
    #[default]
    All,
}

/// A regular body of rows x columns x stacks particles: rows along y, columns along x, stacks
/// along z. A size of 1 makes a sheet, a rope or a point.
///
/// Particles count stacks fastest, then columns, then rows. Springs count family by family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    size: [usize; 3],
    /// The first spring of each family, and the number of springs at the end.
    starts: [usize; 14],
}

impl Lattice {
    /// Makes a lattice of `size` = (rows, columns, stacks), each at least 1.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a size of 0, [`Error::TooLarge`] beyond [`MAX_PARTICLES`] or
    /// [`MAX_SPRINGS`].
    pub fn new(size: [usize; 3], neighbours: Neighbours) -> Result<Self, Error> {
        for (row, &length) in size.iter().enumerate() {
            let at = ("dimension", row);
            check(0 < length, "size", at, length as f64, "at least 1")?;
        }
        check_product("the number of particles", size, MAX_PARTICLES)?;
        let families = if neighbours == Neighbours::All { FAMILIES.len() } else { AXES };
        let mut starts = [0; 14];
        for family in 0..FAMILIES.len() {
            // Cannot overflow: a family has fewer springs than there are particles.
            let cells = cells(size, FAMILIES[family]);
            let count = if family < families { cells[0] * cells[1] * cells[2] } else { 0 };
            starts[family + 1] = starts[family] + count;
        }
        let (count, limit) = (starts[13] as u128, MAX_SPRINGS);
        if MAX_SPRINGS < starts[13] {
            return Err(Error::TooLarge { what: "the number of springs", count, limit });
        }
        Ok(Lattice { size, starts })
    }

    /// Rows, columns, stacks.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// The number of particles.
    pub fn particle_count(&self) -> usize {
        self.size[0] * self.size[1] * self.size[2]
    }

    /// The number of springs.
    pub fn spring_count(&self) -> usize {
        self.starts[13]
    }

    /// The particle at (row, column, stack).
    pub fn particle(&self, at: [usize; 3]) -> usize {
        (at[0] * self.size[1] + at[1]) * self.size[2] + at[2]
    }

    /// The (row, column, stack) of a particle; of one past the last, a row past the last.
    pub fn place(&self, particle: usize) -> [usize; 3] {
        let [_, columns, stacks] = self.size;
        [particle / stacks / columns, particle / stacks % columns, particle % stacks]
    }

    /// The springs of a family: one kind, all of the same length.
    pub fn family(&self, family: usize) -> core::ops::Range<usize> {
        self.starts[family]..self.starts[family + 1]
    }

    /// The family of a spring, one of 13 for a spring of the lattice.
    pub fn family_of(&self, spring: usize) -> usize {
        self.starts.partition_point(|&start| start <= spring) - 1
    }

    /// Length of the springs of a family in units of the spacing: 1, √2 or √3.
    pub fn family_length(family: usize) -> f64 {
        let squared: isize = FAMILIES[family].iter().map(|step| step * step).sum();
        crate::number::Real::sqrt(squared as f64)
    }

    /// The two particles that a spring joins.
    ///
    /// # Panics
    /// If `spring` is not below [`Lattice::spring_count`].
    pub fn spring(&self, spring: usize) -> [usize; 2] {
        let family = self.family_of(spring);
        let step = FAMILIES[family];
        let [_, columns, stacks] = cells(self.size, step);
        let cell = spring - self.starts[family];
        let cell = [cell / stacks / columns, cell / stacks % columns, cell % stacks];
        // A negative step starts at the far side of the cell.
        let from = [0, 1, 2].map(|axis| cell[axis] + usize::from(step[axis] < 0));
        let to = [0, 1, 2].map(|axis| cell[axis] + usize::from(0 < step[axis]));
        [self.particle(from), self.particle(to)]
    }

    /// The spring that joins two particles, in either order; `None` if they are not neighbours.
    pub fn spring_between(&self, ends: [usize; 2]) -> Option<usize> {
        let [a, b] = ends.map(|end| self.place(end));
        let step = [0, 1, 2].map(|axis| b[axis] as isize - a[axis] as isize);
        let back = step.map(|length| -length);
        let family = FAMILIES.iter().position(|&known| known == step || known == back)?;
        let cell = [0, 1, 2].map(|axis| a[axis].min(b[axis]));
        let [_, columns, stacks] = cells(self.size, FAMILIES[family]);
        let spring = self.starts[family] + (cell[0] * columns + cell[1]) * stacks + cell[2];
        (spring < self.starts[family + 1]).then_some(spring)
    }
}

/// The number of places where a step fits, by axis.
fn cells(size: [usize; 3], step: [isize; 3]) -> [usize; 3] {
    [0, 1, 2].map(|axis| size[axis] - step[axis].unsigned_abs().min(size[axis]))
}

fn check_product(what: &'static str, size: [usize; 3], limit: usize) -> Result<(), Error> {
    let count = size.iter().fold(1u128, |product, &n| product.saturating_mul(n as u128));
    if count <= limit as u128 { Ok(()) } else { Err(Error::TooLarge { what, count, limit }) }
}

/// A side of a lattice: the grid axes u and v, in (row, column, stack), with u x v outward, and
/// which end of the third axis it lies at.
struct Side {
    u: usize,
    v: usize,
    across: usize,
    far: bool,
}

// Rows run along y, columns along x, stacks along z: +x is columns, rows x stacks = y x z = +x.
const SIDES: [Side; 6] = [
    Side { u: 0, v: 2, across: 1, far: true },
    Side { u: 2, v: 0, across: 1, far: false },
    Side { u: 2, v: 1, across: 0, far: true },
    Side { u: 1, v: 2, across: 0, far: false },
    Side { u: 1, v: 0, across: 2, far: true },
    Side { u: 0, v: 1, across: 2, far: false },
];

/// The surface of a lattice: six sides of a block, one of a sheet, none of a rope.
impl Lattice {
    /// Whether the lattice is a sheet: exactly one dimension is 1.
    pub fn is_sheet(&self) -> bool {
        self.size.iter().filter(|&&length| length == 1).count() == 1
    }

    fn sides(&self) -> impl Iterator<Item = &'static Side> + '_ {
        let thin = self.size.iter().filter(|&&length| length == 1).count();
        SIDES.iter().filter(move |side| match thin {
            0 => true,
            1 => side.far && self.size[side.across] == 1,
            _ => false,
        })
    }

    fn quads(&self, side: &Side) -> usize {
        (self.size[side.u] - 1) * (self.size[side.v] - 1)
    }

    /// The number of triangles of the surface.
    pub fn triangle_count(&self) -> usize {
        self.sides().map(|side| 2 * self.quads(side)).sum()
    }

    /// The number of corners of the surface; a particle at an edge has one per side.
    pub fn corner_count(&self) -> usize {
        self.sides().map(|side| self.size[side.u] * self.size[side.v]).sum()
    }

    /// The particle and the texture coordinates of a corner; `None` past the last.
    pub fn corner(&self, corner: usize) -> Option<Corner> {
        let mut corner = corner;
        for side in self.sides() {
            let (across_u, across_v) = (self.size[side.u], self.size[side.v]);
            if across_u * across_v <= corner {
                corner -= across_u * across_v;
                continue;
            }
            let (u, v) = (corner / across_v, corner % across_v);
            let mut at = [0; 3];
            at[side.across] = if side.far { self.size[side.across] - 1 } else { 0 };
            (at[side.u], at[side.v]) = (u, v);
            let uv = [u as f32 / (across_u - 1) as f32, v as f32 / (across_v - 1) as f32];
            return Some(Corner { particle: self.particle(at) as u32, uv });
        }
        None
    }

    /// The three corners of a triangle, counter-clockwise from outside; `None` past the last.
    pub fn triangle(&self, triangle: usize) -> Option<[u32; 3]> {
        let (mut quad, half) = (triangle / 2, triangle % 2);
        let mut first = 0;
        for side in self.sides() {
            if self.quads(side) <= quad {
                quad -= self.quads(side);
                first += self.size[side.u] * self.size[side.v];
                continue;
            }
            let across = self.size[side.v];
            let here = first + quad / (across - 1) * across + quad % (across - 1);
            let corners = match half {
                0 => [here, here + across, here + across + 1],
                _ => [here, here + across + 1, here + 1],
            };
            return Some(corners.map(|corner| corner as u32));
        }
        None
    }
}
