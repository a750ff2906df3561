//! You will see a hash that is the same on every machine: a run without `std`, as on bare metal.
#![no_std]

extern crate alloc;
extern crate std; // for `println!` alone: a microcontroller would use its own way out

use msd::core::{Error, Material, Scene, Settings, Simulation, shape};

fn main() -> Result<(), Error> {
    let material = Material { mass: 1.0, stiffness: 500.0, damping: 2.0 };
    let mut part = shape::block([4, 4, 4], 1.0, material)?;
    part.particles[0].position.x -= 0.5;
    let mut simulation = Simulation::<f32>::new(&Scene::of("block", part), Settings::default())?;
    for _ in 0..300 {
        simulation.step()?;
    }
    std::println!("{:016x} after {} s", hash(simulation.state()), simulation.time());
    Ok(())
}

/// FNV-1a (Fowler, Noll, Vo, 1991) over the bits of the positions.
fn hash(state: &msd::core::State<f32>) -> u64 {
    let words = state.positions.iter().flat_map(|position| position.to_array());
    let bytes = words.flat_map(|word| word.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
