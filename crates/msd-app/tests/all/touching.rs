//! Contact settings in the window, and reports of surfaces that pass through each other.

use crate::frames::{frame, loaded, run, session};
use egui::Vec2;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::link::Link;
use msd_app::panel::theme;
use msd_app::session::{Deed, MarkKind, MaterialEdit, MixedValue, Session, TouchEdit, shells_of};
use msd_app::viewer::{Command, Viewer, catalogue};
use msd_core::scene::Between;
use msd_core::{Select, Shell};
use msd_run::Runner;
use msd_scene::schema::SolverRow;
use msd_scene::{default_shell, open, state_hash};

fn rows(session: &Session) -> &[Shell] {
    shells_of(session.runner())
}

fn first(value: Option<MixedValue>) -> f64 {
    value.expect("a body touches").first
}

#[test]
fn bodies_touch_as_a_scene_file_would_have_it_from_the_click_on() {
    let mut session = session("cloth");
    run(&mut session, 5);
    let (state, before) = (state_hash(&session.runner().state()), session.touch_values());
    assert_eq!((before.on, before.thickness), (false, None));
    session.edit_touch(TouchEdit::On(true));
    assert_eq!(session.refusal(), None);
    let by_default = default_shell(&session.loaded().scene, 0).expect("it has springs");
    assert_eq!(rows(&session), [by_default]);
    assert_eq!(state_hash(&session.runner().state()), state, "nothing moves by it");
    assert!(session.touch_values().on && session.material().is_edited());
    // Undo and redo handle one edit after the other, and the motion continues.
    let thickness = first(session.touch_values().thickness);
    run(&mut session, 80);
    session.edit_touch(TouchEdit::Thickness(0.5 * thickness));
    run(&mut session, 80);
    session.edit_touch(TouchEdit::Friction(0.125));
    assert_eq!(session.undoes(), Some(Deed::Edit("friction between bodies")));
    session.undo();
    session.undo();
    let values = session.touch_values();
    assert_eq!((first(values.thickness), first(values.friction)), (thickness, 0.5));
    session.undo();
    assert!(rows(&session).is_empty() && !session.material().is_edited());
    (0..3).for_each(|_| session.redo());
    let values = session.touch_values();
    assert_eq!((first(values.thickness), first(values.friction)), (0.5 * thickness, 0.125));
    // A restart keeps the edits; a reset returns to the scene.
    session.restart();
    assert_eq!(session.touch_values(), values);
    session.reset_material();
    assert!(rows(&session).is_empty() && session.runner().steps() == 0);
}

#[test]
fn a_thickness_is_bounded_and_a_refused_one_changes_nothing() {
    let mut session = session("drape");
    session.edit_touch(TouchEdit::Thickness(1.0));
    let by_default = default_shell(&session.loaded().scene, 0).expect("it has springs");
    assert_eq!(rows(&session)[0].thickness, 4.0 * by_default.thickness);
    session.edit_touch(TouchEdit::Restitution(0.5));
    assert_eq!(rows(&session)[0].restitution, 0.5);
    let before = rows(&session).to_vec();
    session.edit_touch(TouchEdit::Thickness(-1.0));
    assert!(session.refusal().is_some_and(|why| why.contains("thickness")));
    assert_eq!(rows(&session), before, "what is refused changes nothing");
}

#[test]
fn one_body_of_many_is_set_and_those_that_pass_through_it_still_do() {
    let text = "version = 1\n[[bodies]]\nname = 'a'\nkind = 'rope'\nsize = [4]\ntouch = {}\n\
                [[bodies]]\nname = 'b'\nkind = 'rope'\nsize = [4]\nposition = [0, 1, 0]\n\
                [[bodies]]\nname = 'c'\nkind = 'rope'\nsize = [4]\nposition = [0, 2, 0]\n\
                touch = { ignore = ['a'], thickness = 0.25 }\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("three.toml");
    std::fs::write(&path, text).expect("a file");
    let mut session = Session::new(open(&path).expect("a scene")).expect("a valid scene");
    let values = session.touch_values();
    assert!(!values.on && values.thickness.is_some_and(|thickness| thickness.mixed));
    assert_eq!(rows(&session)[1].ignored, [0]);
    session.select(Select::Body(1));
    session.edit_touch(TouchEdit::On(true));
    // The row of b is now before that of c.
    assert_eq!(rows(&session).len(), 3);
    assert_eq!(rows(&session)[2].ignored, [0]);
    session.select(Select::Body(0));
    session.edit_touch(TouchEdit::On(false));
    assert!(rows(&session).iter().all(|row| row.ignored.is_empty()));
    session.edit_touch(TouchEdit::On(true));
    assert_eq!(rows(&session)[2].ignored, [0]);
    let first = rows(&session)[0].clone();
    assert_eq!((first.thickness, first.edges), (0.1, vec![[0, 1], [1, 2], [2, 3]]));
}

