//! Elastic things - cloth, jelly, foam, rope, a bunny - as particles joined by springs and dampers.
//!
//! This package is a thin facade: [`core`] simulates, [`scene`] reads scene files, meshes and saved
//! runs, [`run`] steps what was read and records it, [`study`] measures what accuracy costs,
//! [`report`] shows that on a page. With the feature `render`, `msd::render` draws, and with the
//! feature `gpu`, `msd::gpu` steps on a graphics card. The window and the command line are the
//! package `msd-app`.
#![forbid(unsafe_code)]

pub use msd_core as core;
#[cfg(feature = "gpu")]
pub use msd_gpu as gpu;
#[cfg(feature = "render")]
pub use msd_render as render;
pub use msd_report as report;
pub use msd_run as run;
pub use msd_scene as scene;
pub use msd_study as study;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(doctest)]
#[doc = include_str!("../docs/tutorial/first-program.md")]
struct FirstProgram;
