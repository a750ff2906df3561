//! The past of a session: looking back and resuming from there, undo, and a twin beside the run.

use crate::frames::{run, session};
use msd_app::session::{Deed, MarkKind, MaterialEdit, Session, Wind};
use msd_core::glam::DVec3;
use msd_core::{Integrator, Real, Settings, Vector};
use msd_run::on;
use msd_scene::schema::SolverRow;
use msd_scene::{Precision, state_hash};

/// Returns the number of steps, and the hash of the state.
fn now(session: &Session) -> (u64, u64) {
    (session.runner().steps(), state_hash(&session.runner().state()))
}

fn stiffness(session: &Session) -> f64 {
    on!(session.runner(), simulation => simulation.model().stiffness(0).to_f64())
}

fn rest_length(session: &Session) -> f64 {
    on!(session.runner(), simulation => simulation.model().rest_lengths()[7].to_f64())
}

#[test]
fn looking_back_shows_the_very_states_and_drops_none() {
    let mut session = session("jelly");
    let mut seen = vec![now(&session)];
    for _ in 0..50 {
        run(&mut session, 1);
        seen.push(now(&session));
    }
    for back in [20, 50, 3, 1, 49, 0, 1000] {
        session.look_back(back);
        let back = back.min(50);
        assert_eq!(now(&session), seen[50 - back]);
        assert_eq!((session.steps_ahead(), session.steps_back()), (back, 50 - back));
        assert!(session.is_paused());
    }
    // A step forward or back moves along the kept states.
    session.step_forward();
    session.step_forward();
    assert!(session.step_back());
    assert_eq!((now(&session), session.steps_ahead()), (seen[1], 49));
}

#[test]
fn going_on_drops_what_came_after_and_has_the_same_bits() {
    let mut session = session("jelly");
    run(&mut session, 30);
    let end = now(&session);
    session.look_back(12);
    session.toggle_pause();
    run(&mut session, 2);
    assert_eq!((session.runner().steps(), session.steps_ahead()), (19, 0));
    run(&mut session, 11);
    assert_eq!(now(&session), end);
    session.look_back(12);
    session.edit(MaterialEdit::Stiffness(900.0));
    assert_eq!(
        (session.runner().steps(), session.steps_ahead(), session.steps_back()),
        (18, 0, 18)
    );
}

#[test]
fn six_hundred_states_are_kept() {
    let mut session = session("chain");
    run(&mut session, 700);
    session.look_back(10_000);
    assert_eq!((session.runner().steps(), session.steps_ahead()), (100, 600));
    session.look_back(0);
    assert_eq!((session.runner().steps(), session.steps_back()), (700, 600));
}

#[test]
fn impacts_warnings_and_edits_are_marked() {
    let mut session = session("square");
    let is_marked = |session: &Session, kind| session.marks().any(|mark| mark.kind == kind);
    run(&mut session, 30);
    session.edit(MaterialEdit::Gravity(30.0));
    let edit = session.marks().last().expect("the edit is marked");
    assert_eq!((edit.kind, edit.step), (MarkKind::Edit, 30));
    assert!(!is_marked(&session, MarkKind::Impact));
    for _ in 0..300 {
        if !is_marked(&session, MarkKind::Impact) {
            run(&mut session, 1);
        }
    }
    let impact = session.marks().last().expect("it falls on the floor");
    assert_eq!((impact.kind, impact.step), (MarkKind::Impact, session.runner().steps()));
    assert!(!is_marked(&session, MarkKind::Warning));
    session.edit(MaterialEdit::Stiffness(3e5));
    run(&mut session, 3);
    assert!(is_marked(&session, MarkKind::Warning), "over the limit");
    session.look_back(session.runner().steps() as usize - 20);
    session.toggle_pause();
    // The first frame after a pause takes no steps.
    run(&mut session, 2);
    // Dropped states have no marks, and the springs are still too stiff.
    let marks: Vec<_> = session.marks().map(|mark| (mark.step, mark.kind)).collect();
    assert_eq!(marks, [(21, MarkKind::Warning)]);
}

#[test]
fn a_slider_is_put_back_where_it_was_taken() {
    let mut session = session("jelly");
    // A drag over two seconds, then another.
    for frame in 0..120 {
        session.edit(MaterialEdit::Stiffness(2000.0 + f64::from(frame)));
        run(&mut session, 1);
    }
    run(&mut session, 70);
    session.edit(MaterialEdit::Stiffness(50.0));
    let state = now(&session);
    session.undo();
    assert_eq!((stiffness(&session), now(&session)), (2119.0, state));
    session.undo();
    assert_eq!((stiffness(&session), now(&session)), (2200.0, state));
    assert!(session.undoes().is_none() && !session.material().is_edited());
    session.undo();
    session.redo();
    session.redo();
    assert_eq!((stiffness(&session), session.redoes()), (50.0, None));
    assert_eq!(session.material().values().stiffness.map(|value| value.first), Some(50.0));
    session.undo();
    session.restart();
    assert_eq!(stiffness(&session), 2119.0, "a restart keeps what is set");
    assert!(session.undoes().is_none());
}

