//! The built-in scenes show what their titles promise.

use msd_core::glam::DVec3;
use msd_core::{Simulation, Vector, Witness};
use msd_run::{Runner, on};
use msd_scene::{BUILTINS, open};

fn runner(name: &str) -> Runner {
    Runner::open(&open(name).expect(name)).expect("a built-in scene runs")
}

fn run(runner: &mut Runner, seconds: f64) {
    let steps = (seconds / runner.settings().step).round() as usize;
    for _ in 0..steps {
        runner.step().expect("a built-in scene stays in the world");
    }
}

fn single(runner: &Runner) -> &Simulation<f32> {
    match runner {
        Runner::F32(simulation, _) => simulation,
        Runner::F64(..) => panic!("the built-in scenes run in f32"),
    }
}

fn positions(runner: &Runner) -> Vec<DVec3> {
    single(runner).positions().map(|position| position.to_f64()).collect()
}

/// Lets a scene run for 10 s and looks at its largest stable substep twice a second.
fn stays_in_the_world_and_well_below_the_largest_stable_substep(name: &str) {
    let mut runner = runner(name);
    let h = runner.settings().substep();
    for _ in 0..20 {
        run(&mut runner, 0.5);
        let stable = runner.stable_substep();
        // Automatic ones are those that the prediction allows.
        let part = if runner.is_automatic() { 1.0 } else { 0.75 };
        assert!(h <= part * stable, "{name} at {} s: {h:e} of {stable:e}", runner.time());
    }
    let finite = on!(&runner, simulation => simulation.energy().total().is_finite());
    assert!(finite);
}

macro_rules! ten_seconds {
    ($($name:ident)*) => {
        mod ten_seconds_of {
            $(#[test]
            fn $name() {
                let name = stringify!($name);
                super::stays_in_the_world_and_well_below_the_largest_stable_substep(name);
            })*
            pub const NAMES: &[&str] = &[$(stringify!($name)),*];
        }
    };
}

ten_seconds! {
    cube jelly bunny cloth drape pile flag stairs dice foam mattress snake spinner waffle teapot
    chain square square4
}

/// Scenes of which `touching_scenes.rs` and `gripper.rs` ask the same.
const ELSEWHERE: [&str; 6] = ["trampoline", "twist", "funnel", "knot", "curtain", "gripper"];

#[test]
fn every_built_in_scene_runs_for_ten_seconds() {
    let here = BUILTINS.map(|builtin| builtin.name).into_iter();
    let here: Vec<&str> = here.filter(|name| !ELSEWHERE.contains(name)).collect();
    assert_eq!(here, ten_seconds_of::NAMES);
    assert_eq!(BUILTINS.len(), here.len() + ELSEWHERE.len());
}

#[test]
fn the_foam_comes_down_all_the_stairs() {
    let mut runner = runner("stairs");
    (0..600).for_each(|_| runner.step().expect("a stable run"));
    let positions = positions(&runner);
    let middle = positions.iter().sum::<DVec3>() / positions.len() as f64;
    assert!(2.0 < middle.x && middle.y < 0.6, "{middle}");
}

/// Its free edge stays up and swings to and fro, and the air is booked in the energy balance.
#[test]
fn the_flag_flies() {
    let mut runner = runner("flag");
    let mut witness = Witness::default();
    let (rows, columns) = (21, 31);
    let mut swings = Vec::new();
    for step in 0..600 {
        runner.step().expect("a stable run");
        runner.show_to(&mut witness);
        assert_eq!((witness.gain(), witness.surplus()), (0.0, 0.0), "{} s", runner.time());
        // The wind has lifted it by then.
        if 120 <= step {
            let positions = positions(&runner);
            let edge: DVec3 = (0..rows).map(|row| positions[row * columns + columns - 1]).sum();
            let edge = edge / rows as f64;
            assert!(1.7 < edge.y && 0.8 < edge.x, "{edge} at {} s", runner.time());
            swings.push(edge.z);
        }
    }
    let mean = swings.iter().sum::<f64>() / swings.len() as f64;
    let squares: f64 = swings.iter().map(|z| (z - mean) * (z - mean)).sum();
    let swing = (squares / swings.len() as f64).sqrt();
    assert!(0.1 < swing, "{swing} m");
    assert!(0.0 < single(&runner).given());
}

