//! Measurements: the cost of a choice, and its error against a reference.

pub(crate) mod cache;
pub mod clock;
pub mod machine;
pub mod errors;
pub mod reference;
pub mod trial;
