//! Scene files of any bytes: a text that starts with a brace is JSON, any other TOML.

use super::promise::{check_message, check_simulation, step};
use msd_core::{Integrator, Real, Scene, Settings, Simulation};
use msd_scene::schema::{BodyRow, Kind, SceneFile, SolidKind, SolidRow};
use msd_scene::{SceneFormat, parse, read, write};

/// The largest scene that is built and run, particles.
const LARGEST: u128 = 1000;
/// Scenes with more particles are refused for their size before they are built.
const REFUSED: u128 = 1 << 24;

/// Reads bytes as a scene and runs a few steps of it in both precisions.
pub fn check(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let json = text.trim_start().starts_with('{');
    let format = if json { SceneFormat::Json } else { SceneFormat::Toml };
    let file = match read(&text, format, "scene") {
        Ok(file) => file,
        Err(error) => {
            check_message(&error);
            // The rows are what `parse` starts from.
            assert!(parse(&text, format, "scene").is_err());
            return;
        }
    };
    check_round_trip(&file, format);
    if !is_quick(&file) {
        return;
    }
    match parse(&text, format, "scene") {
        Ok(loaded) => {
            loaded.notes.iter().for_each(check_message);
            run::<f32>(&loaded.scene, loaded.settings);
            run::<f64>(&loaded.scene, loaded.settings);
        }
        Err(error) => check_message(&error),
    }
}

/// Checks that a file that is written reads back the same.
fn check_round_trip(file: &SceneFile, format: SceneFormat) {
    match write(file, format) {
        Ok(text) => {
            let back = read(&text, format, "scene");
            // A NaN differs from itself, so the texts are compared.
            let back = back.and_then(|back| write(&back, format));
            assert_eq!(back.as_ref(), Ok(&text));
        }
        Err(error) => check_message(&error),
    }
}

/// Whether a scene is refused for its size at once or built in no time.
fn is_quick(file: &SceneFile) -> bool {
    if !file.world.solids.iter().all(is_coarse) {
        return false;
    }
    let sizes: Vec<u128> = file.bodies.iter().map(particles).collect();
    let total = sizes.iter().fold(0, |sum: u128, &size| sum.saturating_add(size));
    total <= LARGEST || sizes.first().is_some_and(|&first| REFUSED < first)
}

/// Whether a solid is no mesh, or has few cells.
fn is_coarse(solid: &SolidRow) -> bool {
    let few = |cell: f64| solid.length.unwrap_or(1.0) <= 16.0 * cell;
    solid.kind != SolidKind::Mesh || solid.cell.is_some_and(few)
}

/// How many particles a body asks for; a mesh that the crate carries takes long to build.
fn particles(body: &BodyRow) -> u128 {
    match body.kind {
        Kind::Explicit => 0,
        Kind::Mesh => {
            let carried = body.file.as_deref().is_some_and(|file| file.ends_with(".obj"));
            if carried { LARGEST + 1 } else { 0 }
        }
        _ => {
            let size = body.size.iter().flatten();
            size.fold(1, |product: u128, &length| product.saturating_mul(length.into()))
        }
    }
}

fn run<R: Real>(scene: &Scene, settings: Settings) {
    let mut settings = settings;
    let made = Simulation::<R>::new(scene, settings);
    // Checked as written, then run with few substeps: a large number of them is no mistake.
    (settings.substeps, settings.newton) = (settings.substeps.min(3), settings.newton.min(2));
    if settings.integrator.is_adaptive() && 8 < scene.particles.len() {
        settings.integrator = Integrator::Rk4;
    }
    let mut simulation = match made {
        Ok(simulation) => simulation,
        Err(error) => return check_message(&error),
    };
    // A substep that is longer may be refused.
    if let Err(error) = simulation.set_settings(settings) {
        return check_message(&error);
    }
    for _ in 0..3 {
        check_simulation(&simulation);
        if !step(&mut simulation) {
            break;
        }
    }
    check_simulation(&simulation);
}
