//! What is a step compared with, and on which work?

pub mod forces;
pub mod simple;
pub mod terms;
pub mod textbook;
pub mod works;
