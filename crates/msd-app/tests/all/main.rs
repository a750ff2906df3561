//! Tests of the command line, and of the window without a display.
//!
//! One binary, as linking takes longer than compiling; `window/` and `readers/` depend on programs
//! that a machine may lack.

#[path = "../common/mod.rs"]
mod common;
mod frames;
mod bench;
mod cli;
mod cli_bad_input;
mod cli_film;
mod cli_keep;
mod cli_outputs;
mod cli_set;
#[cfg(feature = "gpu")]
mod devices;
#[cfg(feature = "gpu")]
mod ensembles;
mod export;
mod files;
mod film;
mod filming;
mod focus;
mod frame_rate;
mod gpu;
mod hands;
mod honesty;
mod left_panel;
mod lessons;
mod links;
mod looks;
mod manners;
mod material_panel;
mod panel;
mod parts;
mod past;
mod phone;
mod readme;
mod recording;
mod session;
mod sides;
mod sweep;
mod touching;
mod trade;
mod trade_panel;
mod viewer;
mod warnings;
