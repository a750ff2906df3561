//! Bodies that touch: their settings, and a count of surfaces that cross.

mod crossings;
mod settings;

pub(super) use crossings::CrossingCount;
pub(super) use settings::touch_as;
pub use settings::{TouchEdit, TouchValues, touch_rows, touches_of};
