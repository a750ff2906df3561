//! Opening of a graphics device in a page of a browser, between its frames.

use js_sys::{Reflect, global};

/// Runs a future whenever something that it awaits is there.
pub(super) fn spawn<F: Future<Output = ()> + 'static>(make: impl FnOnce() -> F) {
    wasm_bindgen_futures::spawn_local(make());
}

/// Returns why no graphics device can be opened, if that is known without a try.
pub fn gpu_obstacle() -> Option<&'static str> {
    let navigator = Reflect::get(&global(), &"navigator".into());
    let gpu = navigator.and_then(|navigator| Reflect::get(&navigator, &"gpu".into()));
    let is_there = gpu.is_ok_and(|gpu| !gpu.is_undefined());
    (!is_there).then_some("WebGPU is not available in this browser: the processor takes the steps")
}
