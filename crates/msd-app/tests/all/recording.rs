//! Recordings of sessions: a replay repeats all user input in the window, to the last bit.

use crate::frames::{run, session};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::panel::{self, theme};
use msd_app::session::{MaterialEdit, Session, Wind};
use msd_app::viewer::{Viewer, catalogue};
use msd_core::glam::DVec3;
use msd_core::{Friction, Integrator, Interaction};
use msd_run::recording::{Event, Recording, load_recording};
use msd_run::replay::Replay;
use msd_run::rescue::Origin;
use msd_scene::schema::SolverRow;
use msd_scene::{Precision, open, state_hash};
use std::path::Path;

/// Returns the end of a replay: steps, time, and the hash of the state.
fn replayed(recording: &Recording) -> (u64, f64, u64) {
    let mut replay = Replay::new(recording, SolverRow::default()).expect("a start");
    while replay.advance().expect("a step") {}
    let runner = replay.runner();
    (runner.steps(), runner.time(), state_hash(&runner.state()))
}

/// Records user input in a session, and compares its end with that of the replay.
fn happens_again(mut session: Session, what: impl FnOnce(&mut Session)) -> Recording {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.msdrec");
    session.start_recording(&path);
    assert!(session.recording().is_some(), "{:?}", session.refusal());
    what(&mut session);
    session.stop_recording();
    assert_eq!((session.recording(), session.refusal()), (None, None));
    let recording = load_recording(&path).expect("a recording");
    let runner = session.runner();
    let end = (runner.steps(), runner.time(), state_hash(&runner.state()));
    assert_eq!(replayed(&recording), end);
    assert_eq!(recording.hash(), Some(end.2));
    recording
}

#[test]
fn a_throw_is_replayed_to_the_bit() {
    let mut session = session("jelly");
    run(&mut session, 20);
    let recording = happens_again(session, |session| {
        run(session, 3);
        let at = session.position(400);
        session.grab(400, at);
        for frame in 1..30 {
            session.move_grab(at + DVec3::new(0.0, 0.1, 0.05) * f64::from(frame));
            run(session, 1);
        }
        session.release();
        run(session, 10);
        // The clock drops the time that it cannot catch up with; a pause stops it.
        session.advance(10.0, &|| 0.0);
        session.toggle_pause();
        run(session, 10);
        session.step_forward();
        session.toggle_pause();
        session.set_speed(0.25);
        run(session, 10);
    });
    assert!(40 < recording.steps());
}

#[test]
fn a_solid_that_is_dragged_through_a_cloth_is_replayed_to_the_bit() {
    let mut session = session("drape");
    run(&mut session, 30);
    let recording = happens_again(session, |session| {
        session.grab_solid(0);
        let at = session.grab_target().expect("it is held");
        for frame in 1..20 {
            session.move_grab(at + DVec3::new(0.02, 0.05, 0.0) * f64::from(frame));
            run(session, 1);
        }
        session.release();
        run(session, 10);
    });
    let is_move = |event: &&Event| matches!(event, Event::Act(Interaction::MoveSolid { .. }));
    // Grabbed, moved before each step, and released.
    assert_eq!(recording.events.iter().filter(is_move).count(), 1 + 19 + 1);
}

#[test]
fn sliders_pins_and_solvers_are_replayed_to_the_bit() {
    happens_again(session("cloth"), |session| {
        run(session, 5);
        session.edit(MaterialEdit::Stiffness(700.0));
        session.edit(MaterialEdit::Damping(0.3));
        session.edit(MaterialEdit::Gravity(5.0));
        session.edit(MaterialEdit::RestScale(1.1));
        session.pin_toggle(40);
        run(session, 5);
        // A dragged pin has another velocity in each step.
        let at = session.position(40);
        session.grab(40, at);
        session.move_grab(at + DVec3::new(0.5, 0.5, 0.0));
        run(session, 8);
        session.release();
        session.freeze();
        for integrator in Integrator::ALL {
            session.tune(SolverRow::substeps(40));
            session.tune(SolverRow::integrator(integrator));
            run(session, 2);
        }
        session.tune(SolverRow::integrator(Integrator::VelocityVerlet));
        session.tune(SolverRow::precision(Precision::F64));
        run(session, 3);
        session.tune(SolverRow::precision(Precision::F32));
        session.edit(MaterialEdit::Mass(0.2));
        // Refused, and so not recorded.
        session.edit(MaterialEdit::Mass(-1.0));
        session.tune(SolverRow::substeps(0));
        session.edit(MaterialEdit::Mass(0.2));
        run(session, 3);
    });
}

#[test]
fn steps_back_are_replayed_to_the_bit() {
    let mut session = session("square");
    run(&mut session, 10);
    happens_again(session, |session| {
        run(session, 5);
        session.edit(MaterialEdit::Friction(Friction::Coulomb(0.1)));
        (0..3).for_each(|_| assert!(session.step_back()));
        session.edit(MaterialEdit::Stiffness(300.0));
        session.step_forward();
        // Beyond the start of the recording.
        (0..6).for_each(|_| assert!(session.step_back()));
        session.tune(SolverRow::precision(Precision::F64));
        assert!(session.step_back());
        session.step_forward();
        session.toggle_pause();
        run(session, 5);
    });
}

