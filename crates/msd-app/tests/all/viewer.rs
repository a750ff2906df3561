//! The viewer around a session: files opened, dropped and saved, the gallery, the tour,
//! preferences, and the keyboard.

use crate::frames::{type_in, window};
use egui::accesskit::{Action, Role};
use egui::{Key, RawInput, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use glam::Vec3;
use msd_app::input::take_drops;
use msd_app::session::{MaterialEdit, Wind};
use msd_app::viewer::{Command, Guide, GuideStep, Preferences, Viewer, catalogue};
use msd_core::{Friction, Integrator, Select};
use msd_scene::schema::SolverRow;
use msd_scene::{Precision, open, state_hash};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn viewer(scene: &str, folder: &Path) -> Viewer {
    let loaded = open(scene).expect("a scene");
    let mut viewer = Viewer::new(loaded, catalogue()).expect("a valid scene");
    viewer.folder = folder.to_owned();
    viewer
}

fn harness(viewer: Viewer, size: [f32; 2]) -> Harness<'static, Viewer> {
    window(viewer, size)
}

fn note(viewer: &Viewer) -> &str {
    viewer.note.as_deref().unwrap_or_default()
}

const ROPE: &str = "# mine\nversion = 1\n[world]\ngravity = [0, -5, 0] # weak\n[[world.planes]]\n\
                    sticky = true\n[[bodies]]\nkind = 'rope'\nsize = [4]\nstiffness = 50 # soft\n\
                    [[bodies]]\nkind = 'block'\nsize = [2, 2, 2]\n";

#[test]
fn a_file_is_opened_and_a_bad_one_is_told_of_while_the_run_goes_on() {
    let folder = folder();
    let good = folder.path().join("rope.toml");
    std::fs::write(&good, ROPE).expect("a file");
    let bad = folder.path().join("bad.toml");
    std::fs::write(&bad, "version = 1\nbodies = 3").expect("a file");
    let mut viewer = viewer("chain", folder.path());
    viewer.command(Command::StepForward);
    for path in [bad, folder.path().join("gone.obj"), folder.path().join("odd.xyz")] {
        viewer.open_path(&path);
        let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
        assert!(note(&viewer).contains(name), "{}", note(&viewer));
        assert_eq!(viewer.session.loaded().name, "chain");
        assert_eq!(viewer.session.runner().steps(), 1);
    }
    viewer.open_path(&good);
    assert_eq!((viewer.session.loaded().name.as_str(), viewer.current()), ("rope", None));
    viewer.open_entry(0);
    viewer.reopen();
    assert_eq!(viewer.session.loaded().name, "rope", "it stays within reach");
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }
    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

#[test]
fn a_dropped_mesh_becomes_a_body() {
    let folder = folder();
    let mesh = folder.path().join("tent.obj");
    let text = "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n";
    std::fs::write(&mesh, text).expect("a file");
    let mut viewer = viewer("chain", folder.path());
    let input = RawInput { dropped_files: vec![Arc::new(Dropped(mesh))], ..RawInput::default() };
    take_drops(&input, &mut viewer);
    assert_eq!(viewer.session.loaded().name, "tent", "{}", note(&viewer));
    assert!(4 <= viewer.session.runner().particle_count());
}

#[test]
fn a_saved_run_goes_on_with_the_same_bits() {
    let folder = folder();
    let mut viewer = viewer("cloth", folder.path());
    (0..20).for_each(|_| viewer.command(Command::StepForward));
    viewer.session.cut(&[5, 6]);
    viewer.command(Command::SaveRun);
    let path = folder.path().join("cloth-1.msd");
    assert!(note(&viewer).contains("cloth-1.msd"), "{}", note(&viewer));
    let mut again = self::viewer(path.to_str().expect("a plain path"), folder.path());
    (0..20).for_each(|_| viewer.command(Command::StepForward));
    (0..20).for_each(|_| again.command(Command::StepForward));
    let hash = |viewer: &Viewer| state_hash(&viewer.session.runner().state());
    assert_eq!(hash(&again), hash(&viewer));
}

