//! Baselines of a step, and the works on which it is measured.

pub mod forces;
pub mod simple;
pub mod terms;
pub mod textbook;
pub mod works;
