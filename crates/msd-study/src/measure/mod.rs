//! Measurements: the cost of a choice, and its error against a reference.

pub mod cache;
pub mod clock;
pub mod device;
pub mod machine;
pub mod errors;
pub mod reference;
pub mod trial;
