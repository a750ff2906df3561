//! Hash of a state, to compare runs to the last bit.

use crate::number::{Real, Vector};
use crate::system::state::State;

/// A hash of positions and velocities: FNV-1a, 64 bits (Fowler, Noll and Vo, 1991), over the
/// little-endian bits of x, y, z, vx, vy, vz of each particle in turn, in their own precision.
///
/// It is the same on every machine and in every version of msd; 0 and −0 differ. A row that only
/// one column has is left out.
pub fn state_hash<R: Real>(state: &State<R>) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for (position, velocity) in state.positions.iter().zip(&state.velocities) {
        let row = [position.components(), velocity.components()];
        for byte in row.into_iter().flatten().flat_map(R::to_le_bytes) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    hash
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;
    use glam::DVec3;

    fn hash_of<R: Real>(x: R) -> u64 {
        let position = R::Vec3::of(DVec3::new(x.to_f64(), 0.0, 0.0));
        state_hash::<R>(&State { positions: vec![position], velocities: vec![R::Vec3::ZERO] })
    }

    #[test]
    fn the_hash_of_nothing_is_the_offset_basis_of_fnv() {
        assert_eq!(state_hash::<f32>(&State::default()), 0xcbf2_9ce4_8422_2325);
    }

    #[test]
    fn the_hash_tells_the_last_bit_the_sign_of_zero_and_the_precision() {
        assert_ne!(hash_of(1.0f32), hash_of(f32::from_bits(1.0f32.to_bits() + 1)));
        assert_ne!(hash_of(1.0f64), hash_of(f64::from_bits(1.0f64.to_bits() + 1)));
        assert_ne!(hash_of(0.0f32), hash_of(-0.0f32));
        assert_ne!(hash_of(1.0f32), hash_of(1.0f64));
    }
}
