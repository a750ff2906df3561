//! Refusals of scene files, by place, key, value and domain.

use msd_scene::{Loaded, Precision, SceneFormat, load, load_state, open, parse};
use std::path::Path;

fn toml(text: &str) -> Result<Loaded, String> {
    parse(text, SceneFormat::Toml, "s.toml").map_err(|error| error.to_string())
}

fn refusal(text: &str) -> String {
    let message = toml(text).expect_err(text);
    assert_eq!(message.lines().count(), 1, "{message}");
    message
}

/// A scene of one body with these lines.
fn body(lines: &str) -> String {
    format!("version = 1\n[[bodies]]\n{lines}")
}

const ROPE: &str = "kind = 'rope'\nsize = [3]\n";

/// Lines after those of a rope of three particles, and what is told.
const LINES: [(&str, &str); 48] = [
    ("mass = -1", "s.toml:5:8: bodies[0].mass is -1; it must be positive and finite"),
    ("mass = 0", "bodies[0].mass is 0; it must be positive"),
    ("mass = nan", "bodies[0].mass is NaN; it must be positive and finite"),
    ("mass = inf", "bodies[0].mass is inf; it must be positive and finite"),
    (
        "mass = 1e-40",
        "s.toml:5:8: bodies[0].mass is 1e-40; it must be positive and finite, from 3e-39",
    ),
    ("[solver]\nnewton = 2000", "s.toml:6:10: solver.newton is 2000; it must be from 1 to 1000"),
    ("[solver]\nstep = 1e7", "solver.step is 10000000; it must be positive and at most 1e6"),
    (
        "[solver]\nstep = 1e-22",
        "solver.step is 1e-22; it must be positive and at most 1e6; a substep",
    ),
    ("[solver]\nsteps_per_second = 1e-7", "solver.steps_per_second is 1e-7; it must be finite and"),
    ("[solver]\nsteps_per_second = 1e-300", "solver.steps_per_second is 1e-300; it must be finite"),
    (
        "[[world.planes]]\nfriction = 1e39",
        "friction is 1e39; it must be finite and not negative, at",
    ),
    ("mass = 'heavy'", "bodies[0].mass is \"heavy\"; it must be a number"),
    ("stiffness = -5", "bodies[0].stiffness is -5; it must be finite and not negative"),
    ("damping = nan", "bodies[0].damping is NaN; it must be finite and not negative"),
    ("spacing = 0", "bodies[0].spacing is 0; it must be positive and finite"),
    ("position = [0, 2e6, 0]", "bodies[0].position[1] is 2000000; it must be finite and inside"),
    ("position = [0, 0]", "bodies[0].position is a list of 2; it must be a list of three"),
    ("position = [0, 0, 0, 0]", "bodies[0].position is a list of 4; it must be a list of three"),
    ("velocity = [0, inf, 0]", "bodies[0].velocity[1] is inf; it must be finite"),
    ("rotation = { axis = [0, 0, 0], angle_deg = 1 }", "bodies[0].rotation.axis is zero"),
    ("spin = { speed = 1 }", "bodies[0].spin needs one of the keys `axis` and `random_axis_seed`"),
    ("spin = 5", "bodies[0].spin is 5; it must be a list of three numbers, or a table"),
    ("neighbours = 8", "bodies[0].neighbours is 8; it must be 2 for a rope"),
    ("file = 'a.obj'", "bodies[0].file means nothing to a rope; it belongs to kind mesh"),
    ("[[pins]]\nparticle = 3", "pins[0].particle is 3; it must be from 0 to 2"),
    (
        "[[pins]]\nbody = 1\nparticle = 0",
        "pins[0].body is 1; it must be from 0 to 0: there is 1 body",
    ),
    ("[[pins]]\nevery = 0", "pins[0].every is 0; it must be at least 1"),
    ("[[pins]]\nat = [0, 3, 0]", "pins[0].at[1] is 3; it must be from 0 to 2"),
    ("[[pins]]\nbody = 0", "pins[0] needs exactly one of the keys"),
    ("[solver]\nstep = 0", "solver.step is 0; it must be positive and at most 1e6; a substep"),
    ("[solver]\nsteps_per_second = inf", "solver.steps_per_second is inf"),
    ("[solver]\nsubsteps = 0", "solver.substeps is 0; it must be from 1 to 4294967295"),
    ("[solver]\nsubsteps = 1e3", "solver.substeps is 1000.0; it must be a whole number, without a"),
    (
        "[solver]\nintegrator = 'rk5'",
        "solver.integrator is \"rk5\"; it must be one of explicit-euler",
    ),
    ("[solver]\nprecision = 'f16'", "solver.precision is \"f16\"; it must be one of f32, f64"),
    ("[world]\ngravity = [0, nan, 0]", "world.gravity[1] is NaN; it must be finite"),
    ("[world]\ndrag = -1", "world.drag is -1; it must be finite and not negative"),
    ("[solver]\nsubsteps = 99999999999", "is 99999999999; it must be from 1 to 4294967295"),
    (
        "stiffness = 1e300",
        "stiffness is 1e300; it must be at most 3.4e38 to fit f32; precision = \"f64\"",
    ),
    ("spacing = 1e-30", "bodies[0].spacing is 1e-30; it must be so large that f32 tells"),
    ("position = [1e6, 0, 0]\nspacing = 0.01", "bodies[0].spacing is 0.01; it must be so large"),
    (
        "[[pins]]\nparticle = 2\n[[pins]]\nat = [0, 2, 0]",
        "pins[1] and pins[0] hold the same particle, number 2 of the scene",
    ),
    ("[world]\nextent = 0", "world.extent is 0; it must be positive"),
    ("[[world.planes]]\nnormal = [0, 0, 0]", "world.planes[0].normal is zero"),
    (
        "[[world.planes]]\nrestitution = 1.5",
        "world.planes[0].restitution is 1.5; it must be from 0 to 1",
    ),
    ("[[world.planes]]\nfriction = -0.1", "world.planes[0].friction is -0.1"),
    ("[[world.planes]]\nfriction = 1\ntangential_loss = 0", "exclude each other"),
    ("[[world.planes]]\nsticky = true\nfriction = 1", "world.planes[0].sticky says it all"),
];

