//! Errors of devices.

use msd_core::Error;

/// Why a device does not step a simulation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No driver is installed, or none has the name.
    #[error("no graphics adapter{0}; `msd devices` lists them")]
    NoAdapter(String),
    /// The adapter cannot compute.
    #[error("{adapter} has no compute shaders: it allows {most} storage buffers, and 8 are needed")]
    NoCompute {
        /// Its name.
        adapter: String,
        /// The storage buffers that a program may have.
        most: u32,
    },
    /// The adapter refuses to open a device.
    #[error("{adapter} does not open: {reason}")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// The words of the driver.
        reason: String,
    },
    /// The scene needs what a device does not step.
    #[error("a GPU does not step {0}; run the scene on the processor (--device cpu)")]
    Unsupported(String),
    /// A buffer is larger than the device allows.
    #[error("{what} take {bytes} bytes, and {adapter} allows {most} in one buffer")]
    TooLarge {
        /// The content of the buffer.
        what: &'static str,
        /// Its size.
        bytes: u64,
        /// The name of the adapter.
        adapter: String,
        /// The most that fits.
        most: u64,
    },
    /// The memory of the device is used up, or it refuses a program.
    #[error("{adapter} refuses: {reason}")]
    Refused {
        /// The name of the adapter.
        adapter: String,
        /// The words of the driver.
        reason: String,
    },
    /// The device is gone: a driver was reset, or a card was removed. The simulation stands at the
    /// last state that was read back.
    #[error("{adapter} was lost: {reason}")]
    Lost {
        /// The name of the adapter.
        adapter: String,
        /// The words of the driver.
        reason: String,
    },
    /// The bits of a step differ from those of the processor.
    #[error(
        "{adapter} computed step {step} with other bits than the processor, first of particle \
         {particle}; the run stands before that step"
    )]
    Differs {
        /// The name of the adapter.
        adapter: String,
        /// The step, from 1.
        step: u64,
        /// The first particle that differs.
        particle: usize,
    },
    /// A step failed, as it does on the processor.
    #[error(transparent)]
    Step(#[from] Error),
}
