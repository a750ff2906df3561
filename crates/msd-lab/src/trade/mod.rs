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
pub mod study;
