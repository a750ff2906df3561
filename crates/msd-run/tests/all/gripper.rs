//! The built-in scene of a gripper with soft fingers on guided pins.

use msd_core::Vector;
use msd_run::{Runner, Touched, on};
use msd_scene::open;

/// The lowest and the mean height of the cube, metres.
fn heights(runner: &Runner) -> (f64, f64) {
    let cube: Vec<f64> = on!(runner, simulation => {
        simulation.positions().take(6 * 6 * 6).map(|position| position.to_f64().y).collect()
    });
    let sum: f64 = cube.iter().sum();
    (cube.iter().copied().fold(f64::INFINITY, f64::min), sum / cube.len() as f64)
}

/// The fingers close within a second, lift by half a metre in 1.3 s, hold it for 4.5 s, set it down
/// and open.
#[test]
fn the_gripper_lifts_the_cube_holds_it_and_sets_it_down() {
    let mut runner = Runner::open(&open("gripper").expect("a built-in scene")).expect("a run");
    let nothing = Touched { passes: 0, crossings: 0, went_through: Vec::new() };
    let start = heights(&runner).1;
    let mut held = Vec::new();
    for step in 1..=60 * 10 {
        runner.step().expect("a step");
        assert_eq!(runner.touched(), Some(nothing.clone()), "at {} s", runner.time());
        if (150..=420).contains(&step) {
            held.push(heights(&runner));
        }
    }
    // The cube gives by its weight, and does not slip: it is as high at the end as when it was up.
    // Half a second after it has stopped.
    let (first, last) = (held[30].1, held[held.len() - 1].1);
    assert!(held.iter().all(|&(lowest, mean)| 0.3 < lowest && 0.4 < mean - start));
    assert!((first - last).abs() < 0.02, "{first} m to {last} m");
    let (lowest, mean) = heights(&runner);
    assert!(lowest.abs() < 0.01 && (mean - start).abs() < 0.03, "{lowest} m, {mean} m");
    let energy = runner.energy();
    assert!(0.0 < energy.supplied && energy.supplied.is_finite());
}
