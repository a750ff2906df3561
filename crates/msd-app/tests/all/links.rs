//! Links: made in the window, followed by the window and by the command line.

use crate::common::{folder, json, msd, outcome, refused, text};
use msd_app::catalogue;
use msd_app::link::{Changes, Link, LinkError, Look, OwnScene};
use msd_app::session::{MaterialEdit, MixedValue, Wind};
use msd_app::viewer::Viewer;
use msd_core::{Integrator, Select};
use msd_run::on;
use msd_scene::parts::Part;
use msd_scene::schema::SolverRow;
use msd_scene::{Assignment, Edits, Precision, state_hash};

const STEPS: u64 = 30;

fn viewer(scene: &str) -> Viewer {
    let loaded = msd_scene::open(scene).expect("a built-in scene");
    Viewer::new(loaded, catalogue()).expect("a valid scene")
}

/// Returns a cloth with changes of everything that a user can set.
fn changed() -> Viewer {
    let mut viewer = viewer("cloth");
    let session = &mut viewer.session;
    session.tune(SolverRow::integrator(Integrator::Rk4));
    session.tune(SolverRow::substeps(16));
    session.edit(MaterialEdit::Stiffness(321.0));
    session.edit(MaterialEdit::Gravity(3.7));
    session.edit(MaterialEdit::Damping(0.25));
    session.edit(MaterialEdit::RestScale(1.125));
    session.set_speed(0.25);
    (viewer.aim.follow, viewer.style.wireframe, viewer.style.shadows) = (false, true, false);
    viewer.camera.orbit(0.5, 0.25);
    viewer.camera.zoom(1.5);
    viewer
}

fn hash_after(viewer: &Viewer, steps: u64) -> u64 {
    let mut runner = viewer.session.runner().clone();
    (0..steps).for_each(|_| runner.step().expect("a run that stays up"));
    state_hash(&runner.state())
}

#[test]
fn a_link_brings_back_settings_camera_and_bits() {
    let first = changed();
    let link = Link::parse(&first.link().expect("a built-in scene").to_string());
    let mut second = viewer("jelly");
    second.open_link(&link.expect("a link"));
    assert_eq!(second.session.refusal(), None);
    assert_eq!(second.session.loaded().name, "cloth");
    assert_eq!(second.session.runner().settings(), first.session.runner().settings());
    assert_eq!(second.session.material().values(), first.session.material().values());
    assert_eq!(second.session.speed(), 0.25);
    assert_eq!((second.camera, second.aim.follow), (first.camera, first.aim.follow));
    assert_eq!(second.style, first.style);
    assert_eq!(hash_after(&second, STEPS), hash_after(&first, STEPS));
    assert_eq!(second.link(), first.link());
    // Settings from a link count as edits: a restart keeps them.
    assert!(second.session.material().is_edited());
}

#[test]
fn a_link_leaves_nothing_to_undo_and_no_mark() {
    let link = changed().link().expect("a built-in scene");
    let viewer = Viewer::of_link(&link, catalogue()).expect("a link");
    assert_eq!((viewer.session.undoes(), viewer.session.marks().count()), (None, 0));
}

#[test]
fn a_link_holds_the_wind_and_a_run_follows_it() {
    let mut first = viewer("cloth");
    first.session.set_wind(Wind { strength: 3.0, heading: 0.75, gusts: 0.0 });
    let link = first.link().expect("a built-in scene");
    let mut second = viewer("jelly");
    second.open_link(&link);
    assert_eq!(second.session.wind(), first.session.wind());
    let blown = |viewer: &mut Viewer| {
        while viewer.session.runner().steps() < STEPS {
            viewer.session.advance(1.0 / 60.0, &|| 0.0);
        }
        assert_eq!(viewer.session.runner().steps(), STEPS);
        state_hash(&viewer.session.runner().state())
    };
    let here = blown(&mut first);
    assert_eq!(blown(&mut second), here);
    assert_ne!(blown(&mut viewer("cloth")), here, "without a wind");
    assert_eq!(hash_of_run(&link.to_string()), format!("{here:016x}"));
    let wind = Wind { gusts: 0.5, ..first.session.wind() };
    first.session.set_wind(wind);
    first.session.restart();
    let gusty = first.link().expect("a built-in scene").to_string();
    let here = blown(&mut first);
    assert_eq!(hash_of_run(&gusty), format!("{here:016x}"));
}

