//! The tables and maps of the pages.

mod beam_table;
mod calibration;
mod commands;
mod extremes;
mod promise;
mod stability_table;
