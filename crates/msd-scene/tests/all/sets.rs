//! Named sets, masses on particles and links between bodies.

use msd_core::glam::DVec3;
use msd_core::{Scene, Simulation};
use msd_scene::{Draft, Finer, Loaded, SceneFormat, open_bytes_with, parse, read, write};
use std::collections::BTreeMap;
use std::path::Path;

fn toml(text: &str) -> Result<Loaded, String> {
    parse(text, SceneFormat::Toml, "s.toml").map_err(|error| error.to_string())
}

fn scene(text: &str) -> Scene {
    toml(&format!("version = 1\n{text}")).unwrap().scene
}

/// The particles that a set of one body holds.
fn held(body: &str, set: &str) -> Vec<usize> {
    let scene = scene(&format!("[[bodies]]\n{body}\n[[pins]]\nset = '{set}'\n"));
    scene.pins.iter().map(|pin| pin.particle).collect()
}

const BLOCK: &str = "kind = 'block'\nsize = [3, 4, 5]";
const CLOTH: &str = "kind = 'cloth'\nsize = [3, 4]";
const ROPE: &str = "kind = 'rope'\nsize = [4]";

#[test]
fn the_sets_of_a_lattice_are_its_corners_edges_surface_and_sides() {
    // Of r x c x s: 8, then 4 (r + c + s) - 16, then all but the inside.
    for (body, set, count) in [
        (BLOCK, "all", 60),
        (BLOCK, "corners", 8),
        (BLOCK, "edges", 32),
        (BLOCK, "surface", 54),
        (BLOCK, "left", 15),
        (BLOCK, "right", 15),
        (BLOCK, "bottom", 20),
        (BLOCK, "top", 20),
        (BLOCK, "back", 12),
        (BLOCK, "front", 12),
        (CLOTH, "all", 12),
        (CLOTH, "corners", 4),
        (CLOTH, "edges", 10),
        (CLOTH, "left", 3),
        (CLOTH, "top", 4),
    ] {
        assert_eq!(held(body, set).len(), count, "{body}: {set}");
    }
    assert_eq!(held(ROPE, "corners"), [0, 3]);
    assert_eq!([held(ROPE, "first"), held(ROPE, "last")], [[0], [3]]);
    assert_eq!([held(ROPE, "left"), held(ROPE, "right")], [[0], [3]]);
    assert_eq!(held("kind = 'rope'\nsize = [1]", "corners"), [0]);
}

#[test]
fn a_side_is_where_its_name_says_before_the_body_is_turned() {
    let start = scene(&format!("[[bodies]]\n{BLOCK}\n"));
    for (set, direction) in [
        ("left", -DVec3::X),
        ("right", DVec3::X),
        ("bottom", -DVec3::Y),
        ("top", DVec3::Y),
        ("back", -DVec3::Z),
        ("front", DVec3::Z),
    ] {
        let along = |particle: usize| start.particles[particle].position.dot(direction);
        let most = (0..start.particles.len()).map(along).fold(f64::MIN, f64::max);
        let found: Vec<usize> =
            (0..start.particles.len()).filter(|&particle| along(particle) == most).collect();
        assert_eq!(held(BLOCK, set), found, "{set}");
        let turned = format!("{BLOCK}\nrotation = {{ axis = [1, 2, 3], angle_deg = 70 }}");
        assert_eq!(held(&turned, set), found, "{set}");
    }
}

#[test]
fn a_box_and_a_sphere_hold_what_is_inside_and_on_them_at_the_start() {
    let set = |space: &str| {
        let text = format!(
            "[[bodies]]\nkind = 'rope'\nsize = [11]\nspacing = 0.1\nposition = [5, 0, 0]\n\
             [[sets]]\nname = 'part'\n{space}\n[[pins]]\nset = 'part'\n"
        );
        scene(&text).pins.iter().map(|pin| pin.particle).collect::<Vec<_>>()
    };
    // From 4.8 to 5.2, whose ends are particles but for the rounding of 0.1.
    assert_eq!(set("box = { position = [5, 0, 0], size = [0.4, 1, 1] }"), [3, 4, 5, 6, 7]);
    assert_eq!(set("sphere = { position = [5.5, 0, 0], radius = 0.2 }"), [8, 9, 10]);
}

