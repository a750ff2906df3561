//! The inside of a mesh with holes, by generalised winding numbers.
//!
//! A triangle is seen from a point under a solid angle. The sum of these angles over 4π is the
//! winding number of the mesh around the point (Jacobson and others, 2013). It is whole where the
//! mesh is closed, and nearly so behind a surface with small holes.

use crate::mesh::clean::topology::{Sets, edges, sides, volume6};
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// The most triangles that are summed one by one.
const LEAF: usize = 8;
/// Triangles that lie so many times as far away as they reach are seen as one small face (Barill
/// and others, 2018). The angle is then right within a ninth, and the sum of many within a few
/// hundredths.
const FAR: f64 = 3.0;
/// The farthest that a winding number may be from a whole one to be taken for it.
const DECIDED: f64 = 0.25;

/// Some triangles that lie near each other.
#[derive(Debug)]
struct Cluster {
    /// Half the sum of the cross products of two sides: the area, along the normal.
    area: DVec3,
    middle: DVec3,
    /// The farthest corner from the middle.
    reach: f64,
    first: usize,
    count: usize,
    /// Its two parts are the next cluster and this one; none in a leaf.
    second: Option<usize>,
}

/// The triangles of a mesh in a tree.
#[derive(Debug)]
pub(crate) struct Winding {
    clusters: Vec<Cluster>,
    corners: Vec<[DVec3; 3]>,
}

impl Winding {
    /// Sorts the triangles into a tree.
    pub(crate) fn new(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let corners = triangles.iter().map(|t| t.map(|corner| positions[corner as usize]));
        let mut tree = Winding { clusters: Vec::new(), corners: corners.collect() };
        tree.grow(0, triangles.len());
        tree
    }

    fn grow(&mut self, first: usize, count: usize) {
        let faces = &mut self.corners[first..first + count];
        let ends = || faces.iter().flatten().copied();
        let (low, high) =
            (ends().fold(DVec3::MAX, DVec3::min), ends().fold(DVec3::MIN, DVec3::max));
        let middle = (low + high) / 2.0;
        let reach = ends().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
        let area = faces.iter().map(|[a, b, c]| (b - a).cross(c - a) / 2.0).sum();
        let cluster = self.clusters.len();
        self.clusters.push(Cluster { area, middle, reach, first, count, second: None });
        if count <= LEAF {
            return;
        }
        let axis = (high - low).max_position();
        let place = |[a, b, c]: &[DVec3; 3]| a[axis] + b[axis] + c[axis];
        faces.sort_by(|a, b| place(a).total_cmp(&place(b)));
        self.grow(first, count / 2);
        self.clusters[cluster].second = Some(self.clusters.len());
        self.grow(first + count / 2, count - count / 2);
    }

    /// The winding number of the mesh around a point; positive inside faces that look outward.
    pub(crate) fn number(&self, point: DVec3) -> f64 {
        let mut waiting = vec![0];
        let mut angle = 0.0;
        while let Some(index) = waiting.pop() {
            let cluster = &self.clusters[index];
            let away = cluster.middle - point;
            let distance = away.length();
            if FAR * cluster.reach < distance {
                angle += cluster.area.dot(away) / (distance * distance * distance);
            } else if let Some(second) = cluster.second {
                waiting.extend([second, index + 1]);
            } else {
                let faces = &self.corners[cluster.first..cluster.first + cluster.count];
                angle += faces.iter().map(|face| solid_angle(*face, point)).sum::<f64>();
            }
        }
        angle / (4.0 * PI)
    }

    /// Whether a point is inside.
    pub(crate) fn contains(&self, point: DVec3) -> bool {
        0.5 < self.number(point).abs()
    }

    /// The share of the area from one side of which the winding number is undecided: farther than
    /// a quarter from a whole number.
    pub(crate) fn undecided(&self) -> f64 {
        let (mut all, mut undecided) = (0.0, 0.0);
        for &[a, b, c] in &self.corners {
            let normal = (b - a).cross(c - a);
            let area = normal.length() / 2.0;
            let off = 1e-3 * area.sqrt() * normal.normalize_or_zero();
            let middle = (a + b + c) / 3.0;
            let is_open = |side: f64| {
                let number = self.number(middle + side * off);
                DECIDED < (number - number.round()).abs()
            };
            all += area;
            undecided += if is_open(1.0) || is_open(-1.0) { area } else { 0.0 };
        }
        // All of a mesh whose area underflows.
        if all == 0.0 { 1.0 } else { undecided / all }
    }
}

