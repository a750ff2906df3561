//! Scene files: their values take effect, and values that do not are refused by name.

use msd_core::obstacles::Placed;
use msd_core::{
    Error, Friction, Integrator, Neighbours, Pattern, Real, Scene, Settings, Shape, Simulation,
};
use msd_scene::mesh::{self, Filling, Format, MeshOptions, parse as parse_mesh};
use msd_scene::schema::{SceneFile, find};
use msd_scene::{
    Assignment, BUILTINS, LESSONS, Loaded, Precision, SceneFormat, open, open_set, parse, read,
    write,
};
use std::path::Path;

fn toml(text: &str) -> Result<Loaded, String> {
    parse(text, SceneFormat::Toml, "s.toml").map_err(|error| error.to_string())
}

/// A scene of one body with these lines besides its kind.
fn body(lines: &str) -> String {
    format!("version = 1\n[[bodies]]\n{lines}")
}

const ROPE: &str = "kind = 'rope'\nsize = [3]\n";

/// Takes some steps; returns the largest stable substep at the start, seconds.
fn run(loaded: &Loaded, steps: usize) -> Result<f64, Error> {
    fn run_in<R: Real>(loaded: &Loaded, steps: usize) -> Result<f64, Error> {
        let mut simulation = Simulation::<R>::new(&loaded.scene, loaded.settings)?;
        let stable = simulation.stable_substep();
        (0..steps).try_for_each(|_| simulation.step())?;
        Ok(stable)
    }
    match loaded.precision {
        Precision::F32 => run_in::<f32>(loaded, steps),
        Precision::F64 => run_in::<f64>(loaded, steps),
    }
}

fn scene(lines: &str) -> Scene {
    toml(&body(lines)).expect(lines).scene
}

