//! The loss of the graphics device: a browser takes it away when it likes, and gives another.

use super::page::{PageEvent, send};
use std::cell::RefCell;
use wasm_bindgen::prelude::wasm_bindgen;

thread_local! {
    static DEVICE: RefCell<Option<wgpu::Device>> = const { RefCell::new(None) };
}

/// Lets the window know when a device is lost, and asks for another.
pub(super) fn watch_device(device: &wgpu::Device) {
    // WebGL2 has no such word: there the canvas says so, and the page passes it on.
    device.set_device_lost_callback(|_, _| {
        send(PageEvent::Lost);
        send(PageEvent::Restored);
    });
    DEVICE.set(Some(device.clone()));
}

/// Tells the window that the canvas has lost its graphics context.
#[wasm_bindgen]
pub fn graphics_lost() {
    send(PageEvent::Lost);
}

/// Tells the window that the canvas has a graphics context again.
#[wasm_bindgen]
pub fn graphics_restored() {
    send(PageEvent::Restored);
}

/// Destroys the graphics device, as a browser may: for tests.
#[wasm_bindgen]
pub fn lose_device() {
    DEVICE.with_borrow(|device| device.as_ref().map(wgpu::Device::destroy));
}
