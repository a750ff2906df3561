//! Solids too thin for the bodies of a scene are told of.

use msd_scene::{Loaded, SceneFormat, parse};

fn load(radius: f64, keys: &str, touch: &str) -> Loaded {
    let text = format!(
        "version = 1\n[[world.solids]]\nkind = 'capsule'\nlength = 2\nradius = {radius}\n{keys}\n\
         [[bodies]]\nkind = 'cloth'\nname = 'sheet'\nsize = [5, 5]\nspacing = 0.25\n{touch}\n"
    );
    parse(&text, SceneFormat::Toml, "thin.toml").expect("a scene")
}

#[test]
fn a_solid_between_particles_is_told_and_meets_springs_where_it_is_wished() {
    let told = |radius, keys, touch| load(radius, keys, touch).notes.join("\n");
    assert_eq!(
        told(0.1, "", ""),
        "world.solids[0] is 0.200 m thick, the particles of sheet are 0.250 m apart and pass \
         beside it; with `springs = true` it meets the springs between them too"
    );
    // As thick as particles are apart, or together with their radii.
    assert_eq!(told(0.125, "", ""), "");
    assert_eq!(told(0.1, "", "touch = { obstacles = true, radius = 0.1 }"), "");
    assert!(told(0.1, "", "touch = { radius = 0.1 }").contains("pass beside it"));
    let loaded = load(0.1, "springs = true", "");
    assert!(loaded.scene.solids[0].springs && loaded.notes.is_empty());
    assert!(!load(0.1, "", "").scene.solids[0].springs);
    // The hole between a side of a square and its diagonals is 0.104 m across.
    assert_eq!(told(0.0525, "springs = true", ""), "");
    assert_eq!(
        told(0.05, "springs = true", ""),
        "world.solids[0] is 0.100 m thick: its ends fit through the squares of sheet, 0.250 m \
         wide, between the springs"
    );
}