#[test]
fn a_mesh_has_its_surface_and_an_open_one_its_rim() {
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";
    let meshes = BTreeMap::from([("open.obj".to_string(), faces.as_bytes().to_vec())]);
    let held = |set: &str| {
        let text = format!(
            "version = 1\n[[bodies]]\nkind = 'mesh'\nfile = 'open.obj'\n[[pins]]\nset = '{set}'\n"
        );
        let loaded = open_bytes_with("s.toml", text.as_bytes(), &meshes).unwrap();
        loaded.scene.pins.iter().map(|pin| pin.particle).collect::<Vec<_>>()
    };
    assert_eq!(held("surface"), [0, 1, 2, 3]);
    // The face 2 3 4 is not there.
    assert_eq!(held("edges"), [1, 2, 3]);
}

#[test]
fn two_sets_may_share_particles_that_they_hold_alike() {
    let cloth = |pins: &str| toml(&format!("version = 1\n[[bodies]]\n{CLOTH}\n{pins}"));
    let loaded = cloth("[[pins]]\nset = 'left'\n[[pins]]\nset = 'top'\n").unwrap();
    assert_eq!(loaded.scene.pins.len(), 3 + 4 - 1);
    let message =
        cloth("[[pins]]\nset = 'left'\n[[pins]]\nset = 'top'\nvelocity = [1, 0, 0]\n").unwrap_err();
    assert!(message.contains("pins[1] and pins[0] hold the same particle"), "{message}");
}

#[test]
fn a_mass_is_added_to_that_of_a_particle_and_the_body_spins_about_its_new_centre() {
    let scene = scene(
        "[[bodies]]\nkind = 'rope'\nsize = [3]\nmass = 2\nvelocity = [0, 0, 3]\nspin = [0, 5, 0]\n\
         [[masses]]\nset = 'last'\nmass = 4\n[[masses]]\nparticle = 2\nmass = 1\n",
    );
    assert_eq!(scene.particles.iter().map(|p| p.mass).collect::<Vec<_>>(), [2.0, 2.0, 7.0]);
    let momentum: DVec3 = scene.particles.iter().map(|p| p.mass * p.velocity).sum();
    // 11 kg at 3 m/s; a few roundings.
    assert!((momentum - DVec3::Z * 33.0).length() < 1e-13, "{momentum}");
    let turn = scene.particles[2].velocity - scene.particles[0].velocity;
    assert!((turn - DVec3::Y.cross(DVec3::X) * 10.0).length() < 1e-14, "{turn}");
}

const CUBE_ON_ROPE: &str = "version = 1\n\
    [[bodies]]\nname = 'rope'\nkind = 'rope'\nsize = [5]\nspacing = 0.25\n\
    rotation = { axis = [0, 0, 1], angle_deg = -90 }\nposition = [0, 2, 0]\n\
    [[bodies]]\nname = 'cube'\nkind = 'block'\nsize = [3, 3, 3]\nspacing = 0.1\n\
    position = [0, 1.2, 0]\n\
    [[masses]]\nbody = 'cube'\nset = 'bottom'\nmass = 0.5\n\
    [[pins]]\nbody = 'rope'\nset = 'first'\n\
    [[links]]\nfrom = { body = 'cube', set = 'top' }\nto = { body = 'rope', set = 'last' }\n\
    stiffness = 300\ndamping = 2\n";

