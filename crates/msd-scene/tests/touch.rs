//! The table `touch` of bodies: what it makes of their particles.

use msd_core::{Between, Settings, Simulation, Touch};
use msd_scene::{Loaded, SceneFormat, parse};

fn load(bodies: &str) -> Loaded {
    let text = format!("version = 1\n{bodies}");
    parse(&text, SceneFormat::Toml, "s.toml").expect("a valid scene")
}

#[test]
fn defaults_follow_from_the_springs() {
    let loaded = load(
        "[[bodies]]\nkind = 'cloth'\nsize = [5, 5]\nspacing = 0.2\nstiffness = 80\ndamping = 0.4\n\
         touch = { obstacles = false }\n",
    );
    let [touch] = &loaded.scene.touches[..] else { panic!("one row") };
    let Touch { particles, radius, stiffness, damping, friction, itself, obstacles, .. } = touch;
    assert_eq!(*particles, (0..25).collect::<Vec<_>>());
    // 16 particles have fewer springs than the 8 of those inside: 72 springs, each at two.
    let sum = 2.0 * 72.0 * 80.0 / 25.0;
    assert!((radius - 0.09).abs() < 1e-12 && (stiffness - sum / 8.0).abs() < 1e-9);
    assert!((damping / stiffness - 0.4 / 80.0).abs() < 1e-12);
    assert_eq!((*friction, *itself, *obstacles), (0.5, true, false));
    assert!(touch.ignored.is_empty() && touch.between.is_empty());
    assert!(loaded.scene.exempt.is_empty() && loaded.notes.is_empty());
}

#[test]
fn a_block_touches_with_its_surface_a_rope_with_all_of_it() {
    let loaded = load(
        "[[bodies]]\nkind = 'block'\nsize = [5, 5, 5]\ntouch = { damping = 1 }\n\
         [[bodies]]\nkind = 'rope'\nsize = [7]\nposition = [0, 9, 0]\ntouch = {}\n\
         [[bodies]]\nkind = 'rope'\nsize = [7]\nposition = [0, 19, 0]\n",
    );
    let counts: Vec<usize> = loaded.scene.touches.iter().map(|row| row.particles.len()).collect();
    assert_eq!(counts, [5 * 5 * 5 - 3 * 3 * 3, 7]);
}

#[test]
fn bodies_are_ignored_by_name_in_either_order() {
    let rope = |name: &str, ignore: &str, key: &str| {
        format!(
            "[[bodies]]\nkind = 'rope'\nname = '{name}'\nsize = [3]\n\
             touch = {{ {key} ignore = [{ignore}] }}\n"
        )
    };
    let all = |key: &str| [rope("a", "'c'", key), rope("b", "'a'", ""), rope("c", "", "")].concat();
    let rows = load(&all("")).scene.shells;
    let ignored: Vec<&[usize]> = rows.iter().map(|row| &row.ignored[..]).collect();
    assert_eq!(ignored, [&[][..], &[0], &[0]]);
    let rows = load(&all("radius = 0.4,")).scene.touches;
    let ignored: Vec<&[usize]> = rows.iter().map(|row| &row.ignored[..]).collect();
    assert_eq!(ignored, [&[][..], &[0], &[0]]);
}