#[test]
fn what_stands_between_two_bodies_stays_while_both_touch() {
    let text = "version = 1\n[[bodies]]\nname = 'a'\nkind = 'rope'\nsize = [4]\n\
                touch = { with = [{ body = 'b', friction = 0.125 }] }\n\
                [[bodies]]\nname = 'b'\nkind = 'rope'\nsize = [4]\nposition = [0, 2, 0]\n\
                touch = {}\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("two.toml");
    std::fs::write(&path, text).expect("a file");
    let mut session = Session::new(open(&path).expect("a scene")).expect("a valid scene");
    let between = |session: &Session| -> Vec<Between> {
        rows(session).iter().flat_map(|row| row.between.clone()).collect()
    };
    let written = [Between { shell: 0, friction: Some(0.125), ..Between::default() }];
    assert_eq!(between(&session), written);
    session.edit_touch(TouchEdit::Friction(0.75));
    assert_eq!((rows(&session)[1].friction, &between(&session)[..]), (0.75, &written[..]));
    session.select(Select::Body(0));
    session.edit_touch(TouchEdit::On(false));
    assert!(between(&session).is_empty());
    session.edit_touch(TouchEdit::On(true));
    assert_eq!(between(&session), written);
}

#[test]
fn a_run_whose_touches_were_set_is_that_of_the_scene_that_is_saved_of_it() {
    let folder = tempfile::tempdir().expect("a folder");
    for scene in ["cloth", "pile"] {
        let mut viewer = Viewer::new(loaded(scene), catalogue()).expect("a valid scene");
        viewer.folder = folder.path().to_owned();
        let session = &mut viewer.session;
        session.edit(MaterialEdit::Damping(0.25));
        session.edit_touch(TouchEdit::On(true));
        session.edit_touch(TouchEdit::Friction(0.25));
        let thickness = first(session.touch_values().thickness);
        session.edit_touch(TouchEdit::Thickness(0.75 * thickness));
        session.tune(SolverRow::substeps(20));
        session.restart();
        viewer.command(Command::SaveScene);
        let path = folder.path().join(format!("{scene}-1.toml"));
        let read = open(&path).unwrap_or_else(|_| panic!("{:?}", viewer.note));
        let mut again = Runner::open(&read).expect("a valid scene");
        assert_eq!(shells_of(&again), shells_of(viewer.session.runner()), "{scene}");
        for _ in 0..3 {
            viewer.session.step_forward();
            again.step().expect("a step");
        }
        let hash = |runner: &Runner| state_hash(&runner.state());
        assert_eq!(hash(&again), hash(viewer.session.runner()), "{scene}");
        shows_the_same_by_link(&viewer);
    }
}

/// Asserts that a link gives the same contact in the window and on the command line.
fn shows_the_same_by_link(viewer: &Viewer) {
    let text = viewer.link().expect("a link").to_string();
    let link = Link::parse(&text).expect("a link");
    let second = Viewer::of_link(&link, catalogue()).expect("a link");
    assert_eq!(rows(&second.session), rows(&viewer.session));
    assert_eq!(second.link().expect("a link").to_string(), text);
    assert_eq!(link.open().expect("a scene").scene.shells, rows(&viewer.session));
}

/// Returns a scene of two ropes and a cloth, in a folder; the cloth has a row for the first rope.
fn three(folder: &std::path::Path) -> Viewer {
    let text = "version = 1\n[[bodies]]\nname = 'a'\nkind = 'rope'\nsize = [4]\n\
                touch = { friction = 0.25 }\n\
                [[bodies]]\nname = 'b'\nkind = 'rope'\nsize = [4]\nposition = [0, 2, 0]\n\
                touch = { friction = 1, restitution = 0.5 }\n\
                [[bodies]]\nname = 'c'\nkind = 'cloth'\nsize = [3, 3]\nposition = [0, 4, 0]\n\
                touch = { with = [{ body = 'a', friction = 0.125 }] }\n";
    let path = folder.join("three.toml");
    std::fs::write(&path, text).expect("a file");
    let mut viewer = Viewer::new(open(&path).expect("a scene"), catalogue()).expect("a scene");
    viewer.folder = folder.to_owned();
    viewer
}

