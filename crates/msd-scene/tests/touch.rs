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
         touch = {}\n",
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
        "[[bodies]]\nkind = 'block'\nsize = [5, 5, 5]\ntouch = { itself = false }\n\
         [[bodies]]\nkind = 'rope'\nsize = [7]\nposition = [0, 9, 0]\ntouch = {}\n\
         [[bodies]]\nkind = 'rope'\nsize = [7]\nposition = [0, 19, 0]\n",
    );
    let counts: Vec<usize> = loaded.scene.touches.iter().map(|row| row.particles.len()).collect();
    assert_eq!(counts, [5 * 5 * 5 - 3 * 3 * 3, 7]);
}

#[test]
fn bodies_are_ignored_by_name_in_either_order() {
    let rope = |name: &str, ignore: &str| {
        format!(
            "[[bodies]]\nkind = 'rope'\nname = '{name}'\nsize = [3]\n\
             touch = {{ ignore = [{ignore}] }}\n"
        )
    };
    let text = [rope("a", "'c'"), rope("b", "'a'"), rope("c", "")].concat();
    let rows = load(&text).scene.touches;
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
    let again = "bodies[1].touch.with[0].body is a again: how the two touch is said once";
    refused([rope("a", &of_b), rope("b", &of_a)], again);
    let ignores = "touch = { ignore = ['b'] }";
    let words = "bodies[1].touch.with[0].body is a, and one of the two ignores the other";
    refused([rope("a", ignores), rope("b", &of_a)], words);
    // One that touches nothing is told.
    let notes = load(&[rope("a", ""), rope("b", &of_a)].concat()).notes;
    assert_eq!(notes, ["bodies[1].touch.with[0] has no effect: a has no table `touch`"]);
}

#[test]
fn a_sheet_that_leaks_is_told_and_one_radius_is_offered() {
    let notes = |radius: &str| {
        let text = format!(
            "[[bodies]]\nkind = 'cloth'\nsize = [5, 5]\nspacing = 0.1\ntouch = {{ {radius} }}\n"
        );
        load(&text).notes
    };
    assert!(notes("").is_empty() && notes("radius = 0.04").is_empty());
    let told = &notes("radius = 0.03")[0];
    assert!(told.contains("leak") && told.contains("0.045 m"), "{told}");
    assert!(told.contains("`triangles = true` closes them"), "{told}");
    assert!(notes("radius = 0.03, triangles = true").is_empty());
}

#[test]
fn triangles_are_those_of_the_surface() {
    let rows = |kind: &str, triangles: &str| {
        let text = format!("[[bodies]]\nkind = {kind}\nspacing = 0.2\ntouch = {{ {triangles} }}\n");
        load(&text).scene.touches
    };
    assert!(rows("'cloth'\nsize = [4, 5]", "")[0].triangles.is_empty());
    assert!(rows("'cloth'\nsize = [4, 5]", "triangles = false")[0].triangles.is_empty());
    assert_eq!(rows("'cloth'\nsize = [4, 5]", "triangles = true")[0].triangles.len(), 2 * 3 * 4);
    let [block] = &rows("'block'\nsize = [3, 4, 5]", "triangles = true")[..] else {
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