#[test]
fn restarts_divergence_and_other_scenes_are_replayed_to_the_bit() {
    happens_again(session("jelly"), |session| {
        run(session, 10);
        session.edit(MaterialEdit::Stiffness(3000.0));
        session.restart();
        run(session, 10);
        session.tune(SolverRow::substeps(1));
        session.edit(MaterialEdit::Stiffness(1e6));
        run(session, 200);
        assert!(session.failure().is_some());
        let offers = session.offers().to_vec();
        // From the last state before debris and from the start.
        let origins = [Origin::Here, Origin::Start, Origin::Scene];
        let of = |origin| offers.iter().copied().find(|offer| offer.origin == origin);
        let taken = origins.into_iter().filter_map(of).map(|offer| {
            session.take(offer);
            run(session, 5);
        });
        assert!(2 <= taken.count());
        session.open(open("chain").expect("a built-in scene")).expect("a valid scene");
        session.advance(0.0, &|| 0.0);
        run(session, 20);
    });
}

#[test]
fn cuts_groups_and_gusts_are_replayed_to_the_bit() {
    happens_again(session("cloth"), |session| {
        run(session, 3);
        session.cut(&[7, 400, 401, 402, 1200]);
        session.set_wind(Wind { strength: 0.2, heading: 1.0, gusts: 0.8 });
        run(session, 5);
        session.select_group(vec![500, 3, 530, 531]);
        let at = session.position(530);
        session.grab(530, at);
        for frame in 1..20 {
            session.move_grab(at + DVec3::new(0.1, 0.05, 0.1) * f64::from(frame));
            run(session, 1);
        }
        session.cut(&[900, 901]);
        session.release();
        run(session, 5);
        assert!(session.step_back());
        session.toggle_pause();
        session.restart();
        session.set_wind(Wind::default());
        run(session, 5);
    });
}

#[test]
fn a_saved_run_restarts_where_it_was_saved() {
    let mut first = session("dice");
    run(&mut first, 30);
    let saved = first.runner().to_loaded("dice", "");
    let mut session = Session::new(saved).expect("a saved run");
    let start = session.runner().state();
    session.advance(0.0, &|| 0.0);
    run(&mut session, 10);
    assert_eq!(session.runner().steps(), 40);
    session.restart();
    assert_eq!((session.runner().state(), session.runner().steps()), (start, 30));
}

#[test]
fn a_session_that_ends_ends_its_recording() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.msdrec");
    let mut session = session("chain");
    session.start_recording(&path);
    run(&mut session, 5);
    let running = load_recording(&path).expect("a file from the start on");
    assert!(running.is_cut_short);
    drop(session);
    let recording = load_recording(&path).expect("a recording");
    assert_eq!((recording.steps(), recording.is_cut_short), (5, false));
}

#[test]
fn a_file_that_cannot_be_made_is_reported_and_nothing_is_recorded() {
    let mut session = session("chain");
    session.start_recording(Path::new("no/such/folder/run.msdrec"));
    assert_eq!(session.recording(), None);
    assert!(session.refusal().is_some_and(|text| text.contains("there is no folder")));
}

#[test]
fn the_button_records_into_a_file_of_a_free_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut viewer =
        Viewer::new(open("chain").expect("a built-in scene"), catalogue()).expect("a valid scene");
    viewer.folder = folder.path().to_path_buf();
    let mut harness = Harness::builder()
        .with_size(egui::Vec2::new(1280.0, 800.0))
        .build_ui_state(|ui, viewer: &mut Viewer| panel::show(ui, viewer), viewer);
    theme::apply(&harness.ctx);
    harness.run_steps(3);
    for _ in 0..2 {
        harness.get_by_label("Record").click();
        harness.run_steps(3);
        assert!(harness.state().session.recording().is_some());
        harness.get_by_label("End recording").click();
        harness.run_steps(3);
        assert_eq!(harness.state().session.recording(), None);
    }
    for name in ["chain-1.msdrec", "chain-2.msdrec"] {
        assert!(load_recording(&folder.path().join(name)).is_ok(), "{name}");
    }
}

#[test]
fn automatic_substeps_are_replayed_as_they_were_chosen() {
    let mut session = session("foam");
    session.tune(SolverRow::automatic());
    let recording = happens_again(session, |session| {
        run(session, 500);
        session.edit(MaterialEdit::Damping(160.0));
        run(session, 20);
        (0..200).for_each(|_| assert!(session.step_back()));
        session.toggle_pause();
        run(session, 10);
    });
    let chosen = recording.events.iter().filter(|event| matches!(event, Event::Settings(_)));
    assert!(2 <= chosen.count(), "a renewal and an edit");
}

#[test]
fn what_was_looked_back_to_undone_and_gone_on_from_is_replayed() {
    let mut session = session("jelly");
    run(&mut session, 20);
    happens_again(session, |session| {
        run(session, 40);
        session.look_back(10);
        session.look_back(25);
        session.look_back(0);
        session.toggle_pause();
        run(session, 5);
        session.look_back(30);
        session.edit(MaterialEdit::Stiffness(1500.0));
        session.toggle_pause();
        run(session, 30);
        session.cut(&[3, 4]);
        run(session, 5);
        session.undo();
        run(session, 5);
        session.undo();
        session.redo();
        // Beyond the start of the recording, which ends with the shown state.
        session.look_back(45);
        session.toggle_pause();
        run(session, 10);
        session.look_back(4);
    });
}