#[test]
fn each_particle_of_a_link_is_joined_to_the_nearest_at_the_distance_of_the_start() {
    let scene = toml(CUBE_ON_ROPE).unwrap().scene;
    let own = scene.bodies[1].springs.end;
    let links = &scene.springs[own..];
    assert_eq!(links.len(), 9);
    for link in links {
        let [a, b] = link.ends;
        assert_eq!((b, link.stiffness, link.damping), (4, 300.0, 2.0));
        let [from, to] = [a, b].map(|end| scene.particles[end].position);
        assert_eq!(link.rest_length, from.distance(to));
        // The top of the cube.
        assert!((from.y - 1.3).abs() < 1e-15);
    }
    let within = CUBE_ON_ROPE.to_owned() + "within = 0.22\nrest_length = 0.1\n";
    // 0.2 below the rope: the middle and its four neighbours are at 0.2 and 0.2236 m.
    let scene = toml(&within).unwrap().scene;
    assert_eq!(scene.springs.len(), own + 1);
    assert_eq!(scene.springs[own].rest_length, 0.1);
    assert_eq!(scene.pins[0].particle, 0);
}

#[test]
fn two_of_one_body_that_are_nearest_to_each_other_get_one_spring() {
    let text = "[[bodies]]\nkind = 'explicit'\nparticles = [{ position = [0, 0, 0] }, \
                { position = [1, 0, 0] }, { position = [3, 0, 0] }]\n\
                [[links]]\nfrom = { set = 'all' }\nto = { set = 'all' }\n";
    let ends = |text: &str| -> Vec<[usize; 2]> {
        scene(text).springs.iter().map(|spring| spring.ends).collect()
    };
    assert_eq!(ends(text), [[0, 1], [2, 1]]);
    // Another table adds its own, beside the same two.
    let again = format!("{text}[[links]]\nfrom = {{ particle = 2 }}\nto = {{ particle = 1 }}\n");
    assert_eq!(ends(&again), [[0, 1], [2, 1], [2, 1]]);
}

/// Two particles of masses m and M on a spring k: ω² = k (1/m + 1/M).
#[test]
fn two_linked_bodies_swing_at_the_frequency_of_their_link() {
    let text = "version = 1\n\
        [solver]\nintegrator = 'rk4'\nstep = 1e-3\nsubsteps = 1\nprecision = 'f64'\n\
        [world]\ngravity = [0, 0, 0]\n\
        [[bodies]]\nname = 'a'\nkind = 'rope'\nsize = [1]\nmass = 2\n\
        [[bodies]]\nname = 'b'\nkind = 'rope'\nsize = [1]\nmass = 3\nposition = [1.25, 0, 0]\n\
        [[links]]\nfrom = { body = 'a', particle = 0 }\nto = { body = 'b', particle = 0 }\n\
        rest_length = 1\nstiffness = 60\n";
    let loaded = toml(text).unwrap();
    let mut simulation = Simulation::<f64>::new(&loaded.scene, loaded.settings).unwrap();
    let rate = f64::sqrt(60.0 * (1.0 / 2.0 + 1.0 / 3.0));
    for _ in 0..1000 {
        simulation.step().unwrap();
    }
    let positions = &simulation.state().positions;
    let gap = positions[1].x - positions[0].x;
    // An error of phase of (ωh)⁴/120 per radian, of 7 rad, times 0.25 m: 4e-11.
    assert!((gap - 1.0 - 0.25 * rate.cos()).abs() < 1e-10, "{gap}");
}

fn finer(text: &str) -> Result<(Loaded, Finer), String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    let draft = Draft::open(Path::new("scene.toml"), folder.path()).unwrap();
    let source = draft.source().unwrap();
    let coarse = draft.load(&source).map_err(|error| error.to_string())?;
    let finer = draft.finer(&source, &coarse.scene, 1).map_err(|error| error.to_string())?;
    Ok((coarse, finer))
}

