//! States of either precision, and their hash.

use msd_core::State;

/// A state in the precision of its run.
#[derive(Clone, Debug, PartialEq)]
pub enum AnyState {
    /// Single precision.
    F32(State<f32>),
    /// Double precision.
    F64(State<f64>),
}

/// A hash of positions and velocities, see [`msd_core::state_hash`].
pub fn state_hash(state: &AnyState) -> u64 {
    match state {
        AnyState::F32(state) => msd_core::state_hash(state),
        AnyState::F64(state) => msd_core::state_hash(state),
    }
}
