//! Files in the window: edits of a running scene, and typed paths.

use crate::frames::{type_in, window};
use egui::Key;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::viewer::{Command, Viewer, catalogue};
use std::path::Path;

fn rope(mass: &str) -> String {
    format!("version = 1\n[[bodies]]\nkind = 'rope'\nsize = [4]\nmass = {mass}\n")
}

fn masses(viewer: &Viewer) -> f64 {
    viewer.session.loaded().scene.particles.iter().map(|particle| particle.mass).sum()
}

/// Returns a viewer of a rope of four particles of 1 kg, after a step.
fn viewer(file: &Path) -> Viewer {
    std::fs::write(file, rope("1.0")).expect("a file");
    let mut viewer =
        Viewer::new(msd_scene::open(file).expect("a scene"), catalogue()).expect("a valid scene");
    viewer.command(Command::StepForward);
    viewer
}

#[test]
fn a_scene_that_is_edited_is_read_again_and_camera_pause_and_selection_stay() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("rope.toml");
    let mut viewer = viewer(&file);
    viewer.session.select_particle(Some(2));
    viewer.camera.yaw += 1.0;
    let camera = viewer.camera;
    viewer.follow_files(1.0);
    assert_eq!((viewer.session.runner().steps(), masses(&viewer)), (1, 4.0), "nothing was edited");
    // A text of another length: two writes within the resolution of the clock would count as one.
    std::fs::write(&file, rope("2.50")).expect("a file");
    viewer.follow_files(0.01);
    assert_eq!(masses(&viewer), 4.0, "it is looked at a few times a second only");
    viewer.follow_files(1.0);
    assert_eq!((viewer.session.runner().steps(), masses(&viewer)), (0, 10.0));
    assert!(viewer.session.is_paused());
    assert_eq!((viewer.session.selected(), viewer.camera), (Some(2), camera));
    let note = viewer.note.clone().expect("a line on it");
    assert!(note.starts_with("reloaded: ") && note.ends_with("rope.toml"), "{note}");
}

#[test]
fn a_bad_edit_keeps_the_run_and_shows_every_refusal() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("rope.toml");
    let mut viewer = viewer(&file);
    std::fs::write(&file, rope("-2.5\nspacing = 0")).expect("a file");
    viewer.follow_files(1.0);
    assert_eq!((viewer.session.runner().steps(), masses(&viewer)), (1, 4.0));
    let note = viewer.note.take().expect("a refusal");
    assert!(note.contains("rope.toml:5:8: bodies[0].mass is -2.5"), "{note}");
    assert!(note.contains("rope.toml:6:11: bodies[0].spacing is 0"), "{note}");
    // The message appears once, until the next edit.
    viewer.follow_files(1.0);
    assert_eq!(viewer.note, None);
    std::fs::write(&file, rope("3")).expect("a file");
    viewer.follow_files(1.0);
    assert_eq!(masses(&viewer), 12.0);
    // A missing file, as while an editor writes it, is not an edit.
    std::fs::remove_file(&file).expect("a file");
    viewer.follow_files(1.0);
    assert!(!viewer.is_edited());
}

#[test]
fn a_restart_takes_the_file_as_it_is_and_a_built_in_scene_as_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("rope.toml");
    let mut viewer = viewer(&file);
    viewer.command(Command::Restart);
    assert_eq!((viewer.session.runner().steps(), masses(&viewer)), (0, 4.0));
    for (command, mass) in [(Command::Restart, "2.0"), (Command::Reload, "10.0")] {
        std::fs::write(&file, rope(mass)).expect("a file");
        viewer.command(command);
        assert_eq!(masses(&viewer), 4.0 * mass.parse::<f64>().expect("a number"));
        viewer.command(Command::StepForward);
    }
    viewer.open_named("chain");
    viewer.command(Command::StepForward);
    viewer.command(Command::Reload);
    let name = viewer.session.loaded().name.clone();
    assert_eq!((viewer.session.runner().steps(), &*name), (0, "chain"));
}

#[test]
fn what_is_typed_in_the_gallery_does_not_reach_the_scene_and_a_wrong_path_stays() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut viewer = viewer(&folder.path().join("rope.toml"));
    viewer.folder = folder.path().into();
    let mut harness = window(viewer, [1280.0, 800.0]);
    harness.state_mut().command(Command::Open);
    harness.run_steps(3);
    let files = || std::fs::read_dir(folder.path()).expect("a folder").count();
    for (text, key) in [("s", Key::S), ("s", Key::S), ("r", Key::R), ("1", Key::Num1)] {
        type_in(&mut harness, text, key);
    }
    let path = |harness: &Harness<'_, Viewer>| {
        harness.state().layout.gallery.as_ref().map(|gallery| gallery.path.clone())
    };
    // S would save a run, R restart it and 1 open another scene.
    assert_eq!((path(&harness).as_deref(), files()), (Some("ssr1"), 1));
    assert_eq!(harness.state().session.runner().steps(), 1);
    type_in(&mut harness, "", Key::Enter);
    assert_eq!(path(&harness).as_deref(), Some("ssr1"), "it is there to be mended");
    assert!(harness.state().note.as_deref().is_some_and(|note| note.contains("no scene `ssr1`")));
    assert_eq!(&*harness.state().session.loaded().name, "rope");
    type_in(&mut harness, "", Key::Escape);
    assert_eq!(path(&harness), None);
}

#[test]
fn a_file_that_is_called_as_a_built_in_scene_is_listed_by_its_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let harness = window(viewer(&folder.path().join("cloth.toml")), [1280.0, 800.0]);
    let listed = |name: &str| harness.query_all_by_role_and_label(Role::Button, name).count();
    // The label of the built-in scene also contains its shortcut.
    assert_eq!((listed("cloth"), listed("cloth.toml")), (0, 1));
}