/// Sets values that a scene file can hold.
fn set_values(viewer: &mut Viewer) {
    let session = &mut viewer.session;
    session.tune(SolverRow::integrator(Integrator::Rk4));
    session.tune(SolverRow::substeps(11));
    session.tune(SolverRow::precision(Precision::F64));
    session.edit(MaterialEdit::Gravity(2.5));
    session.edit(MaterialEdit::Restitution(0.25));
    session.edit(MaterialEdit::Friction(Friction::Coulomb(0.75)));
    session.edit(MaterialEdit::Mass(1.5));
    session.set_wind(Wind { strength: 0.125, heading: 0.0, gusts: 0.0 });
    session.select(Select::Body(0));
    session.edit(MaterialEdit::Stiffness(1234.5));
    session.edit(MaterialEdit::Damping(0.3));
}

#[test]
fn a_saved_scene_says_what_was_set_and_keeps_what_its_author_wrote() {
    let folder = folder();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, ROPE).expect("a file");
    let path = path.to_str().expect("a plain path");
    for (scene, name) in [(path, "mine-1.toml"), ("cube", "cube-1.toml"), ("cloth", "cloth-1.toml")]
    {
        let mut viewer = viewer(scene, folder.path());
        set_values(&mut viewer);
        viewer.command(Command::SaveScene);
        assert!(note(&viewer).contains(name), "{scene}: {}", note(&viewer));
        let read = open(folder.path().join(name)).expect("a scene");
        let runner = viewer.session.runner();
        assert_eq!((read.settings, read.precision), (runner.settings(), Precision::F64));
        let rope = read.scene.bodies[0].springs.clone().map(|spring| read.scene.springs[spring]);
        assert!(rope.into_iter().all(|spring| (spring.stiffness, spring.damping) == (1234.5, 0.3)));
        assert!(read.scene.particles.iter().all(|particle| particle.mass == 1.5), "{scene}");
        assert!((read.scene.world.gravity.y + 2.5).abs() < 1e-6, "{scene}");
        assert_eq!(read.scene.world.force.x, 0.125, "{scene}");
    }
    let text = std::fs::read_to_string(folder.path().join("mine-1.toml")).expect("a file");
    assert!(
        text.contains("# mine") && text.contains("# weak") && text.contains("# soft"),
        "{text}"
    );
}

#[test]
fn automatic_substeps_by_their_other_name_are_saved_under_their_own() {
    let folder = folder();
    let text = "version = 1\n[solver]\nstep = 'auto'\n[[bodies]]\nkind = 'rope'\nsize = [3]\n";
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, text).expect("a file");
    let mut viewer = viewer(path.to_str().expect("a plain path"), folder.path());
    assert!(viewer.session.runner().is_automatic());
    for (tuning, line) in [
        (SolverRow::integrator(Integrator::Rk4), "substeps = \"auto\""),
        (SolverRow::substeps(7), "substeps = 7"),
    ] {
        viewer.session.tune(tuning);
        viewer.command(Command::SaveScene);
        let told = note(&viewer).strip_prefix("saved ").and_then(|told| told.split_once(','));
        let (name, _) = told.unwrap_or_else(|| panic!("{}", note(&viewer)));
        let text = std::fs::read_to_string(folder.path().join(name)).expect("a file");
        assert!(text.contains(line) && !text.contains("step = "), "{text}");
    }
}

#[test]
fn a_scene_that_no_file_can_say_is_refused_and_nothing_is_left() {
    let folder = folder();
    // Its springs have individual values, instead of that of the body.
    let text = "version = 1\n[[bodies]]\nkind = 'explicit'\nparticles = [{ position = [0, 0, 0] }, \
                { position = [1, 0, 0] }]\nsprings = [{ ends = [0, 1], stiffness = 300 }]\n";
    let path = folder.path().join("two.toml");
    std::fs::write(&path, text).expect("a file");
    let mut viewer = viewer(path.to_str().expect("a plain path"), folder.path());
    viewer.session.edit(MaterialEdit::Stiffness(500.0));
    viewer.command(Command::SaveScene);
    assert!(note(&viewer).contains("save the run instead"), "{}", note(&viewer));
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
}

