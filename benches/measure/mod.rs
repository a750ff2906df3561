//! Measurements behind `docs/measured/performance.md`.

pub mod asked;
pub mod compiler;
pub mod frames;
pub mod machine;
pub mod memory;
pub mod race;
pub mod results;
pub mod threaded;
pub mod rivals;
