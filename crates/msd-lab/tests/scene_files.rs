//! Does a scene file say what it means, and is one that does not refused by name?

use msd_lab::msd_core::{Friction, Integrator, Neighbours, Scene, Settings};
use msd_lab::schema::SceneFile;
use msd_lab::{BUILTINS, Loaded, Precision, SceneFormat, open, parse, read, write};

fn toml(text: &str) -> Result<Loaded, String> {
    parse(text, SceneFormat::Toml, "s.toml").map_err(|error| error.to_string())
}

fn refusal(text: &str) -> String {
    let message = toml(text).expect_err(text);
    assert_eq!(message.lines().count(), 1, "{message}");
    message
}

/// A scene of one body with these lines besides its kind.
fn body(lines: &str) -> String {
    format!("version = 1\n[[bodies]]\n{lines}")
}

const ROPE: &str = "kind = 'rope'\nsize = [3]\n";

fn scene(lines: &str) -> Scene {
    toml(&body(lines)).expect(lines).scene
}

#[test]
fn what_is_left_out_takes_its_default() {
    let loaded = toml(&body(ROPE)).expect("a rope");
    assert_eq!(loaded.settings, Settings::default());
    assert_eq!(loaded.precision, Precision::F32);
    assert_eq!(loaded.title, "s");
    let Scene { world, particles, springs, .. } = loaded.scene;
    assert_eq!(world, msd_lab::msd_core::World::default());
    assert_eq!(particles.iter().map(|p| p.position.x).collect::<Vec<_>>(), [-1.0, 0.0, 1.0]);
    assert!(particles.iter().all(|particle| particle.mass == 1.0));
    assert!(springs.iter().all(|s| (s.stiffness, s.damping, s.rest_length) == (1000.0, 0.0, 1.0)));
    let plane =
        toml(&format!("{}[[world.planes]]\n", body(ROPE))).expect("a plane").scene.planes[0];
    assert_eq!(plane.normal.to_array(), [0.0, 1.0, 0.0]);
    assert_eq!((plane.offset, plane.restitution), (0.0, 0.0));
    assert_eq!(plane.friction, Friction::Coulomb(0.5));
}

#[test]
fn the_solver_says_how_the_scene_is_stepped() {
    let text = "version = 1\n[solver]\nintegrator = 'rk4'\nsteps_per_second = 120\nsubsteps = 3\n\
                precision = 'f64'\n[[bodies]]\nkind = 'rope'\nsize = [2]\n";
    let loaded = toml(text).expect("a rope");
    let expected = Settings { integrator: Integrator::Rk4, step: 1.0 / 120.0, substeps: 3 };
    assert_eq!((loaded.settings, loaded.precision), (expected, Precision::F64));
}

#[test]
fn a_body_is_turned_then_put_and_spins_about_its_centre() {
    let lines = "rotation = { axis = [0, 0, 2], angle_deg = 90 }\nposition = [5, 6, 7]\n\
                 velocity = [1, 0, 0]\nspin = { axis = [0, 0, 3], speed = 2 }\n";
    let scene = scene(&format!("{ROPE}{lines}"));
    let [low, middle, high] = [0, 1, 2].map(|row| scene.particles[row]);
    assert!((low.position - glam::DVec3::new(5.0, 5.0, 7.0)).length() < 1e-15);
    assert_eq!(middle.position.to_array(), [5.0, 6.0, 7.0]);
    // v + w x r with r = (0, 1, 0) and w = (0, 0, 2).
    assert!((high.velocity - glam::DVec3::new(-1.0, 0.0, 0.0)).length() < 1e-15);
    assert_eq!(middle.velocity.to_array(), [1.0, 0.0, 0.0]);
}

#[test]
fn a_random_axis_is_the_same_everywhere() {
    let scene = scene(&format!("{ROPE}spin = {{ random_axis_seed = 6, speed = 15 }}\n"));
    let spun = scene.particles[2].velocity;
    // Recorded: the bits must be these on every machine.
    assert_eq!(spun.to_array().map(f64::to_bits), RECORDED);
}

const RECORDED: [u64; 3] = [0, 0x401c_4ecc_4ec1_7e9d, 0x402a_5d0b_400c_5d0b];

#[test]
fn pins_are_named_by_particle_by_place_and_by_every() {
    let cloth = "kind = 'cloth'\nsize = [2, 4]\n";
    let pins = |lines: &str| -> Vec<usize> {
        let scene = scene(&format!("{ROPE}[[bodies]]\n{cloth}[[pins]]\nbody = 1\n{lines}"));
        scene.pins.iter().map(|pin| pin.particle).collect()
    };
    assert_eq!(pins("particle = 2"), [5]);
    assert_eq!(pins("at = [1, 3, 0]"), [10]);
    assert_eq!(pins("every = 3"), [7, 10]);
}