#[test]
fn the_command_is_that_of_the_scene_or_of_a_run_saved_for_it() {
    let folder = folder();
    let mut harness = harness(viewer("chain", folder.path()), [1280.0, 800.0]);
    let copied = |harness: &mut Harness<'_, Viewer>| {
        harness.state_mut().command(Command::CopyCommand);
        let line = harness.state().wishes.clipboard.clone().expect("a command");
        harness.step();
        let commands = &harness.output().platform_output.commands;
        let mut copies = commands.iter().filter_map(|command| match command {
            egui::OutputCommand::CopyText(text) => Some(text),
            _ => None,
        });
        assert_eq!(copies.next_back(), Some(&line), "on the clipboard");
        line
    };
    assert_eq!(copied(&mut harness), "msd view chain");
    let session = &mut harness.state_mut().session;
    session.tune(SolverRow::integrator(Integrator::BackwardEuler));
    session.tune(SolverRow::substeps(7));
    session.tune(SolverRow::newton(2));
    let line = copied(&mut harness);
    let options = "--integrator backward-euler --substeps 7 --newton 2";
    assert_eq!(line, format!("msd view chain {options}"));
    // A state rounded to single precision is not the initial one in double precision.
    harness.state_mut().session.tune(SolverRow::precision(Precision::F64));
    assert!(copied(&mut harness).ends_with("chain-1.msd"));
    harness.state_mut().command(Command::StepForward);
    let line = copied(&mut harness);
    let saved = line.strip_prefix("msd view ").expect("a view");
    let read = open(saved.trim_matches('\'')).expect("the run that was saved for it");
    assert_eq!(read.progress.expect("a saved run").steps, 1);
}

#[test]
fn a_recording_says_its_file_and_how_to_see_it_again() {
    let folder = folder();
    let mut viewer = viewer("chain", folder.path());
    viewer.command(Command::Record);
    assert!(note(&viewer).contains("chain-1.msdrec"), "{}", note(&viewer));
    viewer.command(Command::StepForward);
    viewer.command(Command::Record);
    assert!(note(&viewer).contains("msd run --replay "), "{}", note(&viewer));
    assert!(note(&viewer).contains("chain-1.msdrec"), "{}", note(&viewer));
}

#[test]
fn the_gallery_offers_scenes_and_files_and_opens_what_is_clicked() {
    let folder = folder();
    std::fs::write(folder.path().join("rope.toml"), ROPE).expect("a file");
    std::fs::write(folder.path().join("other.toml"), "[package]\nname = 'x'\n").expect("a file");
    let mut harness = harness(viewer("chain", folder.path()), [1280.0, 800.0]);
    harness.get_by_label("Open…").click();
    harness.run_steps(3);
    let gallery = harness.state().layout.gallery.as_ref().expect("it is open");
    let names: Vec<&str> = gallery.pictures.iter().map(|picture| &*picture.name).collect();
    assert_eq!(names.len(), msd_scene::BUILTINS.len() + 1);
    assert!(names[names.len() - 1].ends_with("rope.toml"));
    let wanted = harness.query_all_by_role(Role::Button).find(|node| {
        node.accesskit_node().labelled_by().any(|label| label.value().as_deref() == Some("drape"))
    });
    wanted.expect("a picture to click").click();
    harness.run_steps(3);
    assert_eq!(harness.state().session.loaded().name, "drape");
    assert!(harness.state().layout.gallery.is_none());
}

#[test]
fn the_guide_follows_what_is_done_and_is_not_offered_twice() {
    let mut viewer = viewer("cube", Path::new(""));
    viewer.set_preferences(Preferences::default());
    let mut harness = harness(viewer, [1280.0, 800.0]);
    let now =
        |harness: &Harness<'_, Viewer>| harness.state().layout.guide.as_ref().and_then(Guide::step);
    let wait = |harness: &mut Harness<'_, Viewer>, frames: usize| {
        for _ in 0..frames {
            harness.state_mut().session.advance(1.0 / 60.0 + 1e-9, &|| 0.0);
        }
        harness.run_steps(2);
    };
    wait(&mut harness, 2);
    assert_eq!(now(&harness), Some(GuideStep::Grab));
    assert!(harness.query_by_label_contains("let go to throw it").is_some());
    let at = harness.state().session.position(0);
    harness.state_mut().session.grab(0, at);
    wait(&mut harness, 5);
    assert_eq!(now(&harness), Some(GuideStep::Grab), "not before it is let go");
    harness.state_mut().session.release();
    wait(&mut harness, 2);
    assert_eq!(now(&harness), Some(GuideStep::Stiffen));
    harness.state_mut().session.edit(MaterialEdit::Stiffness(1e6));
    harness.state_mut().session.advance(0.0, &|| 0.0);
    harness.run_steps(1);
    assert_eq!(now(&harness), Some(GuideStep::BlowUp));
    wait(&mut harness, 300);
    assert_eq!(now(&harness), Some(GuideStep::BlowUp), "long enough to be read");
    assert!(harness.query_by_label_contains("It blew up").is_some());
    // Frames of a quarter of a second.
    harness.run_steps(12);
    assert_eq!(now(&harness), Some(GuideStep::BlowUp));
    harness.run_steps(6);
    assert_eq!(now(&harness), Some(GuideStep::Mend));
    let offer = harness.state().session.offers()[0];
    harness.state_mut().take(offer);
    wait(&mut harness, 3);
    assert_eq!(now(&harness), Some(GuideStep::Cost));
    harness.state_mut().session.set_estimating(true);
    wait(&mut harness, 60);
    assert_eq!(now(&harness), None);
    harness.get_by_label("Close the tour").click();
    harness.run_steps(2);
    assert!(harness.state().layout.guide.is_none());
    let kept = harness.state_mut().remember([1280.0, 800.0], 1.0).clone();
    assert!(kept.is_guided);
    harness.state_mut().set_preferences(kept);
    assert!(harness.state().layout.guide.is_none());
    harness.state_mut().command(Command::Guide);
    assert_eq!(now(&harness), Some(GuideStep::Grab), "asked for, it comes again");
}

