//! Steps of a device, taken again on the processor.

use msd_core::{Simulation, State, Vector};

/// A step that the device has taken.
pub struct Taken {
    /// The simulation before it, if its model is another than at the last check.
    pub simulation: Option<Box<Simulation<f32>>>,
    /// The state before it.
    pub before: State<f32>,
    /// The steps before it.
    pub steps: u64,
    /// The state after it.
    pub after: State<f32>,
}

/// A step of the device whose bits differ from those of the processor.
#[derive(Debug)]
pub struct Difference {
    /// The state before it.
    pub before: State<f32>,
    /// The steps before it.
    pub steps: u64,
    /// The first particle that differs.
    pub particle: usize,
}

/// The simulation that takes steps again.
#[derive(Debug, Default)]
pub struct Again(Option<Box<Simulation<f32>>>);

impl Again {
    /// Takes a step again, and compares. The first step brings a simulation.
    pub fn take(&mut self, taken: Taken) -> Option<Difference> {
        let Taken { simulation: other, before, steps, after } = taken;
        if other.is_some() {
            self.0 = other;
        }
        let simulation = self.0.as_mut().expect("the simulation of the first step");
        let is_taken =
            simulation.set_state(&before, steps).and_then(|()| simulation.step()).is_ok();
        // A step that fails here fails on the device too: it refuses what leaves the world.
        let particle =
            if is_taken { first_difference(&simulation.state(), &after) } else { Some(0) };
        particle.map(|particle| Difference { before, steps, particle })
    }
}

/// The first particle whose bits differ in two states.
pub fn first_difference(a: &State<f32>, b: &State<f32>) -> Option<usize> {
    let bits = |state: &State<f32>, particle: usize| {
        let motion = [state.positions[particle], state.velocities[particle]];
        motion.map(|vector| vector.components().map(f32::to_bits))
    };
    (0..a.positions.len()).find(|&particle| bits(a, particle) != bits(b, particle))
}