#[test]
fn pins_cuts_and_frozen_shapes_are_undone_and_the_motion_goes_on() {
    let mut session = session("cloth");
    run(&mut session, 20);
    let is_cut =
        |session: &Session| on!(session.runner(), simulation => simulation.model().is_cut(7));
    let (at_rest, precision) = (rest_length(&session), session.runner().precision());
    session.pin_toggle(3);
    run(&mut session, 5);
    session.cut(&[7, 8]);
    run(&mut session, 5);
    session.freeze();
    run(&mut session, 5);
    assert!(session.is_pinned(3) && is_cut(&session));
    session.undo();
    assert!((rest_length(&session) - at_rest).abs() < 1e-6 && is_cut(&session));
    session.undo();
    assert!(session.is_pinned(3) && !is_cut(&session));
    run(&mut session, 5);
    session.undo();
    assert!(!session.is_pinned(3));
    assert_eq!((session.runner().steps(), session.runner().precision()), (40, precision));
    run(&mut session, 30);
    assert!(session.failure().is_none());
    session.redo();
    assert!(session.is_pinned(3));
}

#[test]
fn what_was_refused_is_not_undone_and_a_hand_lets_go() {
    let mut session = session("jelly");
    session.edit(MaterialEdit::Mass(-1.0));
    assert!(session.undoes().is_none());
    session.grab(5, session.position(5));
    session.edit(MaterialEdit::Mass(2.0));
    run(&mut session, 3);
    session.undo();
    let grabs = on!(session.runner(), simulation => simulation.model().grabs().len());
    assert_eq!((session.held(), grabs), (None, 0));
}

#[test]
fn what_was_set_of_the_solver_is_undone_and_the_model_of_now_stays() {
    let mut session = session("jelly");
    let solver = |session: &Session| {
        let runner = session.runner();
        (runner.settings(), runner.precision(), runner.is_automatic())
    };
    let start = solver(&session);
    let deeds: [(SolverRow, &str); 5] = [
        (SolverRow::integrator(Integrator::Rk4), "method"),
        (SolverRow::substeps(37), "substeps"),
        (SolverRow::precision(Precision::F64), "precision"),
        (SolverRow::automatic(), "automatic substeps"),
        (SolverRow::integrator(Integrator::DormandPrince), "method"),
    ];
    let mut seen = vec![start];
    for (tuning, words) in deeds {
        session.tune(tuning);
        assert_eq!(session.undoes(), Some(Deed::Solver(words)));
        run(&mut session, 3);
        seen.push(solver(&session));
    }
    // An edit between them is undone separately.
    session.edit(MaterialEdit::Stiffness(1234.0));
    session.tune(SolverRow::tolerance(1e-5));
    session.undo();
    assert_eq!((stiffness(&session), solver(&session)), (1234.0, seen[5]));
    session.undo();
    assert_eq!((stiffness(&session), solver(&session)), (2200.0, seen[5]));
    let (steps, _) = now(&session);
    session.edit(MaterialEdit::Stiffness(2100.0));
    session.undo();
    for before in seen[..5].iter().rev() {
        session.undo();
        assert_eq!(solver(&session), *before);
        assert_eq!((stiffness(&session), session.runner().steps()), (2200.0, steps));
    }
    assert_eq!(session.undoes(), None);
    for after in &seen[1..] {
        session.redo();
        assert_eq!(solver(&session), *after);
    }
    // A refused edit adds no undo step, and undo returns a dragged slider to its start.
    while session.undoes().is_some() {
        session.undo();
    }
    session.tune(SolverRow::substeps(0));
    assert!(session.refusal().is_some() && session.undoes().is_none());
    for substeps in 9..60 {
        session.tune(SolverRow::substeps(substeps));
        run(&mut session, 1);
    }
    session.undo();
    assert_eq!((solver(&session), session.undoes()), (start, None));
}

fn force(session: &Session) -> DVec3 {
    on!(session.runner(), simulation => simulation.model().force().to_f64())
}

#[test]
fn undo_of_a_wind_turns_it_back_and_of_anything_else_leaves_it() {
    let mut session = session("cloth");
    run(&mut session, 5);
    session.set_wind(Wind { strength: 2.0, ..Wind::default() });
    session.cut(&[7]);
    assert_eq!(session.undoes(), Some(Deed::Cut));
    session.undo();
    run(&mut session, 2);
    assert_eq!((force(&session), session.undoes()), (DVec3::X * 2.0, Some(Deed::Wind)));
    let before = session.runner().steps();
    session.undo();
    run(&mut session, 2);
    // The motion continues.
    assert_eq!((force(&session), session.runner().steps()), (DVec3::ZERO, before + 2));
    assert_eq!((session.wind(), session.undoes()), (Wind::default(), None));
    session.redo();
    run(&mut session, 2);
    assert_eq!((force(&session), session.wind().strength), (DVec3::X * 2.0, 2.0));
}

