//! Built-in scenes under each method: the hash of the processor after a second.

use super::device;
use msd_core::{Integrator, Settings, Simulation, state_hash};
use msd_gpu::{GpuError, GpuSimulation};
use msd_scene::{BUILTINS, Loaded, open};

const METHODS: [Integrator; 4] = [
    Integrator::ExplicitEuler,
    Integrator::SymplecticEuler,
    Integrator::VelocityVerlet,
    Integrator::Rk4,
];

/// A step per frame, of as many substeps as the scene asks for.
fn settings(loaded: &Loaded, integrator: Integrator) -> Settings {
    let asked = loaded.settings;
    Settings { integrator, substeps: asked.substeps.max(8), ..asked }
}

/// Compares a run on the device with one on the processor, which may both end in an error.
fn compare(name: &str, integrator: Integrator, steps: u64) -> Result<String, GpuError> {
    let device = device().expect("an adapter");
    let loaded = open(name).expect(name);
    let start = Simulation::<f32>::new(&loaded.scene, settings(&loaded, integrator));
    let start = start.expect("a built-in scene runs");
    let (mut here, mut there) = (start.clone(), start);
    let mut gpu = pollster::block_on(GpuSimulation::new(&device, &there))?;
    if std::env::var_os("TRACE").is_some() {
        for step in 0..steps {
            if here.step().is_err() {
                println!("{name} {integrator:?} diverges at {step}");
                break;
            }
            gpu.advance(&mut there, 1)?;
            let (a, b) = (here.state(), there.state());
            let bits = |v: msd_core::glam::Vec3A| v.to_array().map(f32::to_bits);
            let differs = (0..a.positions.len()).filter(|&i| {
                bits(a.positions[i]) != bits(b.positions[i])
                    || bits(a.velocities[i]) != bits(b.velocities[i])
            });
            let list: Vec<usize> = differs.collect();
            if let Some(&i) = list.first() {
                println!(
                    "{name} {integrator:?} step {step}: {} differ, first {i}: {:?} {:?} | {:?} {:?} {:?}",
                    list.len(),
                    a.positions[i],
                    b.positions[i],
                    a.velocities[i],
                    b.velocities[i],
                    gpu.tally()
                );
                return Ok(String::new());
            }
        }
        println!("{name} {integrator:?} same {:?}", gpu.tally());
        return Ok(String::new());
    }
    let failure = (0..steps).find_map(|_| here.step().err());
    let lost = gpu.advance(&mut there, steps).err();
    match (&failure, &lost) {
        (None, None) => {}
        (Some(here), Some(GpuError::Step(there))) => assert_eq!(here, there, "{name}"),
        other => panic!("{name} {integrator:?}: {other:?}"),
    }
    assert_eq!(here.steps(), there.steps(), "{name} {integrator:?}");
    let hashes = [&here, &there].map(|simulation| state_hash(&simulation.state()));
    let tally = gpu.tally();
    let line = format!("{name} {integrator:?} {hashes:x?} {tally:?} {failure:?}");
    println!("{line}");
    if hashes[0] != hashes[1] {
        println!("DIFFERS {line}");
    }
    Ok(line)
}

#[test]
fn built_in_scenes_end_in_the_bits_of_the_processor() {
    if device().is_none() {
        return;
    }
    for builtin in BUILTINS.iter().filter(|b| std::env::var("SCENE").map_or(true, |s| b.name == s))
    {
        for integrator in METHODS {
            let start = std::time::Instant::now();
            match compare(builtin.name, integrator, 60) {
                Ok(_) => println!("    {:.1} s", start.elapsed().as_secs_f64()),
                Err(error) => println!("{}: {error}", builtin.name),
            }
        }
    }
}