#[test]
fn two_bodies_are_set_undone_and_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut viewer = three(folder.path());
    let session = &mut viewer.session;
    assert!(session.touch_partners().is_empty(), "no body is selected");
    session.select(Select::Body(0));
    assert_eq!(session.touch_partners(), [1, 2]);
    // The root of the product, and the larger one; then the values of the file.
    assert_eq!(session.touch_with(1), Some([0.5, 0.5]));
    assert_eq!(session.touch_with(2), Some([0.125, 0.0]));
    session.edit_touch(TouchEdit::FrictionWith(1, 0.75));
    session.edit_touch(TouchEdit::RestitutionWith(1, 0.25));
    session.edit_touch(TouchEdit::RestitutionWith(2, 0.375));
    assert_eq!(session.undoes(), Some(Deed::Edit("restitution between two bodies")));
    assert_eq!(session.refusal(), None);
    assert_eq!(session.touch_with(1), Some([0.75, 0.25]));
    // The other side has the same values, and another edit keeps them.
    session.select(Select::Body(1));
    session.edit_touch(TouchEdit::Friction(0.5));
    assert_eq!(session.touch_with(0), Some([0.75, 0.25]));
    session.undo();
    session.undo();
    session.select(Select::Body(2));
    assert_eq!(session.touch_with(0), Some([0.125, 0.0]), "undone");
    session.redo();
    session.select(Select::Body(2));
    assert_eq!(session.touch_with(0), Some([0.125, 0.375]), "done again");
    session.edit_touch(TouchEdit::FrictionWith(0, -1.0));
    assert!(session.refusal().is_some_and(|why| why.contains("friction")));
    assert_eq!(session.touch_with(0), Some([0.125, 0.375]), "what is refused changes nothing");
    shows_the_same_by_link(&viewer);
    viewer.command(Command::SaveScene);
    let path = folder.path().join("three-1.toml");
    let read = open(&path).unwrap_or_else(|_| panic!("{:?}", viewer.note));
    assert_eq!(read.scene.shells, rows(&viewer.session));
}

#[test]
fn two_bodies_have_sliders_once_the_other_one_is_chosen() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut viewer = three(folder.path());
    viewer.session.select(Select::Body(0));
    let builder = Harness::builder().with_size(Vec2::new(1280.0, 1100.0));
    let mut harness = builder.build_ui_state(frame, viewer);
    theme::apply(&harness.ctx);
    harness.run_steps(3);
    assert!(harness.query_by_role_and_label(Role::Slider, "Pair grip").is_none());
    harness.get_by_role_and_label(Role::ComboBox, "With").click();
    harness.run_steps(3);
    harness.get_by_label("b").click();
    harness.run_steps(3);
    let slider = harness.get_by_role_and_label(Role::Slider, "Pair grip").rect();
    let at = slider.left_center() + Vec2::new(12.0, 0.0);
    harness.drag_at(at);
    harness.run_steps(1);
    harness.drop_at(at);
    harness.run_steps(2);
    let session = &harness.state().session;
    let [friction, restitution] = session.touch_with(1).expect("they meet");
    assert!(friction < 0.4 && restitution == 0.5, "{friction} {restitution}");
    assert_eq!(session.undoes(), Some(Deed::Edit("friction between two bodies")));
    assert!(harness.query_by_role_and_label(Role::Slider, "Pair bounce").is_some());
}

#[test]
fn the_sliders_are_there_for_what_touches() {
    let viewer = Viewer::new(loaded("cloth"), catalogue()).expect("a valid scene");
    let builder = Harness::builder().with_size(Vec2::new(1280.0, 1000.0));
    let mut harness = builder.build_ui_state(frame, viewer);
    theme::apply(&harness.ctx);
    harness.run_steps(3);
    assert!(harness.query_by_role_and_label(Role::Slider, "Gap").is_none());
    harness.get_by_role_and_label(Role::CheckBox, "Collide").click();
    harness.run_steps(3);
    let thickness =
        |harness: &Harness<'_, Viewer>| first(harness.state().session.touch_values().thickness);
    let before = thickness(&harness);
    for label in ["Gap", "Grip", "Bounce"] {
        let slider = harness.get_by_role_and_label(Role::Slider, label).rect();
        let at = slider.left_center() + Vec2::new(12.0, 0.0);
        harness.drag_at(at);
        harness.run_steps(1);
        harness.drop_at(at);
        harness.run_steps(2);
    }
    assert!(thickness(&harness) < before);
    assert_eq!(harness.state().session.undoes(), Some(Deed::Edit("restitution between bodies")));
    harness.get_by_role_and_label(Role::CheckBox, "Collide").click();
    harness.run_steps(3);
    assert!(rows(&harness.state().session).is_empty());
}

