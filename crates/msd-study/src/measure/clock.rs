//! A stopwatch of processor time, so that a busy machine does not choose for us.

/// A stopwatch of the time that the processor gave to this thread.
#[derive(Clone, Copy, Debug)]
pub struct CpuClock {
    #[cfg(not(target_arch = "wasm32"))]
    start: cpu_time::ThreadTime,
    #[cfg(target_arch = "wasm32")]
    start: web_time::Instant,
}

impl CpuClock {
    /// The shortest time that it measures to some percent, seconds: that of a browser goes in ticks
    /// of up to a millisecond.
    pub const SURE: f64 = if cfg!(target_arch = "wasm32") { 0.02 } else { 0.0 };

    /// Name of the measured time, in words: a browser does not report CPU time.
    pub const MEASURES: &str = if cfg!(target_arch = "wasm32") { "time" } else { "CPU time" };

    /// Starts the watch; in a browser, which does not report CPU time, it shows wall time.
    pub fn start() -> Self {
        #[cfg(not(target_arch = "wasm32"))]
        let start = cpu_time::ThreadTime::now();
        #[cfg(target_arch = "wasm32")]
        let start = web_time::Instant::now();
        CpuClock { start }
    }

    /// Time since the start, seconds.
    pub fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }
}