/// Lines of a body, and what is told.
const BODIES: [(&str, &str); 12] = [
    ("kind = 'blok'", "bodies[0].kind is \"blok\"; it must be one of rope, cloth, block"),
    ("kind = 'blok'", "did you mean `block`?"),
    ("kind = 3", "bodies[0].kind is 3; it must be one of rope"),
    ("kind = 'rope'\nsize = [0]", "bodies[0].size[0] is 0; it must be at least 1"),
    ("kind = 'rope'\nsize = [-3]", "bodies[0].size[0] is -3; it must be a whole number"),
    ("kind = 'rope'\nsize = [1.5]", "bodies[0].size[0] is 1.5; it must be a whole number"),
    ("kind = 'rope'\nsize = [1, 2]", "bodies[0].size is a list of 2; it must be one number"),
    ("kind = 'cloth'\nsize = [1, 2, 3]", "it must be two numbers: [rows, columns]"),
    (
        "kind = 'rope'\nsize = [99999999999999999999]",
        "bodies[0].size[0] is 1e20; it must be a whole number from 0 to 18446744073709551615",
    ),
    ("kind = 'explicit'\nparticles = []", "bodies[0].particles is empty"),
    ("kind = 'explicit'\nspacing = 1", "bodies[0].spacing means nothing to an explicit body; it"),
    ("kind = 'mesh'\nfile = 'teapot.obj'\nfilling = 'solid'", "bodies[0].filling: teapot.obj: not"),
];

/// Springs between two particles, and what is told.
const SPRINGS: [(&str, &str); 5] = [
    ("{ ends = [0, 2] }", "bodies[0].springs[0].ends[1] is 2; it must be from 0 to 1"),
    ("{ ends = [0, 1, 2] }", "ends is a list of 3; it must be a list of two whole numbers"),
    ("{ ends = [0, -1] }", "bodies[0].springs[0].ends[1] is -1; it must be a whole number"),
    ("{ ends = [1, 1] }", "bodies[0].springs[0].ends joins particle 1 to itself"),
    ("{ ends = [0, 1], rest_length = -1 }", "springs[0].rest_length is -1"),
];

/// Whole scenes, and what is told.
const SCENES: [(&str, &str); 4] = [
    ("version = 2\nbodies = []", "version is 2; it must be 1"),
    ("version = 1\nbodies = []", "bodies is empty"),
    ("version = 1\nbodies = 3", "bodies is 3; it must be a list"),
    ("version = 1\n[[bodies]\n", "s.toml:2:"),
];

