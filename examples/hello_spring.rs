//! Two masses on a spring that swing once in 1.4 s and come to rest a metre apart.

use msd::core::glam::DVec3;
use msd::core::{Error, Particle, Scene, Settings, Simulation, Spring, World};

fn main() -> Result<(), Error> {
    let at =
        |x: f64| Particle { position: DVec3::new(x, 0.0, 0.0), velocity: DVec3::ZERO, mass: 1.0 };
    let scene = Scene {
        world: World { gravity: DVec3::ZERO, ..World::default() },
        particles: vec![at(0.0), at(1.5)],
        springs: vec![Spring { ends: [0, 1], rest_length: 1.0, stiffness: 10.0, damping: 0.5 }],
        ..Scene::default()
    };
    let mut simulation = Simulation::<f64>::new(&scene, Settings::default())?;
    println!("  time     length   energy");
    for step in 0..=600 {
        if step % 20 == 0 {
            let length = simulation.length(0);
            let energy = simulation.energy();
            let kept = energy.kinetic + energy.elastic;
            let bar = "=".repeat((length * 30.0) as usize);
            println!("{:5.2} s  {length:.4} m  {kept:.4} J  {bar}", simulation.time());
        }
        simulation.step()?;
    }
    Ok(())
}
