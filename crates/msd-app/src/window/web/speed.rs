//! The pace of steps in the page: see [`best_pace`].

use msd_core::Instructions;
use msd_run::pace::best_pace;
use wasm_bindgen::prelude::wasm_bindgen;
use web_time::Instant;

/// Steps a workload for some seconds, and returns the spring updates per second of its best batch.
///
/// # Errors
/// A line on why there is no result.
#[wasm_bindgen]
pub fn measure(work: &str, seconds: f64) -> Result<f64, String> {
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    best_pace(work, Instructions::best(), seconds, &clock).map_err(|error| error.to_string())
}
