//! Bodies that touch: their settings.

mod settings;

pub(super) use settings::meet_as;
pub use settings::{PairValues, TouchEdit, TouchValues, pairs_of, shells_of};
