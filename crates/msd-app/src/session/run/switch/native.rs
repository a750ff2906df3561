//! Opening of a graphics device on a thread.

use std::thread;

/// Runs a future that waits.
pub(super) fn spawn<F: Future<Output = ()>>(make: impl FnOnce() -> F + Send + 'static) {
    thread::spawn(move || pollster::block_on(make()));
}

/// Returns why no graphics device can be opened, if that is known without a try.
pub fn gpu_obstacle() -> Option<&'static str> {
    None
}
