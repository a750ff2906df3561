//! Errors of devices.

use msd_core::Error;

/// Why a device does not step a simulation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No driver is installed, or no adapter has the name.
    #[error("there is no graphics adapter{0}")]
    NoAdapter(String),
    /// The adapter has too few storage buffers, or no compute shaders.
    #[error("{adapter} allows {most} storage buffers in a shader; msd needs 8")]
    NoCompute {
        /// Its name.
        adapter: String,
        /// The most storage buffers of a shader.
        most: u32,
    },
    /// The adapter refuses to open a device.
    #[error("{adapter} does not open: {reason}")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// The message of the driver.
        reason: String,
    },
    /// The scene has a part that a device does not step.
    #[error("a GPU does not step {0}")]
    Unsupported(String),
    /// A buffer is larger than the device allows.
    #[error("the buffer of {what} needs {bytes} bytes; {adapter} allows {most}")]
    TooLarge {
        /// The content of the buffer.
        what: &'static str,
        /// The size of the buffer, bytes.
        bytes: u64,
        /// The name of the adapter.
        adapter: String,
        /// The size limit of the device, bytes.
        most: u64,
    },
    /// The device is out of memory, or it refuses a program.
    #[error("{adapter} refused a buffer or a program: {reason}")]
    Refused {
        /// The name of the adapter.
        adapter: String,
        /// The message of the driver.
        reason: String,
    },
    /// The device is gone: a driver was reset, or a card was removed. The simulation keeps the last
    /// state that was read back.
    #[error("{adapter} was lost: {reason}")]
    Lost {
        /// The name of the adapter.
        adapter: String,
        /// The message of the driver.
        reason: String,
    },
    /// A wait in a browser, which answers only after the program has returned to it.
    #[error("a browser cannot wait for a GPU: poll it")]
    NoWait,
    /// The bits of a step differ from those of the processor.
    #[error(
        "{adapter} computed other bits than the processor in step {step}, first for particle \
         {particle}; the state before that step is kept"
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
