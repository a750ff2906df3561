//! Lessons: in the window, by links, and their sheets.

use crate::common::{done, folder, msd, quiet, refused};
use crate::frames::{click, loaded, window};
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::link::Link;
use msd_app::session::MaterialEdit;
use msd_app::viewer::{Command, Preferences, Viewer, catalogue};
use msd_report::lesson_sheet;
use msd_run::Runner;
use msd_scene::LESSONS;
use std::path::Path;

fn harness(scene: &str, size: [f32; 2]) -> Harness<'static, Viewer> {
    let mut viewer = Viewer::new(loaded(scene), catalogue()).expect("a valid scene");
    viewer.session.toggle_pause();
    window(viewer, size)
}

/// Types an answer and presses Check.
fn answer(harness: &mut Harness<'_, Viewer>, text: &str) {
    let field = harness.get_by_role_and_label(Role::TextInput, "Answer");
    field.focus();
    harness.run_steps(2);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    harness.get_by_role_and_label(Role::TextInput, "Answer").type_text(text);
    harness.run_steps(2);
    click(harness, Role::Button, "Check");
}

#[test]
fn a_student_finds_a_lesson_answers_and_goes_on() {
    let mut harness = harness("jelly", [1280.0, 800.0]);
    assert!(harness.state().layout.lessons.is_none());
    click(&mut harness, Role::Button, "Lessons");
    assert!(harness.query_by_label("0 of 8 done").is_some());
    click(&mut harness, Role::Button, "1. Hooke's law and frequency");
    assert_eq!(harness.state().session.loaded().name, "lesson-hooke");
    answer(&mut harness, "5");
    assert!(harness.query_by_label_contains("That is the angular frequency").is_some());
    assert!(harness.state().preferences.lessons.is_empty());
    answer(&mut harness, "0,8 Hz");
    assert!(harness.query_by_label_contains("Right: msd computes 0.796 Hz").is_some());
    click(&mut harness, Role::Button, "All lessons");
    assert!(harness.query_by_label("1 of 8 done").is_some());
    click(&mut harness, Role::Button, "1. Hooke's law and frequency, done");
    click(&mut harness, Role::Button, "Next lesson");
    assert_eq!(harness.state().session.loaded().name, "lesson-step");
    // The progress is among the preferences that the window and the page keep.
    let kept = serde_json::to_string(harness.state_mut().remember([800.0, 600.0], 1.0));
    let kept = Preferences::parse(&kept.expect("text")).expect("preferences");
    assert!(kept.lessons.iter().eq(["lesson-hooke"]));
}

#[test]
fn every_lesson_is_answered_from_the_scene_that_stands_there() {
    // As a student would find them, rounded to two or three digits.
    let answers = ["0.8", "0.5", "6.7", "4", "0.01", "0.15", "1.0", "0.58"];
    for (lesson, right) in LESSONS.into_iter().zip(answers) {
        let mut harness = harness(lesson.name, [1280.0, 800.0]);
        answer(&mut harness, right);
        assert!(harness.query_by_label_contains("Right: msd").is_some(), "{}", lesson.name);
        answer(&mut harness, "1e9");
        assert!(harness.query_by_label("It is too large.").is_some(), "{}", lesson.name);
        let last = lesson.name == LESSONS[LESSONS.len() - 1].name;
        assert_eq!(harness.query_by_label("Next lesson").is_none(), last);
    }
    let mut harness = harness("lesson-hooke", [1280.0, 800.0]);
    harness.state_mut().session.edit(MaterialEdit::Stiffness(200.0));
    for (given, right) in [("1.59", "1.59 Hz."), ("0.8", "0.796 Hz for the scene as written.")] {
        answer(&mut harness, given);
        assert!(harness.query_by_label_contains(&format!("Right: msd computes {right}")).is_some());
    }
}

#[test]
fn a_scene_without_a_lesson_closes_the_box_and_the_button_toggles_it() {
    let mut harness = harness("lesson-euler", [1280.0, 800.0]);
    harness.state_mut().open_named("jelly");
    harness.run_steps(3);
    assert!(harness.state().layout.lessons.is_none());
    harness.state_mut().command(Command::Lessons);
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("of 8 done").is_some());
    harness.state_mut().command(Command::Lessons);
    assert!(harness.state().layout.lessons.is_none());
}

#[test]
fn a_lesson_fits_a_phone() {
    let mut viewer = Viewer::new(loaded("lesson-order"), catalogue()).expect("a valid scene");
    (viewer.layout.by_touch, viewer.layout.in_page) = (true, true);
    viewer.layout.panels = false;
    let size = [360.0, 640.0];
    let harness = window(viewer, size);
    for label in ["Check", "All lessons", "Next lesson"] {
        let place = harness.get_by_role_and_label(Role::Button, label).rect();
        assert!(0.0 <= place.left() && place.right() <= size[0], "{label}: {place}");
        assert!(43.9 <= place.height(), "{label}: {place}");
    }
}

#[test]
fn a_link_opens_a_lesson_and_keeps_its_name() {
    let link = Link::parse("https://example.org/msd/#scene=lesson-friction").expect("a link");
    let mut viewer = Viewer::new(loaded("jelly"), catalogue()).expect("a valid scene");
    viewer.open_link(&link);
    assert_eq!(viewer.session.refusal(), None);
    assert!(viewer.layout.lessons.is_some());
    let again = viewer.link().expect("a link").to_string();
    assert!(again.starts_with("#scene=lesson-friction&with="), "{again}");
}

#[test]
fn lessons_are_listed_run_and_written_as_sheets() {
    let folder = folder();
    let listed = quiet(msd(folder.path(), &["lessons"]));
    assert_eq!(listed.lines().count(), LESSONS.len());
    for lesson in LESSONS {
        assert!(listed.contains(lesson.name), "{listed}");
        let run = ["run", lesson.name, "--duration", "0.1", "--quiet"];
        assert_eq!(done(msd(folder.path(), &run)), "");
    }
    let asked = ["lessons", "lesson-hooke", "--set", "bodies.0.stiffness=200"];
    let said = quiet(msd(folder.path(), &asked));
    assert_eq!(said, "wrote lesson-hooke.html, the teacher's sheet\n");
    let sheet = std::fs::read_to_string(folder.path().join("lesson-hooke.html")).expect("a sheet");
    assert!(sheet.contains("<strong>1.59 Hz</strong>"), "{sheet}");
    let why = refused(msd(folder.path(), &["lessons", "jelly"]), 2);
    assert_eq!(why, "error: jelly: the scene has no lesson\n");
}

/// After a change of a lesson renew the sheets by `MSD_RENEW=1 cargo test --test all -- sheets`.
#[test]
fn the_sheets_in_the_documentation_are_current() {
    let sheets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/lessons");
    for lesson in LESSONS {
        let scene = loaded(lesson.name);
        let settings = Runner::open(&scene).expect("it runs").settings();
        let made = lesson_sheet(&scene, settings).expect("a sheet");
        let file = sheets.join(format!("{}.html", lesson.name));
        if std::env::var_os("MSD_RENEW").is_some() {
            std::fs::create_dir_all(&sheets).expect("a folder");
            std::fs::write(&file, &made).expect("a sheet");
        }
        assert_eq!(std::fs::read_to_string(&file).unwrap_or_default(), made, "{}", lesson.name);
    }
}
