//! The switch to a graphics device: a thread opens and probes it while the window goes on.

use msd_gpu::{Device, probe};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

/// The graphics device of the window, as far as it is known.
#[derive(Debug, Default)]
pub enum GpuSwitch {
    /// Nobody has asked for it.
    #[default]
    Unknown,
    /// A thread opens and probes it.
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
                thread::spawn(move || drop(send.send(open())));
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
fn open() -> Result<Device, String> {
    let device = pollster::block_on(Device::open("")).map_err(|error| error.to_string())?;
    let verdict = pollster::block_on(probe(&device)).map_err(|error| error.to_string())?;
    let manner = verdict.manner().ok_or_else(|| format!("{}: {verdict}", device.name()))?;
    Ok(device.with_manner(manner))
}