#[test]
fn what_stands_between_two_bodies_is_said_by_either() {
    let rope = |name: &str, touch: &str| {
        format!("[[bodies]]\nkind = 'rope'\nname = '{name}'\nsize = [3]\n{touch}\n")
    };
    let with = |other: &str| format!("with = [{{ body = '{other}', friction = 0.125 }}]");
    let between = Between { row: 0, friction: Some(0.125), ..Between::default() };
    let [plain, of_a, of_b] =
        ["".into(), with("a"), with("b")].map(|with| format!("touch = {{ {with} }}"));
    for text in [[rope("a", &of_b), rope("b", &plain)], [rope("a", &plain), rope("b", &of_a)]] {
        let rows = load(&text.concat()).scene.touches;
        assert_eq!((&rows[0].between[..], &rows[1].between[..]), (&[][..], &[between][..]));
    }
    let refused = |bodies: [String; 2], words: &str| {
        let text = format!("version = 1\n{}", bodies.concat());
        let error = parse(&text, SceneFormat::Toml, "s.toml").expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    let again = "bodies[1].touch.with[0].body is \"a\" again: how the two touch is said once";
    refused([rope("a", &of_b), rope("b", &of_a)], again);
    let ignores = "touch = { ignore = ['b'] }";
    let words = "bodies[1].touch.with[0].body is \"a\", and one of the two ignores the other";
    refused([rope("a", ignores), rope("b", &of_a)], words);
    // One that touches nothing is told.
    let notes = load(&[rope("a", ""), rope("b", &of_a)].concat()).notes;
    assert_eq!(notes, ["bodies[1].touch.with[0] has no effect: \"a\" has no table `touch`"]);
}

#[test]
fn a_sheet_that_leaks_is_told_and_one_radius_is_offered() {
    let notes = |radius: &str| {
        let text = format!(
            "[[bodies]]\nkind = 'cloth'\nsize = [5, 5]\nspacing = 0.1\ntouch = {{ {radius} }}\n"
        );
        load(&text).notes
    };
    assert!(notes("damping = 1").is_empty() && notes("radius = 0.04").is_empty());
    let told = &notes("radius = 0.03")[0];
    assert!(told.contains("leak already at rest; from a radius of 0.045 m on"), "{told}");
    // Two particles of a radius of 0.036 m in the middle of a square: 0.036 x 2 √2 / 0.1 = 1.018.
    let told = &notes("radius = 0.036")[0];
    assert!(told.contains("leak where they are stretched by 1.8 %;"), "{told}");
    assert!(told.contains("`triangles = true` closes them"), "{told}");
    assert!(notes("radius = 0.03, triangles = true").is_empty());
}

#[test]
fn triangles_are_those_of_the_surface() {
    let rows = |kind: &str, triangles: &str| {
        let text = format!("[[bodies]]\nkind = {kind}\nspacing = 0.2\ntouch = {{ {triangles} }}\n");
        load(&text).scene.touches
    };
    assert!(rows("'cloth'\nsize = [4, 5]", "damping = 1")[0].triangles.is_empty());
    assert!(
        rows("'cloth'\nsize = [4, 5]", "damping = 1, triangles = false")[0].triangles.is_empty()
    );
    assert_eq!(
        rows("'cloth'\nsize = [4, 5]", "damping = 1, triangles = true")[0].triangles.len(),
        2 * 3 * 4
    );
    let [block] = &rows("'block'\nsize = [3, 4, 5]", "damping = 1, triangles = true")[..] else {
        panic!("one row")
    };
    assert_eq!(block.triangles.len(), 4 * (2 * 3 + 3 * 4 + 4 * 2));
    // A surface is closed: every edge has two triangles, one each way.
    let mut edges: Vec<[usize; 2]> =
        block.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    let both = edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok());
    assert!(both && edges.windows(2).all(|pair| pair[0] != pair[1]));
}

#[test]
fn a_mesh_as_it_is_made_does_not_push_itself() {
    let loaded = load(
        "[world]\ngravity = [0, 0, 0]\n[[bodies]]\nkind = 'mesh'\nfile = 'teapot.obj'\n\
         touch = { radius = 0.01 }\n",
    );
    assert!(!loaded.scene.exempt.is_empty());
    let simulation = Simulation::<f64>::new(&loaded.scene, Settings::default()).expect("a scene");
    let (forces, _) = simulation.forces();
    let largest = forces.iter().map(|force| force.length()).fold(0.0, f64::max);
    assert!(largest < 1e-9, "{largest} N");
}

/// Lines after those of a rope of three particles, and what is told; ` ... ` stands for any text.
const REFUSED: [(&str, &str); 16] = [
    ("touch = { radius = 0 }", "bodies[0].touch.radius is 0; it must be positive and at most 1e12"),
    ("touch = { radius = 2 }", "bodies[0].touch.radius is 2; it must be at most the spacing, 1 m"),
    ("touch = { friction = -1 }", "bodies[0].touch.friction is -1; it must be finite and not"),
    ("touch = { ignore = ['rop'] }", "touch.ignore[0] names no body: \"rop\"; `rope` is one"),
    (
        "touch = { radius = 0.1, triangles = true }",
        "touch.triangles needs a surface, and this body has none",
    ),
    ("touch = { ignore = ['rope'] }", "touch.ignore[0] is the body itself; ... itself = false"),
    ("touch = { raduis = 1 }", "raduis"),
    ("touch = [0.1]", "s.toml:5:9: bodies[0].touch is a list; it must be a table"),
    (
        "touch = {}\n[[bodies]]\nkind = 'explicit'\nparticles = [{ position = [0, 0, 0] }]\n\
         touch = {}",
        "bodies[1].touch lacks the keys `radius` and `stiffness`: the body has no springs that",
    ),
    (
        "touch = {}\n[[bodies]]\nkind = 'explicit'\nparticles = [{ position = [0, 0, 0] }]\n\
         touch = { radius = 1 }",
        "bodies[1].touch lacks the key `stiffness`: the body has no spring that it follows from",
    ),
    (
        "touch = { ignore = ['rope'] }\n[[bodies]]\nkind = 'rope'\nsize = [3]\ntouch = {}",
        "bodies[0].touch.ignore[0] is \"rope\", the name of bodies 0 and 1: give each a `name`",
    ),
    (
        "name = \"e\\u001b[31m\\n\\u202e\"\ntouch = { ignore = [\"e\\u001b[31m\\n\"] }",
        "names no body: \"e\\u{1b}[31m\\n\"; `e\\u{1b}[31m\\n\\u{202e}` is one",
    ),
    ("touch = { with = [{ body = 'rop' }] }", "with[0].body names no body: \"rop\"; `rope` is one"),
    ("touch = { with = [{ body = 'rope' }] }", "touch.with[0].body is the body itself; its own"),
    ("touch = { with = [{ body = 'rope', friction = -1 }] }", "with[0].friction is -1; it must be"),
    (
        "stiffness = 0\ntouch = { radius = 0.1 }",
        "bodies[0].touch lacks the key `stiffness`: the body has no",
    ),
];