#[test]
fn what_is_left_out_takes_its_default() {
    let loaded = toml(&body(ROPE)).expect("a rope");
    assert_eq!(loaded.settings, Settings::default());
    assert!(loaded.automatic, "substeps are chosen");
    assert_eq!(loaded.precision, Precision::F32);
    assert_eq!(loaded.title, "s");
    let Scene { world, particles, springs, .. } = loaded.scene;
    assert_eq!(world, msd_core::World::default());
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
fn solids_are_placed_turned_and_set_in_motion() {
    let lines = "[[world.solids]]\nkind = 'capsule'\nradius = 0.5\nlength = 2\n\
                 position = [1, 2, 3]\nrotation = { axis = [0, 0, 2], angle_deg = 90 }\n\
                 velocity = [0, 1, 0]\nspin = [0, 0, 3]\nsticky = true\n[[world.solids]]\n\
                 kind = 'box'\nsize = [1, 2, 3]\n";
    let solids = toml(&format!("{}{lines}", body(ROPE))).expect("solids").scene.solids;
    assert_eq!(solids[0].shape, Shape::Capsule { radius: 0.5, length: 2.0 });
    assert_eq!(solids[0].position.to_array(), [1.0, 2.0, 3.0]);
    // Its axis, y, is turned to −x; a half turn later, to x, and it has gone up by π/3 m.
    assert!((solids[0].axes.y_axis.x + 1.0).abs() < 1e-15);
    let placed = Placed::new(&solids[0], std::f64::consts::PI / 3.0);
    assert!((placed.axes.y_axis.x - 1.0).abs() < 1e-15);
    assert!((placed.middle.y - 2.0 - std::f64::consts::PI / 3.0).abs() < 1e-15);
    assert_eq!(solids[0].friction, Friction::TangentialLoss(1.0));
    assert!(solids[0].keys.is_empty());
    let Shape::Box { size } = solids[1].shape else { panic!("{:?}", solids[1]) };
    assert_eq!((size.to_array(), solids[1].friction), ([1.0, 2.0, 3.0], Friction::Coulomb(0.5)));
}

#[test]
fn a_key_frame_takes_what_it_leaves_out_from_the_one_before() {
    let lines = "[[world.solids]]\nkind = 'sphere'\nradius = 1\nposition = [1, 2, 3]\n\
                 key_frames = [{ time = 1, rotation = { axis = [0, 0, 2], angle_deg = 90 } }, \
                 { time = 2.5, position = [0, 1, 0] }]\n";
    let solid = &toml(&format!("{}{lines}", body(ROPE))).expect("a solid").scene.solids[0];
    assert_eq!(solid.keys.iter().map(|key| key.time).collect::<Vec<_>>(), [1.0, 2.5]);
    assert_eq!(solid.keys[0].position.to_array(), [1.0, 2.0, 3.0]);
    assert_eq!(solid.keys[1].position.to_array(), [0.0, 1.0, 0.0]);
    assert!((solid.keys[0].axes.x_axis.y - 1.0).abs() < 1e-15);
    assert_eq!(solid.keys[1].axes, solid.keys[0].axes);
}

#[test]
fn the_solver_says_how_the_scene_is_stepped() {
    let text = "version = 1\n[solver]\nintegrator = 'rk4'\nsteps_per_second = 120\nsubsteps = 3\n\
                precision = 'f64'\n[[bodies]]\nkind = 'rope'\nsize = [2]\n";
    let loaded = toml(text).expect("a rope");
    let expected = Settings {
        integrator: Integrator::Rk4,
        step: 1.0 / 120.0,
        substeps: 3,
        ..Settings::default()
    };
    assert_eq!((loaded.settings, loaded.precision), (expected, Precision::F64));
    assert!(!loaded.automatic);
    let automatic = text.replace("substeps = 3", "substeps = 'auto'");
    assert!(toml(&automatic).expect("a rope").automatic);
    let rows = read(&automatic, SceneFormat::Toml, "s.toml").expect("a scene");
    let written = write(&rows, SceneFormat::Json).expect("a scene");
    assert!(written.contains("\"substeps\": \"auto\""), "{written}");
    assert_eq!(read(&written, SceneFormat::Json, "s.json").expect("a scene"), rows);
    // Another name for the same, which is not written.
    let named = text.replace("substeps = 3", "step = 'auto'");
    let (named, automatic) = (toml(&named).expect("a rope"), toml(&automatic).expect("a rope"));
    assert_eq!((named.settings, named.automatic), (automatic.settings, true));
    let rows = read("version = 1\n[solver]\nstep = 'auto'\n", SceneFormat::Toml, "s.toml");
    let written = write(&rows.expect("a scene"), SceneFormat::Toml).expect("a scene");
    assert!(!written.contains("step"), "{written}");
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
    // Some editors put a mark of the byte order first.
    let toml = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]";
    for (format, text) in [(SceneFormat::Json, json), (SceneFormat::Toml, toml)] {
        let marked = parse(&format!("\u{feff}{text}"), format, "s");
        assert!(marked.is_ok(), "{:?}", marked.err());
    }
    let json = parse(json, SceneFormat::Json, "s.json").expect("JSON").scene;
    assert_eq!(json, scene(&format!("{ROPE}spin = [0, 1, 0]\n[[pins]]\nparticle = 0\n")));
}

#[test]
fn every_built_in_scene_is_the_same_after_writing_it_and_reading_it_again() {
    for builtin in BUILTINS.iter().chain(&LESSONS) {
        let rows: SceneFile = read(builtin.text, SceneFormat::Toml, builtin.name).expect("rows");
        for format in [SceneFormat::Toml, SceneFormat::Json] {
            let text = write(&rows, format).expect("text");
            assert_eq!(read(&text, format, builtin.name).expect(&text), rows);
        }
    }
}