#[test]
fn at_half_the_spacing_masses_and_links_stay_where_they_were() {
    let (coarse, finer) = finer(CUBE_ON_ROPE).unwrap();
    let (before, after) = (&coarse.scene, &finer.loaded.scene);
    let links = |scene: &Scene| {
        let links = scene.springs[scene.bodies[1].springs.end..].iter();
        let place = |end: usize| scene.particles[end].position;
        links
            .map(|link| (link.ends.map(place), link.rest_length, link.stiffness, link.damping))
            .collect::<Vec<_>>()
    };
    let (before_links, after_links) = (links(before), links(after));
    assert_eq!(before_links.len(), after_links.len());
    for (a, b) in before_links.iter().zip(&after_links) {
        assert_eq!((a.1, a.2, a.3), (b.1, b.2, b.3));
        // A few roundings of coordinates of some metres.
        assert!((0..2).all(|end| a.0[end].distance(b.0[end]) < 1e-14), "{a:?} {b:?}");
    }
    // Nine masses of 0.5 kg on a cube whose particles share out 27 kg as 125 of 1/8 kg.
    let heavy = after.particles.iter().filter(|particle| particle.mass == 0.625).count();
    assert_eq!(heavy, 9);
    assert_eq!(after.pins.len(), 1);
    let again = parse(&write(&finer.rows, SceneFormat::Toml).unwrap(), SceneFormat::Toml, "again");
    assert!(again.unwrap().scene == *after);
}

#[test]
fn a_set_is_refined_as_the_pins_that_it_names() {
    let (_, finer) =
        finer(&format!("version = 1\n[[bodies]]\n{CLOTH}\n[[pins]]\nset = 'edges'\n")).unwrap();
    // 5 x 7 particles.
    assert_eq!(finer.loaded.scene.pins.len(), 2 * (5 + 7) - 4);
}

#[test]
fn what_is_inside_a_mesh_has_no_place_in_a_finer_one() {
    let message = finer(
        "version = 1\n[[bodies]]\nkind = 'mesh'\nfile = 'bunny.obj'\n[[masses]]\nset = 'last'\n\
         mass = 1\n",
    );
    let message = message.unwrap_err();
    assert!(message.contains("masses hold particle"), "{message}");
}

#[test]
fn rows_are_written_as_they_were_read() {
    let file = read(CUBE_ON_ROPE, SceneFormat::Toml, "s.toml").unwrap();
    for format in [SceneFormat::Toml, SceneFormat::Json] {
        let text = write(&file, format).unwrap();
        assert_eq!(read(&text, format, "s").unwrap(), file);
    }
}