/// Returns the hash after half a second on the command line.
fn hash_of_run(scene: &str) -> String {
    let report = json(msd(folder().path(), &["run", scene, "--duration", "0.5"]));
    report["state_hash"].as_str().expect("a hash").to_owned()
}

#[test]
fn a_link_holds_what_was_set_of_each_body_rest_lengths_too() {
    let mut first = viewer("mattress");
    first.session.edit(MaterialEdit::RestScale(1.0625));
    first.session.select(Select::Body(0));
    // Half of the factor for all: a factor of two does not round again.
    first.session.edit(MaterialEdit::RestScale(0.53125));
    first.session.edit(MaterialEdit::Stiffness(654.0));
    first.session.switch(Part::Contact, false);
    let link = first.link().expect("a built-in scene").to_string();
    let second = Viewer::of_link(&Link::parse(&link).expect("a link"), catalogue());
    let second = second.expect("a link");
    assert_eq!(hash_after(&second, STEPS), hash_after(&first, STEPS));
    assert_eq!(second.link().map(|link| link.to_string()), Ok(link.clone()));
    assert_eq!(hash_of_run(&link), format!("{:016x}", hash_after(&first, STEPS)));
    assert_ne!(hash_of_run("mattress"), hash_of_run(&link));
    // A restart keeps them, like all other keys.
    first.session.restart();
    assert_eq!(first.link().map(|link| link.to_string()), Ok(link));
}

#[test]
fn study_tune_inspect_and_render_take_a_link_and_a_sweep_says_that_it_does_not() {
    let mut viewer = viewer("chain");
    viewer.session.switch(Part::Gravity, false);
    viewer.session.edit(MaterialEdit::Damping(0.0));
    let link = viewer.link().expect("a built-in scene");
    let opened = link.open().expect("a scene");
    assert_eq!(opened.scene.world.gravity, msd_core::glam::DVec3::ZERO);
    let link = link.to_string();
    let folder = folder();
    let rows = json(msd(folder.path(), &["study", &link, "--terms", "--duration", "0.1"]));
    let terms: Vec<&str> =
        rows.as_array().expect("rows").iter().filter_map(|row| row["term"].as_str()).collect();
    assert!(!terms.contains(&"gravity") && !terms.contains(&"damping"), "{terms:?}");
    let goal = ["--max-error", "0.01", "--duration", "0.1"];
    let tuned = json(msd(folder.path(), &[&["tune", &link][..], &goal].concat()));
    assert_eq!(tuned["scene"], "chain");
    let write = msd(folder.path(), &[&["tune", &link, "--write"][..], &goal].concat());
    assert!(refused(write, 2).contains("--write changes a scene file"));
    let inspected = json(msd(folder.path(), &["inspect", &link]));
    assert_eq!(inspected["scene"], "chain");
    let drawn = outcome(msd(folder.path(), &["render", &link, "--time", "0", "--size", "64x48"]));
    // Without a graphics driver, the command fails only at the rendering.
    let said = text(&drawn.stderr);
    assert!(folder.path().join("chain.png").exists() || said.contains("adapter"), "{said}");
    assert!(refused(msd(folder.path(), &["sweep", &link]), 2).contains("not a link"));
    let sweep =
        format!("version = 1\nscene = '{link}'\nduration = 1\n[grid]\n'world.drag' = [0, 1]\n");
    std::fs::write(folder.path().join("sweep.toml"), sweep).expect("a file");
    let said = refused(msd(folder.path(), &["sweep", "sweep.toml"]), 2);
    assert!(said.contains("a sweep takes no link"), "{said}");
}

