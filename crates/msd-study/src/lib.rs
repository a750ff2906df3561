//! The cost of accuracy: a scene stepped in many ways, each compared with a reference.
//!
//! Work that takes long reports to a [`Monitor`](monitor::Monitor), which may cancel it.
//!
//! Read in this order: a [`Choice`](choice::Choice) of method, fineness and precision; the
//! [`Reference`](reference::Reference) it is compared with; the [`Trial`](trial::Trial), which is
//! its cost and its [`Errors`](errors::Errors). A [`Study`] is many trials, made by
//! [`conduct`](conduct::study); [`tune`](tune::tune) searches for one choice, and [`sweep`] runs a
//! scene over a grid of its keys. [`lesson`] computes the answers of lessons. [`live_error`]
//! estimates the error of a run while it goes on. [`quantity`] prints errors and costs in
//! sentences.
//!
//! ```
//! use msd_study::tune::{Goal, tune};
//! let scene = msd_scene::open("chain")?.scene;
//! let tuned = tune(&scene, 0.1, Goal::MaxError(0.1), &mut ())?;
//! assert!(tuned.met && tuned.best.trial.error() <= 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod monitor;
mod candidates;
mod measure;
mod behaviour;
pub mod space;
mod study;
pub mod tune;
pub mod live_error;
pub mod lesson;
#[cfg(not(target_arch = "wasm32"))]
pub mod sweep;

pub use behaviour::{audit, inspection, limits, terms};
pub use candidates::{choice, ladder};
pub use measure::{cache, clock, device, errors, machine, reference, trial};
pub use msd_run::quantity;
pub use msd_scene::parts;
pub use study::{OnDevice, ReferenceNote, Study, conduct, words};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
