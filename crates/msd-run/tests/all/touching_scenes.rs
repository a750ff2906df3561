//! The built-in scenes of bodies that touch show what their titles say.

use msd_core::glam::DVec3;
use msd_core::{Vector, Witness};
use msd_run::{Piercing, Runner, Touched, on};
use msd_scene::open;

fn runner(name: &str) -> Runner {
    Runner::open(&open(name).expect(name)).expect("a built-in scene runs")
}

/// A scene of `tests/scenes/`.
fn own(name: &str) -> Runner {
    runner(&format!("{}/tests/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR")))
}

/// Runs for so many seconds. After each step nothing has passed through anything; after each second
/// the substep is below the largest stable one, and no energy was gained.
fn run(name: &str, runner: &mut Runner, seconds: usize, mut look: impl FnMut(&Runner)) {
    let nothing = Touched { passes: 0, crossings: 0, went_through: Vec::new() };
    let (mut witness, mut piercing) = (Witness::default(), Piercing::default());
    for second in 1..=seconds {
        for _ in 0..60 {
            runner.step().expect(name);
            runner.show_to(&mut witness);
            piercing.look(runner);
            assert_eq!(runner.touched(), Some(nothing.clone()), "{name} at {} s", runner.time());
            look(runner);
        }
        assert_eq!(piercing.first(), None, "{name} after {second} s");
        let (h, stable) = (runner.settings().substep(), runner.stable_substep());
        assert!(h <= stable, "{name} after {second} s: {h:e} of {stable:e}");
        assert_eq!(witness.gain(), 0.0, "{name} after {second} s");
    }
}

fn positions(runner: &Runner) -> Vec<DVec3> {
    on!(runner, simulation => simulation.positions().map(|position| position.to_f64()).collect())
}

/// All comes to rest within a minute.
#[test]
fn the_cloth_on_the_ball_and_the_pile_come_to_rest() {
    for (name, kinetic) in [("drape", 0.01), ("pile", 0.05)] {
        let mut runner = runner(name);
        run(name, &mut runner, 60, |_| {});
        let moving = runner.energy().kinetic;
        assert!(moving < kinetic, "{name}: {moving} J after a minute");
    }
}

#[test]
fn the_cubes_leave_the_trampoline_and_stay_above_it() {
    let mut runner = runner("trampoline");
    let mut highest = 0.0f64;
    let cubes = |runner: &Runner| positions(runner).split_off(31 * 31);
    run("trampoline", &mut runner, 10, |runner| {
        let heights = cubes(runner).into_iter().map(|position| position.y);
        let lowest = heights.fold(f64::INFINITY, f64::min);
        // Once they have all come down.
        highest = if runner.time() < 1.0 { 0.0 } else { highest.max(lowest) };
        assert!(0.0 < lowest, "fallen through at {} s", runner.time());
    });
    assert!(0.9 < highest, "all of the cubes at once at most {highest} m high");
}

#[test]
fn the_strip_is_twisted_by_three_turns_and_turned_back() {
    let mut runner = runner("twist");
    let ends = |runner: &Runner| {
        let positions = positions(runner);
        // The first and the last particle in the lowest row of the strip.
        let across = positions[8] - positions[0];
        f64::atan2(across.z, across.x)
    };
    let (mut before, mut turned, mut most, mut back) = (ends(&runner), 0.0f64, 0.0f64, 0.0f64);
    run("twist", &mut runner, 60, |runner| {
        let now = ends(runner);
        let step = (now - before + core::f64::consts::PI).rem_euclid(core::f64::consts::TAU)
            - core::f64::consts::PI;
        (before, turned) = (now, turned + step / core::f64::consts::TAU);
        most = most.max(turned.abs());
        back = back.max(most - turned.abs());
    });
    assert!((2.5..4.0).contains(&most), "{most} turns");
    assert!(2.0 < back, "{back} turns back");
}

