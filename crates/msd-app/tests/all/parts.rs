//! Model terms, switched off and on again during a run: edits like any other.

use crate::frames::{loaded, run, session};
use msd_app::catalogue;
use msd_app::link::Link;
use msd_app::session::{Deed, MarkKind, MaterialEdit, Session};
use msd_app::viewer::{Command, Viewer};
use msd_core::{Scene, Vector};
use msd_run::on;
use msd_run::recording::load_recording;
use msd_run::replay::Replay;
use msd_scene::open;
use msd_scene::parts::Part;
use msd_scene::schema::SolverRow;

fn parts(session: &mut Session) -> Vec<(Part, bool)> {
    session.look_at_parts();
    session.parts().to_vec()
}

fn is_on(session: &mut Session, part: Part) -> bool {
    parts(session).contains(&(part, true))
}

/// Returns the current scene, in its initial state.
fn scene(session: &Session) -> Scene {
    session.runner().progress().0
}

/// Formats springs, world and planes, for comparison.
fn model(session: &Session) -> String {
    let Scene { world, springs, planes, .. } = scene(session);
    format!("{world:?} {springs:?} {planes:?}")
}

#[test]
fn every_part_of_a_scene_is_switched_off_and_on_in_one_edit_that_undo_takes_back() {
    let mut session = session("jelly");
    let there = parts(&mut session);
    let expected =
        [Part::Damping, Part::Gravity, Part::FaceDiagonals, Part::SpaceDiagonals, Part::Contact];
    assert_eq!(there, expected.map(|part| (part, true)));
    let whole = model(&session);
    for part in expected {
        session.switch(part, false);
        assert!(!is_on(&mut session, part), "{part:?}");
        let others = parts(&mut session).iter().filter(|(other, on)| *other != part && *on).count();
        assert_eq!(others, expected.len() - 1, "{part:?}");
        assert_eq!(session.undoes(), Some(Deed::Switch(part.name())));
        assert!(session.marks().any(|mark| mark.kind == MarkKind::Edit));
        let without = model(&session);
        session.undo();
        assert_eq!(model(&session), whole, "{part:?}");
        session.redo();
        assert_eq!(model(&session), without, "{part:?}");
        // A term that is off stays off after a restart.
        session.restart();
        assert_eq!(model(&session), without, "{part:?}");
        session.switch(part, true);
        assert_eq!(model(&session), whole, "{part:?}");
        assert_eq!(session.refusal(), None);
        session.restart();
    }
}

#[test]
fn parts_that_share_springs_come_back_alone() {
    let mut session = session("jelly");
    let whole = model(&session);
    session.switch(Part::FaceDiagonals, false);
    session.switch(Part::Damping, false);
    session.switch(Part::FaceDiagonals, true);
    assert!(is_on(&mut session, Part::FaceDiagonals) && !is_on(&mut session, Part::Damping));
    assert!(scene(&session).springs.iter().all(|spring| spring.damping == 0.0));
    session.switch(Part::FaceDiagonals, false);
    session.switch(Part::Damping, true);
    assert!(!is_on(&mut session, Part::FaceDiagonals) && is_on(&mut session, Part::Damping));
    session.switch(Part::FaceDiagonals, true);
    assert_eq!(model(&session), whole);
    session.switch(Part::FaceDiagonals, false);
    session.switch(Part::Damping, false);
    session.switch(Part::Damping, true);
    assert!(!is_on(&mut session, Part::FaceDiagonals) && is_on(&mut session, Part::Damping));
    session.switch(Part::FaceDiagonals, true);
    assert_eq!(model(&session), whole);
    assert!(session.material().set().is_empty());
}