#[test]
fn undo_stops_a_pin_that_was_moved() {
    let mut session = session("cloth");
    run(&mut session, 5);
    let pin = (0..961).find(|&row| session.is_pinned(row)).expect("the cloth hangs");
    session.grab(pin, session.position(pin) + DVec3::X);
    run(&mut session, 3);
    session.freeze();
    session.release();
    session.undo();
    let there = session.position(pin);
    run(&mut session, 10);
    assert_eq!(session.position(pin), there);
}

#[test]
fn automatic_substeps_of_another_model_do_not_come_back() {
    let mut session = session("jelly");
    session.tune(SolverRow::automatic());
    let substeps = |session: &Session| session.runner().settings().substeps;
    let soft = substeps(&session);
    run(&mut session, 20);
    session.edit(MaterialEdit::Stiffness(220_000.0));
    let stiff = substeps(&session);
    // A hundred times as stiff: a tenth of the step, apart from dampers.
    assert!(5 * soft < stiff, "{soft} {stiff}");
    run(&mut session, 5);
    session.look_back(15);
    assert!(5 * soft < substeps(&session), "{}", substeps(&session));
    session.toggle_pause();
    run(&mut session, 1);
    assert!(session.step_back() && 5 * soft < substeps(&session));
}

fn with(session: &Session, integrator: Integrator) -> Settings {
    Settings { integrator, ..session.runner().settings() }
}

/// Performs every user input, within two seconds.
fn handle(session: &mut Session) {
    run(session, 10);
    let there = session.position(7);
    session.grab(7, there);
    for frame in 0..30 {
        session.move_grab(there + DVec3::Y * 0.05 * f64::from(frame));
        run(session, 1);
    }
    session.pin_toggle(3);
    session.release();
    session.edit(MaterialEdit::Stiffness(3000.0));
    session.cut(&[11]);
    run(session, 40);
    session.edit(MaterialEdit::RestScale(1.1));
    run(session, 40);
}

#[test]
fn a_twin_of_the_same_settings_stays_where_the_run_is_whatever_hands_do() {
    let mut session = session("jelly");
    session.set_twin(Some(session.runner().settings()));
    handle(&mut session);
    let twin = session.twin().expect("it is on");
    assert_eq!((twin.apart().max, twin.failure()), (0.0, None));
    assert_eq!(twin.apart().step, session.runner().steps());
    assert!(twin.trace().all(|then| then.rms == 0.0));
}

#[test]
fn a_twin_changes_no_bit_of_the_run() {
    let (mut alone, mut beside) = (session("jelly"), session("jelly"));
    beside.set_twin(Some(with(&beside, Integrator::Rk4)));
    handle(&mut alone);
    handle(&mut beside);
    assert_eq!(now(&alone), now(&beside));
    assert_eq!(alone.runner().energy(), beside.runner().energy());
    let twin = beside.twin().expect("it is on");
    assert!(0.0 < twin.apart().rms && twin.apart().rms <= twin.apart().max);
}

#[test]
fn explicit_euler_leaves_the_world_beside_a_run_that_goes_on() {
    let mut session = session("cube");
    session.set_twin(Some(with(&session, Integrator::ExplicitEuler)));
    let stops = (0..1200).any(|_| {
        run(&mut session, 1);
        session.twin().is_some_and(|twin| twin.failure().is_some())
    });
    assert!(stops);
    let (steps, apart) = (session.runner().steps(), session.twin().expect("it is on").apart());
    let twin = session.twin().expect("it is on");
    assert!(apart.step < steps && apart.step == twin.runner().steps(), "{apart:?}");
    // It shows a state before debris, not particles scattered over a world of 1e6 m.
    let size = on!(session.runner(), simulation => simulation.model().size());
    assert!(apart.max < 2.0 * size, "{apart:?} of {size} m");
    assert!(twin.trace().all(|then| then.step <= apart.step && then.max < 2.0 * size));
    run(&mut session, 20);
    assert_eq!((session.runner().steps(), session.failure()), (steps + 20, None));
    assert_eq!(session.twin().expect("it is on").apart(), apart);
    let told = session.twin().and_then(|twin| twin.failure()).expect("it stopped");
    assert!(told.contains("explicit-euler diverged"), "{told}");
    // It can begin again from the state of the run.
    session.set_twin(Some(with(&session, Integrator::Rk4)));
    assert_eq!(session.twin().map(|twin| twin.apart().rms), Some(0.0));
    session.set_twin(None);
    assert!(session.twin().is_none());
}
