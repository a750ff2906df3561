//! `--set`: keys of a scene on the command line, typed and checked as in a file.

use crate::common::{done, folder, json, msd, parse, quiet, refused};
use serde_json::json;
use std::fs;
use std::path::Path;

const ROPE: &str = "version = 1\ntitle = 'a rope'\n[[bodies]]\nkind = 'rope'\nname = 'r'\n\
                    size = [5]\nstiffness = 900\ndamping = 1\n";

/// The rope with two changed and two additional keys.
const CHANGED: &str = "version = 1\ntitle = 'a rope'\n[solver]\nintegrator = 'rk4'\n[world]\n\
                       gravity = [0, -1.62, 0]\n[[bodies]]\nkind = 'rope'\nname = 'r'\n\
                       size = [5]\nstiffness = 300\ndamping = 1\n";

const SET: [&str; 6] = [
    "--set",
    "world.gravity=[0,-1.62,0]",
    "--set",
    "bodies.0.stiffness=300",
    "--set",
    "solver.integrator=rk4",
];

fn rope() -> tempfile::TempDir {
    let folder = folder();
    fs::write(folder.path().join("rope.toml"), ROPE).expect("a scene");
    fs::write(folder.path().join("changed.toml"), CHANGED).expect("a scene");
    folder
}

