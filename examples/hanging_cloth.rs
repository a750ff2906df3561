//! A window with a cloth that hangs by its top corners; drag it with the mouse.

use msd::core::glam::DVec3;
use msd::core::{Material, Pin, Scene, Settings, shape};
use msd::scene::Loaded;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let material = Material { mass: 0.05, stiffness: 400.0, damping: 0.4 };
    let mut scene = Scene::of("cloth", shape::cloth([25, 25], 0.2, material)?);
    let top = 24 * 25;
    scene.pins = [top, top + 24].map(|particle| Pin { particle, velocity: DVec3::ZERO }).to_vec();
    // A breath of wind: a uniform force on every particle, newtons.
    scene.world.force = DVec3::new(0.0, 0.0, 0.05);
    let settings = Settings { substeps: 12, ..Settings::default() };
    msd_app::view(Loaded::new("hanging cloth", scene, settings))?;
    Ok(())
}
