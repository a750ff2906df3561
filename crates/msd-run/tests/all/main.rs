//! Runs, recordings, saved runs and exports.

mod automatic;
mod builtin_scenes;
mod crossings;
mod gltf_files;
mod gripper;
mod guided_pins;
mod overturned;
mod piercing;
mod recordings;
mod rescue;
mod saved_runs;
mod state_files;
mod touching_scenes;
mod watch;
mod went_through;
mod workloads;
