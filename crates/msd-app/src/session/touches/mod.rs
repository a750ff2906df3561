//! Bodies that touch: their settings, and a count of surfaces that cross.

mod crossings;
mod settings;

pub(super) use crossings::CrossingCount;
pub(super) use settings::meet_as;
pub use settings::{PairValues, TouchEdit, TouchValues, pairs_of, shells_of};
