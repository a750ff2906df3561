//! The switch to a graphics device, which is opened and probed while the window goes on.

#[cfg(not(target_arch = "wasm32"))]
mod native;
#[cfg(target_arch = "wasm32")]
mod web;

#[cfg(not(target_arch = "wasm32"))]
pub use native::gpu_obstacle;
#[cfg(target_arch = "wasm32")]
pub use web::gpu_obstacle;

use msd_gpu::{Device, probe};
#[cfg(not(target_arch = "wasm32"))]
use native::spawn;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
#[cfg(target_arch = "wasm32")]
use web::spawn;

/// The graphics device of the window, as far as it is known.
#[derive(Debug, Default)]
pub enum GpuSwitch {
    /// Nobody has asked for it.
    #[default]
    Unknown,
    /// It is being opened and probed.
    Opening(Receiver<Result<Device, String>>),
    /// It computes the bits of the processor.
    Open(Box<Device>),
}

impl GpuSwitch {
    /// The device, if it is open; otherwise begins to open it.
    pub(in crate::session) fn ask(&mut self) -> Option<Device> {
        if matches!(self, GpuSwitch::Open(device) if device.is_lost()) {
            *self = GpuSwitch::Unknown;
        }
        match self {
            GpuSwitch::Open(device) => return Some((**device).clone()),
            GpuSwitch::Opening(_) => {}
            GpuSwitch::Unknown => {
                let (send, opened) = channel();
                // The window may be closed before it is open.
                spawn(move || async move { drop(send.send(open().await)) });
                *self = GpuSwitch::Opening(opened);
            }
        }
        None
    }

    /// Returns whether the device is being opened.
    pub(in crate::session) fn is_opening(&self) -> bool {
        matches!(self, GpuSwitch::Opening(_))
    }

    /// The device that was opened since the last call, or why it cannot be used.
    pub(in crate::session) fn opened(&mut self) -> Option<Result<Device, String>> {
        let GpuSwitch::Opening(opened) = self else { return None };
        let opened = match opened.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err("the graphics driver has failed".to_owned()),
            Ok(opened) => opened,
        };
        *self = match &opened {
            Ok(device) => GpuSwitch::Open(Box::new(device.clone())),
            Err(_) => GpuSwitch::Unknown,
        };
        Some(opened)
    }
}

/// Opens the first device and probes it.
async fn open() -> Result<Device, String> {
    let device = Device::open("").await.map_err(|error| error.to_string())?;
    let verdict = probe(&device).await.map_err(|error| error.to_string())?;
    let manner = verdict.manner().ok_or_else(|| format!("{}: {verdict}", device.name()))?;
    Ok(device.with_manner(manner))
}
