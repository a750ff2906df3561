//! Checks of msd itself, no tools for a scene of the user's own: maps of its methods at the
//! extremes, how often tuning is right, the stability table of 2014, the error of coarse beams, and
//! the tables of its pages.
//!
//! `cargo run --release -p xtask -- extremes`, `... -- live-error`, `... -- beam-table` and
//! `... -- stability-table SCENE` run what takes no benchmark; `benches/promise.rs` and
//! `benches/trade.rs` of the root package use the rest.
#![forbid(unsafe_code)]

pub mod marks;
pub mod promise;
pub mod calibration;
pub mod stability_table;
pub mod beam_table;
pub mod extremes;