#[test]
fn what_cannot_be_is_refused_in_a_line_that_names_it() {
    for (lines, told) in REFUSED {
        let text = format!("version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\n{lines}\n");
        let error = parse(&text, SceneFormat::Toml, "s.toml").expect_err(told).to_string();
        assert!(!error.contains(char::is_control), "{error:?}");
        let mut rest = &error[..];
        for part in told.split(" ... ") {
            let at = rest.find(part).unwrap_or_else(|| panic!("{error}\n{told}"));
            rest = &rest[at + part.len()..];
        }
    }
}

/// Two cubes of 4 x 4 x 4 particles, 0.1 m apart, the second one moved by so much.
fn cubes(moved: [f64; 3], touch: [&str; 2], more: &str) -> Vec<String> {
    let cube = |name: &str, position: [f64; 3], touch: &str| {
        format!(
            "[[bodies]]\nname = '{name}'\nkind = 'block'\nsize = [4, 4, 4]\nspacing = 0.1\n\
             position = {position:?}\n{touch}\n"
        )
    };
    load(&[&cube("a", [0.0; 3], touch[0]), &cube("b", moved, touch[1]), more].concat()).notes
}

#[test]
fn a_body_that_starts_inside_another_is_told() {
    let both = ["touch = { radius = 0.045 }"; 2];
    // Of 64 particles 27 are inside, of which 8 are inside of b too. Each is √3 x 0.05 m from the
    // nearest corners of the squares around it, and two radii more are 0.09 m.
    let told = "b starts inside a with 19 of the 56 particles by which it touches, up to about \
                0.18 m deep: they push each other apart at once";
    assert_eq!(cubes([0.05; 3], both, ""), [told]);
    // One in another that is larger: the other way round.
    let small = "[[bodies]]\nname = 'c'\nkind = 'block'\nsize = [2, 2, 2]\nspacing = 0.01\n\
                 touch = {}\n";
    let small = cubes([9.0; 3], both, small);
    assert!(
        small.len() == 1 && small[0].starts_with("c starts inside a with 8 of the 8 particles")
    );
    // Beside it, where they overlap by less than half of 0.09 m and by more.
    let beside = |gap: f64| cubes([0.3 + gap, 0.0, 0.0], both, "");
    assert!(beside(0.046).is_empty());
    let told = "b starts inside a with 16 of the 56 particles by which it touches, up to about \
                0.046 m deep: they push each other apart at once";
    assert_eq!(beside(0.044), [told]);
}

#[test]
fn bodies_that_may_be_in_each_other_are_not_told() {
    let notes = |touch: [&str; 2], more: &str| cubes([0.05; 3], touch, more);
    assert!(notes(["touch = {}", ""], "").is_empty(), "one touches nothing");
    assert!(notes(["touch = { ignore = ['b'] }", "touch = {}"], "").is_empty());
    let pins = "[[pins]]\nset = 'all'\n[[pins]]\nbody = 'b'\nset = 'all'";
    assert!(notes(["touch = {}"; 2], pins).is_empty(), "nothing can move");
    let links = "[[links]]\nfrom = { body = 'b', set = 'all' }\nto = { body = 'a', set = 'all' }";
    assert!(notes(["touch = {}"; 2], links).is_empty(), "glued");
}