/// Returns two sheets, one body each, one of which passes through the other within a step.
fn shot() -> Session {
    let sheet = |y: f64, v: f64| {
        format!(
            "[[bodies]]\nkind = 'cloth'\nsize = [5, 5]\nspacing = 0.1\nmass = 0.01\n\
             position = [0.02, {y}, 0.03]\nvelocity = [0, {v}, 0]\ntouch = {{}}\n"
        )
    };
    let text = format!(
        "version = 1\n[solver]\nsubsteps = 1\n[world]\ngravity = [0, 0, 0]\n{}{}",
        sheet(0.0, 0.0),
        sheet(1.0, -90.0)
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shot.toml");
    std::fs::write(&path, text).expect("a file");
    Session::new(open(&path).expect("a scene")).expect("a valid scene")
}

#[test]
fn what_may_have_passed_through_is_told_and_marked() {
    let mut session = shot();
    assert!(session.findings().is_empty());
    (0..2).for_each(|_| session.step_forward());
    assert!(0 < session.runner().passes());
    let warning = session.marks().find(|mark| mark.kind == MarkKind::Warning);
    assert!(warning.is_some());
    let viewer = {
        let mut viewer = Viewer::new(loaded("cube"), catalogue()).expect("a valid scene");
        viewer.session = session;
        viewer
    };
    let builder = Harness::builder().with_size(Vec2::new(1600.0, 800.0));
    let mut harness = builder.build_ui_state(frame, viewer);
    theme::apply(&harness.ctx);
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("may have crossed").is_some());
    // Before that step, nothing has passed.
    harness.state_mut().session.look_back(2);
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("may have crossed").is_none());
}

#[test]
fn a_body_that_goes_through_another_is_named_in_the_status_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("pressed.toml");
    std::fs::write(&path, include_str!("../../../msd-run/tests/scenes/pressed.toml"))
        .expect("a file");
    let viewer = Viewer::new(open(&path).expect("a scene"), catalogue()).expect("a valid scene");
    let builder = Harness::builder().with_size(Vec2::new(1600.0, 800.0));
    let mut harness = builder.build_ui_state(frame, viewer);
    theme::apply(&harness.ctx);
    (0..23).for_each(|_| harness.state_mut().session.step_forward());
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("went through").is_none());
    (0..7).for_each(|_| harness.state_mut().session.step_forward());
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("ball went through bed at t = 40").is_some());
    harness.state_mut().session.restart();
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("went through").is_none(), "a new run");
}

#[test]
fn surfaces_that_cross_are_counted_while_the_run_is_as_it_is() {
    let text = "version = 1\n[world]\ngravity = [0, 0, 0]\n[[bodies]]\nkind = 'cloth'\n\
                size = [3, 3]\ntouch = {}\n\
                [[bodies]]\nkind = 'cloth'\nsize = [3, 3]\n\
                position = [0.3, 0, 0.2]\nrotation = { axis = [1, 0, 0], angle_deg = 90 }\n\
                touch = {}\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("crossed.toml");
    std::fs::write(&path, text).expect("a file");
    let mut session = Session::new(open(&path).expect("a scene")).expect("a valid scene");
    session.toggle_pause();
    assert_eq!(session.crossings(), None, "not counted yet");
    session.advance(0.1, &|| 0.0);
    let known = session.runner().touched().expect("they touch").crossings;
    assert!(0 < known);
    assert_eq!(session.crossings(), Some(known));
    session.edit(MaterialEdit::Damping(0.5));
    assert_eq!(session.crossings(), None, "void with the change");
    session.advance(0.1, &|| 0.0);
    assert_eq!(session.crossings(), Some(known));
    // Without colliding bodies, nothing is counted.
    session.edit_touch(TouchEdit::On(false));
    session.advance(0.1, &|| 0.0);
    assert_eq!(session.crossings(), None);
}

#[test]
fn a_ball_that_goes_through_a_cloth_is_told_in_the_status_line() {
    let text = "version = 1\n[solver]\nsubsteps = 128\n[[world.solids]]\nkind = 'sphere'\n\
                radius = 0.1\nposition = [0, 0, -1]\nvelocity = [0, 0, 30]\n[[bodies]]\n\
                kind = 'cloth'\nsize = [21, 21]\nspacing = 0.05\nmass = 0.002\nstiffness = 60\n\
                damping = 0.02\n[[pins]]\nset = 'top'\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shot.toml");
    std::fs::write(&path, text).expect("a file");
    let viewer = Viewer::new(open(&path).expect("a scene"), catalogue()).expect("a valid scene");
    let builder = Harness::builder().with_size(Vec2::new(1600.0, 800.0));
    let mut harness = builder.build_ui_state(frame, viewer);
    theme::apply(&harness.ctx);
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("went through").is_none());
    run(&mut harness.state_mut().session, 18);
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("solid 0 went through cloth").is_some());
    harness.state_mut().session.restart();
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("went through").is_none(), "a new run");
}
