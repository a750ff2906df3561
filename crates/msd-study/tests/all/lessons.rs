//! The answers of the built-in lessons against their closed forms.

use msd_core::glam::DVec2;
use msd_core::{Friction, Simulation};
use msd_run::Runner;
use msd_scene::{LESSONS, Loaded, open, open_set};
use msd_study::lesson::{Grade, Question, read_number};

fn with_question<T>(loaded: &Loaded, act: impl FnOnce(Question<'_>) -> T) -> T {
    let lesson = loaded.lesson.as_deref().expect("a lesson");
    let settings = Runner::open(loaded).expect("it runs").settings();
    act(Question { lesson, scene: &loaded.scene, settings })
}

fn answer(loaded: &Loaded) -> f64 {
    with_question(loaded, |question| question.answer().expect(&loaded.name))
}

/// The error in the place of an oscillator of angular frequency 5 and amplitude 0.4 after 1 s of
/// RK4: its step multiplies the state by the polynomial of degree 4 of exp(i ω h).
fn error_of_rk4(steps: u32) -> f64 {
    let angle = 5.0 / f64::from(steps);
    let square = angle * angle;
    let step =
        DVec2::new(1.0 - square / 2.0 + square * square / 24.0, angle - square * angle / 6.0);
    let end = (0..steps).fold(DVec2::X, |state, _| state.rotate(step));
    0.4 * (end.x - 5.0f64.cos()).abs()
}

#[test]
fn each_answer_has_its_closed_form() {
    let order = (error_of_rk4(10) / error_of_rk4(20)).log2();
    // Nearly all are exact but for rounding. The exact run of `order` has an error of 1e-12 of the
    // size, 1e-7 of the smaller error, and searches for modes end at 1e-6.
    let expected = [
        ("lesson-hooke", 5.0 / core::f64::consts::TAU, 1e-6),
        ("lesson-step", 10.0 * 0.1 * 1.0 / 2.0, 1e-9),
        ("lesson-euler", 1.1f64.powi(20), 1e-9),
        ("lesson-order", order, 1e-6),
        ("lesson-stiffness", 2.0 / 200.0, 1e-6),
        ("lesson-damping", 3.0 / (2.0 * 10.0), 1e-6),
        ("lesson-resolution", 10.0 / (2.0 * 5.0), 1e-6),
        ("lesson-friction", 30f64.to_radians().tan(), 1e-9),
    ];
    assert_eq!(LESSONS.map(|lesson| lesson.name), expected.map(|row| row.0));
    for (name, closed_form, tolerance) in expected {
        let loaded = open(name).expect(name);
        let error = answer(&loaded) / closed_form - 1.0;
        assert!(error.abs() <= tolerance, "{name}: {closed_form}, off by {error:e}");
    }
    assert!((order - 4.0).abs() <= 0.05 * 4.0);
}

#[test]
fn an_answer_follows_the_values_of_the_scene() {
    for (name, set, factor) in [
        ("lesson-hooke", "bodies.0.stiffness=200", 2.0),
        ("lesson-step", "solver.substeps=2", 0.5),
        ("lesson-stiffness", "bodies.0.mass=0.4", 2.0),
        ("lesson-damping", "bodies.0.damping=1.5", 0.5),
        ("lesson-resolution", "world.gravity=[0,-5,0]", 0.5),
    ] {
        let set = msd_scene::Assignment::parse(set).expect(set);
        let ratio = answer(&open_set(name, &[set]).expect(name)) / answer(&open(name).expect(name));
        assert!((ratio - factor).abs() <= 1e-6, "{name}: {ratio}");
    }
}

#[test]
fn each_typical_mistake_has_its_own_reason_and_the_right_answer_passes() {
    for builtin in LESSONS {
        let loaded = open(builtin.name).expect(builtin.name);
        assert_eq!(loaded.title, builtin.title);
        let lesson = loaded.lesson.as_deref().expect("a lesson");
        with_question(&loaded, |question| {
            let right = question.answer().expect("an answer");
            for given in [right, right * (1.0 - 0.9 * lesson.tolerance)] {
                let grade = question.check(given).expect("a grade");
                assert!(matches!(grade, Grade::Right(_)), "{}: {grade:?}", builtin.name);
            }
            let wrong = question.wrong_answers().expect("numbers");
            assert!(3 <= wrong.len());
            for (number, row) in wrong.into_iter().zip(&lesson.mistakes) {
                let grade = question.check(number).expect("a grade");
                assert_eq!(grade, Grade::Wrong(row.says.clone()), "{}", builtin.name);
            }
            for (factor, says) in
                [(17.3, "It is too large."), (1e6, "A power of ten is wrong: check the units.")]
            {
                let grade = question.check(right * factor).expect("a grade");
                assert_eq!(grade, Grade::Wrong(says.into()), "{}", builtin.name);
            }
        });
    }
}

/// How far the block of the lesson slides in 2 s with some friction, metres.
fn slide(loaded: &Loaded, friction: f64) -> f64 {
    let mut scene = loaded.scene.clone();
    scene.planes[0].friction = Friction::Coulomb(friction);
    let settings = Runner::open(loaded).expect("it runs").settings();
    let mut simulation = Simulation::<f64>::new(&scene, settings).expect("it runs");
    let start = simulation.position(13);
    for _ in 0..120 {
        simulation.step().expect("a step");
    }
    (simulation.position(13) - start).length()
}

#[test]
fn the_block_slides_below_the_critical_friction_and_stays_above() {
    let loaded = open("lesson-friction").expect("a lesson");
    let critical = answer(&loaded);
    // Just below it slides with the acceleration g cos θ (tan θ − μ), here by 2 % of tan θ.
    let sliding = 0.5 * 9.82 * 0.5 * 0.02 * 4.0;
    let slow = slide(&loaded, 0.98 * critical);
    assert!(0.5 * sliding < slow, "{slow} of {sliding}");
    // It settles by as much as it is squeezed.
    let still = slide(&loaded, 1.02 * critical);
    assert!(still < 0.1 * sliding, "{still} of {sliding}");
}

#[test]
fn a_scene_without_the_number_says_so() {
    let set = msd_scene::Assignment::parse("world.planes=[]").expect("a value");
    let loaded = open_set("lesson-friction", &[set]).expect("a scene");
    let why = with_question(&loaded, |question| question.check(1.0));
    assert_eq!(why, Err("this scene has no plane".into()));
    let set = msd_scene::Assignment::parse("lesson.time=1e9").expect("a value");
    let long = open_set("lesson-euler", &[set]).expect("a scene");
    assert!(
        with_question(&long, |question| question.answer())
            .is_err_and(|why| why.contains("too long"))
    );
}

#[test]
fn a_number_is_read_as_people_type_it() {
    for text in ["0.8", " 0,8 ", "0.8 Hz", "0,8Hz", "8e-1"] {
        assert_eq!(read_number(text, "Hz"), Ok(0.8), "{text}");
    }
    for text in ["", "Hz", "eight", "inf", "0.8 m"] {
        assert_eq!(read_number(text, "Hz"), Err("Type a number, such as 1.5 Hz".into()), "{text}");
    }
    assert_eq!(read_number("2", ""), Ok(2.0));
}
