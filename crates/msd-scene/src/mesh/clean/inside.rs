//! The inside of a closed mesh.

use glam::DVec3;

/// Triangles sorted into columns along y, to count the exits of a vertical ray from the mesh.
pub(crate) struct Inside<'a> {
    positions: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    low: [f64; 2],
    cell: f64,
    side: usize,
    /// Where the faces of each cell start; one more than there are cells.
    starts: Vec<usize>,
    faces: Vec<u32>,
}

impl<'a> Inside<'a> {
    /// Sorts the triangles into a square of cells in x and z.
    pub(crate) fn new(positions: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Self {
        let corners = || triangles.iter().flatten().map(|&corner| positions[corner as usize]);
        let low = corners().fold(DVec3::MAX, DVec3::min);
        let high = corners().fold(DVec3::MIN, DVec3::max);
        let extent = (high.x - low.x).max(high.z - low.z);
        let mut inside = Self {
            positions,
            triangles,
            low: [low.x, low.z],
            cell: 1.0,
            side: 2 * (triangles.len() as f64).sqrt().ceil().clamp(1.0, 1024.0) as usize,
            starts: Vec::new(),
            faces: Vec::new(),
        };
        // Long triangles lie in many cells: coarser cells keep the lists short whatever the mesh.
        loop {
            let cell = extent / inside.side as f64;
            inside.cell = if 0.0 < cell { cell } else { 1.0 };
            if inside.side == 1 || inside.entries() <= 16 * triangles.len() {
                break;
            }
            inside.side = inside.side.div_ceil(2);
        }
        inside.fill();
        inside
    }

    /// Whether the mesh winds around a point, by the nonzero rule: bodies that overlap are one,
    /// and a void is a void if its faces point into it.
    pub(crate) fn contains(&self, point: DVec3) -> bool {
        let (Some(x), Some(z)) = (self.cell_of(0, point.x), self.cell_of(1, point.z)) else {
            return false;
        };
        let cell = z * self.side + x;
        let faces = &self.faces[self.starts[cell]..self.starts[cell + 1]];
        faces.iter().map(|&face| self.crossing(face, point)).sum::<i32>() != 0
    }

    /// The crossings of one triangle by the ray from a point along +y: −1, 0 or 1 by its side.
    ///
    /// Every edge is judged alike by both its faces, ties included, so that no ray slips between
    /// two faces or counts a shared edge twice.
    fn crossing(&self, face: u32, point: DVec3) -> i32 {
        let corners = self.triangles[face as usize];
        let mut winding = 0;
        for i in 0..3 {
            winding += self.edge_crossing(corners[i], corners[(i + 1) % 3], point);
        }
        if winding == 0 {
            return 0;
        }
        let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
        let normal = (b - a).cross(c - a);
        let slope = normal.x * (point.x - a.x) + normal.z * (point.z - a.z);
        // A nearly vertical face has no trustworthy height of its own: its corners bound it.
        let height = a.y - if normal.y == 0.0 { 0.0 } else { slope / normal.y };
        let height = height.max(a.y.min(b.y).min(c.y)).min(a.y.max(b.y).max(c.y));
        if point.y < height { winding } else { 0 }
    }

    /// Whether the edge, seen from above, passes the point on the side of larger x.
    fn edge_crossing(&self, from: u32, to: u32, point: DVec3) -> i32 {
        let [start, end] = [from, to].map(|corner| self.positions[corner as usize]);
        if (start.z <= point.z) == (end.z <= point.z) {
            return 0;
        }
        // Computed from the lower index, so that both faces of the edge round alike.
        let (a, b) = if from < to { (start, end) } else { (end, start) };
        let x = a.x + (point.z - a.z) / (b.z - a.z) * (b.x - a.x);
        match (point.x < x, start.z < end.z) {
            (false, _) => 0,
            (true, true) => 1,
            (true, false) => -1,
        }
    }

    fn cell_of(&self, axis: usize, value: f64) -> Option<usize> {
        let steps = (value - self.low[axis]) / self.cell;
        // The far border belongs to the last cell.
        let last = self.side as f64;
        (0.0 <= steps && steps <= last).then(|| (steps as usize).min(self.side - 1))
    }

    /// The first and last cell of a triangle in x and z.
    fn span(&self, triangle: &[u32; 3]) -> [[usize; 2]; 2] {
        let [a, b, c] = triangle.map(|corner| self.positions[corner as usize]);
        let clamped = |axis, value: f64| self.cell_of(axis, value).unwrap_or(self.side - 1);
        let span = |axis, a: f64, b: f64, c: f64| {
            [clamped(axis, a.min(b).min(c)), clamped(axis, a.max(b).max(c))]
        };
        [span(0, a.x, b.x, c.x), span(1, a.z, b.z, c.z)]
    }

    fn entries(&self) -> usize {
        let cells = |[low, high]: [usize; 2]| high - low + 1;
        self.triangles.iter().map(|t| self.span(t).map(cells).iter().product::<usize>()).sum()
    }

    /// Counts the faces of each cell, then puts them there.
    fn fill(&mut self) {
        let spans: Vec<_> = self.triangles.iter().map(|triangle| self.span(triangle)).collect();
        let side = self.side;
        let cells = |[[x0, x1], [z0, z1]]: [[usize; 2]; 2]| {
            (z0..=z1).flat_map(move |z| (x0..=x1).map(move |x| z * side + x))
        };
        let mut starts = vec![0; side * side + 1];
        for cell in spans.iter().flat_map(|&span| cells(span)) {
            starts[cell + 1] += 1;
        }
        for cell in 0..side * side {
            starts[cell + 1] += starts[cell];
        }
        let mut next = starts.clone();
        let mut faces = vec![0; starts[side * side]];
        for (face, &span) in spans.iter().enumerate() {
            for cell in cells(span) {
                faces[next[cell]] = face as u32;
                next[cell] += 1;
            }
        }
        self.starts = starts;
        self.faces = faces;
    }
}
