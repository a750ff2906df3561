//! The trade-off in the window: a background study, which a change of the scene voids but not one
//! of the solver; the choice of settings; the error as a colour.

use egui::Vec2;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::input::read_pointer;
use msd_app::panel::{self, theme};
use msd_app::session::{Deed, ERROR_WINDOW, MaterialEdit, Session, StudyFrom, choice_of};
use msd_app::viewer::{Viewer, catalogue};
use msd_core::glam::{DMat3, DVec3};
use msd_core::{Friction, Integrator, Interaction, Material, Plane, Scene, World, shape};
use msd_render::Quantity;
use msd_scene::parts::Part;
use msd_scene::schema::SolverRow;
use msd_scene::{Loaded, Precision};
use msd_study::Study;
use msd_study::choice::{Choice, FRAME, Fineness};
use msd_study::reference::{Wish, make_reference};
use msd_study::trial::try_choice;
use msd_study::tune::Goal;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Returns a scene with a study of a few seconds.
fn chain() -> Loaded {
    let mut loaded = msd_scene::open("chain").expect("a built-in scene");
    loaded.scene.world = World::default();
    loaded
}

fn session() -> Session {
    let mut session = Session::new(chain()).expect("a valid scene");
    session.toggle_pause();
    session.set_trading(true);
    session
}

