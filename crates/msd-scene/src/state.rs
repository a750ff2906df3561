//! Are two states of any precision the same to the last bit?

use crate::runner::AnyState;

/// A hash of positions and velocities, see [`msd_core::state_hash`].
pub fn state_hash(state: &AnyState) -> u64 {
    match state {
        AnyState::F32(state) => msd_core::state_hash(state),
        AnyState::F64(state) => msd_core::state_hash(state),
    }
}
