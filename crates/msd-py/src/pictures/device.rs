//! The graphics device of the process, opened by its first picture.

use crate::errors::error;
use crate::run::lock::forks;
use msd_film::open_gpu;
use msd_render::{Gpu, Offscreen};
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The most sizes whose textures and pipelines are kept.
const MOST: usize = 4;

/// A device and what was prepared to draw by it.
struct Device {
    /// [`forks`] when it was opened: a child has no threads of its driver.
    opened: u32,
    gpu: Gpu,
    /// The size that was used last is the last.
    screens: Vec<([u32; 2], Offscreen)>,
}

static DEVICE: Mutex<Option<Device>> = Mutex::new(None);

/// The device of this process, if it is open. Held by who is attached to Python, and only for a
/// moment: so no fork finds it locked.
fn device(_: Python<'_>) -> MutexGuard<'static, Option<Device>> {
    let mut device = DEVICE.lock().unwrap_or_else(PoisonError::into_inner);
    if device.as_ref().is_some_and(|device| device.opened != forks()) {
        // To close it would wait for threads of the parent.
        std::mem::forget(device.take());
    }
    device
}

/// Opens the device of this process, unless it is open.
pub fn open(py: Python<'_>) -> PyResult<Gpu> {
    if let Some(device) = &*device(py) {
        return Ok(device.gpu.clone());
    }
    let gpu = py.detach(open_gpu).map_err(|reason| error(py, reason))?;
    *device(py) = Some(Device { opened: forks(), gpu: gpu.clone(), screens: Vec::new() });
    Ok(gpu)
}

/// Draws on a screen of a size, pixels, which is kept for the next picture.
pub fn draw_on<T>(
    py: Python<'_>,
    size @ [width, height]: [u32; 2],
    draw: impl FnOnce(&mut Offscreen) -> PyResult<T>,
) -> PyResult<T> {
    let gpu = open(py)?;
    let kept = device(py).as_mut().and_then(|Device { screens, .. }| {
        let place = screens.iter().position(|(of, _)| *of == size)?;
        Some(screens.remove(place).1)
    });
    let made = kept.map_or_else(|| py.detach(|| Offscreen::new(&gpu, width, height)), Ok);
    let mut screen = made.map_err(|reason| error(py, reason))?;
    let drawn = draw(&mut screen)?;
    if let Some(Device { screens, .. }) = &mut *device(py) {
        screens.push((size, screen));
        if MOST < screens.len() {
            screens.remove(0);
        }
    }
    Ok(drawn)
}