#[test]
fn a_value_outside_its_domain_is_refused_by_key() {
    let pairs = |lines: &str| {
        body(&format!(
            "kind = 'explicit'\nparticles = [{{ position = [0, 0, 0] }}, \
             {{ position = [1, 0, 0] }}]\nsprings = [{lines}]\n"
        ))
    };
    let rows = LINES.map(|(line, told)| (body(&format!("{ROPE}{line}\n")), told)).into_iter();
    let rows = rows.chain(BODIES.map(|(lines, told)| (body(lines), told)));
    let rows = rows.chain(SPRINGS.map(|(lines, told)| (pairs(lines), told)));
    for (text, told) in rows.chain(SCENES.map(|(text, told)| (text.to_string(), told))) {
        let message = refusal(&text);
        assert!(message.contains(told), "{message}\n{told}");
    }
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest_one_and_its_place() {
    let message = refusal(&body(&format!("{ROPE}stifness = 5\n")));
    let told = "s.toml:5:1: unknown key `stifness` in bodies[0]; did you mean `stiffness`?";
    assert_eq!(message, told);
    for (text, told) in [
        ("version = 1\nbodys = []\n", "unknown key `bodys` in the scene; did you mean `bodies`?"),
        ("version = 1\n[world]\ngravitation = 1", "in world; did you mean `gravity`?"),
        ("version = 1\n[solver]\nsubstep = 1", "in solver; did you mean `substeps`?"),
        (
            "version = 1\n[[world.planes]]\nfrction = 1",
            "in world.planes[0]; did you mean `friction`?",
        ),
        ("version = 1\n[[pins]]\npartcle = 1", "in pins[0]; did you mean `particle`?"),
        ("version = 1\nqqq = 1", "the keys are version, title, solver, world, bodies, pins"),
        (
            &body(&format!("{ROPE}spin = {{ axs = [1, 0, 0], speed = 1 }}")),
            "`axs` in bodies[0].spin",
        ),
        (
            &body("kind = 'explicit'\nparticles = [{ position = [0, 0, 0], weight = 1 }]"),
            "unknown key `weight` in bodies[0].particles[0]; the keys are position, velocity, mass",
        ),
    ] {
        assert!(refusal(text).contains(told), "{}", refusal(text));
    }
}

#[test]
fn a_missing_key_is_named() {
    for (text, told) in [
        ("[[bodies]]\nkind = 'rope'\nsize = [3]", "the scene lacks the key `version`"),
        ("version = 1\n[[bodies]]\nsize = [3]", "bodies[0] lacks the key `kind`"),
        (&body("kind = 'rope'"), "bodies[0] lacks the key `size`"),
        (&body("kind = 'mesh'"), "bodies[0] lacks the key `file`"),
        (&body("kind = 'explicit'"), "bodies[0] lacks the key `particles`"),
        (
            &body(&format!("{ROPE}spin = {{ axis = [1, 0, 0] }}")),
            "bodies[0].spin lacks the key `speed`",
        ),
        ("version = 1", "bodies is empty; a scene needs at least one body"),
    ] {
        assert!(refusal(text).contains(told), "{}", refusal(text));
    }
}

#[test]
fn a_lattice_of_many_gigabytes_is_refused_before_it_is_built() {
    for lines in [
        "kind = 'block'\nsize = [250, 250, 250]",
        "kind = 'block'\nsize = [18446744073709551615, 18446744073709551615, 18446744073709551615]",
        "kind = 'rope'\nsize = [100000000]",
        // Each fits alone.
        "kind = 'block'\nsize = [99, 100, 200]\n[[bodies]]\nkind = 'block'\nsize = [99, 99, 200]",
    ] {
        let message = refusal(&body(lines));
        assert!(message.contains("].size asks for") && message.contains("4.0 GB fit"), "{message}");
    }
}

#[test]
fn what_a_file_holds_cannot_move_the_cursor_of_a_terminal() {
    let message = refusal("version = 1\n[[bodies]]\nkind = \"a\\u001b[2Jb\\n\"\n");
    assert!(message.contains("bodies[0].kind is \"a\\u{1b}[2Jb\\n\"; it must be"), "{message}");
    let message = refusal("version = 1\n[[bodies]]\nkind = \"mesh\"\nfile = \"a\\u001b.obj\"\n");
    assert!(message.contains("bodies[0].file is a\\u{1b}.obj; it must be a name"), "{message}");
    let message = refusal("version = 1\n\"\\u0007\" = 1\n");
    assert!(message.contains("unknown key `\\u{7}` in the scene"), "{message}");
}

#[test]
fn a_count_that_does_not_fit_is_not_told_by_the_digit() {
    let message = refusal(&body("kind = 'block'\nsize = [9223372036854775807, 9e18, 9]"));
    assert!(message.contains("size[1] is 9e18"), "{message}");
    let huge = "9223372036854775807";
    let message = refusal(&body(&format!("kind = 'block'\nsize = [{huge}, {huge}, {huge}]")));
    assert!(message.contains("more than 1e38 particles"), "{message}");
    assert!(message.len() < 200, "{message}");
}

#[test]
fn a_mesh_with_too_fine_a_lattice_is_refused_at_once_by_its_spacing() {
    let bunny = "kind = 'mesh'\nfile = 'bunny.obj'\nlength = 2\n";
    for spacing in ["0.009", "0.0001", "1e-300"] {
        let message = refusal(&body(&format!("{bunny}spacing = {spacing}")));
        assert!(message.starts_with("s.toml:6:11: bodies[0].spacing: bunny.obj: "), "{message}");
        assert!(message.ends_with("at most 2097152 fit: make the spacing larger"), "{message}");
    }
}

#[test]
fn what_a_mesh_file_gets_wrong_is_told_by_scene_file_key_and_path() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("s.toml");
    let told = |file: &str| {
        std::fs::write(&scene, body(&format!("kind = 'mesh'\nfile = '{file}'"))).expect("a file");
        load(&scene).expect_err(file).to_string()
    };
    let start =
        |path: &Path| format!("{}:4:8: bodies[0].file: {}: ", scene.display(), path.display());
    let none = folder.path().join("none.obj");
    assert!(told("none.obj").starts_with(&start(&none)), "{}", told("none.obj"));
    let message = told("/");
    assert!(message.starts_with(&start(Path::new("/"))), "{message}");
    assert!(message.contains("it is a folder"), "{message}");
    let text = folder.path().join("text.obj");
    std::fs::write(&text, "hello world\n").expect("a file");
    assert_eq!(told("text.obj"), format!("{}no faces found", start(&text)));
    assert_eq!(
        open(&text).expect_err("no mesh").to_string(),
        format!("{}: no faces found", text.display())
    );
}

