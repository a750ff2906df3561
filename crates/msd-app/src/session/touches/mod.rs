//! Bodies that touch: their settings.

mod settings;

pub use settings::{TouchEdit, TouchValues, shells_of};