/// Runs frames until a condition holds; only a failing test waits until the end.
fn wait_until(session: &mut Session, mut holds: impl FnMut(&Session) -> bool) {
    let begin = Instant::now();
    while !holds(session) {
        assert!(begin.elapsed() < Duration::from_secs(240), "it never came");
        session.advance(FRAME, &|| 0.0);
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn found(session: &Session) -> Option<Arc<Study>> {
    session.study().and_then(|report| report.found)
}

fn points(session: &Session) -> usize {
    found(session).map_or(0, |study| study.trials.len())
}

#[test]
fn a_change_of_the_scene_voids_the_study_at_once_and_a_change_of_the_solver_does_not() {
    let mut session = session();
    wait_until(&mut session, |session| 3 <= points(session));
    let kept: [fn(&mut Session); 8] = [
        |session| session.tune(SolverRow::substeps(11)),
        |session| session.tune(SolverRow::integrator(Integrator::Rk4)),
        |session| session.tune(SolverRow::precision(Precision::F64)),
        |session| session.tune(SolverRow::precision(Precision::F32)),
        |session| session.grab(3, session.position(3)),
        |session| session.release(),
        |session| session.step_forward(),
        |session| session.restart(),
    ];
    for (row, change) in kept.into_iter().enumerate() {
        let before = points(&session);
        change(&mut session);
        assert!(3 <= before && before <= points(&session), "change {row}");
    }
    let voids: [fn(&mut Session); 7] = [
        |session| session.switch(Part::Damping, false),
        |session| session.edit(MaterialEdit::Stiffness(777.0)),
        |session| session.edit(MaterialEdit::Gravity(1.6)),
        |session| session.edit(MaterialEdit::Damping(0.25)),
        |session| session.pin_toggle(4),
        |session| session.freeze(),
        |session| session.study_from(StudyFrom::Here),
    ];
    for (row, change) in voids.into_iter().enumerate() {
        session.step_forward();
        change(&mut session);
        assert!(session.study().is_none() && session.terms().is_none(), "change {row}");
        wait_until(&mut session, |session| 1 <= points(session));
    }
    assert_eq!(session.trade().start(), Some(session.runner().time()));
    session.set_trading(false);
    assert!(session.study().is_none() && !session.trade().is_on());
}

#[test]
fn the_present_setting_is_measured_whatever_it_is() {
    let mut session = session();
    // A number that the study would not try.
    session.tune(SolverRow::substeps(37));
    let now = choice_of(session.runner()).expect("a whole number of substeps in a frame");
    let is_there = |session: &Session| {
        found(session).is_some_and(|study| study.trials.iter().any(|trial| trial.choice == now))
    };
    wait_until(&mut session, is_there);
}

#[test]
fn a_choice_sets_method_fineness_and_precision_and_says_so() {
    let mut session = session();
    let choice = Choice {
        integrator: Integrator::Rk4,
        fineness: Fineness::Substeps(5),
        precision: Precision::F64,
    };
    let before = session.runner().precision();
    session.adopt(choice);
    assert_eq!(choice_of(session.runner()), Some(choice));
    let text = session.adopted().expect("something was changed").to_owned();
    assert!(text.contains("to rk4") && text.contains("to 5 substeps"), "{text}");
    assert_eq!(text.contains("to f64"), before != Precision::F64, "{text}");
    // A manual change is not attributed to the trade-off.
    session.tune(SolverRow::substeps(6));
    assert_eq!(session.adopted(), None);
    let adaptive = Choice {
        integrator: Integrator::DormandPrince,
        fineness: Fineness::Tolerance(1e-5),
        precision: Precision::F32,
    };
    session.adopt(adaptive);
    assert_eq!(choice_of(session.runner()), Some(adaptive));
}

#[test]
fn a_search_finds_a_setting_within_the_error_takes_it_and_says_what_changed() {
    let mut session = session();
    session.tune(SolverRow::integrator(Integrator::ExplicitEuler));
    session.tune(SolverRow::substeps(300));
    let error = 1e-4;
    session.search(Goal::MaxError(error));
    assert!(session.searched().is_some_and(|search| search.words().contains("waiting")));
    wait_until(&mut session, |session| session.searched().is_some_and(|search| !search.is_busy()));
    let words = session.searched().expect("the scene is as it was").words();
    assert!(words.contains("found") && words.contains("tried"), "{words}");
    assert!(words.contains("from the current state"), "{words}");
    let changed = session.adopted().expect("a setting was taken").to_owned();
    assert!(changed.contains("explicit-euler to "), "{changed}");
    let now = choice_of(session.runner()).expect("a choice");
    // The study measures the same setting against another reference.
    let measured = |session: &Session| {
        let study = found(session)?;
        study.trials.iter().find(|trial| trial.choice == now).map(|trial| trial.error())
    };
    wait_until(&mut session, |session| measured(session).is_some());
    let measured = measured(&session).expect("a trial");
    assert!(measured <= 1.01 * error, "{measured}");
    // The line of the current setting shows its cost.
    assert!(!words.contains("per frame"), "{words}");
    // Undo reverts the whole setting with its message, and redo repeats it.
    assert_eq!(session.undoes(), Some(Deed::Solver("found setting")));
    session.undo();
    let before = session.runner().settings();
    assert_eq!((before.integrator, before.substeps), (Integrator::ExplicitEuler, 300));
    assert!(session.searched().is_none(), "what was found is not what is stepped by");
    session.redo();
    assert_eq!(choice_of(session.runner()), Some(now));
    assert_eq!(session.searched().map(|search| search.words()), Some(words));
    // The search applies its result once: later changes by the user stay.
    session.tune(SolverRow::substeps(77));
    session.advance(FRAME, &|| 0.0);
    assert_eq!(session.runner().settings().substeps, 77);
}

#[test]
fn what_a_search_takes_serves_the_run_as_it_is_and_not_only_as_it_began() {
    // A block is in free fall for longer than the study, and bent by the ground at the search.
    let material = Material { mass: 1.0, stiffness: 2000.0, damping: 2.0 };
    let mut loaded = chain();
    let mut part = shape::block([3, 3, 3], 1.0, material).expect("small");
    part.place(DMat3::from_rotation_z(0.4), DVec3::Y * 8.0);
    loaded.scene = Scene::of("block", part);
    let friction = Friction::Coulomb(0.3);
    loaded.scene.planes = vec![Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.3, friction }];
    let mut session = Session::new(loaded.clone()).expect("a valid scene");
    while session.runner().contacts().count == 0 {
        session.step_forward();
    }
    session.set_trading(true);
    let error = 0.02;
    session.search(Goal::MaxError(error));
    wait_until(&mut session, |session| session.searched().is_some_and(|search| !search.is_busy()));
    let words = session.searched().expect("the scene is as it was").words();
    let adopted = session.adopted().is_some();
    assert_eq!(adopted, words.contains("found"), "{words}");
    // The cheapest setting from the start suits the fall only: it is skipped, or nothing applied.
    assert!(words.contains("rejected") || words.contains("nothing was changed"), "{words}");
    if adopted {
        let choice = choice_of(session.runner()).expect("a choice");
        let here = session.runner().progress().0;
        let right = make_reference(&here, Wish::default(), &mut ()).expect("it runs");
        let trial = try_choice(&here, choice, (&right, right.reliable(0.1 * error)), &mut ())
            .expect("it runs");
        assert!(trial.is_within(1.01 * error), "{choice}: {} m, {words}", trial.error());
    }
}

#[test]
fn a_search_is_void_with_its_scene_and_changes_nothing_that_does_not_meet_it() {
    let mut session = session();
    session.search(Goal::MaxError(1e-6));
    wait_until(&mut session, |session| {
        session
            .searched()
            .is_some_and(|search| search.words().contains("pairs of method and precision done"))
    });
    session.edit(MaterialEdit::Stiffness(777.0));
    assert!(session.searched().is_none());
    let before = choice_of(session.runner());
    session.search(Goal::Budget(1e-15));
    wait_until(&mut session, |session| session.searched().is_some_and(|search| !search.is_busy()));
    let words = session.searched().expect("the scene is as it was").words();
    assert!(words.contains("nothing was changed; nearest: "), "{words}");
    assert_eq!((choice_of(session.runner()), session.adopted()), (before, None));
    session.end_search();
    assert!(session.searched().is_none());
}

#[test]
fn the_worth_of_the_parts_comes_and_says_how_the_scene_was_stepped_until_it_is_known_anew() {
    let mut session = session();
    let rows = |session: &Session| session.terms().and_then(|report| report.found);
    wait_until(&mut session, |session| rows(session).is_some());
    let known = rows(&session).expect("rows");
    assert!(known.iter().any(|row| row.term == "gravity"));
    assert!(session.former_terms().is_none());
    let was = choice_of(session.runner()).expect("a choice").to_string();
    session.tune(SolverRow::substeps(9));
    assert!(session.terms().is_none());
    session.advance(FRAME, &|| 0.0);
    let former = session.former_terms().expect("what was known");
    assert_eq!((former.of, former.rows), (was, known));
    wait_until(&mut session, |session| rows(session).is_some());
    // A change of the scene voids both.
    session.edit(MaterialEdit::Stiffness(777.0));
    assert!(session.terms().is_none() && session.former_terms().is_none());
}

#[test]
fn a_setting_taken_from_the_diagram_is_tried_from_the_state_of_now() {
    // Free fall, in which the setting is sound, and then the ground.
    let mut session =
        Session::new(msd_scene::open("jelly").expect("a built-in scene")).expect("a valid scene");
    session.toggle_pause();
    session.set_trading(true);
    let loose = Choice {
        integrator: Integrator::DormandPrince,
        fineness: Fineness::Tolerance(1e-2),
        precision: Precision::F32,
    };
    session.adopt(loose);
    assert_eq!(session.fault_of_adopted(), None, "not known yet");
    wait_until(&mut session, |session| session.fault_of_adopted().is_some());
    let why = session.fault_of_adopted().expect("a fault");
    assert!(why.contains("that nothing supplied"), "{why}");
    // The next choice gets a new trial, and a sound one has no fault.
    session.tune(SolverRow::integrator(Integrator::VelocityVerlet));
    assert_eq!(session.fault_of_adopted(), None);
}

#[test]
fn a_study_changes_no_bit_of_the_run() {
    let run = |trading: bool| {
        let mut session = Session::new(chain()).expect("a valid scene");
        session.set_trading(trading);
        session.advance(0.0, &|| 0.0);
        for _ in 0..120 {
            session.advance(FRAME + 1e-9, &|| 0.0);
            std::thread::sleep(Duration::from_millis(u64::from(trading)));
        }
        session.runner().state()
    };
    assert_eq!(run(true), run(false));
}

/// Runs a frame of the window.
fn frame(ui: &mut egui::Ui, viewer: &mut Viewer) {
    read_pointer(ui.ctx(), viewer);
    viewer.session.advance(FRAME, &|| 0.0);
    panel::show(ui, viewer);
}

#[test]
fn the_slider_walks_from_fast_to_accurate_and_the_panel_says_what_changed() {
    let mut viewer = Viewer::new(chain(), catalogue()).expect("a valid scene");
    viewer.session.toggle_pause();
    let builder = Harness::builder().with_size(Vec2::new(1280.0, 800.0));
    let mut harness = builder.build_ui_state(frame, viewer);
    theme::apply(&harness.ctx);
    harness.run_steps(3);
    harness.get_by_label_contains("Accuracy vs. cost").click();
    harness.run_steps(3);
    assert!(harness.state().session.trade().is_on());
    wait_until(&mut harness.state_mut().session, |session| 20 <= points(session));
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("settings measured").is_some());
    assert!(harness.query_by_label_contains("current: ").is_some());
    let slider = harness.get_by_role_and_label(Role::Slider, "fast – accurate").rect();
    let press = |harness: &mut Harness<'_, Viewer>, at: egui::Pos2| {
        harness.hover_at(at);
        harness.run_steps(2);
        harness.drag_at(at);
        harness.run_steps(2);
        harness.drop_at(at);
        harness.run_steps(3);
    };
    let error = |harness: &Harness<'_, Viewer>| {
        let session = &harness.state().session;
        let now = choice_of(session.runner()).expect("a choice of the study");
        let study = found(session).expect("points");
        let trial = study.trials.iter().find(|trial| trial.choice == now).expect("measured");
        (trial.cost, trial.error())
    };
    press(&mut harness, slider.right_center() - Vec2::new(6.0, 0.0));
    let accurate = error(&harness);
    assert!(harness.query_by_label_contains("changed: ").is_some());
    press(&mut harness, slider.left_center() + Vec2::new(6.0, 0.0));
    let fast = error(&harness);
    assert!(fast.0 < accurate.0 && accurate.1 < fast.1, "{fast:?} {accurate:?}");
    assert!(harness.query_by_label_contains("changed: ").is_some());
    one_slow_drag_is_one_edit(&mut harness, slider);
    // A change of a field starts a search, which shows its progress.
    harness.get_by_role_and_label(Role::SpinButton, "within").increment_accesskit();
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("searching for error below").is_some());
    assert!(harness.query_by_label("Stop").is_some());
    // The switch of gravity switches it off, which voids study and search.
    harness.get_by_role_and_label(Role::CheckBox, "gravity").click();
    harness.run_steps(2);
    assert_eq!(harness.state().session.material().values().gravity, 0.0);
    assert!(harness.query_by_label_contains("searching for error below").is_none());
    assert!(harness.query_by_label("off").is_some());
    assert!(harness.query_by_label_contains("waiting until you stop").is_some());
}

