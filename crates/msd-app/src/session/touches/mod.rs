//! Settings of colliding bodies.

mod settings;

pub use settings::{TouchEdit, TouchValues, shells_of};
