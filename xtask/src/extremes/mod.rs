//! Runs at the extremes: maps with a known answer and a table of hardships, for every method:
//! accurate, bounded, or an error that says so, and never anything else.

pub mod outcome;
pub mod judge;
mod crew;
pub mod oscillator;
pub mod map;
pub mod bodies;
pub mod hardships;
pub mod conduct;
mod colours;
pub mod figure;
pub mod distance;
pub mod tables;