#[test]
fn a_thickness_makes_shells_of_surfaces_and_of_the_springs_of_ropes() {
    let loaded = load(
        "[[bodies]]\nkind = 'cloth'\nsize = [3, 3]\nspacing = 0.1\nneighbours = 8\n\
         touch = { thickness = 0.01 }\n\
         [[bodies]]\nkind = 'rope'\nsize = [4]\nspacing = 0.1\nposition = [0, 9, 0]\n\
         touch = { thickness = 0.02, friction = 0.25, itself = false, ignore = ['cloth'] }\n",
    );
    let [cloth, rope] = &loaded.scene.shells[..] else { panic!("two shells") };
    assert_eq!((cloth.triangles.len(), cloth.edges.len()), (8, 0));
    assert_eq!((cloth.thickness, cloth.friction, cloth.itself), (0.01, 0.5, true));
    assert_eq!(rope.edges, [[9, 10], [10, 11], [11, 12]]);
    assert_eq!((rope.thickness, rope.friction, rope.itself), (0.02, 0.25, false));
    assert_eq!((&cloth.ignored[..], &rope.ignored[..]), (&[][..], &[0][..]));
    assert!(loaded.scene.touches.is_empty() && loaded.notes.is_empty(), "{:?}", loaded.notes);
}

#[test]
fn bodies_meet_by_a_tenth_of_their_spacing_unless_a_key_gives_radii() {
    let cloth = |touch: &str| {
        let body = "[[bodies]]\nkind = 'cloth'\nsize = [3, 3]\nspacing = 0.1";
        load(&format!(
            "{body}\nname = 'a'\ntouch = {touch}\n{body}\nname = 'b'\nposition = [0, 0, 1]\n\
                        touch = {{}}\n"
        ))
    };
    let loaded = cloth("{ friction = 0.25 }");
    let [a, b] = &loaded.scene.shells[..] else { panic!("two shells") };
    assert!((a.thickness - 0.01).abs() < 1e-15 && a.thickness == b.thickness);
    assert_eq!((a.friction, b.friction, a.itself), (0.25, 0.5, true));
    assert!(loaded.scene.touches.is_empty() && loaded.notes.is_empty());
    let loaded = cloth("{ triangles = true }");
    assert_eq!((loaded.scene.shells.len(), loaded.notes.len()), (2, 1));
    assert!(
        loaded.notes[0].starts_with("a: `touch.triangles` has no effect"),
        "{:?}",
        loaded.notes
    );
    for key in ["radius = 0.04", "stiffness = 9", "damping = 1", "obstacles = true"] {
        let loaded = cloth(&format!("{{ {key} }}"));
        assert_eq!((loaded.scene.shells.len(), loaded.scene.touches.len()), (0, 2), "{key}");
    }
}

#[test]
fn a_surface_that_starts_in_another_is_reported() {
    let told = "b starts inside a with 19 of the 56 particles by which it touches, up to about";
    let [note] = &cubes([0.05; 3], ["touch = {}"; 2], "")[..] else { panic!("one note") };
    assert!(note.starts_with(told) && note.ends_with("they stay in each other: move one of them"));
}

#[test]
fn keys_beside_a_thickness_and_a_thick_surface_are_refused() {
    let refused = |touch: &str, words: &str| {
        let body = "kind = 'cloth'\nsize = [3, 3]\nspacing = 0.1";
        let text = format!("version = 1\n[[bodies]]\n{body}\ntouch = {touch}\n");
        let error = parse(&text, SceneFormat::Toml, "s.toml").expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    refused("{ thickness = 0.01, radius = 0.04 }", "bodies[0].touch.radius is for particles");
    refused("{ thickness = 0.01, damping = 1 }", "bodies[0].touch.damping is for particles");
    refused("{ thickness = 0 }", "bodies[0].touch.thickness is 0; it must be positive");
    let words = "bodies[0].touch.thickness is 0.05; it must be at most 0.4 of the spacing, 0.04 m";
    refused("{ thickness = 0.05 }", words);
}

#[test]
fn a_radius_and_a_thickness_that_do_not_meet_are_noted() {
    let notes = load(
        "[[bodies]]\nkind = 'rope'\nname = 'a'\nsize = [3]\ntouch = { radius = 0.4 }\n\
         [[bodies]]\nkind = 'rope'\nname = 'b'\nsize = [3]\ntouch = { thickness = 0.01 }\n",
    )
    .notes;
    let [note] = &notes[..] else { panic!("{notes:?}") };
    assert!(note.contains("a touches by the radius of its particles and b by the thickness"));
}