#[test]
fn what_is_off_stays_off_under_the_sliders_and_comes_back_as_they_set_it() {
    let mut session = session("jelly");
    session.switch(Part::SpaceDiagonals, false);
    session.edit(MaterialEdit::Stiffness(300.0));
    session.edit(MaterialEdit::Damping(0.5));
    assert!(!is_on(&mut session, Part::SpaceDiagonals) && is_on(&mut session, Part::Damping));
    let without = model(&session);
    session.restart();
    assert_eq!(model(&session), without);
    session.switch(Part::SpaceDiagonals, true);
    let all = |session: &Session, wanted: [f64; 2]| {
        scene(session).springs.iter().all(|spring| [spring.stiffness, spring.damping] == wanted)
    };
    assert!(all(&session, [300.0, 0.5]));
    session.restart();
    assert!(all(&session, [300.0, 0.5]));
    // The slider of a term that is off switches it on, and the switch shows it.
    session.switch(Part::Damping, false);
    assert!(!is_on(&mut session, Part::Damping));
    session.edit(MaterialEdit::Damping(0.25));
    assert!(is_on(&mut session, Part::Damping) && all(&session, [300.0, 0.25]));
    // One step of undo for each.
    session.undo();
    assert!(all(&session, [300.0, 0.0]));
}

#[test]
fn a_body_of_a_material_is_switched_in_a_few_edits_however_many_values_it_has() {
    let folder = tempfile::tempdir().expect("a folder");
    let gel = folder.path().join("gel.toml");
    let text = "version = 1\n[[bodies]]\nkind = 'block'\nsize = [9, 9, 9]\nspacing = 0.01\n\
        material = 'gelatine-3%'\n";
    std::fs::write(&gel, text).expect("a file");
    let mut session = Session::new(open(&gel).expect("a scene")).expect("a valid scene");
    // Automatic substeps would differ between the run and its twin.
    session.tune(SolverRow::substeps(64));
    let whole = model(&session);
    let tape = folder.path().join("tape.msdrec");
    session.start_recording(&tape);
    session.set_twin(Some(session.runner().settings()));
    run(&mut session, 3);
    session.switch(Part::FaceDiagonals, false);
    run(&mut session, 3);
    let set: Vec<&str> = session.material().set().iter().map(|edit| edit.key()).collect();
    assert_eq!(set, ["off"]);
    session.switch(Part::FaceDiagonals, true);
    assert_eq!(model(&session), whole);
    assert!(session.material().set().is_empty());
    run(&mut session, 3);
    let twin = session.twin().expect("it is on");
    assert_eq!((twin.apart().max, twin.failure()), (0.0, None));
    session.restart();
    assert_eq!(model(&session), whole);
    session.stop_recording();
    let tape = load_recording(&tape).expect("a recording");
    assert!(tape.events.len() < 40, "{} events", tape.events.len());
    let mut replay = Replay::new(&tape, SolverRow::default()).expect("a run");
    while replay.advance().expect("it replays") {}
}

/// Returns the positions of all particles.
fn places(session: &Session) -> Vec<msd_core::glam::DVec3> {
    on!(session.runner(), simulation => {
        simulation.positions().map(|position| position.to_f64()).collect()
    })
}

#[test]
fn what_fell_through_the_ground_is_lifted_out_as_it_is() {
    let mut session = session("jelly");
    let by_switch: fn(&mut Session) = |session| session.switch(Part::Contact, true);
    for back in [by_switch, Session::undo] {
        session.restart();
        session.switch(Part::Contact, false);
        run(&mut session, 240);
        let plane = loaded("jelly").scene.planes[0];
        let depth = |places: &[msd_core::glam::DVec3]| {
            places.iter().map(|at| at.dot(plane.normal) - plane.offset).fold(f64::MAX, f64::min)
        };
        let below = places(&session);
        assert!(depth(&below) < -1.0);
        back(&mut session);
        let above = places(&session);
        // Single precision at some metres.
        assert!(-1e-4 <= depth(&above) && depth(&above) < 1e-3, "{}", depth(&above));
        let way = above[0] - below[0];
        assert!(below.iter().zip(&above).all(|(a, b)| (*b - *a - way).length() < 1e-3));
        run(&mut session, 60);
        assert!(session.failure().is_none() && -0.1 < depth(&places(&session)));
        assert!(is_on(&mut session, Part::Contact));
    }
}