#[test]
fn a_file_that_is_named_like_a_link_is_a_file() {
    let folder = folder();
    let name = "#scene=x.toml";
    let text = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\n";
    std::fs::write(folder.path().join(name), text).expect("a file");
    for scene in [name, "./#scene=x.toml"] {
        let report = json(msd(folder.path(), &["run", scene, "--duration", "0.1"]));
        assert_eq!(report["particles"], 3, "{scene}");
    }
    let missing = refused(msd(folder.path(), &["run", "./#scene=y.toml"]), 2);
    assert!(missing.contains("y.toml") && !missing.contains("link"), "{missing}");
}

#[test]
fn the_command_line_runs_a_link_as_the_window_does() {
    let mut changed = changed();
    changed.session.tune(SolverRow::precision(Precision::F64));
    let link = changed.link().expect("a built-in scene");
    // Not from the state of the other window, which was rounded to f32 first.
    let viewer = Viewer::of_link(&link, catalogue()).expect("a link");
    let link = format!("https://a.example/{link}");
    let folder = folder();
    let arguments = ["run", &link, "--duration", "0.5", "--save", "end.msd"];
    let report = json(msd(folder.path(), &arguments));
    assert_eq!((&report["scene"], &report["integrator"]), (&"cloth".into(), &"rk4".into()));
    assert_eq!((&report["precision"], &report["substeps"]), (&"f64".into(), &16.into()));
    let end = msd_scene::open(folder.path().join("end.msd")).expect("a saved run");
    let end = msd_run::Runner::open(&end).expect("a saved run");
    on!(&end, simulation => assert_eq!(simulation.steps(), STEPS));
    assert_eq!(state_hash(&end.state()), hash_after(&viewer, STEPS));
}

#[test]
fn a_link_that_says_nothing_usable_is_refused_in_one_line() {
    let whole = changed().link().expect("a link").to_string();
    let cut = &whole[..whole.len() - 5];
    for (link, words) in [
        (cut, "damaged"),
        ("#scene=nothing", "an unknown scene: `nothing`"),
        ("#scene=/etc/passwd", "an unknown scene"),
        ("#scene=", "names no scene"),
    ] {
        for command in ["run", "view"] {
            let output = outcome(msd(folder().path(), &[command, link]));
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{said}");
            assert_eq!(said.lines().count(), 1, "{said}");
            assert!(said.contains(words), "{said}");
        }
    }
}

const TETRAHEDRON: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// A scene of the user's own, with an own mesh.
const OWN: &str = r#"
version = 1
title = "My own"
[world]
gravity = [0.0, -3.0, 0.0]
[[bodies]]
name = "tetrahedron"
kind = "mesh"
file = "./parts/t.obj"
"#;

/// Returns a viewer of the user's own scene, with changes of everything that a user can set.
fn own(folder: &std::path::Path) -> Viewer {
    std::fs::create_dir(folder.join("parts")).expect("a folder");
    std::fs::write(folder.join("parts/t.obj"), TETRAHEDRON).expect("a mesh");
    // It has the name of a built-in scene, but differs.
    std::fs::write(folder.join("cloth.toml"), OWN).expect("a scene");
    let mut viewer = viewer("cube");
    viewer.open_path(&folder.join("cloth.toml"));
    assert_eq!(viewer.session.loaded().title, "My own", "{:?}", viewer.note);
    viewer.session.edit(MaterialEdit::Stiffness(321.0));
    viewer.camera.orbit(0.5, 0.25);
    viewer.aim.follow = false;
    viewer
}

