//! Are two states the same to the last bit? A short number tells.

use crate::runner::AnyState;
use crate::state_file::components;
use msd_core::{Real, State};

/// A hash of positions and velocities: FNV-1a, 64 bits (Fowler, Noll and Vo, 1991), over the
/// little-endian bits of x, y, z, vx, vy, vz of each particle in turn, in their own precision.
///
/// It is the same on every machine and in every version of msd; 0 and −0 differ.
pub fn state_hash(state: &AnyState) -> u64 {
    match state {
        AnyState::F32(state) => hash(state, |value| value.to_le_bytes()),
        AnyState::F64(state) => hash(state, |value| value.to_le_bytes()),
    }
}

fn hash<R: Real, const N: usize>(state: &State<R>, bytes: impl Fn(R) -> [u8; N]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for (&position, &velocity) in state.positions.iter().zip(&state.velocities) {
        let row = [components::<R>(position), components::<R>(velocity)];
        for byte in row.into_iter().flatten().flat_map(&bytes) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    hash
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use msd_core::Vector;

    fn hash_of(xs: &[f32]) -> u64 {
        let vector = |&x: &f32| Vector::of(DVec3::new(x.into(), 0.0, 0.0));
        let positions: Vec<_> = xs.iter().map(vector).collect();
        let velocities = vec![Vector::of(DVec3::ZERO); positions.len()];
        state_hash(&AnyState::F32(State { positions, velocities }))
    }

    #[test]
    fn the_hash_of_nothing_is_the_offset_basis_of_fnv() {
        assert_eq!(hash_of(&[]), 0xcbf2_9ce4_8422_2325);
    }

    #[test]
    fn the_hash_tells_the_last_bit_and_the_sign_of_zero() {
        assert_ne!(hash_of(&[1.0]), hash_of(&[f32::from_bits(1.0f32.to_bits() + 1)]));
        assert_ne!(hash_of(&[0.0]), hash_of(&[-0.0]));
    }
}