/// Lines after two ropes of three particles, `a` at the origin and `b` 1 m above, and the message.
const REFUSED: [(&str, &str); 38] = [
    (
        "[[pins]]\nset = 'edgs'",
        "s.toml:12:7: pins[0].set is \"edgs\"; it must be a set of body 0, `a`:",
    ),
    (
        "[[pins]]\nset = 'firts'",
        "a set of body 0, `a`: all, first, last, corners, left, right, or one of [[sets]]; did you \
         mean `first`?",
    ),
    ("[[pins]]\nparticle = -1", "pins[0].particle is -1; it must be from 0 to 2: there are 3"),
    (
        "[[links]]\nfrom = { particle = -1 }\nto = { body = 1, set = 'all' }",
        "links[0].from.particle is -1; it must be from 0 to 2: there are 3 particles",
    ),
    ("[[pins]]\nat = [-1, 0, 0]", "pins[0].at[0] is -1; it must be a whole number, not negative"),
    (
        "[[sets]]\nname = ''\nsphere = { position = [0, 0, 0], radius = 1 }",
        "sets[0].name is \"\"; it must be a name, which rows can call it by",
    ),
    (
        "[[pins]]\nset = 'edges'",
        "it must be a set of body 0, `a`: all, first, last, corners, left,",
    ),
    (
        "[[pins]]\nbody = 'c'\nset = 'all'",
        "pins[0].body is \"c\"; it must be the number or the name",
    ),
    ("[[pins]]\nbody = -1\nset = 'all'", "pins[0].body is -1; it must be a whole number, not nega"),
    ("[[pins]]\nbody = 2\nset = 'all'", "pins[0].body is 2; it must be from 0 to 1: there are 2"),
    ("[[pins]]\nbody = 1.5\nset = 'all'", "pins[0].body is 1.5; it must be a whole number, not"),
    (
        "[[pins]]\nset = 'all'\nparticle = 1",
        "pins[0] needs exactly one of the keys `particle`, `at`",
    ),
    ("[[masses]]\nset = 'all'", "masses[0] lacks the key `mass`"),
    ("[[masses]]\nset = 'all'\nmass = 0", "masses[0].mass is 0; it must be positive and finite"),
    (
        "[[masses]]\nset = 'all'\nmass = 3.5e38",
        "masses[0].mass is 3.5e38; it must be at most 3.4e38",
    ),
    ("[[masses]]\nmass = 1", "masses[0] needs exactly one of the keys `particle`, `at` and `set`"),
    ("[[masses]]\nevery = 1\nmass = 1", "unknown key `every` in masses[0]"),
    ("[[sets]]\nname = 'x'", "sets[0] needs exactly one of the keys `box` and `sphere`"),
    ("[[sets]]\nsphere = { position = [0, 0, 0], radius = 1 }", "sets[0] lacks the key `name`"),
    (
        "[[sets]]\nname = 'x'\nsphere = { position = [0, 0, 0], radius = 0 }",
        "s.toml:13:43: sets[0].sphere.radius is 0; it must be positive and at most 1e12",
    ),
    (
        "[[sets]]\nname = 'x'\nbox = { position = [0, 0, 0], size = [1, -1, 1] }",
        "sets[0].box.size[1] is -1; it must be positive and at most 1e12",
    ),
    (
        "[[sets]]\nname = 'x'\nbox = { position = [0, 9, 0], size = [1, 1, 1] }",
        "sets[0] holds no particle of body 0, `a`, which lies from (-1, 0, 0) to (1, 0, 0)",
    ),
    (
        "[[bodies]]\nkind = 'rope'\nsize = [3]\nspacing = 0.2\n\
         [[sets]]\nname = 'x'\nbody = 2\nbox = { position = [0, 9, 0], size = [1, 1, 1] }",
        "which lies from (-0.2, 0, 0) to (0.2, 0, 0)",
    ),
    (
        "[[sets]]\nname = 'top'\nsphere = { position = [0, 0, 0], radius = 1 }",
        "sets[0].name is `top`, which bodies have of their own: choose another",
    ),
    (
        "[[sets]]\nname = 'x'\nsphere = { position = [0, 0, 0], radius = 1 }\n\
         [[sets]]\nname = 'x'\nsphere = { position = [0, 0, 0], radius = 1 }",
        "sets[1].name is \"x\"; it must be a name that no other set has",
    ),
    (
        "[[sets]]\nname = 'x'\nsphere = { position = [0, 0, 0], radius = 1 }\n\
         [[pins]]\nbody = 'b'\nset = 'x'",
        "pins[0].set is \"x\"; it must be a set of body 1, `b`; this is one of body 0, `a`",
    ),
    (
        "[[sets]]\nname = 'patch'\nsphere = { position = [0, 0, 0], radius = 1 }\n\
         [[pins]]\nset = 'pach'",
        "did you mean `patch`?",
    ),
    ("[[links]]\nfrom = { set = 'all' }", "links[0] lacks the key `to`"),
    (
        "[[links]]\nfrom = { particle = 1 }\nto = { particle = 1 }",
        "links[0] joins particle 1 of the scene to itself; its ends must differ",
    ),
    (
        "[[links]]\nfrom = { set = 'all' }\nto = { set = 'last' }",
        "links[0] joins particle 2 of the scene to itself; its ends must differ",
    ),
    (
        "[[links]]\nfrom = { body = 'b', set = 'first' }\nto = { body = 'b', set = 'first' }",
        "links[0] joins particle 3 of the scene to itself; its ends must differ",
    ),
    (
        "[[links]]\nfrom = { set = 'all' }\nto = { body = 1, set = 'all' }\nwithin = 0.5",
        "links[0].within is 0.5; it must be at least 1, the distance of the nearest two",
    ),
    (
        "[[links]]\nfrom = { set = 'all' }\nto = { body = 1, set = 'all' }\nwithin = 0",
        "links[0].within is 0; it must be positive and finite",
    ),
    (
        "[[links]]\nfrom = { set = 'all' }\nto = { body = 1, set = 'all' }\nstiffness = -1",
        "links[0].stiffness is -1; it must be finite and not negative",
    ),
    (
        "[[links]]\nfrom = { set = 'all' }\nto = { body = 1, set = 'all' }\nrest_length = nan",
        "links[0].rest_length is NaN; it must be finite and not negative",
    ),
    (
        "[[links]]\nfrom = { set = 'all' }\nto = { body = 1, set = 'all' }\ndamping = 1e39",
        "links[0].damping is 1e39; it must be at most 3.4e38",
    ),
    (
        "[[links]]\nfrom = { set = 'all' }\nto = { body = 1, particle = 7 }",
        "s.toml:13:29: links[0].to.particle is 7; it must be from 0 to 2: there are 3 particles",
    ),
    (
        "[[links]]\nfrom = { sett = 'all' }\nto = { body = 1, particle = 7 }",
        "unknown key `sett` in links[0].from; did you mean `set`?",
    ),
];

