//! The section of the window for bodies with a material.

use crate::frames::{run, window};
use egui::Vec2;
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use msd_app::link::Link;
use msd_app::session::{MaterialEdit, Session};
use msd_app::viewer::{Command, Viewer, catalogue};
use msd_core::{Scene, Select};
use msd_scene::materials::named;
use msd_scene::parts::Part;
use msd_scene::{Loaded, open};
use std::path::{Path, PathBuf};

/// Creates a scene file of a sheet and of a block whose cells also resist a change of volume.
fn scene(folder: &Path, young: f64, rest: &str) -> PathBuf {
    let path = folder.join("both.toml");
    let text = format!(
        "version = 1\n[solver]\nsubsteps = 64\n[[bodies]]\nkind = 'block'\nsize = [3, 4, 3]\n\
         spacing = 0.02\nyoung = {young} # soft\npoisson = 0.4\n{rest}\n\
         [[bodies]]\nkind = 'cloth'\nsize = [4, 5]\nspacing = 0.02\n\
         material = 'natural-rubber'\nthickness = 1e-3\n\
         relaxation_time = 1e-4\nposition = [0, 1, 0]\n"
    );
    std::fs::write(&path, text).expect("a file");
    path
}

fn rows(session: &Session) -> Scene {
    session.runner().progress().0
}

/// Asserts that springs, bends, volumes and masses are equal up to the single-precision rounding of
/// a few products.
fn assert_alike(a: &Scene, b: &Scene) {
    let numbers = |scene: &Scene| -> Vec<f64> {
        let springs = scene.springs.iter().flat_map(|row| [row.stiffness, row.damping]);
        let bends = scene.bends.iter().flat_map(|row| [row.stiffness, row.damping]);
        let volumes = scene.volumes.iter().flat_map(|row| [row.modulus, row.damping]);
        let masses = scene.particles.iter().map(|row| row.mass);
        springs.chain(bends).chain(volumes).chain(masses).collect()
    };
    let (a, b) = (numbers(a), numbers(b));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.into_iter().zip(b) {
        assert!((a - b).abs() <= 1e-6 * b.abs(), "{a} is not {b}");
    }
}

const BLOCK: &str = "density = 900\nrelaxation_time = 1e-4";

fn loaded(folder: &Path) -> Loaded {
    open(scene(folder, 1e5, BLOCK)).expect("a scene")
}

#[test]
fn setting_a_number_of_a_material_makes_the_body_of_that_material() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut session = Session::new(loaded(folder.path())).expect("a valid scene");
    let before = rows(&session);
    session.select(Select::Body(0));
    session.edit(MaterialEdit::Young(3e5));
    session.edit(MaterialEdit::Density(1200.0));
    session.edit(MaterialEdit::RelaxationTime(2e-4));
    let other = open(scene(folder.path(), 3e5, "density = 1200\nrelaxation_time = 2e-4"));
    let other = Session::new(other.expect("a scene")).expect("a valid scene");
    assert_alike(&rows(&session), &rows(&other));
    let made = |session: &Session, body: usize| session.material().made()[body].expect("made");
    assert_eq!(made(&session, 0), made(&other, 0));
    // The restart keeps the edits; undo reverts one after the other.
    session.restart();
    assert_alike(&rows(&session), &rows(&other));
    session.edit(MaterialEdit::Young(4e5));
    session.undo();
    assert_eq!(made(&session, 0), made(&other, 0));
    assert_alike(&rows(&session), &rows(&other));
    session.reset_material();
    assert_alike(&rows(&session), &before);
    assert_eq!(made(&session, 0).young, Some(1e5));
    // By name, for a sheet, whose bends change too.
    session.select(Select::Body(1));
    let steel = named("steel").expect("a material");
    session.edit(MaterialEdit::Named(steel));
    session.edit(MaterialEdit::Thickness(2e-3));
    let text = std::fs::read_to_string(scene(folder.path(), 1e5, BLOCK)).expect("a file");
    let text =
        text.replace("natural-rubber", "steel").replace("thickness = 1e-3", "thickness = 2e-3");
    // Steel has no relaxation time.
    let text = text.replace("relaxation_time = 1e-4\nposition", "position");
    let path = folder.path().join("steel.toml");
    std::fs::write(&path, text).expect("a file");
    let other = Session::new(open(&path).expect("a scene")).expect("a valid scene");
    assert_alike(&rows(&session), &rows(&other));
    session.undo();
    assert_eq!(made(&session, 1).material, Some("steel"));
    session.undo();
    assert_eq!(made(&session, 1).material, Some("natural-rubber"));
    assert_alike(&rows(&session), &before);
}

