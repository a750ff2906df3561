//! Built-in scenes under each method: the hash of the processor after a second.

use super::{compare, device};
use msd_core::{Integrator, Settings, Simulation};
use msd_gpu::{GpuError, GpuSimulation};
use msd_scene::{BUILTINS, Loaded, open};

const METHODS: [Integrator; 4] = [
    Integrator::ExplicitEuler,
    Integrator::SymplecticEuler,
    Integrator::VelocityVerlet,
    Integrator::Rk4,
];

/// The built-in scenes that a device steps.
const COVERED: [&str; 14] = [
    "bunny", "chain", "cloth", "cube", "dice", "foam", "jelly", "mattress", "snake", "spinner",
    "square", "square4", "teapot", "waffle",
];

/// A step per frame, of as many substeps as the scene asks for.
fn settings(loaded: &Loaded, integrator: Integrator) -> Settings {
    Settings { integrator, substeps: loaded.settings.substeps.max(8), ..loaded.settings }
}

fn start(name: &str, integrator: Integrator) -> Simulation<f32> {
    let loaded = open(name).expect(name);
    Simulation::new(&loaded.scene, settings(&loaded, integrator)).expect(name)
}

#[test]
fn built_in_scenes_end_in_the_bits_of_the_processor() {
    let Some(device) = device() else { return };
    for name in COVERED {
        for integrator in METHODS {
            let what = format!("{name} {}", integrator.name());
            let tally = compare(&what, &device, &start(name, integrator), 60);
            println!("{what}: {tally:?}");
            let is_stable = integrator != Integrator::ExplicitEuler;
            assert!(!is_stable || tally.processor == 0, "{what}: {tally:?}");
        }
    }
}

#[test]
fn other_built_in_scenes_say_what_a_device_does_not_step() {
    let Some(device) = device() else { return };
    for builtin in BUILTINS.iter().filter(|builtin| !COVERED.contains(&builtin.name)) {
        let simulation = start(builtin.name, Integrator::SymplecticEuler);
        let refused = pollster::block_on(GpuSimulation::new(&device, &simulation));
        let Err(GpuError::Unsupported(reason)) = refused else {
            panic!("{}: {refused:?}", builtin.name);
        };
        let known = ["air", "bodies that collide", "solids other than planes"];
        assert!(known.iter().any(|known| reason.starts_with(known)), "{}: {reason}", builtin.name);
    }
    let implicit = start("cloth", Integrator::BackwardEuler);
    let refused = pollster::block_on(GpuSimulation::new(&device, &implicit));
    let message = refused.expect_err("an implicit method").to_string();
    assert!(message.contains("the method backward-euler"), "{message}");
}