#[test]
fn a_link_holds_a_scene_of_the_users_own_with_its_mesh() {
    let folder = folder();
    let first = own(folder.path());
    let text = first.link().expect("a link").to_string();
    assert!(text.len() < 1000, "{text}");
    std::fs::remove_file(folder.path().join("parts/t.obj")).expect("it was there");
    let link = Link::parse(&text).expect("a link");
    let fresh = Viewer::of_link(&link, catalogue()).expect("a link");
    let mut other = viewer("jelly");
    other.open_link(&link);
    for second in [&fresh, &other] {
        assert_eq!(second.session.loaded().scene, first.session.loaded().scene);
        assert_eq!(second.session.material().values(), first.session.material().values());
        assert_eq!((second.camera, second.current()), (first.camera, None));
        assert_eq!(hash_after(second, STEPS), hash_after(&first, STEPS));
        assert_eq!(second.link().expect("a link").to_string(), text);
    }
    let report =
        json(msd(folder.path(), &["run", &text, "--duration", "0.5", "--save", "end.msd"]));
    assert_eq!(report["scene"], "cloth");
    let end = msd_scene::open(folder.path().join("end.msd")).expect("a saved run");
    let end = msd_run::Runner::open(&end).expect("a saved run");
    assert_eq!(state_hash(&end.state()), hash_after(&first, STEPS));
    // A file that has changed since differs from the displayed scene.
    std::fs::write(folder.path().join("parts/t.obj"), TETRAHEDRON.replace("v 1", "v 2"))
        .expect("a mesh");
    assert!(first.link().expect_err("another scene").contains("open it again"));
}