#[cfg(unix)]
#[test]
fn what_is_not_a_regular_file_is_refused_before_it_is_read() {
    let zero = Path::new("/dev/zero");
    let told = "/dev/zero: cannot be read: it is not a regular file";
    assert_eq!(load(zero).expect_err("a device").to_string(), told);
    let state = load_state(zero, Precision::F32, 3).expect_err("a device");
    assert_eq!(state.to_string(), told);
}

#[test]
fn a_table_of_a_hundred_thousand_keys_is_refused_at_once() {
    let keys: Vec<String> = (0..100_000).map(|key| format!("\"k{key}\": 0")).collect();
    let text = format!("{{{}}}", keys.join(","));
    assert!(parse(&text, SceneFormat::Json, "s.json").is_err());
}

#[test]
fn two_particles_on_one_place_are_meant_and_far_springs_need_precision() {
    let pair = |x: &str, precision: &str| {
        toml(&format!(
            "version = 1\n[solver]\nprecision = '{precision}'\n[[bodies]]\nkind = 'explicit'\n\
             position = [1e5, 0, 0]\nparticles = [{{ position = [0, 0, 0] }}, \
             {{ position = [{x}, 0, 0] }}]\nsprings = [{{ ends = [0, 1], rest_length = 1 }}]\n"
        ))
    };
    assert!(pair("0", "f32").is_ok());
    assert!(pair("1e-4", "f64").is_ok());
    let message = pair("1e-4", "f32").expect_err("too near");
    assert!(
        message.contains("bodies[0].springs[0] joins particles 0 and 1, which f32"),
        "{message}"
    );
}

#[test]
fn text_that_is_no_scene_is_refused_with_its_line() {
    let json = |text: &str| parse(text, SceneFormat::Json, "s.json").expect_err(text).to_string();
    assert!(json("{\"version\": 1,\n \"bodies\": [").starts_with("s.json:2:"));
    assert!(
        json("{\"version\": 1, \"version\": 1}").contains("the key `version` stands here twice")
    );
    assert!(json("[]").contains("the scene is a list"), "{}", json("[]"));
    assert!(
        json("{\"version\": null}").contains("version is null"),
        "{}",
        json("{\"version\": null}")
    );
    assert!(refusal("").contains("lacks the key `version`"));
    assert!(refusal("version = 1\nversion = 1").starts_with("s.toml:2:"));
}

#[test]
fn deep_nesting_is_refused_and_not_a_crash() {
    for text in [
        "[".repeat(100_000),
        format!("a = {}", "[".repeat(100_000)),
        format!("{}a = 1", "a.".repeat(100_000)),
    ] {
        assert!(toml(&text).is_err());
        assert!(parse(&text, SceneFormat::Json, "s.json").is_err());
    }
}

#[test]
fn a_scene_that_is_only_text_cannot_reach_for_files() {
    assert!(toml(&body("kind = 'mesh'\nfile = 'bunny.obj'")).is_ok());
    let message = refusal(&body("kind = 'mesh'\nfile = '/etc/passwd.obj'"));
    assert!(message.contains("only a scene that is loaded from a file"), "{message}");
}

#[test]
fn a_name_that_stands_for_nothing_gets_the_nearest_one() {
    let message = |name: &str| open(name).expect_err(name).to_string();
    assert_eq!(message("jely"), "no scene `jely`: did you mean `jelly`?");
    assert!(message("qqqq").contains("the built-in scenes are jelly, bunny"));
    assert!(message("none.toml").starts_with("none.toml: cannot be read"));
    assert!(message("none.obj").contains("none.obj"));
    assert!(message("/").contains("it is a folder"));
}
