//! Fuzz targets of msd: any bytes are refused in one line, or give results that are finite and in
//! range.
//!
//! Each module is one target: a function `check` that panics where msd breaks that promise. It is
//! called by libFuzzer (`fuzz_targets/`, `scripts/fuzz.sh`) and, by a compiler without it, in
//! `crates/msd-run/tests/rehearsal.rs`, which includes this file: modules name each other by
//! `super`. To add a target, write a module, a row of [`TARGETS`], a file in `fuzz_targets/`, a
//! `[[bin]]` in `Cargo.toml` and a folder of seeds in `corpus/`.
#![forbid(unsafe_code)]

mod promise;
mod numbers;
pub mod world;
pub mod interactions;
pub mod meshes;
pub mod runs;
pub mod scenes;
pub mod states;

/// A check of any bytes.
pub type Check = fn(&[u8]);

/// Every target with its name, which is that of its folder in `corpus/`.
pub const TARGETS: [(&str, Check); 5] = [
    ("scenes", scenes::check),
    ("states", states::check),
    ("meshes", meshes::check),
    ("runs", runs::check),
    ("interactions", interactions::check),
];
