//! The replay of a recording, for a web worker.

use msd_run::recording::read_recording;
use msd_run::replay::Replay;
use msd_scene::schema::SolverRow;
use msd_scene::{saved_bytes, state_hash};
use wasm_bindgen::prelude::wasm_bindgen;

/// Replays the recording of a file called `name`, and returns the bytes of a saved run of its end.
///
/// # Errors
/// A line on why it cannot be read or replayed, or that its last state differs from the recorded
/// one.
#[wasm_bindgen]
pub fn replayed(name: &str, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let recording = read_recording(bytes, name).map_err(|error| error.to_string())?;
    let why = |error: msd_core::Error| format!("{name}: {error}");
    let mut replay = Replay::new(&recording, SolverRow::default()).map_err(why)?;
    while replay.advance().map_err(why)? {}
    let end = replay.runner();
    if recording.hash().is_some_and(|hash| hash != state_hash(&end.state())) {
        return Err(format!("{name}: the last state differs from the recorded one"));
    }
    let start = &recording.start;
    saved_bytes(&end.to_loaded(&start.name, &start.title)).map_err(|error| error.to_string())
}
