//! Internal checks of msd, not tools for a user's scene: maps of its methods at the extremes, the
//! success rate of tuning, the stability table of 2014, the error of coarse beams, and the tables
//! of its pages.
//!
//! `cargo run --release -p xtask -- extremes`, `... -- live-error`, `... -- beam-table` and `... --
//! stability-table SCENE` run all that needs no benchmark; `benches/promise.rs` and
//! `benches/trade.rs` of the root package use the rest.
#![forbid(unsafe_code)]

pub mod marks;
pub mod promise;
pub mod calibration;
pub mod stability_table;
pub mod beam_table;
pub mod extremes;
