//! What does a scene cost, and how wrong is it? Trials of a scene against a reference, and what
//! follows from them: studies, tuning, audits.

pub mod cache;
pub mod choice;
pub mod clock;
pub mod errors;
pub mod reference;
pub mod trial;
pub mod audit;
pub mod limits;
pub mod ladder;
pub mod study;
pub mod terms;
pub mod stability_table;
pub mod words;
pub mod machine;
pub mod conduct;
mod slope;
pub mod tune;
pub mod promise;
pub mod estimate;
pub(crate) mod units;
pub mod ink;
pub mod pen;
mod raster;
mod labels;
pub mod figure;
pub mod energy_figure;
mod tables;
pub mod report;
