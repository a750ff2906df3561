//! Pins that follow key frames or a solid, and pins that end.

use msd_core::glam::DVec3;
use msd_core::{Lead, Simulation};
use msd_scene::{Draft, Loaded, SceneFormat, parse};
use std::path::Path;

fn toml(text: &str) -> Result<Loaded, String> {
    parse(text, SceneFormat::Toml, "s.toml").map_err(|error| error.to_string())
}

/// A cloth of 3 x 3 particles about the origin, 0.1 m apart, a solid, and a pin.
fn scene(pin: &str) -> Result<Loaded, String> {
    toml(&format!(
        "version = 1\n[[bodies]]\nkind = 'cloth'\nsize = [3, 3]\nspacing = 0.1\n\
         [[world.solids]]\nname = 'arm'\nkind = 'sphere'\nradius = 0.1\n\
         position = [0, 2, 0]\nspin = [0, 0, 1]\n[[pins]]\n{pin}\n"
    ))
}

fn simulation(pin: &str) -> Simulation<f64> {
    let loaded = scene(pin).unwrap();
    Simulation::new(&loaded.scene, loaded.settings).unwrap()
}

#[test]
fn a_set_goes_through_the_key_frames_of_its_middle_and_turns_about_it() {
    let mut simulation = simulation(
        "set = 'top'\nkey_frames = [{ time = 0.5, position = [1, 0.1, 0], \
         rotation = { axis = [0, 0, 1], angle_deg = 90 } }]",
    );
    (0..30).for_each(|_| simulation.step().unwrap());
    // The top row lay along x about (0, 0.1, 0).
    for (number, x) in [(6, -0.1), (7, 0.0), (8, 0.1)] {
        let exact = DVec3::new(1.0, 0.1 + x, 0.0);
        assert!((simulation.position(number) - exact).length() < 1e-15, "{number}");
    }
}

#[test]
fn a_set_follows_a_solid_by_its_name_its_kind_or_its_number() {
    for solid in ["'arm'", "0"] {
        let loaded = scene(&format!("set = 'top'\nfollow = {solid}")).unwrap();
        let [guide] = &loaded.scene.guides[..] else { panic!("one guide") };
        assert_eq!((&guide.lead, guide.until), (&Lead::Solid(0), None));
        // Places are seen from the middle of the solid, at the start along the axes.
        let places: Vec<_> = guide.held.iter().map(|&(number, place)| (number, place.y)).collect();
        assert_eq!(places, [(6, -1.9), (7, -1.9), (8, -1.9)]);
    }
    let unnamed = toml(
        "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\n[[world.solids]]\n\
         kind = 'half_space'\nposition = [0, -2, 0]\n[[pins]]\nset = 'first'\n\
         follow = 'half_space'",
    );
    assert_eq!(unnamed.unwrap().scene.guides.len(), 1);
}

#[test]
fn a_steady_pin_ends_at_its_time() {
    let mut simulation = simulation("set = 'top'\nvelocity = [0, 1, 0]\nuntil = 0.5");
    (0..29).for_each(|_| simulation.step().unwrap());
    assert!(simulation.model().is_pinned(7));
    simulation.step().unwrap();
    assert!(!simulation.model().is_pinned(7));
    // 30 steps of a 60th of a second.
    assert!((simulation.position(7).y - 0.6).abs() < 1e-14);
}

#[test]
fn two_sets_may_share_particles_that_follow_the_same_solid() {
    let both = |second: &str| {
        scene(&format!("set = 'top'\nfollow = 'arm'\n[[pins]]\nset = 'left'\n{second}"))
    };
    let held = |loaded: Loaded| loaded.scene.guides.iter().map(|guide| guide.held.len()).sum();
    assert_eq!(both("follow = 'arm'").map(held), Ok(5));
    for (second, why) in [
        ("follow = 'arm'\nuntil = 1", "their `until` differs"),
        ("velocity = [0, 1, 0]", "their `follow` differs"),
        (
            "key_frames = [{ time = 1 }]",
            "sets on `key_frames` may not, as each turns about its own middle",
        ),
    ] {
        let message = both(second).unwrap_err();
        let said = "pins[1] and pins[0] hold the same particle, number 6 of the scene; ";
        assert!(message.ends_with(&format!("{said}{why}")), "{message}");
    }
}

#[test]
fn each_mistake_is_one_line_with_its_place_its_value_and_what_it_must_be() {
    let frames = "key_frames = [{ time = 1, position = [1, 1, 0] }]";
    for (pin, said) in [
        (
            "follow = 'leg'".to_string(),
            "s.toml:14:10: pins[0].follow is \"leg\"; it must be the number or the name of a \
             solid: `arm`",
        ),
        (
            "follow = 'amr'".into(),
            "it must be the number or the name of a solid: did you mean `arm`?",
        ),
        ("follow = 1".into(), "pins[0].follow is 1; it must be from 0 to 0: there is 1 solid"),
        ("follow = 1.5".into(), "a whole number, not negative, or a name"),
        (
            format!("follow = 'arm'\n{frames}"),
            "s.toml:14:10: pins[0].follow and key_frames exclude each other: a pin moves by one",
        ),
        (format!("velocity = [1, 0, 0]\n{frames}"), "pins[0].velocity and key_frames exclude"),
        ("velocity = [1, 0, 0]\nfollow = 0".into(), "pins[0].velocity and follow exclude"),
        ("key_frames = []".into(), "pins[0].key_frames must not be empty"),
        (
            "key_frames = [{ time = 2 }, { time = 1 }]".into(),
            "pins[0].key_frames[1].time is 1; it must be later than 2",
        ),
        (
            "key_frames = [{ time = 1, position = [1e9, 0, 0] }]".into(),
            "pins[0].key_frames[0].position[0] is 1000000000; it must be",
        ),
        ("until = 0".into(), "pins[0].until is 0; it must be positive and finite"),
        ("untill = 1".into(), "until"),
    ] {
        let message = scene(&format!("set = 'top'\n{pin}")).unwrap_err();
        assert!(message.contains(said), "{message}\n{said}");
        assert!(message.lines().count() == 1 && message.len() < 250, "{message}");
    }
}

#[test]
fn a_finer_scene_guides_the_same_sets_and_refuses_single_particles() {
    let finer = |pin: &str| {
        let folder = tempfile::tempdir().unwrap();
        let text = format!(
            "version = 1\n[[bodies]]\nkind = 'cloth'\nsize = [3, 3]\nspacing = 0.1\n\
             [[pins]]\n{pin}\n"
        );
        std::fs::write(folder.path().join("scene.toml"), text).unwrap();
        let draft = Draft::open(Path::new("scene.toml"), folder.path()).unwrap();
        let source = draft.source().unwrap();
        let coarse = draft.load(&source).unwrap();
        draft.finer(&source, &coarse.scene, 1).map_err(|error| error.to_string())
    };
    let found = finer("set = 'top'\nuntil = 0.5").unwrap();
    assert_eq!(found.loaded.scene.guides[0].held.len(), 5);
    assert_eq!(found.loaded.scene.pins.len(), 5);
    let Err(message) = finer("particle = 0\nuntil = 0.5") else { panic!("refused") };
    assert!(message.contains("pins[0] has `key_frames`, `follow` or `until`"), "{message}");
}
