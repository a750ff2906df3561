//! Memory of a scene, measured in a process of its own.

use super::rivals::settings;
use crate::baselines::works;
use cap::Cap;
use msd::core::{Integrator, Simulation};
use std::alloc::System;
use std::process::Command;

/// Counts allocations. The size that the system reports for a process is larger: it keeps freed
/// memory for a while.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// The argument that makes this program measure the memory of a work, and nothing else.
pub const ARGUMENT: &str = "--memory-of";

/// Memory of a scene that runs, bytes.
pub struct Memory {
    pub springs: usize,
    /// Held while it is stepped, and the most held before that: the rows of the scene and all that
    /// is forgotten once it is compiled.
    pub held: f64,
    pub most: f64,
}

/// Measures a work in a child of this process; none where there are no processes.
pub fn measure(work: &str) -> Option<Memory> {
    let program = std::env::current_exe().ok()?;
    let output = Command::new(program).args([ARGUMENT, work]).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let numbers: Vec<f64> =
        text.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let &[springs, held, most] = &numbers[..] else { return None };
    Some(Memory { springs: springs as usize, held, most })
}

/// Runs a work and prints its springs, the memory it holds and the most it has held, bytes.
pub fn run(work: &str) {
    let before = ALLOCATOR.allocated();
    let scene = works::scene(work);
    let settings = settings(Integrator::SymplecticEuler);
    let simulation = Simulation::<f32>::new(&scene, settings);
    let mut simulation = simulation.expect("a valid scene");
    drop(scene);
    (0..3).for_each(|_| simulation.step().expect("stable"));
    let springs = simulation.model().spring_count();
    let (held, most) = (ALLOCATOR.allocated() - before, ALLOCATOR.max_allocated() - before);
    println!("{springs} {held} {most}");
}
