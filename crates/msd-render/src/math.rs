//! Positions that can be drawn.

use glam::Vec3;

/// The largest coordinate that is drawn, m. The square of a length must stay far from overflow.
const LARGEST: f32 = 1e9;

/// Returns whether a position can be drawn; NaN, infinite and absurdly distant ones cannot.
pub(crate) fn is_drawable(position: Vec3) -> bool {
    // A comparison with NaN is false, so NaN is refused too.
    position.abs().cmple(Vec3::splat(LARGEST)).all()
}

/// The unit vector along `vector`, or `fallback` where there is no direction.
pub(crate) fn direction_or(vector: Vec3, fallback: Vec3) -> Vec3 {
    let largest = vector.abs().max_element();
    if largest.is_finite() && 0.0 < largest {
        // Divided by the largest component first: the square of a tiny vector would vanish.
        (vector / largest).normalize()
    } else {
        fallback
    }
}

/// Two unit vectors that make a right-handed frame (u, v, normal), steady under small turns.
///
/// A horizontal plane gets the world's x and −z, so that its grid follows the world axes.
pub(crate) fn tangents(normal: Vec3) -> (Vec3, Vec3) {
    let helper = if normal.x.abs() < 0.9 { Vec3::X } else { Vec3::NEG_Z };
    let u = direction_or(helper - normal * normal.dot(helper), Vec3::Z);
    (u, normal.cross(u))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_positions_are_not_drawable() {
        assert!(is_drawable(Vec3::new(1.0, -2.0, 1e6)));
        assert!(!is_drawable(Vec3::new(f32::NAN, 0.0, 0.0)));
        assert!(!is_drawable(Vec3::new(0.0, f32::INFINITY, 0.0)));
        assert!(!is_drawable(Vec3::new(0.0, 0.0, -1e30)));
    }

    #[test]
    fn tangents_are_orthonormal_for_any_normal() {
        for normal in [Vec3::Y, Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::new(0.6, 0.8, 0.0)] {
            let (u, v) = tangents(normal);
            // Three roundings of unit-size products: a few times the f32 epsilon.
            assert!(u.dot(v).abs() < 1e-6 && u.dot(normal).abs() < 1e-6);
            assert!((u.cross(v) - normal).length() < 1e-6);
        }
    }

    #[test]
    fn a_vector_without_direction_takes_the_fallback() {
        assert_eq!(direction_or(Vec3::ZERO, Vec3::Y), Vec3::Y);
        assert_eq!(direction_or(Vec3::NAN, Vec3::Y), Vec3::Y);
        assert_eq!(direction_or(Vec3::X * 1e-30, Vec3::Y), Vec3::X);
    }
}