fn with_set(arguments: &[&'static str]) -> Vec<&'static str> {
    [arguments, &SET].concat()
}

#[test]
fn a_scene_with_keys_set_is_the_scene_whose_file_says_so() {
    let folder = rope();
    let set = json(msd(folder.path(), &with_set(&["run", "rope.toml", "--duration", "1"])));
    let file = json(msd(folder.path(), &["run", "changed.toml", "--duration", "1"]));
    assert_eq!(set["state_hash"], file["state_hash"]);
    assert_eq!(set["integrator"], "rk4");
    let keys = json!({
        "world.gravity": [0, -1.62, 0], "bodies[0].stiffness": 300, "solver.integrator": "rk4"
    });
    assert_eq!((&set["set"], &file["set"]), (&keys, &json!({})));
    let told = quiet(msd(folder.path(), &with_set(&["run", "rope.toml", "--duration", "1"])));
    assert!(told.contains("set bodies[0].stiffness = 300\n"), "{told}");
    // An option of the command line overrides both.
    let both = [&SET[..], &["--integrator", "xpbd"]].concat();
    let both = [&["run", "rope.toml", "--duration", "0.1"], &both[..]].concat();
    assert_eq!(json(msd(folder.path(), &both))["integrator"], "xpbd");
}

#[test]
fn the_other_commands_set_keys_too() {
    let folder = rope();
    let inspected = |scene| json(msd(folder.path(), &["inspect", scene]));
    let set = json(msd(folder.path(), &with_set(&["inspect", "rope.toml"])));
    assert_eq!(set["bodies"], inspected("changed.toml")["bodies"]);
    assert_ne!(set["bodies"], inspected("rope.toml")["bodies"]);
    assert_eq!(set["set"]["bodies[0].stiffness"], 300);
    let tune = |scene, set: &[&'static str]| {
        let goal = ["tune", scene, "--max-error", "0.001", "--duration", "0.1", "--json"];
        parse(&done(msd(folder.path(), &[&goal, set].concat())))
    };
    // The uncertainty of the reference depends on the scene only.
    let uncertain = "reference_uncertainty";
    assert_eq!(tune("rope.toml", &SET)[uncertain], tune("changed.toml", &[])[uncertain]);
    let terms = ["study", "rope.toml", "--terms", "--duration", "0.1", "--json"];
    let without = parse(&done(msd(folder.path(), &terms)));
    let weightless = [&terms[..], &["--set", "world.gravity=[0,0,0]"]].concat();
    let with = parse(&done(msd(folder.path(), &weightless)));
    assert_ne!(without.as_array().map(Vec::len), with.as_array().map(Vec::len));
}

#[test]
fn a_recording_and_a_saved_run_keep_what_was_set() {
    let folder = rope();
    let files = ["run", "rope.toml", "--duration", "1", "--record", "r.msdrec", "--save", "r.msd"];
    let run = json(msd(folder.path(), &with_set(&files)));
    let replayed = json(msd(folder.path(), &["run", "--replay", "r.msdrec"]));
    assert_eq!(replayed["replay"]["same_bits"], true);
    assert_eq!(replayed["state_hash"], run["state_hash"]);
    let saved = msd_scene::open(folder.path().join("r.msd")).expect("a saved run");
    let told = ", with world.gravity = [0, -1.62, 0], bodies[0].stiffness = 300, \
                solver.integrator = \"rk4\"";
    assert_eq!(saved.title, format!("a rope{told}"));
}

#[test]
fn a_mesh_and_a_built_in_scene_have_keys() {
    let folder = folder();
    let run =
        |scene, set| json(msd(folder.path(), &["run", scene, "--duration", "0.1", "--set", set]));
    assert_eq!(run("bunny.obj", "solver.substeps=40")["substeps"], 40);
    assert_eq!(run("cloth", "bodies=[{kind='rope',size=[4]}]")["particles"], 4);
}

/// Sets a key, which every command that opens a scene must refuse in these words.
fn refuse(folder: &Path, scene: &str, set: &str, told: &str) {
    let set = ["--set", set];
    for command in [
        &["run"][..],
        &["inspect"],
        &["tune", "--max-error", "1"],
        &["study"],
        &["export", "--to", "a.npz"],
        #[cfg(feature = "window")]
        &["render"],
        #[cfg(feature = "window")]
        &["view"],
    ] {
        let said = refused(msd(folder, &[command, &[scene], &set].concat()), 2);
        assert_eq!(said, format!("error: {told}\n"), "{command:?}");
    }
    assert_eq!(fs::read_dir(folder).expect("a folder").count(), 2, "something was written");
}

#[test]
fn what_a_file_could_not_say_is_refused_in_the_same_words() {
    let folder = rope();
    for (set, told) in [
        (
            "world.gravty=[0,0,0]",
            "--set world.gravty: unknown key `gravty` in world; did you mean `gravity`?",
        ),
        (
            "bodies.0.stiffness=-3",
            "--set bodies[0].stiffness: bodies[0].stiffness is -3; it must be finite and not \
             negative",
        ),
        (
            "bodies.0.stiffness=many",
            "--set bodies[0].stiffness: bodies[0].stiffness is \"many\"; it must be a number",
        ),
        ("bodies.7.mass=1", "--set bodies[7].mass: bodies of the scene has one row, bodies[0]"),
        (
            "solver.integrator=rk5",
            "--set solver.integrator: solver.integrator is \"rk5\"; it must be one of \
             explicit-euler, symplectic-euler, velocity-verlet, rk4, dormand-prince, \
             backward-euler, implicit-midpoint, xpbd; did you mean `rk4`?",
        ),
    ] {
        refuse(folder.path(), "rope.toml", set, told);
    }
}

#[test]
fn what_has_no_keys_is_refused() {
    let folder = rope();
    quiet(msd(folder.path(), &["run", "rope.toml", "--duration", "0", "--save", "r.msd", "-q"]));
    let refuse = |arguments: &[&str], told: &str| {
        let said = refused(msd(folder.path(), arguments), 2);
        assert!(said.contains(told), "{said}");
    };
    let set = ["--set", "world.drag=1"];
    let saved = [&["run", "r.msd"], &set[..]].concat();
    refuse(&saved, "r.msd: cannot be read: a saved run has no keys that could be set");
    let link = [&["run", "#scene=cloth"], &set[..]].concat();
    refuse(&link, "--set takes a scene by name or file, not by link");
    refuse(&["run", "rope.toml", "--set", "drag"], "must be KEY=VALUE");
    refuse(&["run", "rope.toml", "--set", "world.gravity=[0,"], "a value as in a scene file");
    refuse(&["run", "rope.toml", "--gravity", "1"], "or by --set world.gravity=VALUE");
    let write = ["tune", "rope.toml", "--max-error", "1", "--write", "--set", "world.drag=1"];
    refuse(&write, "cannot be used with");
}
