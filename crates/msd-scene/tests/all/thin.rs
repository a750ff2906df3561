//! Notes on obstacles and bodies: solids too thin to be met, and bodies that start inside.

use msd_core::Simulation;
use msd_scene::{BUILTINS, Loaded, SceneFormat, open, parse};

/// A rod and, a metre beside it, a sheet.
fn load(radius: f64, keys: &str, touch: &str) -> Loaded {
    let text = format!(
        "version = 1\n[[world.solids]]\nkind = 'capsule'\nlength = 2\nradius = {radius}\n{keys}\n\
         [[bodies]]\nkind = 'cloth'\nname = 'sheet'\nsize = [5, 5]\nspacing = 0.25\n\
         position = [0, 0, 1]\n{touch}\n"
    );
    parse(&text, SceneFormat::Toml, "thin.toml").expect("a scene")
}

#[test]
fn a_solid_between_particles_is_told_and_meets_springs_where_it_is_wished() {
    let told = |radius, keys, touch| load(radius, keys, touch).notes.join("\n");
    assert_eq!(
        told(0.1, "", ""),
        "world.solids[0] is 0.2 m thick, the particles of sheet are 0.25 m apart and pass \
         beside it; with `springs = true` it meets the springs between them too"
    );
    assert!(told(0.0002, "", "").starts_with("world.solids[0] is 0.0004 m thick"));
    let plate = "[[world.solids]]\nkind = 'box'\nsize = [4, 0.1, 4]\nposition = [0, -9, 0]";
    assert!(around("", plate).notes[0].contains("and pass beside its edges; with"));
    // As thick as particles are apart, or together with their radii.
    assert_eq!(told(0.125, "", ""), "");
    assert_eq!(told(0.1, "", "touch = { obstacles = true, thickness = 0.1 }"), "");
    assert!(told(0.1, "", "touch = { thickness = 0.1 }").contains("pass beside it"));
    let loaded = load(0.1, "springs = true", "");
    assert!(loaded.scene.solids[0].springs && loaded.notes.is_empty());
    assert!(!load(0.1, "", "").scene.solids[0].springs);
    // The hole between a side of a square and its diagonals is 0.104 m across.
    assert_eq!(told(0.0525, "springs = true", ""), "");
    assert_eq!(
        told(0.05, "springs = true", ""),
        "world.solids[0] is 0.1 m thick: its ends fit through the squares of sheet, 0.25 m \
         wide, between the springs"
    );
}

/// A sheet of 5 x 5 particles, 0.25 m apart, 3 m above the origin, and obstacles.
fn around(touch: &str, obstacles: &str) -> Loaded {
    let text = format!(
        "version = 1\n[[bodies]]\nkind = 'cloth'\nname = 'sheet'\nsize = [5, 5]\n\
         spacing = 0.25\nposition = [0, 3, 0]\n{touch}\n{obstacles}\n"
    );
    parse(&text, SceneFormat::Toml, "inside.toml").expect("a scene")
}

#[test]
fn a_body_that_starts_inside_an_obstacle_is_told_and_is_moved_to_its_surface() {
    let ball = "[[world.solids]]\nkind = 'sphere'\nradius = 0.32\nposition = [0, 3, 0]";
    let told = |touch: &str, more: &str| around(touch, &format!("{ball}\n{more}")).notes.join("\n");
    // The middle and the four next to it, then the four at 0.35 m too, whose thickness counts.
    let inside = |count: u32, depth: f64| {
        format!(
            "sheet starts inside world.solids[0] with {count} of its 25 particles, up to {depth} m \
             deep: a run begins with them at the surface"
        )
    };
    assert_eq!(told("", ""), inside(5, 0.32));
    let touch = |keys: &str| format!("touch = {{ thickness = 0.1{keys} }}");
    assert_eq!(told(&touch(", obstacles = true"), ""), inside(9, 0.42));
    assert_eq!(told(&touch(""), ""), inside(5, 0.32));
    // A pinned particle is not moved.
    assert_eq!(told("", "[[pins]]\nparticle = 12"), inside(4, 0.07));
    let loaded = around("", ball);
    let run = Simulation::<f64>::new(&loaded.scene, loaded.settings).expect("a valid scene");
    let middle = loaded.scene.solids[0].position;
    let gaps = run.positions().map(|place| place.distance(middle) - 0.32);
    assert!(gaps.fold(f64::INFINITY, f64::min).abs() < 1e-12);
    let plane = |offset: f64| {
        around("", &format!("[[world.planes]]\nnormal = [0, 2, 0]\noffset = {offset}")).notes
    };
    // The lowest row is at 2.5 m, and a fifth of the spacing is 0.05 m.
    assert!(plane(2.5).is_empty() && plane(2.54).is_empty());
    let told = &plane(2.56)[..];
    let expected = "inside world.planes[0] with 5 of its 25 particles, up to 0.06 m deep";
    assert!(told.len() == 1 && told[0].contains(expected), "{told:?}");
}

/// The scene around a bare mesh puts it above the ground, wherever its file has it.
#[test]
fn a_bare_mesh_starts_above_the_ground_and_no_note_says_otherwise() {
    let tetrahedron =
        "v 0 -9 0\nv 1 -9 0\nv 0 -8 0\nv 0 -9 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let path = std::env::temp_dir().join(format!("msd-bare-{}.obj", std::process::id()));
    std::fs::write(&path, tetrahedron).expect("a file");
    let loaded = open(&path).expect("a mesh");
    std::fs::remove_file(&path).expect("the file");
    let heights = loaded.scene.particles.iter().map(|particle| particle.position.y);
    assert!((heights.fold(f64::MAX, f64::min) - 0.3).abs() < 1e-12);
    assert!(!loaded.notes.concat().contains("starts inside"), "{:?}", loaded.notes);
}

#[test]
fn no_body_of_a_scene_of_msd_starts_inside_an_obstacle_or_another() {
    let notes_of = |name: &str| open(name).expect("a built-in scene").notes;
    let notes: Vec<String> = BUILTINS.iter().flat_map(|builtin| notes_of(builtin.name)).collect();
    assert!(!notes.concat().contains("starts inside"), "{notes:#?}");
}