#[test]
fn what_lies_in_its_domain_runs_and_what_does_not_is_refused_by_its_words() {
    let scene = |precision: &str, key: &str, value: f64| {
        let (table, key) = key.split_once('.').expect("a table and a key");
        let line =
            |of: &str| if of == table { format!("{key} = {value:e}\n") } else { String::new() };
        toml(&format!(
            "version = 1\n[solver]\nsubsteps = 1\nprecision = '{precision}'\n{}[[bodies]]\n\
             {ROPE}{}",
            line("solver"),
            line("bodies")
        ))
    };
    for (precision, key, inside, outside) in [
        ("f32", "bodies.mass", 3e-39, 2.9e-39),
        ("f64", "bodies.mass", 6e-309, 5.9e-309),
        ("f32", "bodies.mass", 3.4e38, 3.5e38),
        ("f32", "solver.step", 4e-23, 3.9e-23),
        ("f64", "solver.step", 3e-162, 2.9e-162),
        ("f64", "solver.step", 1e6, 1.1e6),
        ("f64", "solver.steps_per_second", 1e-6, 0.9e-6),
        ("f32", "solver.steps_per_second", 2e22, 3e22),
        ("f64", "solver.tolerance", 1.0, 1.1),
        ("f64", "bodies.stiffness", 0.0, -1e-300),
    ] {
        let run = run(&scene(precision, key, inside).expect("in its domain"), 0);
        assert!(run.is_ok(), "{key} = {inside:e}: {}", run.unwrap_err());
        let message = scene(precision, key, outside).expect_err(key).to_string();
        let words = find(key).expect(key).domain.words();
        let told = message.contains(words) || message.contains("at most 3.4e38");
        assert!(told, "{key} = {outside:e}: {message}");
    }
    // A mesh shares its mass among its particles.
    let light = "version = 1\n[[bodies]]\nkind = 'mesh'\nfile = 'bunny.obj'\nmass = 1e-38\n";
    let message = toml(light).expect_err("too light").to_string();
    assert!(
        message.contains("bodies[0].mass is 1e-38; it must be so large that each"),
        "{message}"
    );
}

