//! Runs of a scene: in either precision, with a history, recorded, replayed, side by side.
//!
//! ```
//! let loaded = msd_scene::open("jelly")?;
//! let mut runner = msd_run::Runner::open(&loaded)?;
//! runner.step()?;
//! assert_eq!(runner.particle_count(), 1000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod quantity;
mod crossings;
mod automatic;
mod runner;
mod watch;
mod history;
mod trace;
pub mod live;
pub mod export;
pub mod rescue;
pub mod recording;
pub mod replay;
pub mod twin;
pub mod kept;
pub mod pace;

pub use automatic::{Substeps, steps_between};
pub use crossings::{WentThrough, crossings, steps_between_counts};
pub use history::History;
pub use quantity::EnergyReport;
pub use runner::{Moment, Runner, Touched};
pub use trace::Trace;
pub use watch::{Cells, Finding, Kind, Overturned, Pierced, Piercing, Readings, Watch};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
