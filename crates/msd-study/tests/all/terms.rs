//! The terms of a scene: their list, and the effect of each.

use msd_core::glam::DVec3;
use msd_core::{Friction, Integrator, Material, Plane, Scene, Settings, World, shape};
use msd_scene::{Loaded, Precision};
use msd_study::terms::{TermRow, terms};

fn loaded(scene: Scene, precision: Precision) -> Loaded {
    Loaded { precision, ..Loaded::new("test", scene, Settings::default()) }
}

fn names(rows: &[TermRow]) -> Vec<&str> {
    rows.iter().map(|row| row.term.as_str()).collect()
}

fn row<'a>(rows: &'a [TermRow], term: &str) -> &'a TermRow {
    rows.iter().find(|row| row.term == term).unwrap_or_else(|| panic!("{term}: {rows:?}"))
}

#[test]
fn a_block_has_damping_gravity_diagonals_drag_contact_and_a_precision() {
    let material = Material { mass: 1.0, stiffness: 500.0, damping: 1.0 };
    let mut scene = Scene::of("block", shape::block([3, 3, 3], 1.0, material).unwrap());
    let friction = Friction::Coulomb(0.3);
    scene.planes = vec![Plane { normal: DVec3::Y, offset: -1.2, restitution: 0.0, friction }];
    scene.world.drag = 0.1;
    let rows = terms(&loaded(scene, Precision::F32), 0.5, &mut ()).unwrap();
    let expected = ["damping", "gravity", "face diagonals", "space diagonals", "drag", "contact"];
    assert_eq!(names(&rows)[..6], expected);
    assert_eq!(names(&rows)[6..], ["single precision"]);
    // Without gravity the block, at rest, stays where it is; with it its lower side falls by 0.2 m.
    assert!((0.1..0.5).contains(&row(&rows, "gravity").change.unwrap()));
    // Without the ground the block falls on: by g t² / 2 = 1.2 m less the 0.2 m it fell anyway.
    let contact = row(&rows, "contact");
    assert!(0.5 < contact.change.unwrap() && contact.words.contains("changes"), "{contact:?}");
    // Rounding: 24 bits of some metres, over 240 substeps, does not show at a millimetre.
    assert!(row(&rows, "single precision").change.unwrap() < 1e-3);
    for row in &rows {
        assert!(row.change.unwrap() <= row.worst.unwrap());
    }
}

#[test]
fn drag_is_worth_what_the_closed_form_says() {
    // Free fall of a rope at rest length: only drag makes the runs differ.
    let material = Material { mass: 0.5, stiffness: 100.0, damping: 0.0 };
    let mut scene = Scene::of("rope", shape::rope(4, 1.0, material).unwrap());
    scene.world.drag = 0.2;
    let rows = terms(&loaded(scene, Precision::F64), 1.0, &mut ()).unwrap();
    assert_eq!(names(&rows), ["gravity", "drag", "double precision"]);
    // y = g t² / 2 against g/r² (r t − 1 + e^(−r t)) with r = drag / mass.
    let (g, r) = (9.82, 0.4f64);
    let exact = 0.5 * g - g / (r * r) * (r - 1.0 + (-r).exp());
    let drag = row(&rows, "drag");
    // Verlet is of second order: (r h)² with h = 1/480 is 1e-6.
    assert!((drag.change.unwrap() / exact - 1.0).abs() < 1e-4, "{drag:?} {exact}");
    // The size of a rope of four is three.
    assert!((drag.relative.unwrap() - drag.change.unwrap() / 3.0).abs() < 1e-12);
}

#[test]
fn springs_that_differ_are_compared_with_their_mean() {
    let material = Material { mass: 1.0, stiffness: 400.0, damping: 0.0 };
    let mut scene = Scene::of("rope", shape::rope(5, 1.0, material).unwrap());
    scene.pins = vec![msd_core::Pin { particle: 0, velocity: DVec3::ZERO }];
    scene.springs[1].stiffness = 200.0;
    let rows = terms(&loaded(scene, Precision::F64), 0.5, &mut ()).unwrap();
    assert_eq!(names(&rows), ["gravity", "values of each spring", "double precision"]);
    assert!(0.0 < rows[1].change.unwrap());
}

#[test]
fn the_teapot_bends_and_a_cloth_has_no_bending_springs() {
    let teapot = msd_scene::open("teapot").unwrap();
    let rows = terms(&teapot, 1.0 / 60.0, &mut ()).unwrap();
    let expected = ["damping", "gravity", "bending springs", "contact", "single precision"];
    assert_eq!(names(&rows), expected);
    let bending = row(&rows, "bending springs");
    assert!(0.0 < bending.change.unwrap(), "{bending:?}");
    let rows = terms(&msd_scene::open("cloth").unwrap(), 1.0 / 60.0, &mut ()).unwrap();
    let expected = ["damping", "gravity", "face diagonals", "contact", "single precision"];
    assert_eq!(names(&rows), expected);
    // Its floor is out of reach.
    assert_eq!(row(&rows, "contact").change, Some(0.0));
}

#[test]
fn a_variant_that_diverges_is_told_in_words() {
    // Explicit Euler bears h = b/k and no step at all without dampers.
    let material = Material { mass: 1.0, stiffness: 1e4, damping: 30.0 };
    let scene = Scene::of("cloth", shape::cloth([6, 6], 1.0, material).unwrap());
    let scene = Scene { world: World { extent: 1e3, ..World::default() }, ..scene };
    let mut loaded = loaded(scene, Precision::F32);
    loaded.settings = Settings { integrator: Integrator::ExplicitEuler, ..loaded.settings };
    loaded.scene.particles[7].position.x += 0.1;
    let rows = terms(&loaded, 2.0, &mut ()).unwrap();
    let damping = row(&rows, "damping");
    assert_eq!(damping.change, None, "{damping:?}");
    assert!(damping.words.contains("diverged"), "{damping:?}");
}