#[test]
fn the_list_has_the_titles_of_the_files_and_the_default_first() {
    assert_eq!(BUILTINS[0].name, "cube");
    for builtin in BUILTINS {
        assert_eq!(open(builtin.name).expect(builtin.name).title, builtin.title);
    }
}

/// A cell turns inside out at a corner where its three edges there, taken in order, form a frame of
/// the other hand.
#[test]
fn the_default_scene_keeps_every_cell_the_right_way_out() {
    let mut runner = runner(BUILTINS[0].name);
    let side = 10;
    for _ in 0..100 {
        run(&mut runner, 0.1);
        let positions = positions(&runner);
        let at = |[i, j, k]: [usize; 3]| positions[(i * side + j) * side + k];
        let cells = (0..(side - 1).pow(3)).flat_map(|cell| {
            let cell = [cell / 81, cell / 9 % 9, cell % 9];
            (0..8).map(move |corner| (cell, [corner >> 2, corner >> 1 & 1, corner & 1]))
        });
        for (cell, corner) in cells {
            let corner_of = |turned: Option<usize>| {
                let place = |axis| corner[axis] ^ usize::from(turned == Some(axis));
                at([0, 1, 2].map(|axis| cell[axis] + place(axis)))
            };
            let edges = [0, 1, 2].map(|axis| corner_of(Some(axis)) - corner_of(None));
            // The axes along which a block is numbered are a left-handed frame.
            let sign = if corner.iter().sum::<usize>() % 2 == 0 { -1.0 } else { 1.0 };
            // The lattice may be numbered along the axes in either sense.
            let volume = sign * edges[0].cross(edges[1]).dot(edges[2]);
            assert!(0.2 < volume, "{volume} m3 of 1 at {cell:?} {corner:?}, {} s", runner.time());
        }
    }
}

#[test]
fn the_lattices_of_the_source_report_have_their_sizes() {
    // Springs of r x c x s particles with 26 neighbours: 13 families, counted by hand for 3x3x3:
    // 3 x 18 axes, 6 x 12 face diagonals, 4 x 8 space diagonals = 54 + 72 + 32.
    for (name, particles, springs) in [
        ("mattress", 20 * 7 * 2, 2064),
        ("dice", 27, 158),
        ("snake", 1600, 8784),
        ("cloth", 961, 3660),
        ("foam", 343, 3258),
        ("spinner", 27, 158),
        ("jelly", 1000, 10476),
        ("waffle", 160, 1152),
        ("chain", 5, 4),
        ("square", 16, 42),
        ("square4", 16, 24),
    ] {
        let runner = runner(name);
        assert_eq!(
            (runner.particle_count(), runner.spring_count()),
            (particles, springs),
            "{name}"
        );
    }
}

#[test]
fn the_chain_settles_around_its_unmoved_centre_of_mass() {
    let mut runner = runner("chain");
    let centre = |runner: &Runner| single(runner).centre_of_mass(0..5);
    let start = centre(&runner);
    assert!((start.x - 11.4 / 5.0).abs() < 1e-6);
    run(&mut runner, 25.0);
    // Springs pull both ends alike: only the rounding of 25 s x 60 x 4 substeps is left. Each adds
    // at most half a unit in the last place of about 4 m, as in a random walk.
    assert!((centre(&runner) - start).length() < 0.5 * 4.8e-7 * f64::sqrt(6000.0) * 5.0);
    // The slowest mode dies out as exp(−b/m (1 − cos(π/5)) t) = exp(−0.191 · 25) = 0.0085.
    for (row, position) in positions(&runner).iter().enumerate() {
        let rest = start.x + row as f64 - 2.0;
        assert!((position.x - rest).abs() < 0.0085 * 1.4, "particle {row} at {position}");
        assert_eq!((position.y, position.z), (0.0, 0.0));
    }
}

