//! Colours of bodies and of strain.

/// Colours of bodies, in the order of the bodies, sRGB.
const PALETTE: [[f32; 3]; 8] = [
    [0.20, 0.53, 0.84],
    [0.93, 0.47, 0.29],
    [0.25, 0.66, 0.52],
    [0.87, 0.36, 0.52],
    [0.55, 0.45, 0.80],
    [0.93, 0.70, 0.25],
    [0.30, 0.68, 0.76],
    [0.66, 0.57, 0.45],
];

/// Green, at rest.
const RELAXED: [f32; 3] = [0.16, 0.66, 0.34];
/// Yellow, at half of the full scale.
const TENSE: [f32; 3] = [0.96, 0.78, 0.16];
/// Red, at the full scale and beyond.
const STRAINED: [f32; 3] = [0.88, 0.13, 0.13];

/// Returns the colour of a spring at `strain`, sRGB components from 0 to 1.
///
/// The strain of a spring of length L and rest length l0 is (L − l0) / l0. Green at zero, yellow at
/// half of `full_scale`, red from `full_scale` on; stretched and compressed springs look alike.
/// A strain that is not a number is red, and so is any strain but zero on a scale of zero.
pub fn strain_colour(strain: f32, full_scale: f32) -> [f32; 3] {
    let size = strain.abs();
    if size == 0.0 {
        return RELAXED;
    }
    let share = size / full_scale;
    // Written so that NaN, from a broken strain or scale, ends in red as well.
    if !(0.0..1.0).contains(&share) {
        return STRAINED;
    }
    if share < 0.5 {
        mix(RELAXED, TENSE, smooth(share * 2.0))
    } else {
        mix(TENSE, STRAINED, smooth(share * 2.0 - 1.0))
    }
}

/// Returns the colour of the body with this index, sRGB from 0 to 1; eight colours recur.
pub fn body_colour(index: usize) -> [f32; 3] {
    PALETTE[index % PALETTE.len()]
}

/// Rounds a colour to bytes, with an opacity from 0 to 1.
pub(crate) fn bytes(colour: [f32; 3], opacity: f32) -> [u8; 4] {
    let [red, green, blue] = colour;
    [red, green, blue, opacity].map(|part| (part.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// Mixes two colours: `a` at 0, `b` at 1.
pub(crate) fn mix(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    std::array::from_fn(|part| a[part] + (b[part] - a[part]) * share)
}

/// Half linear, half smoothstep: no visible kink at yellow, yet small strains still show.
fn smooth(x: f32) -> f32 {
    0.5 * x + 0.5 * x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rest_is_green_and_full_scale_is_red() {
        let [red, green, blue] = strain_colour(0.0, 0.2);
        assert!(red < green && blue < green);
        for strain in [0.2, -0.2, 5.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            assert_eq!(strain_colour(strain, 0.2), STRAINED, "at strain {strain}");
        }
        assert_eq!(strain_colour(0.1, 0.2), TENSE);
    }

    #[test]
    fn compression_looks_like_stretch() {
        assert_eq!(strain_colour(-0.07, 0.2), strain_colour(0.07, 0.2));
    }

    #[test]
    fn a_broken_scale_shows_red_for_any_strain_and_green_for_none() {
        for scale in [0.0, -1.0, f32::NAN] {
            assert_eq!(strain_colour(0.1, scale), STRAINED);
            assert_eq!(strain_colour(0.0, scale), RELAXED);
        }
    }

    #[test]
    fn the_gradient_is_continuous_and_redness_grows() {
        let mut before = strain_colour(0.0, 1.0);
        for step in 1..=1000 {
            let colour = strain_colour(step as f32 / 1000.0, 1.0);
            for part in 0..3 {
                // The steepest part rises 0.8 in half the scale, at 1.25 times the mean slope.
                assert!((colour[part] - before[part]).abs() < 0.0025);
            }
            // Red minus green rises all the way: from −0.50 at rest to 0.75 at full scale.
            assert!(before[0] - before[1] <= colour[0] - colour[1] + 1e-6);
            before = colour;
        }
    }

    #[test]
    fn neighbouring_bodies_differ() {
        for index in 0..20 {
            assert_ne!(body_colour(index), body_colour(index + 1));
        }
    }
}
