//! Crossings: triangles of shells that pass through each other.

use msd_core::glam::DVec3;
use msd_core::scene::do_meet;
use msd_core::{Real, Simulation, Vector};
use msd_scene::crossing::{Triangle, each_crossing};

/// What counting costs for a triangle at most, in evaluations of a spring with all that a step does
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