#[test]
fn the_wave_of_the_chain_takes_its_time_to_the_other_end() {
    let mut runner = runner("chain");
    run(&mut runner, 0.1);
    // After a tenth of a second, sqrt(k/m) t = 0.32: the fourth neighbour moves as t to the eighth.
    assert!(positions(&runner)[0].x.abs() < 1e-4);
    run(&mut runner, 1.9);
    assert!(0.1 < positions(&runner)[0].x);
}

/// Area inside the rim of a sheet of 4 x 4 particles in the plane z = 0 (Gauss's formula).
fn area(positions: &[DVec3]) -> f64 {
    let rim = [0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4];
    let corner = |side: usize| positions[rim[side % rim.len()]];
    let twice: f64 = (0..rim.len())
        .map(|side| corner(side).x * corner(side + 1).y - corner(side + 1).x * corner(side).y)
        .sum();
    0.5 * twice.abs()
}

#[test]
fn the_square_with_diagonals_keeps_its_shape_and_the_one_without_collapses() {
    // The square comes to rest under its weight; Dormand-Prince with a tolerance of 1e-8 ends with
    // an area of 7.684 m². Its bounces after 10 s change the area by less than a hundredth of that.
    for (name, least, most) in [("square", 7.61, 7.76), ("square4", 0.0, 0.25 * 9.0)] {
        let mut runner = runner(name);
        assert!((area(&positions(&runner)) - 9.0).abs() < 1e-4);
        run(&mut runner, 10.0);
        let area = area(&positions(&runner));
        assert!((least..=most).contains(&area), "{name}: {area} of 9 m²");
    }
}

#[test]
fn the_pins_of_the_cloth_do_not_move_and_the_rest_does() {
    let mut runner = runner("cloth");
    let before = positions(&runner);
    run(&mut runner, 2.0);
    let after = positions(&runner);
    for particle in [930, 945, 960] {
        assert_eq!(before[particle], after[particle]);
        assert_eq!(before[particle].y, 15.0);
    }
    assert!(after.iter().zip(&before).filter(|(a, b)| a == b).count() == 3);
}

#[test]
fn the_foam_sticks_to_the_wall_where_the_dice_bounces() {
    let mut foam = runner("foam");
    run(&mut foam, 1.5);
    let on_wall = positions(&foam).iter().filter(|position| position.z <= -25.0 + 1e-5).count();
    assert!(7 <= on_wall, "{on_wall} particles on the wall");
    let mut dice = runner("dice");
    run(&mut dice, 2.0);
    assert!(positions(&dice).iter().all(|position| -40.0 <= position.z && -40.0 <= position.x));
    let momentum = dice.momentum().linear;
    assert!(0.0 < momentum.x && 0.0 < momentum.z, "{momentum}");
}

#[test]
fn the_cloth_drapes_the_ball_and_does_not_pass_through_it() {
    let mut drape = runner("drape");
    run(&mut drape, 4.0);
    let middle = DVec3::new(0.0, 0.8, 0.0);
    let gaps: Vec<f64> = positions(&drape).iter().map(|x| (*x - middle).length() - 0.8).collect();
    // To a few roundings of a coordinate of a metre.
    assert!(gaps.iter().all(|&gap| -1e-6 < gap));
    let on_ball = gaps.iter().filter(|&&gap| gap < 1e-6).count();
    assert!(100 < on_ball, "{on_ball} particles on the ball");
    assert!(single(&drape).energy().kinetic < 0.1);
}

/// Each of the dozen lies higher than half its height, and inside the walls.
#[test]
fn the_pile_bears_what_lies_on_it() {
    let mut pile = runner("pile");
    run(&mut pile, 6.0);
    let simulation = single(&pile);
    let bodies = simulation.model().bodies();
    let middles = bodies.iter().map(|body| simulation.centre_of_mass(body.particles.clone()));
    let mut heights: Vec<f64> = middles.map(|middle| middle.y).collect();
    heights.sort_by(f64::total_cmp);
    assert!(0.08 < heights[0], "the lowest is squashed: {heights:?}");
    // Twelve of about 0.3 m each way do not fit into a square of 1 m side by side.
    assert!(0.3 < heights[11], "nothing lies on anything: {heights:?}");
    assert!(positions(&pile).iter().all(|x| x.x.abs() < 0.501 && x.z.abs() < 0.501 && -1e-5 < x.y));
}

