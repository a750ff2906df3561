//! Cells of solids that are flat or inside out.
//!
//! Springs are as long in a mirrored cell as in one at rest. A lattice that was squeezed flat or
//! folded may therefore come to rest inside out.

use crate::{Runner, on};
use msd_core::Vector;
use msd_core::glam::DVec3;
use serde::Serialize;
use std::ops::Range;

/// Least volume of a corner relative to the product of its edges, for edges at nearly right angles.
const SQUARE: f64 = 0.9;
/// The longest edge of a cell at a particle, in the shortest springs there: diagonals are longer.
const EDGE: f64 = 1.2;

/// The part of its volume at the start below which a corner is flat.
const FLAT: f64 = 0.01;

/// A body with cells that are flat or inside out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Overturned {
    /// The body, by its number.
    pub body: usize,
    /// Corners of its cells that are flat or inside out.
    pub corners: usize,
    /// Corners of its cells in all.
    pub of: usize,
}

/// The corners of the cells of solids, by body: a particle and three neighbours at right angles
/// that are joined to each other, so that a corner is as stiff as its springs.
#[derive(Clone, Debug, Default)]
pub struct Cells(Vec<(usize, Vec<Corner>)>);

/// A particle with its neighbours, and six times the volume of their tetrahedron at the start.
type Corner = ([u32; 4], f64);

impl Cells {
    /// Those of the bodies of a run as it stands; sheets and ropes have none.
    pub fn new(runner: &Runner) -> Self {
        let places = places(runner);
        let mut neighbours = vec![Vec::new(); places.len()];
        on!(runner, simulation => {
            let model = simulation.model();
            let present = |spring: &usize| !model.is_cut(*spring);
            for spring in (0..model.ends().len()).filter(present) {
                let [a, b] = model.ends()[spring];
                neighbours[a as usize].push(b);
                neighbours[b as usize].push(a);
            }
            let bent: Vec<usize> =
                model.bends().rows().map(|row| row.particles[0]).collect();
            let bodies = model.bodies().iter().enumerate();
            let is_bent = |own: &Range<usize>| bent.iter().any(|at| own.contains(at));
            let solids = bodies.filter(|(_, body)| !is_bent(&body.particles));
            let corners_of = |own: &Range<usize>| {
                own.clone().flat_map(|at| corners(&places, &neighbours, at)).collect()
            };
            Cells(solids.map(|(number, body)| (number, corners_of(&body.particles))).collect())
        })
    }

    /// The body of which most corners are flat or inside out now; `None` if none are.
    pub fn overturned(&self, runner: &Runner) -> Option<Overturned> {
        if self.0.iter().all(|(_, corners)| corners.is_empty()) {
            return None;
        }
        let places = places(runner);
        let count = |(body, corners): &(usize, Vec<Corner>)| {
            let is_lost = |(corner, start): &&Corner| volume(&places, corner) < FLAT * start;
            let lost = corners.iter().filter(is_lost).count();
            Overturned { body: *body, corners: lost, of: corners.len() }
        };
        let found = self.0.iter().map(count).filter(|found| 0 < found.corners);
        found.max_by_key(|found| found.corners)
    }
}

fn places(runner: &Runner) -> Vec<DVec3> {
    on!(runner, simulation => simulation.positions().map(Vector::to_f64).collect())
}

/// The corners at a particle, each turned so that its volume is positive.
fn corners(places: &[DVec3], neighbours: &[Vec<u32>], at: usize) -> Vec<Corner> {
    let length = |to: u32| places[to as usize].distance(places[at]);
    let all = &neighbours[at];
    let shortest = all.iter().map(|&to| length(to)).fold(f64::INFINITY, f64::min);
    let near: Vec<u32> = all.iter().copied().filter(|&to| length(to) <= EDGE * shortest).collect();
    let mut corners = Vec::new();
    for (first, &a) in near.iter().enumerate() {
        for (second, &b) in near.iter().enumerate().skip(first + 1) {
            for &c in &near[second + 1..] {
                let joined = |a: u32, b: u32| neighbours[a as usize].contains(&b);
                if !(joined(a, b) && joined(b, c) && joined(c, a)) {
                    continue;
                }
                let corner = [at as u32, a, b, c];
                let least = SQUARE * (length(a) * length(b) * length(c));
                match volume(places, &corner) {
                    volume if least < volume => corners.push((corner, volume)),
                    volume if volume < -least => corners.push(([at as u32, b, a, c], -volume)),
                    _ => {}
                }
            }
        }
    }
    corners
}

/// Six times the volume of the tetrahedron of a corner, cubic metres.
fn volume(places: &[DVec3], &[at, a, b, c]: &[u32; 4]) -> f64 {
    let [a, b, c] = [a, b, c].map(|to| places[to as usize] - places[at as usize]);
    a.cross(b).dot(c)
}
