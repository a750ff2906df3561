//! Rotations of bodies and random axes of spin, the same bits on every machine.

use glam::{DMat3, DVec3};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// The matrix of a turn about an axis of length one, by the right-hand rule (Rodrigues, 1840).
///
/// Sine and cosine come from libm: those of the platform differ in the last bit.
pub(crate) fn rotation(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    let DVec3 { x, y, z } = axis;
    let rest = 1.0 - cos;
    DMat3::from_cols(
        DVec3::new(cos + x * x * rest, y * x * rest + z * sin, z * x * rest - y * sin),
        DVec3::new(x * y * rest - z * sin, cos + y * y * rest, z * y * rest + x * sin),
        DVec3::new(x * z * rest + y * sin, y * z * rest - x * sin, cos + z * z * rest),
    )
}

/// An axis of length one drawn by lot: every direction is equally likely (Archimedes: height on a
/// sphere is uniform).
pub(crate) fn random_axis(seed: u64) -> DVec3 {
    // The stream is the generator's customary one; any fixed number would do.
    let mut lot = Pcg32::new(seed, 0xa02b_dbf7_bb3c_0a7a);
    let mut uniform = || f64::from(lot.next_u32()) / f64::from(u32::MAX);
    let (height, turn) = (2.0 * uniform() - 1.0, std::f64::consts::TAU * uniform());
    let radius = (1.0 - height * height).sqrt();
    let (sin, cos) = libm::sincos(turn);
    DVec3::new(radius * cos, height, radius * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let turned = rotation(DVec3::Z, std::f64::consts::FRAC_PI_2) * DVec3::X;
        assert!((turned - DVec3::Y).length() < 1e-15);
    }

    #[test]
    fn a_turn_keeps_its_axis_and_lengths() {
        let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let turn = rotation(axis, 0.7);
        assert!((turn * axis - axis).length() < 1e-15);
        assert!((turn.determinant() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_random_axis_has_length_one_and_follows_its_seed() {
        for seed in 0..100 {
            assert!((random_axis(seed).length() - 1.0).abs() < 1e-15);
            assert_eq!(random_axis(seed), random_axis(seed));
        }
        assert_ne!(random_axis(1), random_axis(2));
    }
}