/// Drags the slider from one end to the other with one frame per two seconds, and undoes that.
fn one_slow_drag_is_one_edit(harness: &mut Harness<'_, Viewer>, slider: egui::Rect) {
    let choice =
        |harness: &Harness<'_, Viewer>| choice_of(harness.state().session.runner()).expect("one");
    let edits = |harness: &Harness<'_, Viewer>| {
        let session = &harness.state().session;
        [session.undoes(), session.redoes()].map(|deed| deed.map(Deed::words))
    };
    let at = |part: f32| slider.left_center() + Vec2::new(part * slider.width(), 0.0);
    let start = choice(harness);
    harness.hover_at(at(0.03));
    harness.run_steps(1);
    harness.drag_at(at(0.03));
    for part in [0.2, 0.4, 0.6, 0.8, 0.95] {
        harness.hover_at(at(part));
        harness.state_mut().session.advance(2.0, &|| 0.0);
        harness.run_steps(1);
    }
    harness.drop_at(at(0.95));
    harness.state_mut().session.advance(2.0, &|| 0.0);
    harness.run_steps(2);
    let setting = Some("chosen setting");
    assert!(choice(harness) != start && edits(harness) == [setting, None]);
    harness.state_mut().session.undo();
    assert_eq!((choice(harness), edits(harness)), (start, [setting; 2]));
    harness.state_mut().session.redo();
}