#[test]
fn what_was_chosen_is_remembered() {
    let mut harness = harness(viewer("cube", Path::new("")), [1280.0, 800.0]);
    harness.state_mut().camera.orbit(0.5, 0.1);
    let camera = harness.state().camera;
    harness.state_mut().open_entry(3);
    harness.run_steps(2);
    assert_ne!(harness.state().camera.yaw, camera.yaw);
    (harness.state_mut().layout.light, harness.state_mut().layout.panels) = (true, false);
    let kept = harness.state_mut().remember([900.0, 700.0], 1.25).clone();
    assert_eq!((kept.size, kept.scale), (Some([900.0, 700.0]), 1.25));
    let last = catalogue().entries[3].name;
    assert_eq!(kept.scene.as_deref(), Some(last));
    let mut other = viewer("cube", Path::new(""));
    other.set_preferences(kept);
    assert!(other.layout.light && !other.layout.panels);
    let harness = self::harness(other, [1280.0, 800.0]);
    assert_eq!(
        (harness.state().camera.yaw, harness.state().camera.pitch),
        (camera.yaw, camera.pitch)
    );
}

#[test]
fn a_remembered_camera_is_at_rest_and_as_far_beside_the_scene_as_it_was() {
    let mut harness = harness(viewer("cloth", Path::new("")), [1280.0, 800.0]);
    let left = harness.state_mut();
    left.look(0.0);
    left.camera.orbit(0.5, 0.1);
    left.camera.pan(0.2, 0.0);
    // The cloth sags, and the camera follows.
    for _ in 0..120 {
        left.session.advance(1.0 / 60.0 + 1e-9, &|| 0.0);
        left.look(1.0 / 60.0);
    }
    let (kept, way) = (left.remember([1280.0, 800.0], 1.0).clone(), beside(left));
    assert!(0.1 < way.length(), "{way}");
    let mut again = viewer("cloth", Path::new(""));
    again.set_preferences(kept);
    again.session.toggle_pause();
    let mut harness = self::harness(again, [1280.0, 800.0]);
    let again = harness.state_mut();
    assert_eq!(beside(again), way);
    let target = again.camera.target;
    again.look(1.0);
    assert!(again.camera.target.distance(target) < 1e-3, "{} m", again.camera.target - target);
}

#[test]
fn a_camera_that_follows_arrives_though_the_run_is_paused() {
    let mut viewer = viewer("cloth", Path::new(""));
    for _ in 0..30 {
        viewer.session.advance(1.0 / 60.0 + 1e-9, &|| 0.0);
        viewer.look(1.0 / 60.0);
    }
    assert!(viewer.is_gliding(), "it lags behind");
    viewer.session.toggle_pause();
    (0..120).for_each(|_| viewer.look(1.0 / 60.0));
    assert!(!viewer.is_gliding());
    let there = viewer.camera.target;
    viewer.look(10.0);
    // In metres, a tenth of a pixel.
    assert!(viewer.camera.target.distance(there) < 2e-4 * viewer.camera.distance);
}

