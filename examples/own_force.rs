//! You will see a planet: a force of your own, k / r², keeps a particle on a closed orbit.

use msd::core::glam::DVec3;
use msd::core::{Error, Integrator, Particle, Scene, Settings, Simulation, World};

const PULL: f64 = 1.0; // newton metres squared

fn main() -> Result<(), Error> {
    let planet = Particle { position: DVec3::X, velocity: DVec3::new(0.0, 1.2, 0.0), mass: 1.0 };
    let scene = Scene {
        world: World { gravity: DVec3::ZERO, ..World::default() },
        particles: vec![planet],
        ..Scene::default()
    };
    let settings = Settings { integrator: Integrator::Rk4, ..Settings::default() };
    let mut simulation = Simulation::<f64>::new(&scene, settings)?;
    // Kepler's third law: 1 / a = 2 / r − v² / k and T² = 4 π² a³ / k.
    let axis = 1.0 / (2.0 - planet.velocity.length_squared() / PULL);
    let period = std::f64::consts::TAU * (axis.powi(3) / PULL).sqrt();
    while simulation.time() < period {
        simulation.step_with(|motion, forces| {
            for (force, position) in forces.iter_mut().zip(motion.positions) {
                *force -= *position * (PULL / position.length().powi(3));
            }
        })?;
        if simulation.steps() % 60 == 0 {
            let position = simulation.position(0);
            println!("{:5.2} s  ({:+.3}, {:+.3}) m", simulation.time(), position.x, position.y);
        }
    }
    let missed = (simulation.position(0) - DVec3::X).length();
    println!("back after {period:.2} s, {missed:.3} m from the start: less than a step's flight");
    Ok(())
}
