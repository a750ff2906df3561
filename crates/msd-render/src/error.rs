//! Errors between a snapshot and a picture.

/// Reasons why a picture cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// No graphics driver, not even a software one.
    #[error(
        "no graphics adapter found; on Debian/Ubuntu install a software one: \
         apt install mesa-vulkan-drivers"
    )]
    NoAdapter(#[source] wgpu::RequestAdapterError),
    /// The adapter gave no device.
    #[error("the graphics adapter {adapter} gave no device: {source}")]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        /// The error of wgpu.
        source: wgpu::RequestDeviceError,
    },
    /// The window gave no surface to draw on.
    #[error("the window cannot be drawn on: {0}")]
    NoSurface(#[from] wgpu::CreateSurfaceError),
    /// The size of the picture is out of its domain.
    #[error("picture size is {width}x{height}; each side must be from 1 to {limit} pixels")]
    Size {
        /// Width asked for, pixels.
        width: u32,
        /// Height asked for, pixels.
        height: u32,
        /// The largest side of this device, pixels.
        limit: u32,
    },
    /// The picture would not fit into one buffer of the device.
    #[error("picture size is {width}x{height}, {bytes} bytes; a buffer may have {limit} bytes")]
    Memory {
        /// Width asked for, pixels.
        width: u32,
        /// Height asked for, pixels.
        height: u32,
        /// Size of the picture with padded rows, bytes.
        bytes: u64,
        /// The largest buffer of this device, bytes.
        limit: u64,
    },
    /// The picture was drawn but did not come back from the device.
    #[error("the picture could not be read back: {0}")]
    ReadBack(String),
}