#[test]
fn a_saved_scene_and_a_link_hold_what_was_set_of_a_material() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut viewer = Viewer::new(loaded(folder.path()), catalogue()).expect("a valid scene");
    viewer.folder = folder.path().to_owned();
    viewer.session.select(Select::Body(0));
    viewer.session.edit(MaterialEdit::Young(123_456.0));
    viewer.session.select(Select::Body(1));
    viewer.session.edit(MaterialEdit::Named(named("sylgard-184").expect("a material")));
    viewer.command(Command::SaveScene);
    let saved = folder.path().join("both-1.toml");
    let text = std::fs::read_to_string(&saved).expect("it was saved");
    assert!(text.contains("young = 123456.0 # soft"), "{text}");
    assert!(text.contains("material = \"sylgard-184\""), "{text}");
    let read = Session::new(open(&saved).expect("a scene")).expect("a valid scene");
    assert_alike(&rows(&viewer.session), &rows(&read));
    let link = viewer.link().expect("it is short").to_string();
    let link = Link::parse(&link).expect("a link");
    let again = Viewer::of_link(&link, catalogue()).expect("a link");
    assert_eq!(rows(&again.session), rows(&viewer.session));
    let young = again.session.material().made()[0].and_then(|made| made.young).expect("made");
    assert!((young / 123_456.0 - 1.0).abs() < 1e-12, "{young}");
}

#[test]
fn switching_damping_off_and_on_acts_on_bends_and_volumes_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut session = Session::new(loaded(folder.path())).expect("a valid scene");
    let before = rows(&session);
    session.switch(Part::Damping, false);
    let off = rows(&session);
    assert!(off.springs.iter().all(|row| row.damping == 0.0));
    assert!(off.bends.iter().all(|row| row.damping == 0.0) && !off.bends.is_empty());
    assert!(off.volumes.iter().all(|row| row.damping == 0.0) && !off.volumes.is_empty());
    run(&mut session, 2);
    session.switch(Part::Damping, true);
    assert_alike(&rows(&session), &before);
    let time = session.material().made()[0].expect("made").relaxation_time;
    assert!((time / 1e-4 - 1.0).abs() < 1e-6, "{time}");
}

#[test]
fn the_panel_shows_the_units_of_a_material_and_the_source_of_its_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("gel.toml");
    let text = "version = 1\n[[bodies]]\nkind = 'block'\nsize = [3, 3, 3]\nspacing = 0.01\n\
        material = 'gelatine-5%'\n";
    std::fs::write(&path, text).expect("a file");
    let viewer = Viewer::new(open(&path).expect("a scene"), catalogue()).expect("a valid scene");
    let size = Vec2::new(1280.0, 800.0);
    let mut harness = window(viewer, size);
    for label in ["Young", "Density", "Relaxation"] {
        harness.get_by_role_and_label(Role::Slider, label);
    }
    assert!(harness.query_by_role_and_label(Role::Slider, "Stiffness").is_none());
    assert!(harness.query_by_role_and_label(Role::Slider, "Thickness").is_none());
    harness.get_by_label("0.25");
    harness.get_by_role_and_label(Role::ComboBox, "Material").click();
    harness.run_steps(3);
    // An entry that is visible without scrolling the list.
    harness.get_by_role_and_label(Role::Button, "gelatine-7%").click();
    harness.run_steps(3);
    let made = harness.state().session.material().made()[0].expect("made");
    assert_eq!(made.material, Some("gelatine-7%"));
    // Twice the product and the quotient of roundings.
    assert!((made.young.expect("a modulus") / 30_720.0 - 1.0).abs() < 1e-15);
}
