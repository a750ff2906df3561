//! Colours of bodies and of quantities.

use crate::viewing::quantity::Scale;
use msd_core::Body;
pub use msd_core::PALETTE;

/// Blue, at the full scale of compression and beyond; grey, at rest; red, at that of stretch. Blue
/// and red differ for colour-blind eyes too, and springs that are not at rest are darker.
const COMPRESSED: [f32; 3] = [0.08, 0.33, 0.72];
const RELAXED: [f32; 3] = [0.72, 0.72, 0.70];
const STRETCHED: [f32; 3] = [0.80, 0.16, 0.10];
/// Between grey and either end, so that small strains show.
const PRESSED: [f32; 3] = [0.38, 0.60, 0.85];
const PULLED: [f32; 3] = [0.93, 0.55, 0.35];
/// Colour of NaN.
const BROKEN: [f32; 3] = [0.85, 0.0, 0.75];
/// From little to much: dark to light, so that it reads without its hues.
const LITTLE: [f32; 3] = [0.16, 0.20, 0.50];
const SOME: [f32; 3] = [0.78, 0.32, 0.45];
const MUCH: [f32; 3] = [0.99, 0.86, 0.36];

/// Returns the colour of a spring at `strain`, sRGB components from 0 to 1.
///
/// The strain of a spring of length L and rest length l0 is (L − l0) / l0. Grey at zero, ever more
/// red up to `full_scale` when stretched, ever more blue down to −`full_scale` when compressed.
/// A strain or a scale that is not a number is purple; on a scale of zero any strain is full.
pub fn strain_colour(strain: f32, full_scale: f32) -> [f32; 3] {
    if strain.is_nan() || full_scale.is_nan() || full_scale < 0.0 {
        return BROKEN;
    }
    let [half, full] = if strain < 0.0 { [PRESSED, COMPRESSED] } else { [PULLED, STRETCHED] };
    if strain == 0.0 {
        return RELAXED;
    }
    between([RELAXED, half, full], strain.abs() / full_scale)
}

/// Returns the colour of a value on a scale, sRGB components from 0 to 1: that of a strain where
/// the quantity has two directions, else that of a share.
pub fn scale_colour(scale: Scale, value: f32) -> [f32; 3] {
    match scale.quantity.is_signed() {
        true => strain_colour(value, scale.full),
        false => share_colour(value / scale.full),
    }
}

/// Returns the colour of a share of a full scale, such as an error or a speed, sRGB components from
/// 0 to 1: dark at 0, light from 1 on. NaN is purple.
pub fn share_colour(share: f32) -> [f32; 3] {
    if share.is_nan() { BROKEN } else { between([LITTLE, SOME, MUCH], share) }
}

/// The colour at a share of the way through three.
fn between([first, middle, last]: [[f32; 3]; 3], share: f32) -> [f32; 3] {
    let share = share.clamp(0.0, 1.0);
    match share < 0.5 {
        true => mix(first, middle, share * 2.0),
        false => mix(middle, last, share * 2.0 - 1.0),
    }
}

/// Returns the colour of a body by its look, or by its kind and its place among the bodies, sRGB
/// from 0 to 1; eight colours recur.
pub fn body_colour(index: usize, body: &Body) -> [f32; 3] {
    body.look.colour_at(index, &body.surface)
}

/// Returns the colour of the other side of a body that is a sheet, sRGB from 0 to 1: that of its
/// look, or a lighter shade.
pub fn back_colour(index: usize, body: &Body) -> [f32; 3] {
    body.look.back.unwrap_or_else(|| lighter(body_colour(index, body)))
}

/// A lighter shade of a colour.
pub(crate) fn lighter(colour: [f32; 3]) -> [f32; 3] {
    mix(colour, [1.0; 3], 0.25)
}

/// Rounds a colour to bytes, with an opacity from 0 to 1.
pub(crate) fn bytes(colour: [f32; 3], opacity: f32) -> [u8; 4] {
    let [red, green, blue] = colour;
    [red, green, blue, opacity].map(|part| (part.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// Mixes two colours: `a` at 0, `b` at 1.
pub(crate) fn mix(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    std::array::from_fn(|part| a[part] * (1.0 - share) + b[part] * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretch_is_red_compression_blue_and_rest_grey() {
        let [red, green, blue] = strain_colour(0.0, 0.2);
        assert!((red - green).abs() < 0.03 && (green - blue).abs() < 0.03);
        for strain in [0.2, 5.0, f32::INFINITY] {
            assert_eq!(strain_colour(strain, 0.2), STRETCHED, "at strain {strain}");
            assert_eq!(strain_colour(-strain, 0.2), COMPRESSED, "at strain -{strain}");
        }
        assert_eq!(strain_colour(0.1, 0.2), PULLED);
        assert_eq!(strain_colour(-0.1, 0.2), PRESSED);
        assert_eq!(strain_colour(f32::NAN, 0.2), BROKEN);
    }

    #[test]
    fn a_scale_of_zero_shows_any_strain_in_full_and_a_broken_one_is_told() {
        assert_eq!(strain_colour(0.1, 0.0), STRETCHED);
        assert_eq!(strain_colour(-0.1, 0.0), COMPRESSED);
        assert_eq!(strain_colour(0.0, 0.0), RELAXED);
        for scale in [-1.0, f32::NAN] {
            assert_eq!(strain_colour(0.1, scale), BROKEN);
        }
    }

    /// The luminance of a colour, 0 to 1: its brightness without hue.
    fn luminance(colour: [f32; 3]) -> f32 {
        let linear = colour.map(|part| part.powf(2.2));
        0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    }

    #[test]
    fn strain_runs_from_blue_to_red_without_a_jump_and_gets_darker_from_rest() {
        let mut before = strain_colour(-1.0, 1.0);
        for step in -999..=1000 {
            let colour = strain_colour(step as f32 / 1000.0, 1.0);
            for part in 0..3 {
                // The steepest part falls 0.43 in half a scale of 500 steps.
                assert!((colour[part] - before[part]).abs() < 0.0012);
            }
            // Red minus blue rises all the way: from -0.64 to 0.70.
            assert!(before[0] - before[2] <= colour[0] - colour[2] + 1e-6);
            let darker = if step <= 0 { [before, colour] } else { [colour, before] };
            assert!(luminance(darker[0]) <= luminance(darker[1]) + 1e-6, "at {step}");
            before = colour;
        }
    }

    #[test]
    fn a_larger_share_is_lighter() {
        for step in 0..1000 {
            let [less, more] = [step, step + 1].map(|step| share_colour(step as f32 / 1000.0));
            assert!(luminance(less) < luminance(more));
        }
        assert_eq!(share_colour(7.0), MUCH);
        assert_eq!(share_colour(f32::NAN), BROKEN);
    }

    #[test]
    fn neighbouring_bodies_differ() {
        let body = Body::default();
        for index in 0..20 {
            assert_ne!(body_colour(index, &body), body_colour(index + 1, &body));
        }
    }
}