#[test]
fn the_snake_stands_and_then_falls() {
    let mut runner = runner("snake");
    let height = |runner: &Runner| positions(runner).iter().map(|p| p.y).fold(f64::MIN, f64::max);
    assert_eq!(height(&runner), 394.0);
    run(&mut runner, 0.5);
    assert!(390.0 < height(&runner));
    run(&mut runner, 9.5);
    assert!(height(&runner) < 200.0);
}

#[test]
fn the_bunny_is_squashed_as_it_lands_and_stands_up_again_with_its_ears_up() {
    let mut runner = runner("bunny");
    let heights = |runner: &Runner| positions(runner).iter().map(|p| p.y).collect::<Vec<_>>();
    let bounds = |heights: &[f64]| {
        let low = heights.iter().copied().fold(f64::MAX, f64::min);
        (low, heights.iter().copied().fold(f64::MIN, f64::max) - low)
    };
    let start = heights(&runner);
    let (low, standing) = bounds(&start);
    // The upper twentieth are the tips of the ears alone.
    let tips: Vec<usize> =
        (0..start.len()).filter(|&row| low + 0.95 * standing < start[row]).collect();
    // Fractions of the standing height: where the lower of the tips is, and the highest particle.
    let shape = |runner: &Runner| {
        let heights = heights(runner);
        let (low, height) = bounds(&heights);
        let tip = tips.iter().map(|&row| heights[row]).fold(f64::MAX, f64::min);
        // On the ground at y = 0, but for the rounding of a way of less than a metre.
        assert!(low.abs() <= f64::from(f32::EPSILON), "{low}");
        ((tip - low) / standing, height / standing)
    };
    run(&mut runner, 0.7);
    let (_, height) = shape(&runner);
    assert!(height < 0.85, "landing: {height}");
    run(&mut runner, 0.3);
    let (tip, height) = shape(&runner);
    assert!(0.8 < tip && height < 0.95, "one second: {tip} of {height}");
    run(&mut runner, 9.0);
    let (tip, height) = shape(&runner);
    assert!(0.75 < tip && 0.85 < height && height < 1.05, "at last: {tip} of {height}");
}

#[test]
fn bounces_add_less_than_a_hundredth_of_the_energy() {
    for name in ["dice", "waffle"] {
        let mut runner = runner(name);
        let start = single(&runner).energy();
        let mut most = start.kinetic + start.elastic;
        // Ten seconds: both have come to rest by then.
        for _ in 0..600 {
            runner.step().expect("a built-in scene stays in the world");
            let energy = single(&runner).energy();
            most = most.max(energy.kinetic + energy.elastic);
        }
        let added = single(&runner).energy().total() - start.total();
        assert!(added < 0.01 * most, "{name}: {added} J of {most} J");
    }
}

/// On a floor that returns every bounce in full; its dampers are weak.
#[test]
fn the_jelly_comes_to_rest_and_its_dampers_book_what_it_loses() {
    let mut runner = runner("jelly");
    let start = single(&runner).energy();
    let all = start.kinetic + start.elastic + start.gravitational;
    run(&mut runner, 30.0);
    let before = single(&runner).energy();
    run(&mut runner, 10.0);
    let after = single(&runner).energy();
    assert!(after.kinetic < 1e-5 * all, "{} J of {all} J", after.kinetic);
    let lost = after.dissipated - before.dissipated;
    let error = after.total() - before.total();
    // A hundredth of the loss: 0.07 J of 13 J is the error of 4800 substeps in f32.
    assert!(error.abs() < 0.01 * lost, "{error} J of {lost} J");
}
