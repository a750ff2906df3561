//! Any text is read or refused by the reader of scenes; none makes it panic.

use msd_core::{Error, Real, Simulation};
use msd_scene::{BUILTINS, Loaded, Precision, SceneFormat, parse, read_state};
use proptest::prelude::*;

/// Replaces a piece of a text by another.
fn mutate(text: &str, (from, length): (usize, usize), piece: &str) -> String {
    let characters: Vec<char> = text.chars().collect();
    let from = from % (characters.len() + 1);
    let to = (from + length).min(characters.len());
    let head: String = characters[..from].iter().collect();
    let tail: String = characters[to..].iter().collect();
    format!("{head}{piece}{tail}")
}

/// Scenes that are cheap to build.
fn small() -> Vec<&'static str> {
    let names = ["chain", "square", "dice", "cloth", "spinner"];
    BUILTINS.iter().filter(|b| names.contains(&b.name)).map(|b| b.text).collect()
}

/// One step of a scene.
fn step<R: Real>(loaded: &Loaded) -> Result<(), Error> {
    Simulation::<R>::new(&loaded.scene, loaded.settings)?.step()
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused_in_one_line(text in ".{0,200}") {
        for format in [SceneFormat::Toml, SceneFormat::Json] {
            if let Err(error) = parse(&text, format, "s") {
                prop_assert_eq!(error.to_string().lines().count(), 1);
            }
        }
    }

    #[test]
    fn a_scene_with_a_slip_of_the_pen_is_read_or_refused_in_one_line(
        which in 0usize..5,
        at in (any::<usize>(), 0usize..12),
        piece in "(-|nan|inf|1e999|0|[a-z]{1,4}|\\[|\\]|\"|\n|,|\\{|\\}|9{1,20})?",
    ) {
        let text = mutate(small()[which], at, &piece);
        match parse(&text, SceneFormat::Toml, "s") {
            // What is read is in its domain, or msd-core refuses it; large ones are left alone.
            Ok(loaded) if loaded.scene.particles.len() < 10_000 => {
                let _ = match loaded.precision {
                    Precision::F32 => step::<f32>(&loaded),
                    Precision::F64 => step::<f64>(&loaded),
                };
            }
            Ok(_) => (),
            Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1),
        }
    }

    #[test]
    fn any_bytes_are_a_state_or_refused_in_one_line(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let with_header = [b"particle,x,y,z,vx,vy,vz\n".as_slice(), &bytes].concat();
        for bytes in [bytes.as_slice(), &with_header] {
            if let Err(error) = read_state(bytes, Precision::F32, ("s", 3)) {
                prop_assert_eq!(error.to_string().lines().count(), 1);
            }
        }
    }
}
