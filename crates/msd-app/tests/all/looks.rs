//! Looks of bodies, set in the window: they are always kept, and do not change a bit of a run.

use crate::frames::{loaded, run, session, window};
use egui::Vec2;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::link::Link;
use msd_app::session::{LookEdit, Session};
use msd_app::viewer::{Command, Viewer, catalogue};
use msd_core::{Look, Pattern, Select};
use msd_run::Runner;
use msd_run::on;
use msd_run::recording::load_recording;
use msd_run::replay::Replay;
use msd_scene::schema::{Finish, SolverRow};
use msd_scene::{open, state_hash};
use std::path::Path;

const RED: [f32; 3] = [1.0, 0.2, 0.0];

fn looks(runner: &Runner) -> Vec<Look> {
    on!(runner, simulation => {
        simulation.model().bodies().iter().map(|body| body.look).collect()
    })
}

/// Returns a scene of a block and a cloth, with looks by its author.
fn both(folder: &Path) -> Viewer {
    let path = folder.join("both.toml");
    let text = "version = 1\n[[bodies]]\nkind = 'block'\nsize = [3, 4, 3]\nspacing = 0.1\n\
                mass = 0.01\nstiffness = 40\n\
                look = { roughness = 0.4, colour = '#204060' } # of glass\n\
                [[bodies]]\nkind = 'cloth'\nsize = [4, 5]\nspacing = 0.1\nmass = 0.01\n\
                stiffness = 40\nposition = [0, 1, 0]\n";
    std::fs::write(&path, text).expect("a file");
    let mut viewer =
        Viewer::new(open(&path).expect("a scene"), catalogue()).expect("a valid scene");
    viewer.folder = folder.to_owned();
    viewer
}

#[test]
fn a_look_changes_no_bit_and_no_reading_and_is_undone() {
    let (mut plain, mut painted) = (session("jelly"), session("jelly"));
    let before = looks(painted.runner());
    for session in [&mut plain, &mut painted] {
        session.set_estimating(true);
        run(session, 20);
    }
    let (energy, stability) = (painted.energy(), painted.stability());
    assert!(energy.is_some() && stability.is_some());
    painted.edit_look(LookEdit::Finish(Finish::Metal));
    painted.edit_look(LookEdit::Colour(RED));
    assert_eq!((painted.energy(), painted.stability()), (energy, stability));
    for session in [&mut plain, &mut painted] {
        run(session, 20);
    }
    let hash = |session: &Session| state_hash(&session.runner().state());
    assert_eq!(hash(&plain), hash(&painted));
    assert_eq!(plain.error(), painted.error());
    let metal = Look { colour: Some(RED), ..Finish::Metal.look() };
    assert_eq!(looks(painted.runner()), [metal]);
    painted.restart();
    assert_eq!(looks(painted.runner()), [metal]);
    painted.edit_look(LookEdit::Roughness(0.5));
    painted.edit_look(LookEdit::Roughness(2.0));
    assert_eq!(looks(painted.runner())[0].roughness, 0.5);
    assert!(painted.refusal().is_some_and(|why| why.contains("roughness")));
    painted.undo();
    assert_eq!(looks(painted.runner()), [metal]);
    painted.redo();
    assert_eq!(looks(painted.runner())[0].roughness, 0.5);
    painted.reset_material();
    assert_eq!(looks(painted.runner()), before);
}

#[test]
fn what_is_set_is_of_the_selected_bodies_and_a_chosen_colour_outlives_a_finish() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut viewer = both(folder.path());
    let session = &mut viewer.session;
    let before = looks(session.runner());
    session.select(Select::Body(1));
    session.edit_look(LookEdit::Finish(Finish::Wood));
    session.edit_look(LookEdit::Back(RED));
    let wood = Look { back: Some(RED), ..Finish::Wood.look() };
    assert_eq!(looks(session.runner()), [before[0], wood]);
    session.select(Select::All);
    let shown = session.look_values().expect("bodies");
    assert_eq!((shown.finish, shown.pattern, shown.roughness.mixed), (None, None, true));
    session.edit_look(LookEdit::Finish(Finish::Clay));
    let blue = Look { colour: before[0].colour, ..Finish::Clay.look() };
    let plain = Look { back: Some(RED), ..Finish::Clay.look() };
    assert_eq!(looks(session.runner()), [blue, plain]);
    assert_eq!(session.look_values().expect("bodies").finish, Some(Finish::Clay));
    // A block has no other side.
    session.edit_look(LookEdit::Back([0.0; 3]));
    assert_eq!(looks(session.runner())[0].back, None);
}

