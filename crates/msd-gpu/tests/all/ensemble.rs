//! Ensembles: each of many simulations ends as it does alone on the processor.

use super::{assert_same, device};
use msd_core::{Integrator, Interaction, Select, Settings, Simulation};
use msd_gpu::{Ensemble, GpuError, Manner, Roots};
use msd_scene::open;

fn start(name: &str, integrator: Integrator, substeps: u32) -> Simulation<f32> {
    let loaded = open(name).expect("a built-in scene");
    let settings = Settings { integrator, substeps, ..loaded.settings };
    Simulation::new(&loaded.scene, settings).expect("a scene that runs")
}

/// The same simulation with other stiffnesses, a factor from one to the next.
fn sweep(start: &Simulation<f32>, count: usize, factor: f64) -> Vec<Simulation<f32>> {
    let of = |number: usize| {
        let mut simulation = start.clone();
        let value = f64::from(start.model().stiffness(0)) * factor.powi(number as i32);
        let springs = Select::Body(0);
        simulation.queue(Interaction::SetStiffness { springs, value }).expect("a stiffness");
        simulation.apply_queued().expect("a good state");
        simulation
    };
    (0..count).map(of).collect()
}

/// Compares an ensemble with its simulations, each alone on the processor.
fn compare(simulations: Vec<Simulation<f32>>, steps: u64) -> usize {
    let Some(device) = device() else { return 0 };
    let mut there = simulations.clone();
    let ensemble = pollster::block_on(Ensemble::new(&device, &there));
    let mut ensemble = ensemble.expect("scenes for a device");
    let ended = ensemble.advance(&mut there, steps).expect("a device that computes").to_vec();
    ensemble.finish_check().expect("the bits of the processor");
    assert!(0 < ensemble.tally().checked, "{:?}", ensemble.tally());
    for (number, (mut here, (there, ended))) in
        simulations.into_iter().zip(there.iter().zip(&ended)).enumerate()
    {
        let failure = (0..steps).find_map(|_| here.step().err());
        assert_eq!(&failure, ended, "number {number}");
        assert_same(&format!("number {number}"), &here, there);
    }
    ended.iter().flatten().count()
}

#[test]
fn a_sweep_of_stiffness_ends_in_the_bits_of_each_run_alone_and_some_diverge() {
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4] {
        let simulations = sweep(&start("cloth", integrator, 4), 12, 1.6);
        let diverged = compare(simulations, 60);
        assert!(device().is_none() || 0 < diverged && diverged < 12, "{diverged}");
    }
}

#[test]
fn different_scenes_that_bounce_step_together() {
    let names = ["square", "chain", "square4", "dice", "spinner", "mattress", "square"];
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4] {
        let simulations = names.map(|name| start(name, integrator, 8)).to_vec();
        compare(simulations, 120);
    }
}

#[test]
fn simulations_may_be_borrowed_and_advanced_in_parts() {
    let Some(device) = device() else { return };
    let mut simulations = sweep(&start("cloth", Integrator::VelocityVerlet, 8), 5, 1.2);
    let whole = simulations.clone();
    let mut borrowed: Vec<&mut Simulation<f32>> = simulations.iter_mut().collect();
    let ensemble = pollster::block_on(Ensemble::new(&device, &borrowed));
    let mut ensemble = ensemble.expect("scenes for a device");
    for steps in [1, 30, 2, 27] {
        ensemble.advance(&mut borrowed, steps).expect("a device that computes");
    }
    for (mut here, there) in whole.into_iter().zip(&simulations) {
        (0..60).for_each(|_| here.step().expect("a stable step"));
        assert_same("in parts", &here, there);
    }
}

#[test]
fn an_ensemble_on_a_device_with_other_bits_is_found() {
    let Some(device) = device() else { return };
    // Roots by steps that are right where `fma` is fused, which no device in software does.
    let manner = Manner { roots: Roots::Fused, ..device.manner() };
    let mut simulations = sweep(&start("cloth", Integrator::SymplecticEuler, 8), 3, 1.1);
    let ensemble = pollster::block_on(Ensemble::new(&device.with_manner(manner), &simulations));
    let mut ensemble = ensemble.expect("scenes for a device");
    let advanced = ensemble.advance(&mut simulations, 100).map(drop);
    let found = advanced.and_then(|()| ensemble.finish_check());
    assert!(matches!(found, Err(GpuError::Differs { step: 1, .. })), "{found:?}");
}

#[test]
fn simulations_of_several_methods_are_no_ensemble() {
    let Some(device) = device() else { return };
    let two =
        [Integrator::SymplecticEuler, Integrator::Rk4].map(|method| start("chain", method, 8));
    let error = pollster::block_on(Ensemble::new(&device, &two)).expect_err("two methods");
    assert!(matches!(error, GpuError::Unsupported(_)), "{error}");
}

#[test]
fn queued_interactions_are_no_part_of_an_ensemble() {
    let Some(device) = device() else { return };
    let mut simulations = vec![start("chain", Integrator::Rk4, 8); 2];
    let ensemble = pollster::block_on(Ensemble::new(&device, &simulations));
    let mut ensemble = ensemble.expect("scenes for a device");
    simulations[1].queue(Interaction::Cut { spring: 0 }).expect("a spring");
    let refused = ensemble.advance(&mut simulations, 1).map(<[_]>::len);
    assert!(matches!(refused, Err(GpuError::Unsupported(_))), "{refused:?}");
}
