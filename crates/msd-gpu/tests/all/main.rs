//! Tests of a device in software: the bits of the processor.
//!
//! Without a graphics adapter each test prints that it skips, unless `MSD_REQUIRE_ADAPTER` is set.

mod same_bits;

use msd_gpu::Device;
use std::sync::OnceLock;

/// The first device of this machine.
fn device() -> Option<Device> {
    static DEVICE: OnceLock<Option<Device>> = OnceLock::new();
    let open = || match pollster::block_on(Device::open("")) {
        Ok(device) => Some(device),
        Err(error) => {
            assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "no adapter: {error}");
            println!("SKIPPED: {error}");
            None
        }
    };
    DEVICE.get_or_init(open).clone()
}