#[test]
fn a_cut_spring_voids_the_study() {
    // The window cuts in other ways; the test needs only a change of the run.
    let mut loaded = chain();
    let mut runner = msd_run::Runner::open(&loaded).expect("a valid scene");
    runner.queue(Interaction::Cut { spring: 2 }).expect("a spring of the scene");
    runner.apply_queued().expect("room for it");
    loaded = runner.to_loaded("chain", "cut");
    let mut session = Session::new(loaded).expect("a valid scene");
    session.toggle_pause();
    session.set_trading(true);
    wait_until(&mut session, |session| 1 <= points(session));
    let study = found(&session).expect("points");
    assert_eq!(study.springs, chain().scene.springs.len() - 1);
}

#[test]
fn particles_are_coloured_by_their_error_as_long_as_it_is_known() {
    let loaded = msd_scene::open("jelly").expect("a built-in scene");
    let mut viewer = Viewer::new(loaded, catalogue()).expect("a valid scene");
    viewer.colour_by(Some(Quantity::Error));
    assert!(viewer.session.error().is_some() && viewer.errors().is_none());
    (0..ERROR_WINDOW).for_each(|_| viewer.session.step_forward());
    let errors: Vec<f32> = viewer.errors().expect("a window has ended").collect();
    assert_eq!(errors.len(), viewer.session.runner().particle_count());
    let most = errors.iter().copied().fold(0.0, f32::max);
    assert!(0.0 < most && viewer.scale().is_some(), "{most}");
    viewer.session.tune(SolverRow::substeps(9));
    assert!(viewer.errors().is_none() && viewer.scale().is_none());
}
