//! Links to solids: springs that end at points of a surface, which move with it.

use msd_core::glam::DVec3;
use msd_core::{Scene, Settings, Simulation};
use msd_scene::{Draft, Loaded, SceneFormat, parse};
use std::path::Path;

fn read(text: &str) -> Result<Loaded, String> {
    parse(text, SceneFormat::Toml, "s.toml").map_err(|error| error.to_string())
}

fn scene(text: &str) -> Scene {
    read(text).expect(text).scene
}

/// A rope beside a drum that moves and turns.
const DRUM: &str = "version = 1\n[world]\n\
    gravity = [0, 0, 0]\n\
    [[world.solids]]\n\
    kind = 'sphere'\nname = 'drum'\nradius = 0.5\nposition = [0, 0, 0]\n\
    velocity = [1, 0, 0]\nspin = [0, 0, 2]\n\
    [[bodies]]\nkind = 'rope'\nsize = [3]\nspacing = 0.5\nposition = [1.5, 0, 0]\n";

#[test]
fn a_link_to_a_solid_ends_at_the_nearest_point_of_its_surface_which_moves_with_it() {
    let text = format!(
        "{DRUM}[[links]]\nfrom = {{ set = 'first' }}\nto = {{ solid = 'drum' }}\nstiffness = 40\n"
    );
    let scene = scene(&text);
    // The rope is from x = 1 to 2, and the surface ends at 0.5.
    assert_eq!(scene.particles.len(), 4);
    let (anchor, link) = (&scene.particles[3], scene.springs[scene.springs.len() - 1]);
    assert!((anchor.position - DVec3::new(0.5, 0.0, 0.0)).length() < 1e-15);
    assert_eq!((link.ends, link.stiffness), ([0, 3], 40.0));
    // Its weight does not show: the lifting solid supplies no energy for it.
    assert!(anchor.mass < 1e-5 * scene.particles[0].mass);
    assert!((link.rest_length - 0.5).abs() < 1e-15);
    let settings = Settings { substeps: 4, ..Settings::default() };
    let mut simulation = Simulation::<f64>::new(&scene, settings).expect("a scene");
    for _ in 0..60 {
        simulation.step().expect("a step");
    }
    // A second later the middle is at (1, 0, 0), and the point has turned by 2 radians about z.
    let expected = DVec3::new(1.0 + 0.5 * 2f64.cos(), 0.5 * 2f64.sin(), 0.0);
    assert!((simulation.position(3) - expected).length() < 1e-12);
}

#[test]
fn a_link_to_a_solid_at_rest_is_a_spring_to_a_fixed_point() {
    // One particle of 2 kg hangs by 200 N/m from a box that rests: it swings about 0.0982 m lower
    // with a period of 2 pi sqrt(2 / 200) s.
    let text = "version = 1\n[world]\ngravity = [0, -9.82, 0]\n\
        [[world.solids]]\nkind = 'box'\nsize = [1, 1, 1]\nposition = [0, 2, 0]\n\
        [[bodies]]\nkind = 'explicit'\nmass = 2\nparticles = [{ position = [0, 1, 0] }]\n\
        [[links]]\nfrom = { particle = 0 }\nto = { solid = 0 }\nstiffness = 200\n";
    let scene = scene(text);
    let settings = Settings { substeps: 40, ..Settings::default() };
    let mut simulation = Simulation::<f64>::new(&scene, settings).expect("a scene");
    for step in 1..=60 {
        simulation.step().expect("a step");
        let time = f64::from(step) / 60.0;
        let deep = 2.0 * 9.82 / 200.0;
        let exact = 1.0 - deep * (1.0 - (10.0 * time).cos());
        // Velocity Verlet: the phase is off by (w h)^2 / 24 of w t.
        let phase = (10.0 / 2400.0f64).powi(2) / 24.0 * 10.0 * time;
        let y = simulation.position(0).y;
        assert!((y - exact).abs() <= 1.1 * deep * phase + 1e-12, "{time}: {y} {exact}");
    }
}

#[test]
fn links_to_solids_are_refused_in_plain_words() {
    let link = |from: &str, to: &str, more: &str| {
        let text = format!("{DRUM}[[links]]\nfrom = {from}\nto = {to}\n{more}");
        read(&text).expect_err(&text)
    };
    let first = "{ particle = 0 }";
    for (from, to, more, expected) in [
        (
            "{ solid = 'drum' }",
            first,
            "",
            "links[0].from.solid is of `to` alone: each particle of `from` is joined to a point \
             of it",
        ),
        (
            first,
            "{ solid = 'drun' }",
            "",
            "links[0].to.solid is \"drun\"; it must be the number or the name of a solid: did you \
             mean `drum`?",
        ),
        (
            first,
            "{ solid = 'drum', set = 'all' }",
            "",
            "links[0].to.solid and set exclude each other",
        ),
        (
            first,
            "{ solid = 0 }",
            "within = 0.25\n",
            "links[0].within is 0.25; it must be at least 0.5, the distance of the nearest two",
        ),
    ] {
        let refusal = link(from, to, more);
        assert!(refusal.contains(expected), "{refusal}");
    }
}

#[test]
fn a_finer_scene_is_linked_to_the_same_points_of_a_solid() {
    let text = format!(
        "{DRUM}[[links]]\nfrom = {{ set = 'first' }}\nto = {{ solid = 'drum' }}\nstiffness = 40\n"
    );
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("scene.toml"), text).expect("written");
    let draft = Draft::open(Path::new("scene.toml"), folder.path()).expect("a scene");
    let source = draft.source().expect("a scene");
    let coarse = draft.load(&source).expect("a scene").scene;
    let fine = draft.finer(&source, &coarse, 1).expect("a finer scene").loaded.scene;
    let last = |scene: &Scene| *scene.springs.last().expect("a link");
    let anchor = |scene: &Scene| scene.particles[last(scene).ends[1]].position;
    assert_eq!((fine.particles.len(), last(&fine).ends), (6, [0, 5]));
    assert_eq!(last(&fine).rest_length, last(&coarse).rest_length);
    assert_eq!(anchor(&fine), anchor(&coarse));
}
