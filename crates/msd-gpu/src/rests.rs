//! Yielding to the event loop of a browser during long work, and asynchronous buffer mapping.

use std::future::poll_fn;
use std::sync::{Arc, Mutex};
use std::task::{Poll, Waker};
use std::time::Duration;
use web_time::Instant;

/// Time between two rests.
const MOST: Duration = Duration::from_millis(8);

/// Rests at intervals.
pub struct Rests(Instant);

impl Rests {
    pub fn new() -> Self {
        Rests(Instant::now())
    }

    /// Rests, if the last rest was some milliseconds ago.
    pub async fn rest_if_due(&mut self) {
        if MOST <= self.0.elapsed() {
            rest().await;
            self.0 = Instant::now();
        }
    }
}

/// Does nothing: outside a browser another thread draws frames.
#[cfg(not(target_arch = "wasm32"))]
async fn rest() {}

/// Lets the page respond to what has happened meanwhile.
#[cfg(target_arch = "wasm32")]
async fn rest() {
    use js_sys::{Function, Promise, Reflect, global};
    use wasm_bindgen::{JsCast, JsValue};
    let promise = Promise::new(&mut |resolve, _| {
        let timer = Reflect::get(&global(), &"setTimeout".into());
        let timer = timer.ok().and_then(|timer| timer.dyn_into::<Function>().ok());
        // Every browser has timers; without one there is no rest.
        let is_set = timer.is_some_and(|timer| timer.call1(&JsValue::NULL, &resolve).is_ok());
        if !is_set {
            resolve.call0(&JsValue::NULL).ok();
        }
    });
    wasm_bindgen_futures::JsFuture::from(promise).await.ok();
}

/// Maps a buffer; the future ends when it is mapped or never will be.
pub fn map(buffer: &wgpu::Buffer) -> impl Future<Output = ()> + use<> {
    let state = Arc::new(Mutex::new((false, Waker::noop().clone())));
    let of_callback = state.clone();
    buffer.map_async(wgpu::MapMode::Read, .., move |_| {
        let mut state = of_callback.lock().expect("no panic while it is held");
        state.0 = true;
        state.1.wake_by_ref();
    });
    poll_fn(move |context| {
        let mut state = state.lock().expect("no panic while it is held");
        state.1.clone_from(context.waker());
        if state.0 { Poll::Ready(()) } else { Poll::Pending }
    })
}
