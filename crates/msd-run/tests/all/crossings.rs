//! Surfaces that pass through each other, and those that do not.

use msd_core::glam::{DMat3, DVec3};
use msd_core::{Material, Part, Scene, Settings, Shell, Simulation, shape};
use msd_run::crossings;
use msd_scene::default_shell;

fn cloth(size: [usize; 2], offset: DVec3, turned: bool) -> Part {
    let mut part = shape::cloth(size, 0.1, Material::default()).expect("a cloth");
    let turn = if turned { DMat3::from_rotation_x(1.1) } else { DMat3::IDENTITY };
    part.place(turn, offset);
    part
}

/// Crossings of bodies that meet as the scene says.
fn count_where(parts: [Part; 2], says: impl FnOnce(&mut Vec<Shell>)) -> u64 {
    let mut scene = Scene::default();
    for part in parts {
        let body = scene.add("cloth", part);
        scene.shells.push(default_shell(&scene, body).expect("a cloth has springs"));
    }
    says(&mut scene.shells);
    let run = Simulation::<f64>::new(&scene, Settings::default()).expect("a valid scene");
    crossings(&run)
}

fn count(parts: [Part; 2]) -> u64 {
    count_where(parts, |_| {})
}

#[test]
fn sheets_side_by_side_do_not_cross() {
    for away in [0.0, 1e-300, 1e-9, 0.3] {
        let offset = DVec3::Z * away;
        let pair = [DVec3::ZERO, offset].map(|offset| cloth([8, 8], offset, false));
        // In one plane they only touch.
        assert_eq!(count(pair), 0, "{away} m apart");
    }
}

/// A sheet of 7 x 7 squares through one of 3 x 3, across it along its middle row.
#[test]
fn a_sheet_through_another_crosses_it() {
    let across = cloth([4, 4], DVec3::new(0.013, 0.021, 0.007), true);
    let found = count([cloth([8, 8], DVec3::ZERO, false), across]);
    // The line on which they cross is 0.3 m long and passes 3 and 7 squares of the two sheets.
    // Between them it meets a new pair of triangles at each of about 3 + 3 + 2 edges.
    assert!((8..=16).contains(&found), "{found}");
}

#[test]
fn what_the_scene_lets_pass_is_not_counted() {
    let across = cloth([4, 4], DVec3::new(0.013, 0.021, 0.007), true);
    let pair = || [cloth([8, 8], DVec3::ZERO, false), across.clone()];
    assert!(0 < count_where(pair(), |rows| rows[0].itself = false));
    assert_eq!(count_where(pair(), |rows| rows[1].ignored.push(0)), 0, "one ignores the other");
    assert_eq!(count_where(pair(), |rows| rows.truncate(1)), 0, "one meets nothing");
    // Both sheets as one shell, which meets itself.
    let joined = |rows: &mut Vec<Shell>| {
        let second = rows.pop().expect("two shells");
        rows[0].triangles.extend(second.triangles);
    };
    assert!(0 < count_where(pair(), joined));
    let passes = |rows: &mut Vec<Shell>| {
        joined(rows);
        rows[0].itself = false;
    };
    assert_eq!(count_where(pair(), passes), 0, "what passes through itself");
}

#[test]
fn a_needle_through_a_triangle_counts_once_however_thin() {
    let needle = |shift: f64| {
        let mut part = cloth([2, 2], DVec3::ZERO, false);
        let corners = [[0.01, 0.012, -1.0], [0.01, 0.012, 1.0]].map(DVec3::from_array);
        for (row, particle) in part.particles.iter_mut().enumerate() {
            particle.position = corners[row % 2] + DVec3::X * (1e-12 * row as f64 + shift);
        }
        part
    };
    assert!(0 < count([cloth([2, 2], DVec3::ZERO, false), needle(0.0)]));
    assert_eq!(count([cloth([2, 2], DVec3::ZERO, false), needle(0.3)]), 0);
}

/// A mesh of two parts that go through each other, as the spout of a teapot does, is at peace.
#[test]
fn parts_of_a_mesh_that_cross_at_rest_neither_count_nor_push() {
    let text = "version = 1\n[world]\ngravity = [0, 0, 0]\n[[bodies]]\nkind = 'mesh'\n\
                file = 'teapot.obj'\ntouch = { itself = true }\n";
    let loaded = msd_scene::parse(text, msd_scene::SceneFormat::Toml, "s").expect("a scene");
    assert!(!loaded.scene.shells[0].exempt.is_empty());
    let mut run = Simulation::<f64>::new(&loaded.scene, loaded.settings).expect("a valid scene");
    (0..60).for_each(|_| run.step().expect("a step"));
    assert_eq!(crossings(&run), 0);
    // Rounding of rest lengths: some 1e-16 of a metre at some 1e4 N/m.
    assert!(run.energy().elastic < 1e-20 && run.energy().kinetic < 1e-20, "{:?}", run.energy());
}