#[test]
fn neighbours_are_counted_as_the_reader_does() {
    for (lines, springs) in [
        ("kind = 'cloth'\nsize = [2, 2]\nneighbours = 4", 4),
        ("kind = 'cloth'\nsize = [2, 2]\nneighbours = 8", 6),
        ("kind = 'block'\nsize = [2, 2, 2]\nneighbours = 6", 12),
        ("kind = 'block'\nsize = [2, 2, 2]\nneighbours = 26", 28),
        ("kind = 'rope'\nsize = [2]\nneighbours = 2", 1),
    ] {
        assert_eq!(scene(lines).springs.len(), springs, "{lines}");
    }
    assert_eq!(Neighbours::default(), Neighbours::All);
}

#[test]
fn an_explicit_body_takes_the_distance_of_its_ends_for_rest_length() {
    let lines = "kind = 'explicit'\nstiffness = 7\nparticles = [{ position = [0, 0, 0] }, \
                 { position = [3, 4, 0], mass = 2 }]\nsprings = [{ ends = [0, 1] }]\n";
    let scene = scene(lines);
    assert_eq!(scene.springs[0].rest_length, 5.0);
    assert_eq!((scene.springs[0].stiffness, scene.particles[1].mass), (7.0, 2.0));
}

#[test]
fn json_says_the_same_as_toml() {
    let json = r#"{"version": 1, "bodies": [{"kind": "rope", "size": [3], "spin": [0, 1, 0]}],
                   "pins": [{"particle": 0}]}"#;
    let json = parse(json, SceneFormat::Json, "s.json").expect("JSON").scene;
    assert_eq!(json, scene(&format!("{ROPE}spin = [0, 1, 0]\n[[pins]]\nparticle = 0\n")));
}

