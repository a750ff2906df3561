//! A rope that grows while it swings: every fifth of a second a particle and a spring are added at
//! its free end. Prints its springs and where it ends.

use msd::core::glam::DVec3;
use msd::core::{
    Error, Material, Particle, Pin, Scene, Settings, Simulation, Spring, Vector, shape,
};

fn main() -> Result<(), Error> {
    let (spacing, material) = (0.1, Material { mass: 0.05, stiffness: 500.0, damping: 0.5 });
    let mut scene = Scene::of("rope", shape::rope(5, spacing, material)?);
    scene.pins.push(Pin { particle: 0, velocity: DVec3::ZERO });
    let mut rope =
        Simulation::<f32>::new(&scene, Settings { substeps: 32, ..Settings::default() })?;
    let mut last = 4;
    for step in 1..=180 {
        rope.step()?;
        if step % 12 == 0 {
            let [before, end] = [last - 1, last].map(|row| rope.position(row).to_f64());
            let direction = (end - before).normalize_or(DVec3::X);
            let particle = Particle {
                position: end + direction * spacing,
                velocity: rope.velocity(last).to_f64(),
                mass: material.mass,
            };
            let next = rope.add_particle(particle)?;
            rope.add_spring(Spring {
                ends: [last, next],
                rest_length: spacing,
                stiffness: material.stiffness,
                damping: material.damping,
            })?;
            last = next;
        }
        if step % 60 == 0 {
            let end = rope.position(last);
            let springs = rope.model().spring_count();
            println!(
                "t = {} s: {springs} springs, end at ({:+.2}, {:+.2}) m",
                step / 60,
                end.x,
                end.y
            );
        }
    }
    Ok(())
}
