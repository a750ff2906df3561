//! Reports of studies: one page to open in a browser, a table of numbers, figures. Lesson sheets.
//!
//! ```no_run
//! use msd_study::conduct::{Plan, study};
//! let (studied, _) = study(&msd_scene::open("cloth")?, Plan::default(), &mut ())?;
//! std::fs::write("report.html", msd_report::html(&studied))?;
//! std::fs::write("work-precision.svg", msd_report::svg(&studied))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod units;
pub mod ink;
pub mod pen;
mod raster;
mod labels;
mod figure;
pub mod energy_figure;
mod balance_figure;
mod tables;
mod report;
mod lesson_sheet;

pub use lesson_sheet::lesson_sheet;
pub use report::{csv, drawing, html, png, svg};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
