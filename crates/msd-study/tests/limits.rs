//! The built-in scenes blow up where it is predicted.

use msd_core::{Integrator, Scene};
use msd_study::limits::limits;

fn scene(name: &str) -> Scene {
    msd_scene::open(name).unwrap().scene
}

#[test]
fn every_built_in_scene_blows_up_where_predicted() {
    let small = ["cloth", "dice", "foam", "mattress", "snake", "waffle", "chain", "square4"];
    for name in small.into_iter().chain(["bunny"]) {
        for limit in limits(&scene(name), 4).unwrap() {
            let observed = limit.observed.filter(|&observed| 0.0 < observed);
            if !Integrator::EXPLICIT.contains(&limit.integrator) {
                continue;
            }
            // What explicit Euler needs to grow is longer than these runs.
            let Some(observed) = observed else {
                assert_eq!(limit.integrator.name(), "explicit-euler", "{name}: {limit:?}");
                continue;
            };
            // It must grow by half in 100 substeps of the bunny: another 2.5 %.
            let slow = limit.integrator == Integrator::ExplicitEuler;
            let room = if slow { 0.03 } else { 0.005 };
            let ratio = limit.predicted / observed;
            assert!((ratio - 1.0).abs() < room, "{name}: {limit:?}: {ratio}");
        }
    }
}