#[test]
fn each_mistake_is_one_line_with_its_place_its_value_and_what_it_must_be() {
    let ropes = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\nname = 'a'\n\
                 [[bodies]]\nkind = 'rope'\nsize = [3]\nname = 'b'\nposition = [0, 1, 0]\n";
    for (lines, told) in REFUSED {
        let message = toml(&format!("{ropes}{lines}\n")).expect_err(lines);
        assert!(message.lines().count() == 1 && message.len() < 250, "{message}");
        assert!(message.contains(told), "{message}\n{told}");
    }
}

#[test]
fn a_name_that_two_bodies_have_names_neither() {
    let text = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\n\
                [[bodies]]\nkind = 'rope'\nsize = [3]\n[[pins]]\nbody = 'rope'\nset = 'first'\n";
    let message = toml(text).unwrap_err();
    let told =
        "pins[0].body is \"rope\"; it must be one name of one body: bodies 0 and 1 have this";
    assert!(message.contains(told), "{message}");
}

/// Fourteen million springs of 100 bytes for each of many rows: counted before they are made.
#[test]
fn links_beyond_the_memory_are_refused_before_they_are_made() {
    let row = "[[links]]\nfrom = { set = 'all' }\nto = { body = 1, particle = 0 }\n";
    let text = format!(
        "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3000000]\nspacing = 1e-3\n\
         [solver]\nprecision = 'f64'\n\
         [[bodies]]\nkind = 'rope'\nsize = [1]\nposition = [0, 1, 0]\n{}",
        row.repeat(9)
    );
    let message = toml(&text).unwrap_err();
    assert!(message.contains("links[") && message.contains("asks for"), "{message}");
}

/// The examples of the documentation that are whole scenes, by the text after their heading.
fn examples() -> Vec<&'static str> {
    let docs = include_str!("../../../../docs/reference/scenes.md");
    let blocks = docs.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
    blocks.filter(|block| block.contains("version = 1")).collect()
}

