//! The error of space agrees with a closed form, and advice and tuning follow from it.

use msd_core::glam::DVec3;
use msd_run::Runner;
use msd_scene::{AnyState, Draft, Precision};
use msd_study::conduct::{Plan, add_space, study};
use msd_study::reference::{Wish, make_reference};
use msd_study::space::{Space, SpacePlan, Verdict, space};
use msd_study::tune::tune_spacing;
use std::path::Path;

/// Length of the bar, metres.
const LENGTH: f64 = 1.0;
/// Speed of sound in it, metres per second: √(E/ρ).
const SOUND: f64 = 10.0;
const RELAXATION: f64 = 4e-3;
const GRAVITY: f64 = 9.82;
/// Cells of the bar as written.
const CELLS: usize = 10;
const DURATION: f64 = 0.5;

/// A bar that is held at one end and starts to hang along x, of so many cells.
fn bar(cells: usize, solver: &str) -> String {
    format!(
        "version = 1\n[solver]\n{solver}\n[world]\ngravity = [{GRAVITY}, 0, 0]\n\
         [[bodies]]\nkind = 'rope'\nsize = [{}]\nspacing = {}\nyoung = 1e5\ndensity = 1000\n\
         diameter = 0.01\nrelaxation_time = {RELAXATION}\nposition = [{}, 0, 0]\n\
         [[pins]]\nat = [0, 0, 0]\n",
        cells + 1,
        LENGTH / cells as f64,
        0.5 * LENGTH
    )
}

fn draft(text: &str) -> Draft {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    Draft::open(Path::new("scene.toml"), folder.path()).unwrap()
}

/// Position of the point of the bar that was at `x`, at a time, by its modes: each an oscillator
/// with damping ratio w τ/2 under a constant load. Springs in line are linear, so this is exact.
fn exact(x: f64, time: f64) -> f64 {
    let mode = |n: usize| {
        let k = (n as f64 - 0.5) * std::f64::consts::PI / LENGTH;
        let (w, load) = (k * SOUND, 2.0 * GRAVITY / (LENGTH * k));
        let half = 0.5 * w * w * RELAXATION;
        let beat = w * w - half * half;
        let left = if 0.0 < beat {
            let beat = beat.sqrt();
            (-half * time).exp() * ((beat * time).cos() + half / beat * (beat * time).sin())
        } else {
            let root = (-beat).sqrt();
            let (slow, fast) = (root - half, -root - half);
            (slow * (fast * time).exp() - fast * (slow * time).exp()) / (slow - fast)
        };
        load / (w * w) * (1.0 - left) * (k * x).sin()
    };
    // The n-th mode has a part of n⁻³.
    x + (1..=2000).map(mode).sum::<f64>()
}

/// Root mean square distance of the points of the bar as written from their exact positions;
/// `positions` are those of a bar of so many parts to a cell.
fn off(positions: &[DVec3], parts: usize, time: f64) -> f64 {
    let points = 0..=CELLS;
    let square = |point: usize| {
        let x = point as f64 * LENGTH / CELLS as f64;
        let right = DVec3::X * exact(x, time);
        positions[point * parts].distance_squared(right)
    };
    (points.map(square).sum::<f64>() / (CELLS + 1) as f64).sqrt()
}

fn found(cells: usize) -> Space {
    let plan = SpacePlan { duration: DURATION, ..SpacePlan::default() };
    space(&draft(&bar(cells, "")), plan, &mut ()).unwrap()
}

#[test]
fn the_error_of_space_of_a_hanging_bar_is_that_of_the_closed_form() {
    let space = found(CELLS);
    let Verdict::Known { error, band, order, is_seen, until } = space.verdict else {
        panic!("{space:?}")
    };
    let scene =
        msd_scene::parse(&bar(CELLS, ""), msd_scene::SceneFormat::Toml, "bar").unwrap().scene;
    let wish = Wish { duration: DURATION, ..Wish::default() };
    let right = make_reference(&scene, wish, &mut ()).unwrap();
    let rows = right.frames.iter().zip(&right.states);
    let errors = rows.map(|(&frame, state)| off(&state.positions, 1, frame as f64 / 60.0));
    let truth = errors.fold(0.0, f64::max);
    println!("{}: error {error:e}, band {band:e}, truth {truth:e}, order {order}", space.words());
    assert!((error - truth).abs() <= band, "{error} ± {band}, {truth}");
    // Linear elements with lumped masses; the highest modes are damped.
    assert!(is_seen && (order - 2.0).abs() < 0.15, "{order}");
    assert!((until - DURATION).abs() < 1e-9);
    assert_eq!((space.points, space.spacings.len()), (CELLS + 1, 3));
    // The same bar at half the spacing has the error that was predicted for it.
    let finer = found(2 * CELLS).error().unwrap();
    let told = space.spacings[1].error.unwrap();
    assert!((finer / told - 1.0).abs() < 0.3, "{finer} {told}");
}