#[test]
fn a_link_holds_a_mesh_that_was_dropped_and_says_which_file_is_too_large() {
    let mut viewer = viewer("cube");
    viewer.open_bytes("tetra.obj", TETRAHEDRON.as_bytes());
    assert_eq!(viewer.session.refusal(), None);
    let link = Link::parse(&viewer.link().expect("a mesh").to_string()).expect("a link");
    let again = Viewer::of_link(&link, catalogue()).expect("a link");
    assert_eq!(again.session.loaded().scene, viewer.session.loaded().scene);
    // An invalid file leaves the scene running.
    viewer.open_bytes("broken.obj", b"v 1 nan");
    assert!(viewer.session.refusal().is_some_and(|line| line.contains("broken.obj")));
    assert_eq!(viewer.session.loaded().name, "tetra");
    // Beyond the largest link, and beyond the largest content.
    for lines in [10_000u64, 100_000] {
        // Incompressible.
        let noise = (0..lines).map(|n| format!("# {}\n", n.wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        let large = TETRAHEDRON.to_owned() + &noise.collect::<String>();
        viewer.open_bytes("large.obj", large.as_bytes());
        assert_eq!(viewer.session.loaded().name, "large");
        let why = viewer.link().map(|link| link.to_string().len());
        assert!(why.as_ref().is_err_and(|why| why.contains("large.obj is too large")), "{why:?}");
    }
}

#[test]
fn a_link_to_a_scene_of_ones_own_that_was_cut_off_or_changed_is_refused_at_every_place() {
    let folder = folder();
    let text = own(folder.path()).link().expect("a link").to_string();
    for end in 1..text.len() {
        // Before its changes, the link is whole: the scene as its author made it.
        if end == text.find("&with").expect("changes") {
            continue;
        }
        let cut = Link::parse(&text[..end]);
        assert!(cut.is_err(), "{end} of {}: {cut:?}", text.len());
    }
    let start = text.find("file=").expect("a file") + 5;
    for place in start + 2..text.find("&with").expect("changes") {
        let mut other = text.clone().into_bytes();
        other[place] = if other[place] == b'A' { b'B' } else { b'A' };
        let other = String::from_utf8(other).expect("letters");
        assert_eq!(Link::parse(&other), Err(LinkError::Damaged), "{place}");
    }
    assert_eq!(Link::parse("#scene=own&file=Y2NjY2NjY2M"), Err(LinkError::Format(99)));
}

#[test]
fn what_a_link_holds_and_is_no_scene_is_refused_in_one_line() {
    let own = |file: &str, text: &str| {
        let own = OwnScene { file: file.into(), bytes: text.into(), meshes: Default::default() };
        Link { own: Some(own), ..Link::to("any") }
    };
    for (file, text_of_file, words) in [
        ("a.toml", "version = 1\nbodies = 3", "a.toml"),
        ("a.exe", "", "unknown extension"),
        ("a.msd", "no run", "a.msd"),
        ("a\n\nb.toml", "version", "b.toml"),
    ] {
        let link = own(file, text_of_file).to_string();
        for command in ["run", "view"] {
            let output = outcome(msd(folder().path(), &[command, &link]));
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{said}");
            assert!(said.contains(words), "{said}");
        }
        let mut viewer = viewer("chain");
        viewer.open_link(&Link::parse(&link).expect("whole"));
        assert!(viewer.session.refusal().is_some());
        assert_eq!(viewer.session.loaded().name, "chain");
    }
}

fn sample() -> Link {
    let look = Look {
        target: [0.5, -1.0, 2.0],
        distance: 7.0,
        yaw: 1.0,
        pitch: 0.25,
        follow: true,
        shown: 0b101_1001,
    };
    let mut set = Edits::default();
    set.set(Assignment::new("bodies.stiffness", 1234.5));
    let solver = [
        SolverRow::substeps(21),
        SolverRow::precision(Precision::F64),
        SolverRow::integrator(Integrator::VelocityVerlet),
    ];
    solver.iter().flat_map(SolverRow::assignments).for_each(|edit| set.set(edit));
    let changes = Changes { speed: 0.25, look, set, former: None };
    Link { changes: Some(changes), ..Link::to("cloth") }
}

#[test]
fn a_link_says_all_that_it_was_made_of_and_is_short() {
    let text = sample().to_string();
    assert_eq!(Link::parse(&text), Ok(sample()));
    assert_eq!(Link::parse(&format!("https://a.example/msd/{text}&embed")), Ok(sample()));
    assert!(text.len() < 250, "{text}");
    let as_fast_as_it_goes = {
        let mut link = sample();
        link.changes.as_mut().expect("changes").speed = f64::INFINITY;
        link
    };
    assert_eq!(Link::parse(&as_fast_as_it_goes.to_string()), Ok(as_fast_as_it_goes));
    let plain = Link::to("jelly");
    assert_eq!(plain.to_string(), "#scene=jelly");
    assert_eq!(Link::parse("#scene=jelly"), Ok(plain));
}

/// A link to `cloth` in format 3: stiffness set, contact off, longer springs, a gusty wind.
const FORMER: &str = concat!(
    "#scene=cloth&with=AwIRERERERGRPxWN7bWg98awPgEAAQMGAAAAAAAASpNAEgoAAAAAAAAA9D8AAAAAAAAEQAAA",
    "AAAAAOA_AAAAAAAA0D8AAAAAAADQPwAAAD8AAIC_AAAAQAAA4EAAAIA_AACAPgFZKUU_Wg",
);

/// The same in format 4, with other keys.
const KEYS: &str = concat!(
    "#scene=cloth&with=BAIRERERERGRPxWN7bWg98awPgEAAQEKAAAAAAAAAPQ_AAAAAAAAAAAAAAAAAAAAAAAAAAAAAA",
    "AAAAAAAAAA0D8AAAA_AACAvwAAAEAAAOBAAACAPwAAgD4BWQMXYm9kaWVzLnN0aWZmbmVzcz0xMjM0LjU7d29ybGQud2",
    "luZD17InN0cmVuZ3RoIjoyLjUsImhlYWRpbmdfZGVnIjozMC4wLCJndXN0cyI6MC4yNX0Pb2ZmPVsiY29udGFjdCJdbP",
    "JxFw",
);

#[test]
fn links_of_formats_before_open_as_they_did() {
    for (text, keys) in [
        (FORMER, ["bodies.stiffness", "bodies[0].rest_scale", "world.wind", "off"]),
        (KEYS, ["bodies[0].rest_scale", "bodies.stiffness", "world.wind", "off"]),
    ] {
        let link = Link::parse(text).expect("a link of a format before");
        let viewer = Viewer::of_link(&link, catalogue()).expect("a link");
        let set = viewer.session.material().set().iter().map(|edit| edit.key().to_owned());
        assert_eq!(set.collect::<Vec<_>>(), keys);
        let values = viewer.session.material().values();
        let first = |value: Option<MixedValue>| value.map(|value| value.first);
        assert_eq!((first(values.stiffness), first(values.rest_scale)), (Some(1234.5), Some(1.25)));
        let runner = viewer.session.runner();
        assert_eq!((runner.settings().substeps, runner.precision()), (21, Precision::F64));
        assert!(!runner.is_automatic() && viewer.session.wind().is_gusty());
        assert_eq!(viewer.session.speed(), 0.25);
        // The window makes a link of the current format from it.
        let again = viewer.link().expect("a link").to_string();
        let again = Viewer::of_link(&Link::parse(&again).expect("a link"), catalogue());
        assert_eq!(hash_after(&again.expect("a link"), STEPS), hash_after(&viewer, STEPS));
    }
}

#[test]
fn a_link_that_was_cut_off_or_changed_is_refused_at_every_place() {
    let text = sample().to_string();
    let start = text.find("with=").expect("changes") + 5;
    for end in text.find('&').expect("changes") + 1..text.len() {
        let cut = Link::parse(&text[..end]);
        assert!(cut.is_err(), "{} of {}: {cut:?}", end, text.len());
    }
    // The first byte is the format: two letters of base 64 hold it.
    for place in start + 2..text.len() {
        let mut other = text.clone().into_bytes();
        other[place] = if other[place] == b'A' { b'B' } else { b'A' };
        let other = String::from_utf8(other).expect("letters");
        assert_eq!(Link::parse(&other), Err(LinkError::Damaged), "{place}");
    }
}

#[test]
fn a_link_of_another_format_or_scene_says_so() {
    // Eight times the byte 99: the format, and any content.
    assert_eq!(Link::parse("#scene=cloth&with=Y2NjY2NjY2M"), Err(LinkError::Format(99)));
    let unknown = Err(LinkError::UnknownScene("/etc/passwd".into()));
    assert_eq!(Link::parse("#scene=/etc/passwd"), unknown);
    assert_eq!(Link::parse("#with=abc"), Err(LinkError::NoScene));
}

#[test]
fn a_link_that_would_be_too_long_is_not_made_and_not_read() {
    let mut link = sample();
    let set = &mut link.changes.as_mut().expect("changes").set;
    (0..2_000).for_each(|row| set.set(Assignment::new(&format!("bodies[{row}].stiffness"), 0.5)));
    assert_eq!(Link::parse(&link.to_string()), Err(LinkError::TooLarge));
    // The address of a page before it does not count.
    let page = format!("http://127.0.0.1/{}/", "msd".repeat(30_000));
    assert_eq!(Link::parse(&format!("{page}#scene=cloth")), Ok(Link::to("cloth")));
}

#[test]
fn a_link_cannot_hold_more_than_settings() {
    for key in ["bodies[0].size", "version", "nothing.of_the_kind", "solver.integrator"] {
        let mut bad = sample();
        bad.changes.as_mut().expect("changes").set.set(Assignment::new(key, 3));
        assert_eq!(Link::parse(&bad.to_string()), Err(LinkError::Damaged), "{key}");
    }
    let mut bad = sample();
    bad.changes.as_mut().expect("changes").look.yaw = f32::NAN;
    assert_eq!(Link::parse(&bad.to_string()), Err(LinkError::Damaged));
}
