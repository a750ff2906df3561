//! Tests of a device in software: the bits of the processor.
//!
//! Without a graphics adapter each test prints that it skips, unless `MSD_REQUIRE_ADAPTER` is set.

mod changes;
mod ensemble;
mod failures;
mod same_bits;

use msd_core::{Simulation, state_hash};
use msd_gpu::{Device, GpuError, GpuSimulation, Manner, Tally, Verdict, probe};
use std::sync::OnceLock;

/// The first device of this machine, in the manner that has the bits of the processor.
fn device() -> Option<Device> {
    static MANNER: OnceLock<Option<Manner>> = OnceLock::new();
    let open = || pollster::block_on(Device::open(""));
    let find = || match open() {
        Ok(device) => match pollster::block_on(probe(&device)) {
            Ok(Verdict::SameBits(manner)) => Some(manner),
            other => panic!("{}: {other:?}", device.name()),
        },
        Err(error) => {
            assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "no adapter: {error}");
            println!("SKIPPED: {error}");
            None
        }
    };
    let manner = *MANNER.get_or_init(find);
    // One for each test: a device that one of them loses is lost to that one alone.
    manner.map(|manner| open().expect("it opened before").with_manner(manner))
}

fn prepared(device: &Device, simulation: &Simulation<f32>) -> GpuSimulation {
    pollster::block_on(GpuSimulation::new(device, simulation)).expect("a scene for a device")
}

/// Advances by so many steps on the processor and on a device. Asserts that both end alike, in the
/// same state or with the same error, and returns who took the steps there.
fn compare(what: &str, device: &Device, start: &Simulation<f32>, steps: u64) -> Tally {
    let (mut here, mut there) = (start.clone(), start.clone());
    let mut gpu = prepared(device, &there);
    let failure = (0..steps).find_map(|_| here.step().err());
    match (failure, gpu.advance(&mut there, steps)) {
        (None, Ok(())) => {}
        (Some(here), Err(GpuError::Step(there))) => assert_eq!(here, there, "{what}"),
        other => panic!("{what}: {other:?}"),
    }
    assert_same(what, &here, &there);
    gpu.tally()
}

fn assert_same(what: &str, here: &Simulation<f32>, there: &Simulation<f32>) {
    assert_eq!(here.steps(), there.steps(), "{what}");
    let [here, there] = [here, there].map(|simulation| state_hash(&simulation.state()));
    assert_eq!(here, there, "{what}");
}
