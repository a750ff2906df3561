//! Devices that fail, and runs that diverge: typed errors, and nothing is lost.

use super::{assert_same, device, prepared};
use msd_core::glam::DVec3;
use msd_core::{Integrator, Interaction, Settings, Simulation};
use msd_gpu::{Device, GpuError, GpuSimulation, Manner, Roots};
use msd_scene::open;

fn cloth(substeps: u32) -> Simulation<f32> {
    let loaded = open("cloth").expect("a built-in scene");
    let settings =
        Settings { integrator: Integrator::SymplecticEuler, substeps, ..loaded.settings };
    Simulation::new(&loaded.scene, settings).expect("a scene that runs")
}

#[test]
fn a_run_that_diverges_stops_at_the_last_good_state_with_the_error_of_the_processor() {
    let Some(device) = device() else { return };
    let (mut here, mut there) = (cloth(1), cloth(1));
    let failure = (0..600).find_map(|_| here.step().err()).expect("too long a step");
    let mut gpu = prepared(&device, &there);
    let Err(GpuError::Step(error)) = gpu.advance(&mut there, 600) else {
        panic!("a step that diverges");
    };
    assert_eq!(error, failure);
    assert_same("the last good state", &here, &there);
}

#[test]
fn after_a_device_is_lost_the_processor_goes_on_from_the_last_state() {
    let Some(device) = device() else { return };
    let (mut here, mut there) = (cloth(8), cloth(8));
    let mut gpu = prepared(&device, &there);
    gpu.advance(&mut there, 5).expect("stable steps");
    gpu.device().lose();
    let lost = gpu.advance(&mut there, 5).expect_err("a device that is gone");
    assert!(matches!(lost, GpuError::Lost { .. }), "{lost}");
    assert_eq!(there.steps(), 5);
    for _ in 0..5 {
        there.step().expect("a stable step");
    }
    (0..10).for_each(|_| here.step().expect("a stable step"));
    assert_same("on the processor", &here, &there);
}

#[test]
fn no_adapter_of_a_name_is_an_error_that_says_so() {
    let error = pollster::block_on(Device::open("no such card")).expect_err("no such adapter");
    assert!(error.to_string().contains("no graphics adapter named \"no such card\""), "{error}");
}

#[test]
fn the_energy_that_steps_on_a_device_dissipate_is_not_a_number() {
    let Some(device) = device() else { return };
    let mut simulation = cloth(8);
    let mut gpu = prepared(&device, &simulation);
    gpu.advance(&mut simulation, 2).expect("stable steps");
    assert!(simulation.ledger().dissipated().is_nan());
    assert!(simulation.energy().kinetic.is_finite());
}

#[test]
fn the_processor_checks_steps_while_a_run_goes_on() {
    let Some(device) = device() else { return };
    let mut simulation = cloth(8);
    let mut gpu = prepared(&device, &simulation);
    gpu.advance(&mut simulation, 1200).expect("stable steps");
    gpu.finish_check(&mut simulation).expect("the bits of the processor");
    let tally = gpu.tally();
    assert_eq!(tally.device, 1200);
    assert!(1 < tally.checked && tally.checked <= 1200 / 16 + 1, "{tally:?}");
}

#[test]
fn a_device_with_other_bits_is_found_while_it_runs() {
    let Some(device) = device() else { return };
    // Roots by steps that are right where `fma` is fused, which no device in software does.
    let manner = Manner { roots: Roots::Fused, ..device.manner() };
    let mut simulation = cloth(8);
    let mut gpu = prepared(&device.with_manner(manner), &simulation);
    let advanced = gpu.advance(&mut simulation, 100);
    let found = advanced.and_then(|()| gpu.finish_check(&mut simulation));
    let Err(GpuError::Differs { step, .. }) = found else { panic!("{found:?}") };
    // The first step is checked; the run stands before it.
    assert_eq!((step, simulation.steps()), (1, 0));
}

#[test]
fn a_step_that_fails_leaves_what_was_queued_for_it() {
    let Some(device) = device() else { return };
    let (mut here, mut simulation) = (cloth(1), cloth(1));
    while here.step().is_ok() {}
    let mut gpu = prepared(&device, &simulation);
    gpu.advance(&mut simulation, here.steps()).expect("the steps before it diverges");
    let grab = Interaction::Grab {
        particle: 7,
        target: DVec3::ZERO,
        frequency: 1.0,
        damping_ratio: 1.0,
        max_force: 1.0,
    };
    simulation.queue(grab).expect("a grab");
    let failed = gpu.advance(&mut simulation, 1);
    assert!(matches!(failed, Err(GpuError::Step(_))), "{failed:?}");
    assert_eq!((simulation.queued().len(), simulation.model().grabs().len()), (1, 0));
    assert_same("the last good state", &here, &simulation);
}

#[test]
fn a_device_that_is_lost_is_prepared_no_more() {
    let Some(device) = device() else { return };
    device.lose();
    let refused = pollster::block_on(GpuSimulation::new(&device, &cloth(8)));
    assert!(matches!(refused, Err(GpuError::Lost { .. })), "{refused:?}");
    assert!(device.is_lost());
}

#[test]
fn more_substeps_than_a_device_numbers_are_refused() {
    let Some(device) = device() else { return };
    let refused = pollster::block_on(GpuSimulation::new(&device, &cloth(20_000)));
    assert!(matches!(refused, Err(GpuError::Unsupported(_))), "{refused:?}");
}
