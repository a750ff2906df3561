//! Rivals of a race: the simple kernel, the textbook and the compiled kernel.

use super::race::Rival;
use super::threaded::updates;
pub use super::threaded::{settings, threaded};
use crate::baselines::simple::Simple;
use crate::baselines::textbook::Textbook;
use msd::core::{Instructions, Integrator, Real, Scene, Settings, Simulation};

/// The simple kernel.
pub fn simple<R: Real>(scene: &Scene, settings: Settings) -> Rival<'static> {
    let mut simple = Simple::<R>::new(scene, settings);
    let run = move |steps| (0..steps).for_each(|_| simple.step());
    Rival { name: "simple".into(), updates: updates(scene, settings), run: Box::new(run) }
}

/// The textbook.
pub fn textbook(scene: &Scene, settings: Settings) -> Rival<'static> {
    let mut textbook = Textbook::new(scene, settings);
    let run = move |steps| (0..steps).for_each(|_| textbook.step());
    Rival { name: "textbook".into(), updates: updates(scene, settings), run: Box::new(run) }
}

/// The compiled kernel.
pub fn kernel<R: Real>(
    scene: &Scene,
    settings: Settings,
    instructions: Instructions,
) -> Rival<'static> {
    let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
    simulation.set_instructions(instructions);
    let run = move |steps| (0..steps).for_each(|_| simulation.step().expect("stable"));
    let name = instructions.name().into();
    Rival { name, updates: updates(scene, settings), run: Box::new(run) }
}

/// The first second of a scene by backward Euler at 1/60 s, from the start each time: later on an
/// iterative method has less to do. An update is a frame.
pub fn backward_euler<R: Real>(scene: &Scene, name: &str) -> Rival<'static> {
    const FRAMES: u64 = 60;
    let settings = Settings { substeps: 1, ..settings(Integrator::BackwardEuler) };
    let start = Simulation::<R>::new(scene, settings).expect("a valid scene");
    let run = move |times| {
        for _ in 0..times {
            let mut simulation = start.clone();
            (0..FRAMES).for_each(|_| simulation.step().expect("stable"));
        }
    };
    Rival { name: name.into(), updates: FRAMES as f64, run: Box::new(run) }
}
