//! Crossings: triangles of shells that pass through each other, and bodies that did.

use msd_core::glam::DVec3;
use msd_core::scene::do_meet;
use msd_core::{Model, Real, ShellPassage, Simulation, Vector};
use msd_scene::crossing::{Triangle, each_crossing};
use serde::Serialize;
use std::fmt;

/// Greatest cost of counting per triangle, in evaluations of a spring with all that a step does
/// beside it: 12 to 88 in the built-in scenes where bodies meet.
const COST: f64 = 100.0;

/// Counts the pairs of triangles of which an edge of one passes through the inside of the other: of
/// two shells that meet, or of one that meets itself.
pub fn crossings<R: Real>(simulation: &Simulation<R>) -> u64 {
    let model = simulation.model();
    let shells = model.shells();
    let positions: Vec<DVec3> = simulation.positions().map(Vector::to_f64).collect();
    let mut shell_of = vec![0; model.particle_count()];
    for (number, shell) in shells.iter().enumerate() {
        shell.particles().for_each(|particle| shell_of[particle] = number);
    }
    let triangles = shells.iter().flat_map(|shell| &shell.triangles);
    let triangles = triangles.map(|&corners| Triangle::new(corners, &positions)).collect();
    let mut count = 0;
    each_crossing(triangles, |[one, other]| {
        let [a, b] = [one[0], other[0]].map(|particle| shell_of[particle]);
        let is_exempt =
            |pair: [usize; 2]| a == b && one.contains(&pair[0]) && other.contains(&pair[1]);
        let exempt = &shells[a].exempt;
        let may_cross = exempt.iter().any(|&[a, b]| is_exempt([a, b]) || is_exempt([b, a]));
        count += u64::from(do_meet(shells, [a, b]) && !may_cross);
    });
    count
}

/// After how many steps to count again so that counting takes at most a share of the work of
/// stepping.
pub fn steps_between_counts<R: Real>(simulation: &Simulation<R>, share: f64) -> u64 {
    let model = simulation.model();
    let triangles: usize = model.shells().iter().map(|shell| shell.triangles.len()).sum();
    let step = model.spring_count().max(1) as f64 * f64::from(simulation.settings().substeps);
    (COST * triangles as f64 / (share * step)).ceil().max(1.0) as u64
}

/// A body that was seen to go through another one or itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WentThrough {
    /// The name of the body, with its number where several have that name.
    pub body: String,
    /// The name of the other one; its own name where it went through itself.
    pub through: String,
    /// When that was first seen, simulated seconds.
    pub time: f64,
}

impl fmt::Display for WentThrough {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let WentThrough { body, through, .. } = self;
        let through = if body == through { "itself" } else { through };
        write!(f, "{body} went through {through}")
    }
}

/// The bodies that were seen to go through each other since the start, each two once.
pub(crate) fn went_through<R: Real>(simulation: &Simulation<R>) -> Vec<WentThrough> {
    let model = simulation.model();
    let named = |&ShellPassage { particles: [first, last], time }: &ShellPassage| {
        // Pinned bodies stay. Otherwise a file lists the lower body first.
        let first_moves = !has_pins(model, first) && has_pins(model, last);
        let [body, through] = if first_moves { [first, last] } else { [last, first] };
        let [body, through] = [body, through].map(|particle| name(model, particle));
        WentThrough { body, through, time }
    };
    simulation.ledger().passages().iter().map(named).collect()
}

/// The name of the body of a particle.
fn name<R: Real>(model: &Model<R>, particle: usize) -> String {
    let body = body_of(model, particle);
    body.map_or_else(|| format!("particle {particle}"), |body| body_name(model, body))
}

/// The name of a body, with its number where several have that name.
pub(crate) fn body_name<R: Real>(model: &Model<R>, number: usize) -> String {
    let bodies = model.bodies();
    let name = &bodies[number].name;
    match bodies.iter().filter(|body| body.name == *name).count() {
        1 => name.clone(),
        _ => format!("{name} (body {number})"),
    }
}

fn has_pins<R: Real>(model: &Model<R>, particle: usize) -> bool {
    let number = body_of(model, particle);
    number.is_some_and(|at| model.bodies()[at].particles.clone().any(|at| model.is_pinned(at)))
}

fn body_of<R: Real>(model: &Model<R>, particle: usize) -> Option<usize> {
    model.bodies().iter().position(|body| body.particles.contains(&particle))
}