#[test]
fn every_built_in_scene_is_the_same_after_writing_it_and_reading_it_again() {
    for builtin in BUILTINS {
        let rows: SceneFile = read(builtin.text, SceneFormat::Toml, builtin.name).expect("rows");
        for format in [SceneFormat::Toml, SceneFormat::Json] {
            let text = write(&rows, format).expect("text");
            assert_eq!(read(&text, format, builtin.name).expect(&text), rows);
        }
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
fn a_value_outside_its_domain_is_refused_by_key() {
    let rope = |line: &str| body(&format!("{ROPE}{line}\n"));
    let explicit = |springs: &str| {
        body(&format!(
            "kind = 'explicit'\nparticles = [{{ position = [0, 0, 0] }}, \
             {{ position = [1, 0, 0] }}]\nsprings = [{springs}]\n"
        ))
    };
    for (text, told) in [
        (rope("mass = -1"), "s.toml:5:8: bodies[0].mass is -1; it must be positive and finite"),
        (rope("mass = 0"), "bodies[0].mass is 0; it must be positive"),
        (rope("mass = nan"), "bodies[0].mass is NaN; it must be positive and finite"),
        (rope("mass = inf"), "bodies[0].mass is inf; it must be positive and finite"),
        (rope("mass = 'heavy'"), "bodies[0].mass is \"heavy\"; it must be a number"),
        (rope("stiffness = -5"), "bodies[0].stiffness is -5; it must be finite and not negative"),
        (rope("damping = nan"), "bodies[0].damping is NaN; it must be finite and not negative"),
        (rope("spacing = 0"), "bodies[0].spacing is 0; it must be positive and finite"),
        (
            rope("position = [0, 2e6, 0]"),
            "bodies[0].position[1] is 2000000; it must be finite and inside",
        ),
        (
            rope("position = [0, 0]"),
            "bodies[0].position is a list of 2; it must be a list of three",
        ),
        (
            rope("position = [0, 0, 0, 0]"),
            "bodies[0].position is a list of 4; it must be a list of three",
        ),
        (rope("velocity = [0, inf, 0]"), "bodies[0].velocity[1] is inf; it must be finite"),
        (rope("rotation = { axis = [0, 0, 0], angle_deg = 1 }"), "bodies[0].rotation.axis is zero"),
        (
            rope("spin = { speed = 1 }"),
            "bodies[0].spin needs one of the keys `axis` and `random_axis_seed`",
        ),
        (rope("spin = 5"), "bodies[0].spin is 5; it must be a list of three numbers, or a table"),
        (rope("neighbours = 8"), "bodies[0].neighbours is 8; it must be 2 for a rope"),
        (rope("file = 'a.obj'"), "bodies[0].file means nothing to a rope; it belongs to kind mesh"),
        (body("kind = 'blok'"), "bodies[0].kind is \"blok\"; it must be one of rope, cloth, block"),
        (body("kind = 'blok'"), "did you mean `block`?"),
        (body("kind = 3"), "bodies[0].kind is 3; it must be one of rope"),
        (body("kind = 'rope'\nsize = [0]"), "bodies[0].size[0] is 0; it must be at least 1"),
        (body("kind = 'rope'\nsize = [-3]"), "bodies[0].size[0] is -3; it must be a whole number"),
        (
            body("kind = 'rope'\nsize = [1.5]"),
            "bodies[0].size[0] is 1.5; it must be a whole number",
        ),
        (
            body("kind = 'rope'\nsize = [1, 2]"),
            "bodies[0].size is a list of 2; it must be one number",
        ),
        (body("kind = 'cloth'\nsize = [1, 2, 3]"), "it must be two numbers: [rows, columns]"),
        (
            body("kind = 'rope'\nsize = [99999999999999999999]"),
            "bodies[0].size[0] is 100000000000000000000",
        ),
        (
            explicit("{ ends = [0, 2] }"),
            "bodies[0].springs[0].ends[1] is 2; it must be from 0 to 1",
        ),
        (
            explicit("{ ends = [0, -1] }"),
            "bodies[0].springs[0].ends[1] is -1; it must be a whole number",
        ),
        (explicit("{ ends = [1, 1] }"), "bodies[0].springs[0].ends joins particle 1 to itself"),
        (explicit("{ ends = [0, 1], rest_length = -1 }"), "springs[0].rest_length is -1"),
        (rope("[[pins]]\nparticle = 3"), "pins[0].particle is 3; it must be from 0 to 2"),
        (rope("[[pins]]\nbody = 1\nparticle = 0"), "pins[0].body is 1; it must be from 0 to 0"),
        (rope("[[pins]]\nevery = 0"), "pins[0].every is 0; it must be at least 1"),
        (rope("[[pins]]\nat = [0, 3, 0]"), "pins[0].at[1] is 3; it must be from 0 to 2"),
        (rope("[[pins]]\nbody = 0"), "pins[0] needs exactly one of the keys"),
        (rope("[solver]\nstep = 0"), "solver.step is 0; it must be positive and finite"),
        (rope("[solver]\nsteps_per_second = inf"), "solver.steps_per_second is inf"),
        (rope("[solver]\nsubsteps = 0"), "solver.substeps is 0; it must be at least 1"),
        (rope("[solver]\nsubsteps = 1e3"), "solver.substeps is 1000; it must be a whole number"),
        (
            rope("[solver]\nintegrator = 'rk5'"),
            "solver.integrator is \"rk5\"; it must be one of explicit-euler",
        ),
        (
            rope("[solver]\nprecision = 'f16'"),
            "solver.precision is \"f16\"; it must be one of f32, f64",
        ),
        (rope("[world]\ngravity = [0, nan, 0]"), "world.gravity[1] is NaN; it must be finite"),
        (rope("[world]\ndrag = -1"), "world.drag is -1; it must be finite and not negative"),
        (rope("[world]\nextent = 0"), "world.extent is 0; it must be positive"),
        (rope("[[world.planes]]\nnormal = [0, 0, 0]"), "world.planes[0].normal is zero"),
        (
            rope("[[world.planes]]\nrestitution = 1.5"),
            "world.planes[0].restitution is 1.5; it must be from 0 to 1",
        ),
        (rope("[[world.planes]]\nfriction = -0.1"), "world.planes[0].friction is -0.1"),
        (rope("[[world.planes]]\nfriction = 1\ntangential_loss = 0"), "exclude each other"),
        (
            rope("[[world.planes]]\nsticky = true\nfriction = 1"),
            "world.planes[0].sticky says it all",
        ),
        ("version = 2\nbodies = []".into(), "version is 2; it must be 1"),
        ("version = 1\nbodies = []".into(), "bodies is empty"),
        ("version = 1\nbodies = 3".into(), "bodies is 3; it must be a list"),
        ("version = 1\n[[bodies]\n".into(), "s.toml:2:"),
    ] {
        assert!(refusal(&text).contains(told), "{}\n{told}", refusal(&text));
    }
}

#[test]
fn a_lattice_of_many_gigabytes_is_refused_before_it_is_built() {
    for lines in [
        "kind = 'block'\nsize = [250, 250, 250]",
        "kind = 'block'\nsize = [18446744073709551615, 18446744073709551615, 18446744073709551615]",
        "kind = 'rope'\nsize = [100000000]",
        // Each fits alone.
        "kind = 'block'\nsize = [100, 100, 200]\n[[bodies]]\nkind = 'block'\nsize = [100, 100, 200]",
    ] {
        let message = refusal(&body(lines));
        assert!(message.contains("].size asks for") && message.contains("4.0 GB fit"), "{message}");
    }
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

#[test]
fn the_documentation_has_every_key_of_the_schema() {
    let docs = include_str!("../../../docs/scenes.md");
    let source = include_str!("../src/schema.rs");
    let field = |line: &str| {
        let rest = line.strip_prefix("    pub ")?;
        rest.split_once(": ").map(|(key, _)| key.to_string())
    };
    let keys: Vec<String> = source.lines().filter_map(field).collect();
    assert!(40 < keys.len());
    for key in keys {
        assert!(docs.contains(&format!("| `{key}` |")), "docs/scenes.md lacks `{key}`");
    }
    for builtin in BUILTINS {
        assert!(open(builtin.name).is_ok());
    }
}

#[test]
fn the_example_of_the_documentation_runs() {
    let docs = include_str!("../../../docs/scenes.md");
    let example = docs.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let loaded = toml(example.expect("an example")).expect("the example");
    let mut runner = loaded.runner().expect("a run");
    assert!(loaded.settings.substep() <= 0.7 * runner.stable_substep());
    for _ in 0..60 {
        runner.step().expect("a step");
    }
}