#[test]
fn every_scene_of_the_documentation_runs_and_stays_whole() {
    let examples = examples();
    assert!(6 <= examples.len(), "{}", examples.len());
    for text in examples {
        let loaded = toml(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert!(!loaded.notes.concat().contains("starts inside"), "{:?}\n{text}", loaded.notes);
        let mut settings = loaded.settings;
        let mut simulation = Simulation::<f64>::new(&loaded.scene, settings).unwrap();
        // The choice of `auto`, and a margin for stretched springs.
        let stable = simulation.stable_substep();
        settings.substeps = (settings.step / (0.6 * stable)).ceil() as u32;
        simulation.set_settings(settings).unwrap();
        for _ in 0..60 {
            simulation.step().unwrap_or_else(|error| panic!("{error}\n{text}"));
        }
        let state = simulation.state();
        for spring in &loaded.scene.springs {
            let [a, b] = spring.ends.map(|end| state.positions[end]);
            let stretch = a.distance(b) / spring.rest_length;
            assert!(stretch < 2.0, "a spring is {stretch} times as long as at rest\n{text}");
        }
    }
}

#[test]
fn a_number_of_a_particle_of_a_mesh_is_said_to_be_no_vertex_of_its_file() {
    let notes = |rows: &str| {
        let mesh = "[[bodies]]\nkind = 'mesh'\nfile = 'bunny.obj'\nname = 'hare'\n";
        let rope = "[[bodies]]\nkind = 'rope'\nsize = [3]\nposition = [0, 3, 0]\n";
        toml(&format!("version = 1\n{mesh}{rope}{rows}")).expect("a scene").notes
    };
    let warned = |rows: &str| notes(rows).concat().contains("not that of a vertex in its file");
    assert!(warned("[[pins]]\nparticle = 20\n"));
    assert!(warned("[[masses]]\nbody = 'hare'\nparticle = 3\nmass = 1\n"));
    assert!(!warned("[[pins]]\nset = 'first'\n"));
    assert!(!warned("[[pins]]\nbody = 1\nparticle = 2\n"));
}

/// A flag of two squares on a pole of one triangle, by objects, groups and materials.
const FLAG: &str = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0 -1 0\n\
    o flag cloth\ng near both\nusemtl red\nf 1 2 5 4\ng far both\nusemtl blue\nf 2 3 6 5\n\
    g\no pole\nf 1 7 2\no nothing\n";

fn of_flag(rows: &str) -> Result<Loaded, String> {
    let meshes = BTreeMap::from([("flag.obj".to_owned(), FLAG.as_bytes().to_vec())]);
    let body = "[[bodies]]\nkind = 'mesh'\nfile = 'flag.obj'\nlength = 2";
    let text = format!("version = 1\n{body}\n{rows}\n");
    open_bytes_with("s.toml", text.as_bytes(), &meshes).map_err(|error| error.to_string())
}

#[test]
fn what_a_mesh_file_names_is_a_set() {
    // Particles stand in the order in which faces use their vertices.
    for (set, right) in [
        ("near", &[0, 1, 2, 3][..]),
        ("red", &[0, 1, 2, 3]),
        ("far", &[1, 2, 4, 5]),
        ("both", &[0, 1, 2, 3, 4, 5]),
        ("flag cloth", &[0, 1, 2, 3, 4, 5]),
        // A material holds until the next one, in other objects too.
        ("blue", &[0, 1, 2, 4, 5, 6]),
        ("pole", &[0, 1, 6]),
    ] {
        let loaded = of_flag(&format!("[[pins]]\nset = '{set}'")).unwrap();
        let held: Vec<usize> = loaded.scene.pins.iter().map(|pin| pin.particle).collect();
        assert_eq!(held, right, "{set}");
    }
    let error = of_flag("[[pins]]\nset = 'nera'").unwrap_err();
    let known = "all, first, last, surface, edges, blue, both, far, flag cloth, near, pole, red";
    assert!(error.contains(known) && error.contains("did you mean `near`?"), "{error}");
}

#[test]
fn the_material_of_a_named_part_is_that_of_the_same_part_of_a_finer_scene() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("flag.obj"), FLAG).unwrap();
    let text = "version = 1\n[[bodies]]\nkind = 'mesh'\nfile = 'flag.obj'\nlength = 2\n\
                [[materials]]\nset = 'far'\ndamping = 7\n";
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    let draft = Draft::open(Path::new("scene.toml"), folder.path()).unwrap();
    let source = draft.source().unwrap();
    let coarse = draft.load(&source).unwrap();
    let fine = draft.finer(&source, &coarse.scene, 1).unwrap();
    // The part of springs whose both ends are on the right square, which starts at its middle.
    for scene in [&coarse.scene, &fine.loaded.scene] {
        let x = |end: usize| scene.particles[end].position.x;
        let left = scene.particles.iter().map(|row| row.position.x).fold(f64::MAX, f64::min);
        for spring in &scene.springs {
            let is_right = spring.ends.iter().all(|&end| left + 1.0 - 1e-9 < x(end));
            assert_eq!(spring.damping == 7.0, is_right, "{spring:?}");
        }
    }
}
