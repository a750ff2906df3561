//! Half spaces of scene files.

use msd_core::obstacles::Placed;
use msd_core::{Shape, Simulation};
use msd_scene::schema::SceneFile;
use msd_scene::{Loaded, SceneFormat, parse, read, write};

/// A sheet 3 m above the origin, and a half space with these keys.
fn load(keys: &str) -> Result<Loaded, String> {
    let text = text(keys);
    parse(&text, SceneFormat::Toml, "half.toml").map_err(|error| error.to_string())
}

fn text(keys: &str) -> String {
    format!(
        "version = 1\n[[world.solids]]\nkind = 'half_space'\n{keys}\n[[bodies]]\nkind = 'cloth'\n\
         name = 'sheet'\nsize = [5, 5]\nspacing = 0.25\nposition = [0, 3, 0]\n"
    )
}

#[test]
fn a_half_space_is_placed_turned_and_set_in_motion() {
    let loaded = load(
        "position = [0, 1, 0]\nrotation = { axis = [0, 0, 1], angle_deg = -90 }\n\
         velocity = [2, 0, 0]\nspin = [0, 0, 0.5]\nrestitution = 0.3\nfriction = 0.1",
    )
    .expect("a scene");
    let solid = &loaded.scene.solids[0];
    assert_eq!((&solid.shape, solid.restitution), (&Shape::HalfSpace, 0.3));
    // Its previous up is +x, and after π seconds up again.
    assert!((solid.axes.y_axis.x - 1.0).abs() < 1e-15);
    let placed = Placed::new(solid, std::f64::consts::PI);
    assert!((placed.axes.y_axis.y - 1.0).abs() < 1e-15);
    assert_eq!(placed.middle.to_array(), [2.0 * std::f64::consts::PI, 1.0, 0.0]);
    let keys = load("key_frames = [{ time = 1, position = [0, 0.5, 0] }]").expect("a scene");
    assert_eq!(keys.scene.solids[0].keys[0].position.y, 0.5);
}

#[test]
fn a_half_space_is_the_same_after_writing_it_and_reading_it_again() {
    let rows: SceneFile = read(&text(""), SceneFormat::Toml, "half.toml").expect("rows");
    for format in [SceneFormat::Toml, SceneFormat::Json] {
        let text = write(&rows, format).expect("text");
        assert_eq!(read(&text, format, "half").expect(&text), rows);
    }
}

#[test]
fn the_example_of_the_documentation_runs() {
    let docs = include_str!("../../../../docs/reference/scenes.md");
    let mut blocks = docs.split("```toml\n").filter_map(|rest| rest.split("```").next());
    let example = blocks.find(|block| block.contains("half_space")).expect("an example");
    let body = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [2]\nspacing = 0.1\nmass = 1\n";
    let loaded = parse(&format!("{body}{example}"), SceneFormat::Toml, "docs").expect("a scene");
    let mut run = Simulation::<f64>::new(&loaded.scene, loaded.settings).expect("a scene");
    (0..540).for_each(|_| run.step().expect("a calm run"));
    let off = run.positions().map(|place| (place.y - 0.5).abs()).fold(0.0, f64::max);
    assert!(off < 1e-9, "{off}");
    // The wall starts 1.95 m to the left of the rope.
    (0..60).for_each(|_| run.step().expect("a calm run"));
    assert!(run.positions().all(|place| -1e-9 < place.x));
}

/// It is thick enough for any sheet, so that no note speaks of its thickness, and no spring has
/// points for it.
#[test]
fn nothing_passes_a_half_space() {
    for keys in ["", "springs = true"] {
        let loaded = load(keys).expect("a scene");
        assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
        let mut run = Simulation::<f64>::new(&loaded.scene, loaded.settings).expect("a scene");
        (0..120).for_each(|_| run.step().expect("a calm run"));
        let low = run.positions().map(|place| place.y).fold(f64::INFINITY, f64::min);
        // The lowest row, 2.5 m up, is there after 0.7 s.
        assert!(low.abs() < 1e-12, "{low}");
    }
    let inside = load("position = [0, 2.56, 0]").expect("a scene").notes;
    let told = "inside world.solids[0] with 5 of its 25 particles, up to 0.06 m deep";
    assert!(inside.len() == 1 && inside[0].contains(told), "{inside:?}");
}

#[test]
fn keys_and_values_that_a_half_space_cannot_have_are_refused() {
    for (keys, told) in [
        ("radius = 1", "world.solids[0].radius does not apply to a half_space, only to sphere"),
        ("size = [1, 1, 1]", "world.solids[0].size does not apply to a half_space, only to box"),
        ("position = [0, inf, 0]", "world.solids[0].position[1] is inf; it must be finite"),
        ("velocity = [nan, 0, 0]", "world.solids[0].velocity[0] is NaN; it must be finite"),
        ("spin = [0, 0, inf]", "world.solids[0].spin[2] is inf; it must be finite"),
        ("restitution = 2", "world.solids[0].restitution is 2; it must be from 0 to 1"),
    ] {
        let message = load(keys).expect_err(keys);
        assert!(message.contains(told), "{keys}: {message}");
    }
    let misspelt = text("").replace("half_space", "halfspace");
    let message = parse(&misspelt, SceneFormat::Toml, "half.toml").unwrap_err().to_string();
    assert!(message.contains("did you mean `half_space`?"), "{message}");
}