#[test]
fn the_documentation_has_the_defaults_of_meshes() {
    let docs = include_str!("../../../../docs/reference/scenes.md");
    let defaults = |file: &str, faces: &str| {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n{faces}");
        let mesh = parse_mesh(text.as_bytes(), Format::Obj, file).expect("a mesh");
        MeshOptions::for_mesh(&mesh, Filling::Auto)
    };
    let closed = defaults("closed.obj", "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    let open = defaults("open.obj", "f 1 3 2\nf 1 2 4\nf 1 4 3\n");
    let solid = scene("kind = 'rope'\nsize = [2]").springs[0];
    for (plain, closed, open) in [
        (solid.stiffness, closed.stiffness, open.stiffness),
        (solid.damping, closed.damping, open.damping),
    ] {
        let told = format!("| {plain}; for a closed mesh {closed}, for an open mesh {open} |");
        assert!(docs.contains(&told), "{told}");
    }
    let shell = scene("kind = 'mesh'\nfile = 'teapot.obj'");
    assert!(shell.springs.iter().all(|s| (s.stiffness, s.damping) == (1000.0, 0.2)));
    let bunny = scene("kind = 'mesh'\nfile = 'bunny.obj'");
    assert!(bunny.springs.iter().all(|s| (s.stiffness, s.damping) == (200.0, 0.04)));
}

#[test]
fn the_example_of_the_documentation_runs() {
    let docs = include_str!("../../../../docs/reference/scenes.md");
    let example = docs.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let loaded = toml(example.expect("an example")).expect("the example");
    let stable = run(&loaded, 60).expect("a run");
    assert!(loaded.settings.substep() <= 0.7 * stable);
}

#[test]
fn looks_are_read_and_change_nothing_of_a_run() {
    let scene = |look: &str, kind: &str| {
        toml(&format!("version = 1\n[[bodies]]\nkind = '{kind}\nspacing = 0.1\n{look}\n"))
    };
    let (block, cloth) = ("block'\nsize = [3, 3, 3]", "cloth'\nsize = [3, 3]");
    let plain = scene("", block).expect("a scene").scene;
    let given = "look = { finish = 'metal', colour = '#ff8000', roughness = 0.5 }";
    let dressed = scene(given, block).expect("a scene").scene;
    let look = dressed.bodies[0].look;
    assert_eq!(look.colour, Some([1.0, 128.0 / 255.0, 0.0]));
    assert!(look.metal && look.roughness == 0.5 && !plain.bodies[0].look.metal);
    let bare = |mut scene: msd_core::Scene| {
        scene.bodies.iter_mut().for_each(|body| body.look = Default::default());
        scene
    };
    assert_eq!(bare(dressed), bare(plain));
    assert_eq!(scene("", cloth).expect("a scene").scene.bodies[0].look.pattern, Pattern::Weave);
    for (look, kind, told) in [
        ("look = { colour = 'red' }", block, "bodies[0].look.colour is \"red\""),
        ("look = { colour = '#12345g' }", block, "a colour such as \"#3d7fb5\""),
        ("look = { back = '#123456' }", block, "bodies[0].look.back does not apply"),
        ("look = { roughness = 1.5 }", cloth, "from 0 to 1"),
        ("look = { pattern_size = 0 }", cloth, "positive and at most 1e12"),
        ("look = { finish = 'wooden' }", cloth, "did you mean `wood`?"),
        ("look = { color = '#123456' }", cloth, "did you mean `colour`?"),
    ] {
        let message = scene(look, kind).expect_err(look).to_string();
        assert!(message.contains(told), "{look}: {message}");
    }
}

#[test]
fn a_camera_is_read_and_checked() {
    let scene =
        |camera: &str| toml(&format!("version = 1\n[camera]\n{camera}\n[[bodies]]\n{ROPE}"));
    let camera = scene("yaw_deg = 30\ntarget = [1, 2, 3]").expect("a camera").camera;
    assert_eq!((camera.yaw_deg, camera.target), (Some(30.0), Some([1.0, 2.0, 3.0])));
    assert_eq!((camera.pitch_deg, camera.distance), (None, None));
    for camera in ["pitch_deg = 90", "distance = 0", "target = [1e9, 0, 0]", "yaw_deg = nan"] {
        assert!(scene(camera).is_err(), "{camera}");
    }
}

#[test]
fn a_key_of_another_table_is_offered_where_it_belongs() {
    let of_body =
        |line: &str| format!("version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\n{line}\n");
    for (text, offered) in [
        (of_body("color = '#ffffff'"), "`color` in bodies[0]; did you mean `look.colour`?"),
        (of_body("gravity = [0, 0, 0]"), "`gravity` in bodies[0]; did you mean `world.gravity`?"),
        (of_body("radius = 1"), "`radius` in bodies[0]; did you mean `world.solids[0].radius`?"),
        (of_body("look.mass = 1"), "`mass` in bodies[0].look; did you mean `bodies[0].mass`?"),
        (of_body("zebra = 1"), "`zebra` in bodies[0]; the keys are kind, name, size"),
        (of_body("[world]\nsubsteps = 3"), "`substeps` in world; did you mean `solver.substeps`?"),
    ] {
        let error = parse(&text, SceneFormat::Toml, "s.toml").expect_err(&text).to_string();
        assert!(error.contains(offered), "{error}\n{offered}");
    }
    for (set, offered) in [
        (
            "gravity=[0,0,0]",
            "--set gravity: unknown key `gravity` in the scene; did you mean `world.g",
        ),
        ("color=red", "did you mean `bodies[0].look.colour`?"),
        ("integrator=rk4", "did you mean `solver.integrator`?"),
        ("stiffness=3", "did you mean `bodies[0].stiffness`?"),
        ("friction=3", "did you mean `world.planes[0].friction`?"),
    ] {
        let set = Assignment::parse(set).expect(set);
        let error = open_set("cloth", &[set]).expect_err(offered).to_string();
        assert!(error.contains(offered), "{error}\n{offered}");
    }
}

#[test]
fn a_file_is_offered_for_its_name_without_the_ending() {
    let folder = tempfile::tempdir().expect("a folder");
    for file in ["bridge.toml", "jelli.json", "part.stl"] {
        std::fs::write(folder.path().join(file), "").expect("a file");
        let name = folder.path().join(file.split('.').next().expect("a name"));
        let error = open(&name).expect_err(file).to_string();
        let offered = format!("did you mean `{}`?", folder.path().join(file).display());
        assert!(error.ends_with(&offered), "{error}");
    }
}

#[test]
fn a_name_that_stands_for_nothing_gets_the_nearest_one() {
    let message = |name: &str| open(name).expect_err(name).to_string();
    assert_eq!(message("jely"), "no scene `jely`: did you mean `jelly`?");
    assert!(message("qqqq").contains("the built-in scenes are cube, jelly"));
    assert!(message("none.toml").starts_with("none.toml: cannot be read"));
    assert!(message("none.obj").contains("none.obj"));
    assert!(message("/").contains("it is a folder"));
}

#[test]
fn a_file_is_known_by_its_ending() {
    let message = |path: &str| mesh::read(Path::new(path)).unwrap_err().to_string();
    assert_eq!(
        message("scene.toml"),
        "scene.toml: unknown mesh format 'toml'; it must be one of obj, stl, ply, gltf, glb"
    );
    assert!(message("not/there.OBJ").starts_with("not/there.OBJ: cannot be read: "));
}
