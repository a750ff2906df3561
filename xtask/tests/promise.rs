//! The scenes over which the promise of tuning is kept.

use msd_core::{Settings, Simulation};
use xtask::promise::random_scene;

#[test]
fn generated_scenes_are_scenes() {
    for seed in 0..200 {
        let scene = random_scene(seed).unwrap();
        let made = Simulation::<f32>::new(&scene, Settings::default());
        assert!(made.is_ok(), "seed {seed}");
    }
}