#[test]
fn without_the_time_for_a_finer_spacing_it_says_so() {
    let plan = SpacePlan { duration: 0.4, budget: 1e-9, ..SpacePlan::default() };
    let space = space(&draft(&bar(7, "")), plan, &mut ()).unwrap();
    assert_eq!(space.verdict, Verdict::Untold);
    assert!(
        space.words().contains("is not known: 1/2 of the spacing takes about"),
        "{}",
        space.words()
    );
}

fn advice(text: &str, duration: f64) -> (String, msd_study::Study) {
    let draft = draft(text);
    let loaded = draft.load(&draft.source().unwrap()).unwrap();
    let plan = Plan { duration, budget: 5.0, fresh: true, ..Plan::default() };
    let mut studied = study(&loaded, plan, &mut ()).unwrap().0;
    let plan = Plan { budget: 60.0, ..plan };
    add_space(&mut studied, &draft, plan, &mut ()).unwrap();
    let balance = studied.balance.clone().unwrap();
    println!("{}\n{}", balance.advice, studied.space_line());
    (balance.advice, studied)
}

#[test]
fn a_block_that_falls_freely_loses_nothing_by_its_spacing() {
    // The runs differ by the error of time that their tolerance leaves.
    let text = "version = 1\n[solver]\nprecision = 'f64'\n[[bodies]]\nkind = 'block'\n\
                size = [2, 5, 2]\nspacing = 0.1\nyoung = 1e5\ndensity = 1000\n";
    let plan = SpacePlan { duration: 0.25, ..SpacePlan::default() };
    let space = space(&draft(text), plan, &mut ()).unwrap();
    let Verdict::Below { error } = space.verdict else { panic!("{:?}", space.verdict) };
    // Of a fall of 0.3 m.
    assert!(error < 1e-6, "{error}");
}

#[test]
fn a_coarse_beam_wants_a_finer_mesh() {
    // One cell thick it is half again too fast; half a period.
    let mut text = "version = 1\n[solver]\nprecision = 'f64'\n[[bodies]]\nkind = 'block'\n\
                    size = [2, 9, 2]\nspacing = 0.1\nyoung = 1e7\ndensity = 1000\n\
                    relaxation_time = 1e-3\n"
        .to_owned();
    for at in ["[0, 0, 0]", "[1, 0, 0]", "[0, 0, 1]", "[1, 0, 1]"] {
        text += &format!("[[pins]]\nat = {at}\n");
    }
    let (advice, studied) = advice(&text, 0.25);
    assert!(advice.starts_with("refine the mesh"), "{advice}");
    let balance = studied.balance.unwrap();
    let (space, time) = (balance.space.unwrap(), balance.time.unwrap());
    assert!(10.0 * time.error < space.error && space.left < space.error);
}

#[test]
fn a_fine_bar_in_long_steps_wants_shorter_ones() {
    let solver = "integrator = 'backward-euler'\nsubsteps = 1\nprecision = 'f64'";
    let (advice, studied) = advice(&bar(20, solver), DURATION);
    assert!(advice.starts_with("shorten the step"), "{advice}");
    // Of first order: half the step has half the error.
    let time = studied.balance.unwrap().time.unwrap();
    assert!((0.35..0.75).contains(&(time.left / time.error)), "{time:?}");
}

#[test]
fn tuning_keeps_the_sum_of_the_errors_within_the_goal() {
    let draft = draft(&bar(CELLS, ""));
    let own = found(CELLS).error().unwrap();
    let plan = SpacePlan { duration: DURATION, ..SpacePlan::default() };
    for (goal, parts) in [(2.0, 1), (0.5, 2), (0.2, 4), (1e-3, 0)] {
        let wanted = goal * own;
        let tuned = tune_spacing(&draft, plan, wanted, &mut ()).unwrap();
        let Some(best) = &tuned.found else {
            assert_eq!(parts, 0, "{:?}", tuned.space);
            continue;
        };
        assert_eq!(best.parts, parts);
        assert!(tuned.is_met() && best.verified + tuned.doubt <= wanted, "{best:?}");
        // Once more, against the closed form, which knows nothing of extrapolation.
        let source = draft.source().unwrap();
        let scene = match parts {
            1 => draft.load(&source).unwrap().scene,
            _ => {
                let coarse = draft.load(&source).unwrap().scene;
                draft.finer(&source, &coarse, parts.ilog2()).unwrap().loaded.scene
            }
        };
        let choice = best.tuned.best.trial.choice;
        let mut runner = Runner::new(&scene, choice.settings(), choice.precision).unwrap();
        let mut truth = 0.0f64;
        while runner.time() < DURATION - 1e-9 {
            runner.step().unwrap();
            let AnyState::F64(state) = runner.convert(Precision::F64).unwrap().state() else {
                unreachable!("it was converted")
            };
            truth = truth.max(off(&state.positions, parts as usize, runner.time()));
        }
        println!("wanted {wanted:e}: 1/{parts}, {choice}: {truth:e}, verified {:e}", best.verified);
        assert!(truth <= wanted, "{truth} {wanted}");
    }
}
