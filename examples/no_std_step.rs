//! A hash that is the same on every machine, of a run without `std`, as on bare metal.
#![no_std]

extern crate alloc;
extern crate std; // for `println!` alone: a microcontroller has an output of its own

use msd::core::{Error, Material, Scene, Settings, Simulation, shape, state_hash};

fn main() -> Result<(), Error> {
    let material = Material { mass: 1.0, stiffness: 500.0, damping: 2.0 };
    let mut part = shape::block([4, 4, 4], 1.0, material)?;
    part.particles[0].position.x -= 0.5;
    let mut simulation = Simulation::<f32>::new(&Scene::of("block", part), Settings::default())?;
    for _ in 0..300 {
        simulation.step()?;
    }
    std::println!("{:016x} after {} s", state_hash(&simulation.state()), simulation.time());
    Ok(())
}