#[test]
fn scenes_links_runs_and_recordings_keep_looks() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut viewer = both(folder.path());
    let record = folder.path().join("run.msdrec");
    viewer.session.start_recording(&record);
    let mut number = 0;
    let bodies = [Select::Body(0), Select::Body(1)];
    for (finish, pattern) in Finish::ALL.into_iter().zip(Pattern::ALL.into_iter().cycle()) {
        viewer.session.select(bodies[number % 2]);
        viewer.session.edit_look(LookEdit::Finish(finish));
        viewer.session.edit_look(LookEdit::Pattern(pattern));
        viewer.session.edit_look(LookEdit::PatternSize(0.25));
        viewer.session.edit_look(LookEdit::Colour(RED));
        viewer.session.edit_look(LookEdit::Translucency(0.1 * number as f64));
        viewer.command(Command::SaveScene);
        number += 1;
        let saved = folder.path().join(format!("both-{number}.toml"));
        let text = std::fs::read_to_string(&saved).expect("it was saved");
        let read = Runner::open(&open(&saved).expect("a scene")).expect("a run");
        assert_eq!(looks(&read), looks(viewer.session.runner()), "{text}");
        assert!(text.contains("# of glass"), "{text}");
    }
    let now = looks(viewer.session.runner());
    let link = viewer.link().expect("it is short").to_string();
    let link = Link::parse(&link).expect("a link");
    let again = Viewer::of_link(&link, catalogue()).expect("a link");
    assert_eq!(looks(again.session.runner()), now);
    assert!(again.session.material().is_edited());
    viewer.command(Command::SaveRun);
    let saved = open(folder.path().join("both-1.msd")).expect("a saved run");
    assert_eq!(looks(&Runner::open(&saved).expect("a run")), now);
    viewer.session.stop_recording();
    let recording = load_recording(&record).expect("a recording");
    let mut replay = Replay::new(&recording, SolverRow::default()).expect("a start");
    while replay.advance().expect("a step") {}
    assert_eq!(looks(replay.runner()), now);
}

/// A scene file cannot remove the colour of wood.
#[test]
fn what_looks_like_wood_but_for_its_colour_is_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut viewer = both(folder.path());
    viewer.session.select(Select::Body(1));
    let edits = [
        LookEdit::Finish(Finish::Clay),
        LookEdit::Pattern(Pattern::Grain),
        LookEdit::Roughness(0.6),
    ];
    edits.into_iter().for_each(|edit| viewer.session.edit_look(edit));
    let now = looks(viewer.session.runner());
    assert_eq!(now[1].colour, None);
    viewer.command(Command::SaveScene);
    let saved = open(folder.path().join("both-1.toml")).expect("a saved scene");
    assert_eq!(looks(&Runner::open(&saved).expect("a run")), now);
}

#[test]
fn the_panel_sets_looks_where_they_are_wanted() {
    let viewer = Viewer::new(loaded("cube"), catalogue()).expect("a valid scene");
    let size = Vec2::new(1280.0, 800.0);
    let mut harness = window(viewer, size);
    assert!(harness.query_by_role_and_label(Role::ComboBox, "Finish").is_none());
    let click = |harness: &mut Harness<'_, Viewer>, role: Role, label: &str| {
        harness.get_by_role_and_label(role, label).click();
        harness.run_steps(3);
    };
    click(&mut harness, Role::Button, "Look");
    click(&mut harness, Role::ComboBox, "Finish");
    click(&mut harness, Role::Button, "wood");
    let look = |harness: &Harness<'_, Viewer>| looks(harness.state().session.runner())[0];
    assert_eq!(look(&harness).pattern, Pattern::Grain);
    assert_eq!(look(&harness).roughness, Finish::Wood.look().roughness);
    click(&mut harness, Role::ComboBox, "Pattern");
    click(&mut harness, Role::Button, "stripes");
    assert_eq!(look(&harness).pattern, Pattern::Stripes);
    harness.get_by_role_and_label(Role::Slider, "Pattern size");
    click(&mut harness, Role::Button, "Colour");
    let before = look(&harness);
    click(&mut harness, Role::Button, "#f2b83d");
    let picked = look(&harness).colour.expect("a colour");
    assert_eq!(picked.map(|part| (part * 255.0).round() as u8), [0xf2, 0xb8, 0x3d]);
    assert_eq!(look(&harness), Look { colour: Some(picked), ..before });
    // The picker stays open, and each component follows its slider.
    harness.get_by_role_and_label(Role::Slider, "Blue").focus();
    harness.run_steps(2);
    harness.key_press(egui::Key::ArrowRight);
    harness.run_steps(3);
    let mixed = look(&harness).colour.expect("a colour");
    assert!(picked[2] < mixed[2] && picked[..2] == mixed[..2], "{picked:?} {mixed:?}");
    harness.state_mut().command(Command::Undo);
    assert_eq!(look(&harness), before);
}
