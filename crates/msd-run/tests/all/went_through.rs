//! Bodies that go through each other are named, with the time.

use msd_core::Integrator;
use msd_run::Runner;
use msd_scene::{Loaded, SceneFormat, parse};

/// A sheet is pressed by a box through another one, which is pinned, in the plane y = 0. The box
/// arrives there after 0.40074 s.
const PRESSED: &str = include_str!("../scenes/pressed.toml");
const ARRIVAL: f64 = 0.20037 / 0.5;

fn pressed() -> Loaded {
    parse(PRESSED, SceneFormat::Toml, "pressed").expect("a scene")
}

fn run(runner: &mut Runner, steps: usize) {
    (0..steps).for_each(|_| runner.step().expect("a step"));
}

/// Asserts that the ball went through the bed in a step around the arrival.
fn went(runner: &Runner, what: &str) {
    let [went] = &runner.went_through()[..] else {
        panic!("{what}: {:?}", runner.went_through());
    };
    assert_eq!(went.to_string(), "ball went through bed", "{what}");
    let step = runner.settings().step;
    assert!((went.time - ARRIVAL).abs() <= step, "{what}: at {} s", went.time);
    assert!(0 < runner.passes(), "{what}");
}

#[test]
fn a_ball_that_is_pressed_through_a_bed_is_named_with_the_time() {
    for integrator in Integrator::ALL.into_iter().filter(|method| method.lets_shells_meet()) {
        let mut loaded = pressed();
        loaded.settings.integrator = integrator;
        let mut runner = Runner::open(&loaded).expect("a valid scene");
        run(&mut runner, 23);
        assert!(runner.went_through().is_empty() && runner.passes() == 0, "{integrator}");
        run(&mut runner, 7);
        went(&runner, integrator.name());
    }
}

/// A step that is taken again keeps the findings of the step before. So does a run that returns.
#[test]
fn automatic_substeps_and_a_run_that_returns_name_it_too() {
    let loaded = Loaded { automatic: true, ..pressed() };
    let mut runner = Runner::open(&loaded).expect("a valid scene");
    run(&mut runner, 30);
    went(&runner, "automatic substeps");
    for steps in 22..30 {
        let mut straight = Runner::open(&pressed()).expect("a valid scene");
        run(&mut straight, steps);
        let moment = straight.moment();
        let mut resumed = Runner::open(&pressed()).expect("a valid scene");
        resumed.go_back(&moment).expect("a state");
        run(&mut straight, 30 - steps);
        run(&mut resumed, 30 - steps);
        went(&resumed, "resumed");
        let [a, b] = [&straight, &resumed].map(|runner| (runner.passes(), runner.went_through()));
        assert_eq!(a, b, "resumed after {steps} steps");
    }
}
