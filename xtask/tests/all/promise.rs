//! The scenes over which the promise of tuning is kept.

use msd_core::{Settings, Simulation};
use msd_study::reference::{Wish, make_reference};
use msd_study::trial::try_choice;
use msd_study::tune::{Goal, tune};
use xtask::promise::{random_scene, touching_scene};

#[test]
fn generated_scenes_are_scenes() {
    let touching = (0..20).map(|seed| touching_scene(seed).unwrap());
    for (row, scene) in (0..200).map(|seed| random_scene(seed).unwrap()).chain(touching).enumerate()
    {
        let made = Simulation::<f32>::new(&scene, Settings::default());
        assert!(made.is_ok(), "scene {row}");
    }
}

#[test]
fn what_tuning_promises_of_bodies_that_meet_it_keeps() {
    const ASKED: f64 = 2e-3;
    // The quick ones of the twenty that `cargo bench --bench promise` tunes.
    for seed in [0, 1, 5] {
        let scene = touching_scene(seed).unwrap();
        let tuned = tune(&scene, 0.3, Goal::MaxError(ASKED), &mut ()).unwrap();
        assert!(tuned.met, "seed {seed}: {}", tuned.verdict());
        // A reference finer than that of tuning, whose errors it would share otherwise.
        let wish = Wish { duration: 0.3, uncertainty: 1e-5, patience: 2.0 };
        let right = make_reference(&scene, wish, &mut ()).unwrap();
        let reliable = right.reliable(0.25 * ASKED);
        assert!(0 < reliable, "seed {seed}: nothing to judge by");
        let delivered =
            try_choice(&scene, tuned.best.trial.choice, (&right, reliable), &mut ()).unwrap();
        assert!(delivered.is_within(ASKED), "seed {seed}: {} m", delivered.error());
    }
}
