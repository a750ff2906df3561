//! Elastic things - cloth, jelly, foam, rope, a bunny - as particles joined by springs and dampers.
//!
//! This package is a thin facade: [`core`] simulates, [`lab`] reads scenes and meshes and writes
//! results, [`render`] draws. The window and the command line are the package `msd-app`.
#![forbid(unsafe_code)]

pub use msd_core as core;
pub use msd_lab as lab;
pub use msd_render as render;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