#[test]
fn what_is_fast_stays_in_the_picture() {
    let mut viewer = viewer("cube", Path::new(""));
    viewer.layout.rect = egui::Rect::from_min_size(egui::Pos2::ZERO, Vec2::new(800.0, 600.0));
    viewer.frame_all();
    viewer.session.edit(MaterialEdit::Gravity(0.0));
    viewer.session.set_wind(Wind { strength: 100.0, heading: 0.0, gusts: 0.0 });
    viewer.look(0.0);
    // A machine with five frames per second; after 12 s the cube is more than a kilometre away.
    for _ in 0..60 {
        viewer.session.advance(0.2, &|| 0.0);
        viewer.look(0.2);
        let middle = viewer.session.position(555).as_vec3();
        let place = viewer.viewport().project(middle).expect("in front");
        assert!(viewer.layout.rect.contains(place), "{place:?}");
    }
    assert!(1e3 < viewer.session.position(555).x, "{}", viewer.session.position(555));
}

/// Returns the offset of the camera's target from the centre of the scene, as in a link, metres.
fn beside(viewer: &Viewer) -> Vec3 {
    let changes = viewer.link().expect("a built-in scene").changes.expect("a camera");
    changes.look.target.into()
}

#[test]
fn everything_is_in_reach_in_a_small_window() {
    let harness = harness(viewer("cube", Path::new("")), [800.0, 600.0]);
    let window = egui::Rect::from_min_size(egui::Pos2::ZERO, Vec2::new(800.0, 600.0));
    for name in ["Pause", "Restart", "Stiffness", "Mass", "Surface", "cube"] {
        let shown = harness.query_all_by_label(name).map(|node| node.rect()).next_back();
        let rect = shown.unwrap_or_else(|| panic!("no {name}"));
        assert!(window.contains_rect(rect), "{name}: {rect:?}");
    }
    let view = harness.state().layout.rect;
    assert!(300.0 <= view.width() && 400.0 <= view.height(), "{view:?}");
}

#[test]
fn the_help_fits_a_small_window() {
    let mut viewer = viewer("cube", Path::new(""));
    viewer.layout.help = true;
    let mut harness = harness(viewer, [800.0, 600.0]);
    harness.run_steps(3);
    let window = egui::Rect::from_min_size(egui::Pos2::ZERO, Vec2::new(800.0, 600.0));
    for node in harness.query_all_by_label("Help") {
        assert!(window.contains_rect(node.rect()), "{:?}", node.rect());
    }
    let first = harness.get_by_label("Left drag on a particle").rect();
    assert!(window.contains_rect(first), "{first:?}");
}

#[test]
fn finer_pixels_leave_everything_where_it_is() {
    let mut harness = harness(viewer("cube", Path::new("")), [1280.0, 800.0]);
    let names = ["Pause", "Stiffness", "Surface", "Frame all"];
    let places = |harness: &Harness<'_, Viewer>| {
        names.map(|name| harness.query_all_by_label(name).map(|node| node.rect()).next_back())
    };
    let (before, view) = (places(&harness), harness.state().layout.rect);
    let window = harness.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
    window.native_pixels_per_point = Some(2.0);
    harness.run_steps(3);
    assert_eq!(harness.ctx.pixels_per_point(), 2.0);
    for (before, now) in before.into_iter().zip(places(&harness)) {
        let [before, now] = [before, now].map(|rect| rect.expect("it is shown").center());
        // Text is aligned to whole pixels.
        assert!(before.distance(now) <= 4.0, "{before:?} {now:?}");
    }
    let moved = (harness.state().layout.rect.min - view.min).length();
    assert!(moved <= 4.0, "the view moved by {moved}");
}

#[test]
fn hidden_panels_leave_the_whole_window_to_the_scene() {
    let mut harness = harness(viewer("cube", Path::new("")), [800.0, 600.0]);
    harness.state_mut().command(Command::Panels);
    harness.run_steps(2);
    // Except for the margin of the harness.
    let size = harness.state().layout.rect.size();
    assert!(780.0 < size.x && 580.0 < size.y, "{size}");
    harness.state_mut().command(Command::Panels);
    harness.run_steps(2);
    assert!(harness.state().layout.rect.width() < 500.0);
}

