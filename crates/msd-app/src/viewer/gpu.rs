//! The switch to a graphics device: a thread opens and probes it while the window goes on.

use super::Viewer;
use msd_gpu::{Device, Verdict, probe};
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

impl Viewer {
    /// Lets the graphics device take the steps, or the processor.
    pub fn use_gpu(&mut self, is_wanted: bool) {
        if !is_wanted {
            self.session.set_device(None);
            return;
        }
        match &self.gpu {
            GpuSwitch::Open(device) => self.session.set_device(Some((**device).clone())),
            GpuSwitch::Opening(_) => {}
            GpuSwitch::Unknown => {
                let (send, opened) = channel();
                // The window may be closed before it is open.
                thread::spawn(move || drop(send.send(open())));
                self.gpu = GpuSwitch::Opening(opened);
            }
        }
    }

    /// Returns whether the device is being opened, and uses it once it is.
    pub(crate) fn is_gpu_opening(&mut self) -> bool {
        let GpuSwitch::Opening(opened) = &self.gpu else { return false };
        match opened.try_recv() {
            Err(TryRecvError::Empty) => return true,
            Ok(Ok(device)) => {
                self.gpu = GpuSwitch::Open(Box::new(device));
                self.use_gpu(true);
            }
            Ok(Err(reason)) => {
                self.gpu = GpuSwitch::Unknown;
                self.note = Some(reason);
            }
            Err(TryRecvError::Disconnected) => self.gpu = GpuSwitch::Unknown,
        }
        false
    }
}

/// Opens the first device and probes it.
fn open() -> Result<Device, String> {
    let device = pollster::block_on(Device::open("")).map_err(|error| error.to_string())?;
    match pollster::block_on(probe(&device)) {
        Ok(Verdict::SameBits(manner)) => Ok(device.with_manner(manner)),
        Ok(verdict) => Err(format!("{}: {verdict}", device.name())),
        Err(error) => Err(error.to_string()),
    }
}