/// The solid angle under which a triangle is seen, positive from behind (van Oosterom and
/// Strackee, 1983).
fn solid_angle(corners: [DVec3; 3], point: DVec3) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - point);
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    // The same on every machine, unlike that of the standard library.
    2.0 * libm::atan2(a.dot(b.cross(c)), below)
}

/// The holes of a mesh: the number of loops of its open edges, and the signed volume that it
/// encloses if a fan around its middle closes each, in cubed units of the positions.
pub(crate) fn holes(positions: &[DVec3], triangles: &[[u32; 3]]) -> (usize, f64) {
    let mut sets = Sets::new(positions.len());
    let sides = sides(triangles);
    let open = || edges(&sides).filter(|edge| edge.len() == 1).map(|edge| edge[0]);
    open().for_each(|side| sets.join(side.ends[0] as usize, side.ends[1] as usize));
    // The sum of the ends of the edges of each hole, and their number.
    let mut sums: BTreeMap<usize, (DVec3, f64)> = BTreeMap::new();
    for side in open() {
        let (sum, count) = sums.entry(sets.find(side.ends[0] as usize)).or_default();
        *sum += side.ends.map(|end| positions[end as usize]).into_iter().sum::<DVec3>();
        *count += 2.0;
    }
    let from = positions.first().copied().unwrap_or_default();
    let faces: f64 = triangles.iter().map(|&face| volume6(positions, face, from)).sum();
    let fans = open().map(|side| {
        let (sum, count) = sums[&sets.find(side.ends[0] as usize)];
        // The fan runs along the edge the other way round.
        let [start, end] = side.along().map(|end| positions[end as usize] - from);
        (sum / count - from).dot(end.cross(start))
    });
    (sums.len(), (faces + fans.sum::<f64>()) / 6.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::clean::inside::Inside;
    use crate::mesh::{self, Format};
    use rand_pcg::Pcg64Mcg;
    use rand_pcg::rand_core::{Rng, SeedableRng};

    const BUNNY: &[u8] = include_bytes!("../../../meshes/bunny.obj");

    #[test]
    fn a_triangle_over_an_octant_is_seen_under_an_eighth_of_the_sphere() {
        for scale in [1e-3, 1.0, 1e3] {
            let corners = [DVec3::X, DVec3::Y, DVec3::Z].map(|corner| scale * corner);
            let angle = solid_angle(corners, DVec3::ZERO);
            assert!((angle - PI / 2.0).abs() < 1e-15, "{angle}");
        }
    }

    #[test]
    fn the_winding_number_of_a_closed_mesh_is_one_inside_and_zero_outside() {
        let mesh = mesh::parse(BUNNY, Format::Obj, "bunny.obj").unwrap();
        let (positions, triangles) = (&mesh.positions, &mesh.triangles);
        let (inside, winding) =
            (Inside::new(positions, triangles), Winding::new(positions, triangles));
        let low = positions.iter().copied().fold(DVec3::MAX, DVec3::min);
        let high = positions.iter().copied().fold(DVec3::MIN, DVec3::max);
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut unit = || random.next_u32() as f64 / u32::MAX as f64;
        let mut found = [0; 2];
        for _ in 0..2000 {
            let point = low + (high - low) * DVec3::new(unit(), unit(), unit());
            let is_inside = inside.contains(point);
            let off = winding.number(point) - f64::from(u8::from(is_inside));
            // A group of faces seen as one is wrong by (1/3)² of its angle at most.
            assert!(off.abs() < 1.0 / (FAR * FAR), "{point}: {off}");
            found[usize::from(is_inside)] += 1;
        }
        assert!(found.into_iter().all(|count| 200 < count), "{found:?}");
        assert_eq!(winding.undecided(), 0.0);
    }

    #[test]
    fn a_fan_closes_a_hole() {
        let corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
        let positions = corners.map(|[x, y, z]| DVec3::new(x.into(), y.into(), z.into()));
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        assert_eq!(holes(&positions, &faces), (0, 1.0 / 6.0));
        for left_out in 0..4 {
            let mut open = faces.to_vec();
            open.remove(left_out);
            let (count, volume) = holes(&positions, &open);
            assert_eq!(count, 1);
            assert!((volume - 1.0 / 6.0).abs() < 1e-16, "{volume}");
        }
    }
}
