//! Loss of the graphics device: a browser may revoke it at any time, and offer another.

use super::page::{PageEvent, send};
use std::cell::RefCell;
use wasm_bindgen::prelude::wasm_bindgen;

thread_local! {
    static DEVICE: RefCell<Option<wgpu::Device>> = const { RefCell::new(None) };
}

/// Notifies the window when a device is lost, and requests another.
pub(super) fn watch_device(device: &wgpu::Device) {
    // WebGL2 lacks this callback: there the canvas sends an event, which the page passes on.
    device.set_device_lost_callback(|_, _| {
        send(PageEvent::Lost);
        send(PageEvent::Restored);
    });
    DEVICE.set(Some(device.clone()));
}

/// Notifies the window that the canvas has lost its graphics context.
#[wasm_bindgen]
pub fn graphics_lost() {
    send(PageEvent::Lost);
}

/// Notifies the window that the canvas has a graphics context again.
#[wasm_bindgen]
pub fn graphics_restored() {
    send(PageEvent::Restored);
}

/// Destroys the graphics device, for tests.
#[wasm_bindgen]
pub fn lose_device() {
    DEVICE.with_borrow(|device| device.as_ref().map(wgpu::Device::destroy));
}