#[test]
fn every_control_is_reached_by_tab_and_used_by_key() {
    let mut harness = harness(viewer("cube", Path::new("")), [1280.0, 800.0]);
    let mut reached = Vec::new();
    for _ in 0..120 {
        type_in(&mut harness, "", Key::Tab);
        let id = harness.ctx.memory(|memory| memory.focused()).expect("something has the focus");
        if reached.contains(&id) {
            break;
        }
        reached.push(id);
    }
    let usable = [Role::Button, Role::CheckBox, Role::Slider, Role::ComboBox, Role::RadioButton];
    let all: usize = usable.map(|role| harness.query_all_by_role(role).count()).iter().sum();
    assert!(40 < all && all <= reached.len(), "{} of {all}", reached.len());
    type_in(&mut harness, "", Key::Escape);
    assert!(!harness.ctx.egui_wants_keyboard_input());
    let camera = harness.state().camera;
    let turns = [Key::ArrowRight, Key::ArrowUp, Key::Plus].into_iter();
    turns.for_each(|turn| type_in(&mut harness, "", turn));
    let turned = harness.state().camera;
    assert!(camera.yaw < turned.yaw && camera.pitch < turned.pitch);
    assert!(turned.distance < camera.distance);
    harness.get_by_role_and_label(Role::Button, "Pause").focus();
    harness.run_steps(2);
    type_in(&mut harness, "", Key::Enter);
    assert!(harness.state().session.is_paused());
    let before = harness.state().session.material().values().gravity;
    harness.get_by_role_and_label(Role::Slider, "Gravity").focus();
    harness.run_steps(2);
    type_in(&mut harness, "", Key::ArrowRight);
    assert!(before < harness.state().session.material().values().gravity);
}

/// Returns focusable controls without a name for screen readers: roles and places.
fn nameless(harness: &Harness<'_, Viewer>) -> Vec<String> {
    let nodes = harness.root().children_recursive();
    let without = nodes.filter(|node| {
        let node = node.accesskit_node();
        let is_spoken = |name: String| name.chars().any(char::is_alphanumeric);
        node.data().supports_action(Action::Focus) && !node.label().is_some_and(is_spoken)
    });
    without.map(|node| format!("{:?} at {:?}", node.accesskit_node().role(), node.rect())).collect()
}

#[test]
fn every_control_has_a_name() {
    let mut harness = harness(viewer("cube", Path::new("")), [1280.0, 1400.0]);
    let none: Vec<String> = Vec::new();
    assert_eq!(nameless(&harness), none, "at the start");
    let wind = Wind { strength: 1.0, ..Wind::default() };
    harness.state_mut().session.set_wind(wind);
    harness.state_mut().command(Command::Help);
    harness.state_mut().command(Command::Guide);
    harness.get_by_label_contains("Compare with ").click();
    harness.get_by_label_contains("Accuracy vs. cost").click();
    let at = harness.state().session.position(0);
    harness.state_mut().session.grab(0, at);
    harness.run_steps(3);
    assert!(harness.query_by_role_and_label(Role::Slider, "Heading").is_some());
    assert_eq!(nameless(&harness), none, "with wind, help, guide, twin, trade and a grab");
    for integrator in [Integrator::ImplicitMidpoint, Integrator::DormandPrince] {
        harness.state_mut().session.tune(SolverRow::integrator(integrator));
        harness.run_steps(2);
        assert_eq!(nameless(&harness), none, "{integrator}");
    }
    for name in ["Method", "Speed"] {
        harness.get_by_role_and_label(Role::ComboBox, name).click();
        harness.run_steps(2);
        assert_eq!(nameless(&harness), none, "{name}");
        type_in(&mut harness, "", Key::Escape);
    }
    harness.get_by_role_and_label(Role::SpinButton, "Gravity").focus();
    harness.run_steps(2);
    assert_eq!(nameless(&harness), none, "while a number is typed");
    harness.state_mut().command(Command::Open);
    harness.run_steps(3);
    assert!(harness.query_by_label("File").is_some());
    assert_eq!(nameless(&harness), none, "in the gallery");
}

#[test]
fn every_control_of_a_failure_and_of_several_bodies_has_a_name() {
    let mut harness = harness(viewer("jelly", Path::new("")), [1280.0, 1400.0]);
    let none: Vec<String> = Vec::new();
    let session = &mut harness.state_mut().session;
    session.tune(SolverRow::substeps(1));
    session.edit(MaterialEdit::Stiffness(1e6));
    (0..600).for_each(|_| {
        session.advance(1.0 / 60.0 + 1e-9, &|| 0.0);
    });
    harness.run_steps(3);
    assert!(!harness.state().session.offers().is_empty());
    assert_eq!(nameless(&harness), none, "over a run that blew up");
    let folder = folder();
    let bodies = folder.path().join("rope.toml");
    std::fs::write(&bodies, ROPE).expect("a file");
    harness.state_mut().open_path(&bodies);
    harness.run_steps(3);
    assert!(harness.query_by_role_and_label(Role::ComboBox, "Of").is_some(), "it has bodies");
    assert_eq!(nameless(&harness), none, "of several bodies");
}