/// It lies still from the third second on.
#[test]
fn the_cloth_is_pulled_through_the_ring() {
    let mut runner = runner("funnel");
    let mut narrowest = f64::INFINITY;
    run("funnel", &mut runner, 10, |runner| {
        let positions = positions(runner);
        let across = positions.iter().map(|x| x.x.hypot(x.z)).fold(0.0, f64::max);
        narrowest = narrowest.min(across);
    });
    // A square of 1.5 m, its corners 1.06 m from the middle, through a ring of 0.48 m.
    assert!(narrowest < 0.6, "{narrowest} m");
    let positions = positions(&runner);
    assert!(positions.iter().all(|x| x.y < 0.1), "not all of it is through");
    assert!(positions.iter().any(|x| 0.9 < x.x.hypot(x.z)), "it does not lie flat");
}

#[test]
fn the_knot_is_pulled_tight_and_holds() {
    let mut runner = runner("knot");
    run("knot", &mut runner, 10, |_| {});
    let positions = positions(&runner);
    let (low, high) = (positions[0], positions[positions.len() - 1]);
    let lengths = positions.windows(2).map(|pair| (pair[1] - pair[0]).length());
    let length: f64 = lengths.sum();
    // An overhand knot takes up more than three times the thickness of the rope.
    assert!(0.1 < length - (high - low).length(), "{length} m of rope, {:?}", high - low);
}

#[test]
fn the_curtain_closes_behind_the_ball() {
    let mut runner = runner("curtain");
    let mut widest = 0.0f64;
    // The inner edges of the two halves, 19 particles wide, at the height of the ball's middle.
    let gap = |runner: &Runner| {
        let positions = positions(runner);
        positions[41 * 19 + 22 * 19].x - positions[22 * 19 + 18].x
    };
    run("curtain", &mut runner, 12, |runner| widest = widest.max(gap(runner)));
    assert!(0.4 < widest, "the ball of 0.7 m opened {widest} m");
    assert!(gap(&runner) < 0.15, "{} m stay open", gap(&runner));
}

/// Five cubes of 4 cm, each lower by at most 4 mm than its own size and both thicknesses by the
/// load that it bears: 200 kPa under 4 cubes of 0.4 kPa each.
#[test]
fn five_cubes_stand_on_each_other() {
    let mut runner = own("stack");
    run("stack", &mut runner, 20, |_| {});
    let positions = positions(&runner);
    let middle = |cube: &[DVec3]| cube.iter().sum::<DVec3>() / cube.len() as f64;
    let middles: Vec<DVec3> = positions.chunks(125).map(middle).collect();
    for pair in middles.windows(2) {
        let way = pair[1] - pair[0];
        assert!((0.0405..0.042).contains(&way.y) && way.x.hypot(way.z) < 1e-3, "{way}");
    }
    assert!(runner.energy().kinetic < 1e-6, "{} J", runner.energy().kinetic);
}

#[test]
fn a_ball_thrown_onto_a_trampoline_bounces_on_it() {
    let mut runner = own("bed");
    let (mut highest, mut lowest) = (0.0f64, f64::INFINITY);
    run("bed", &mut runner, 10, |runner| {
        let ball = positions(runner).split_off(25 * 25);
        let middle = ball.iter().sum::<DVec3>() / ball.len() as f64;
        lowest = lowest.min(middle.y);
        highest = if runner.time() < 0.4 { 0.0 } else { highest.max(middle.y) };
    });
    assert!(0.0 < lowest && 1.2 < highest, "{lowest} to {highest} m");
}

#[test]
fn a_cloth_that_folds_does_not_cross_itself() {
    let mut runner = own("folds");
    run("folds", &mut runner, 20, |_| {});
    let heights = positions(&runner).into_iter().map(|position| position.y);
    assert!(heights.fold(0.0, f64::max) < 0.2, "it stands");
}

#[test]
fn cloths_in_a_box_that_closes_do_not_cross() {
    let mut runner = own("crumple");
    run("crumple", &mut runner, 10, |_| {});
}