#[test]
fn a_scene_file_says_which_parts_are_off() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut viewer = Viewer::new(loaded("jelly"), catalogue()).expect("a valid scene");
    viewer.folder = folder.path().to_owned();
    [Part::Contact, Part::Gravity, Part::Damping]
        .into_iter()
        .for_each(|part| viewer.session.switch(part, false));
    viewer.command(Command::SaveScene);
    let saved = open(folder.path().join("jelly-1.toml")).expect("a scene").scene;
    assert!(saved.planes.is_empty() && saved.world.gravity.length() == 0.0);
    assert!(saved.springs.iter().all(|spring| spring.damping == 0.0));
    viewer.session.switch(Part::FaceDiagonals, false);
    viewer.command(Command::SaveScene);
    let saved = open(folder.path().join("jelly-2.toml")).expect("a scene").scene;
    // The run has rounded the rest lengths.
    let constants = |scene: &Scene| -> Vec<[f64; 2]> {
        scene.springs.iter().map(|spring| [spring.stiffness, spring.damping]).collect()
    };
    assert!(constants(&saved) == constants(&scene(&viewer.session)));
    assert!(constants(&saved).iter().any(|spring| spring[0] == 0.0));
    let gel = folder.path().join("gel.toml");
    let text = "version = 1\n[[bodies]]\nkind = 'block'\nsize = [3, 3, 3]\nspacing = 0.01\n\
        material = 'gelatine-3%'\n";
    std::fs::write(&gel, text).expect("a file");
    let mut of_gel = Viewer::new(open(&gel).expect("a scene"), catalogue()).expect("a valid scene");
    of_gel.folder = folder.path().to_owned();
    of_gel.command(Command::SaveScene);
    assert!(folder.path().join("gel-1.toml").exists(), "{:?}", of_gel.note);
    of_gel.session.switch(Part::FaceDiagonals, false);
    of_gel.command(Command::SaveScene);
    let text = std::fs::read_to_string(folder.path().join("gel-2.toml")).expect("a file");
    assert!(text.starts_with("version = 1\noff = [\"face-diagonals\"]\n"), "{text}");
    // The command saves a run, which contains it.
    viewer.command(Command::CopyCommand);
    let line = viewer.wishes.clipboard.clone().expect("a command");
    let run = line.strip_prefix("msd view ").expect("a command");
    let run = msd_run::Runner::open(&open(run).expect("a saved run")).expect("a saved run");
    assert_eq!(run.progress().0.planes, []);
    assert_eq!(run.progress().0.springs, scene(&viewer.session).springs);
}

#[test]
fn sets_masses_and_links_are_in_a_saved_scene_and_in_a_link_as_they_were_set() {
    let text = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [5]\n\
        [[bodies]]\nkind = 'block'\nsize = [3, 3, 3]\nspacing = 0.5\nposition = [3, 0, 0]\n\
        [[pins]]\nset = 'first'\n[[masses]]\nbody = 'block'\nset = 'right'\nmass = 0.5\n\
        [[links]]\nfrom = { body = 'block', set = 'left' }\nto = { body = 'rope', set = 'last' }\n";
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("hung.toml");
    std::fs::write(&file, text).expect("a file");
    let mut viewer = Viewer::new(open(&file).expect("a scene"), catalogue()).expect("a viewer");
    viewer.folder = folder.path().to_owned();
    viewer.session.edit(MaterialEdit::Stiffness(321.0));
    run(&mut viewer.session, 1);
    viewer.command(Command::SaveScene);
    let saved = open(folder.path().join("hung-1.toml")).expect("a scene").scene;
    let of_file = &viewer.session.loaded().scene;
    // The links too, as all springs were selected.
    assert!(saved.springs.iter().all(|spring| spring.stiffness == 321.0));
    assert_eq!(saved.springs.len(), of_file.springs.len());
    assert_eq!((&saved.particles, &saved.pins), (&of_file.particles, &of_file.pins));
    let link = Link::parse(&viewer.link().expect("a link").to_string()).expect("a link");
    let again = Viewer::of_link(&link, catalogue()).expect("a link");
    assert_eq!(again.session.loaded().scene, *of_file);
    assert_eq!(scene(&again.session).springs, scene(&viewer.session).springs);
}
