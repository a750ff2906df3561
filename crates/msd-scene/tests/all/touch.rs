//! The table `touch` of bodies: the shells that it makes of them.

use msd_core::scene::Between;
use msd_scene::{Loaded, SceneFormat, parse};

fn load(bodies: &str) -> Loaded {
    let text = format!("version = 1\n{bodies}");
    parse(&text, SceneFormat::Toml, "s.toml").expect("a valid scene")
}

#[test]
fn bodies_are_ignored_by_name_or_number_in_either_order() {
    let rope = |name: &str, ignore: &str| {
        format!(
            "[[bodies]]\nkind = 'rope'\nname = '{name}'\nsize = [3]\n\
             touch = {{ ignore = [{ignore}] }}\n"
        )
    };
    let all = [rope("a", "'c'"), rope("b", "'a'"), rope("c", "")].concat();
    let rows = load(&all).scene.shells;
    let ignored: Vec<&[usize]> = rows.iter().map(|row| &row.ignored[..]).collect();
    assert_eq!(ignored, [&[][..], &[0], &[0]]);
    let by_number = [rope("a", "2"), rope("b", "0"), rope("c", "")].concat();
    assert_eq!(load(&by_number).scene.shells, rows);
}

#[test]
fn what_stands_between_two_bodies_is_said_by_either() {
    let rope = |name: &str, touch: &str| {
        format!("[[bodies]]\nkind = 'rope'\nname = '{name}'\nsize = [3]\n{touch}\n")
    };
    let with = |other: &str| {
        format!("with = [{{ body = '{other}', friction = 0.125, restitution = 0.5 }}]")
    };
    let between = Between { shell: 0, friction: Some(0.125), restitution: Some(0.5) };
    let [plain, of_a, of_b] =
        ["".into(), with("a"), with("b")].map(|with| format!("touch = {{ {with} }}"));
    for text in [[rope("a", &of_b), rope("b", &plain)], [rope("a", &plain), rope("b", &of_a)]] {
        let rows = load(&text.concat()).scene.shells;
        assert_eq!((&rows[0].between[..], &rows[1].between[..]), (&[][..], &[between][..]));
    }
    let refused = |bodies: [String; 2], words: &str| {
        let text = format!("version = 1\n{}", bodies.concat());
        let error = parse(&text, SceneFormat::Toml, "s.toml").expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    let again = "bodies[1].touch.with[0].body is \"a\" again; give each pair of bodies one entry";
    refused([rope("a", &of_b), rope("b", &of_a)], again);
    let ignores = "touch = { ignore = ['b'] }";
    let words = "bodies[1].touch.with[0].body is \"a\", and one of the two ignores the other";
    refused([rope("a", ignores), rope("b", &of_a)], words);
    // An entry without an effect is noted.
    let notes = load(&[rope("a", ""), rope("b", &of_a)].concat()).notes;
    assert_eq!(notes, ["bodies[1].touch.with[0] has no effect: \"a\" has no table `touch`"]);
}

#[test]
fn what_stands_between_a_body_and_those_of_a_material_is_said_once() {
    let block = |name: &str, material: &str, touch: &str| {
        format!(
            "[[bodies]]\nkind = 'block'\nname = '{name}'\nsize = [3, 3, 3]\nspacing = 0.01\n\
             material = '{material}'\ntouch = {{ {touch} }}\n"
        )
    };
    let on_jelly = "with = [{ body = 'c', friction = 0.25 }, \
                    { material = 'gelatine-7%', friction = 0.125, restitution = 0.5 }]";
    let text = [
        block("a", "gelatine-7%", ""),
        block("plate", "natural-rubber", on_jelly),
        block("b", "gelatine-7%", "ignore = ['plate']"),
        block("c", "gelatine-7%", ""),
        block("d", "gelatine-7%", ""),
    ];
    let loaded = load(&text.concat());
    let of_entries = |notes: Vec<String>| {
        notes.into_iter().filter(|note| note.contains("with[")).collect::<Vec<_>>()
    };
    assert_eq!(of_entries(loaded.notes), Vec::<String>::new());
    let jelly = |shell, friction| Between { shell, friction: Some(friction), restitution: None };
    let of_jelly = |shell| Between { restitution: Some(0.5), ..jelly(shell, 0.125) };
    let between: Vec<_> = loaded.scene.shells.iter().map(|shell| &shell.between[..]).collect();
    let of_plate = [of_jelly(0)];
    assert_eq!(between, [&[][..], &of_plate, &[], &[jelly(1, 0.25)], &[of_jelly(1)]]);
    let of = |with: &str| {
        let text = block("a", "gelatine-7%", &format!("with = [{with}]"));
        parse(&format!("version = 1\n{text}"), SceneFormat::Toml, "s.toml")
    };
    for (with, words) in [
        ("{ material = 'gelatin-7%' }", "with[0].material is \"gelatin-7%\"; it must be the name"),
        ("{ friction = 1 }", "bodies[0].touch.with[0] lacks the key `body` or `material`"),
        ("{ body = 0, material = 'gelatine-7%' }", "with[0] has both `body` and `material`"),
    ] {
        let error = of(with).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    }
    let notes = of("{ material = 'steel' }").expect("a scene").notes;
    let lacks = "no other body of \"steel\" has a table `touch`";
    let note = format!("bodies[0].touch.with[0] has no effect: {lacks}");
    assert_eq!(of_entries(notes), [note]);
}

/// Lines after those of a rope of three particles, and the message; ` ... ` stands for any text.
const REFUSED: [(&str, &str); 15] = [
    ("touch = { radius = 0 }", "bodies[0].touch.radius is 0; it must be positive and at most 1e12"),
    (
        "touch = { thickness = 0.5 }",
        "bodies[0].touch.thickness is 0.5; it must be at most 0.4 of the spacing, 0.4 m",
    ),
    ("touch = { restitution = 2 }", "bodies[0].touch.restitution is 2; it must be from 0 to 1"),
    ("touch = { friction = -1 }", "bodies[0].touch.friction is -1; it must be finite and not"),
    ("touch = { ignore = ['rop'] }", "touch.ignore[0] names no body: \"rop\"; `rope` is one"),
    (
        "touch = { radius = 0.1, thickness = 0.1 }",
        "touch.radius is the older name of `thickness`, which is given too; remove `radius`",
    ),
    ("touch = { ignore = ['rope'] }", "touch.ignore[0] is the body itself; ... itself = false"),
    ("touch = { raduis = 1 }", "raduis"),
    ("touch = [0.1]", "s.toml:5:9: bodies[0].touch is a list; it must be a table"),
    (
        "touch = {}\n[[bodies]]\nkind = 'explicit'\nparticles = [{ position = [0, 0, 0] }]\n\
         touch = {}",
        "bodies[1].touch lacks the key `thickness`: without springs it has no default",
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
    ("touch = { with = [{ body = 'rope' }] }", "touch.with[0].body is the body itself; set its"),
    ("touch = { with = [{ body = 'rope', friction = -1 }] }", "with[0].friction is -1; it must be"),
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
    let both = ["touch = { thickness = 0.04 }"; 2];
    // Of 64 particles 27 are inside, of which 8 are inside of b too. Each is √3 x 0.05 m from the
    // nearest corners of the squares around it, and both thicknesses more are 0.08 m.
    let told = "b starts inside a with 19 of its 56 contact particles, up to about 0.17 m deep, \
                and is pushed out slowly";
    assert_eq!(cubes([0.05; 3], both, ""), [told]);
    // One in another that is larger: the other way round.
    let small = "[[bodies]]\nname = 'c'\nkind = 'block'\nsize = [2, 2, 2]\nspacing = 0.01\n\
                 touch = {}\n";
    let small = cubes([9.0; 3], both, small);
    assert!(small.len() == 1 && small[0].starts_with("c starts inside a with 8 of its 8 contact"));
    assert!(small[0].ends_with("stays inside: move one of the two bodies"), "{}", small[0]);
    // Beside it, where they overlap by less than half of 0.08 m and by more.
    let beside = |gap: f64| cubes([0.3 + gap, 0.0, 0.0], both, "");
    assert!(beside(0.041).is_empty());
    let told = "b overlaps a with 16 of its 56 contact particles, up to about 0.041 m deep, and is \
                pushed away where the two do not cross";
    assert_eq!(beside(0.039), [told]);
}

#[test]
fn balls_that_overlap_are_pushed_away_unless_they_are_at_one_point() {
    let ball = |name: &str, x: f64| {
        format!(
            "[[bodies]]\nname = '{name}'\nkind = 'explicit'\n\
             particles = [{{ position = [{x}, 0, 0] }}]\ntouch = {{ thickness = 0.1 }}\n"
        )
    };
    let notes = |apart: f64| load(&[ball("a", 0.0), ball("b", apart)].concat()).notes;
    let told = "b overlaps a with 1 of its 1 contact particles, up to about 0.15 m deep, and is \
                pushed away, to nine tenths of the distance that the two keep";
    assert_eq!(notes(0.05), [told]);
    let told = "b overlaps a with 1 of its 1 contact particles, up to about 0.2 m deep, and stays \
                where two particles are at one point: move one of the two bodies";
    assert_eq!(notes(0.0), [told]);
    assert!(notes(0.15).is_empty());
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
    assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
}

#[test]
fn bodies_meet_by_a_tenth_of_their_spacing() {
    let loaded = load(
        "[[bodies]]\nkind = 'cloth'\nsize = [3, 3]\nspacing = 0.1\ntouch = { friction = 0.25 }\n\
         [[bodies]]\nkind = 'block'\nsize = [3, 4, 5]\nposition = [0, 9, 0]\n\
         touch = { restitution = 0.5, obstacles = true }\n",
    );
    let [cloth, block] = &loaded.scene.shells[..] else { panic!("two shells") };
    assert!((cloth.thickness - 0.01).abs() < 1e-15 && (block.thickness - 0.1).abs() < 1e-15);
    assert_eq!((cloth.friction, block.friction), (0.25, 0.5));
    assert_eq!((cloth.restitution, block.restitution), (0.0, 0.5));
    assert_eq!((cloth.itself, block.itself), (true, false));
    assert_eq!((cloth.obstacles, block.obstacles), (false, true));
    // A surface is closed: every edge has two triangles, one each way.
    assert_eq!(block.triangles.len(), 4 * (2 * 3 + 3 * 4 + 4 * 2));
    let mut edges: Vec<[usize; 2]> =
        block.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    let both = edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok());
    assert!(both && edges.windows(2).all(|pair| pair[0] != pair[1]));
}

#[test]
fn particles_without_springs_meet_as_points() {
    let loaded = load(
        "[[bodies]]\nkind = 'explicit'\nparticles = [{ position = [0, 0, 0] }, \
         { position = [1, 0, 0] }, { position = [2, 0, 0] }]\nsprings = [{ ends = [0, 1] }]\n\
         touch = { thickness = 0.1 }\n",
    );
    let [shell] = &loaded.scene.shells[..] else { panic!("one shell") };
    assert_eq!((&shell.edges[..], &shell.points[..]), (&[[0, 1]][..], &[2][..]));
}

#[test]
fn keys_of_older_files_are_read_and_noted() {
    let cloth = |touch: &str| {
        load(&format!(
            "[[bodies]]\nname = 'a'\nkind = 'cloth'\nsize = [3, 3]\nspacing = 0.1\n\
             touch = {touch}\n"
        ))
    };
    let loaded = cloth("{ radius = 0.03, stiffness = 9, damping = 1, triangles = true }");
    assert_eq!(loaded.scene.shells[0].thickness, 0.03);
    let words = [
        "a: `touch.radius` is an older key, read as `thickness = 0.03`",
        "a: `touch.stiffness`, `touch.damping` and `touch.triangles` have no effect: surfaces meet \
         by their triangles, without a stiffness",
    ];
    assert_eq!(loaded.notes, words);
    // No thicker than a thickness may be.
    assert_eq!(cloth("{ radius = 0.09 }").scene.shells[0].thickness, 0.4 * 0.1);
    let one = &cloth("{ damping = 1 }").notes[..];
    assert!(one.len() == 1 && one[0].starts_with("a: `touch.damping` has no effect"), "{one:?}");
    let rope = |name: &str, touch: &str| {
        format!("[[bodies]]\nkind = 'rope'\nname = '{name}'\nsize = [3]\ntouch = {touch}\n")
    };
    let with = "{ with = [{ body = 'a', stiffness = 9, friction = 0.1 }] }";
    let loaded = load(&[rope("a", "{}"), rope("b", with)].concat());
    assert_eq!(loaded.scene.shells[1].between[0].friction, Some(0.1));
    assert!(loaded.notes[0].contains("`stiffness` and `damping` have no effect"));
}
