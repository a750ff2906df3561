//! The legend: a small scale of colours with numbers in a corner of the picture.

use crate::picture::colour::{bytes, scale_colour};
use crate::picture::text;
use crate::viewing::quantity::Scale;
use bytemuck::{Pod, Zeroable};

/// A rectangle over the picture; the layout of `overlay.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Rect {
    /// Left and lower edge, width and height, pixels from the lower left corner of the picture.
    pub area: [f32; 4],
    /// Colour and opacity at the lower edge, sRGB.
    pub lower: [u8; 4],
    /// Colour and opacity at the upper edge, sRGB.
    pub upper: [u8; 4],
}

/// Size of the letters, points.
const LETTERS: f32 = 13.0;
/// Height of a digit, a fraction of the size of its letters.
const DIGIT: f32 = 0.73;
/// Size of the whole legend, points.
pub(crate) const SIZE: [f32; 2] = [104.0, 150.0];
const INK: [u8; 4] = [38, 44, 56, 255];
const PAPER: [u8; 4] = [255, 255, 255, 190];

/// Draws a scale with so many pixels per point.
pub(crate) fn legend(of: Scale, scale: f32) -> Vec<Rect> {
    let mut rects = Vec::new();
    let mut add = |area: [f32; 4], lower: [u8; 4], upper: [u8; 4]| {
        rects.push(Rect { area: area.map(|length| length * scale), lower, upper });
    };
    let (left, bottom) = (12.0, 12.0);
    add([left, bottom, SIZE[0], SIZE[1]], PAPER, PAPER);
    let (bar_left, bar_bottom, bar_width, bar_height) = (left + 12.0, bottom + 14.0, 14.0, 100.0);
    let slices = 20;
    for slice in 0..slices {
        let colour = |step: i32| {
            let value = of.value(step as f32 / slices as f32);
            bytes(scale_colour(of, value), 1.0)
        };
        let height = bar_height / slices as f32;
        let area = [bar_left, bar_bottom + slice as f32 * height, bar_width, height];
        add(area, colour(slice), colour(slice + 1));
    }
    let mut words = Vec::new();
    for (share, text) in of.ticks() {
        let y = bar_bottom + share * bar_height;
        add([bar_left + bar_width, y - 0.5, 4.0, 1.0], INK, INK);
        words.push((text, [bar_left + bar_width + 9.0, y - 0.5 * DIGIT * LETTERS]));
    }
    words.push((of.title(), [bar_left, bottom + SIZE[1] - 22.0]));
    for (words, at) in words {
        let pixels = text::pixels(&words, LETTERS * scale, at.map(|place| place * scale));
        rects.extend(pixels.into_iter().map(dot));
    }
    rects
}

/// A pixel of a letter.
fn dot(([left, lower], cover): text::Pixel) -> Rect {
    let [red, green, blue, _] = INK;
    let ink = [red, green, blue, (255.0 * cover).round() as u8];
    Rect { area: [left, lower, 1.0, 1.0], lower: ink, upper: ink }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::colour::{share_colour, strain_colour};
    use crate::viewing::quantity::Quantity;

    #[test]
    fn the_legend_stays_in_its_area_at_any_scale() {
        let legends = Quantity::ALL.iter().flat_map(|&quantity| {
            [-29, -4, -2, 0, 4].map(|power| Scale { quantity, full: 5.0 * 10f32.powi(power) })
        });
        for (of, scale) in legends.flat_map(|of| [(of, 1.0), (of, 2.0)]) {
            for rect in legend(of, scale) {
                let [left, lower, width, height] = rect.area;
                assert!(12.0 * scale <= left && left + width <= (12.0 + SIZE[0]) * scale);
                assert!(12.0 * scale <= lower && lower + height <= (12.0 + SIZE[1]) * scale);
            }
        }
    }

    #[test]
    fn the_bar_runs_from_the_colour_of_compression_to_that_of_stretch() {
        let rects = legend(Scale { quantity: Quantity::Strain, full: 0.5 }, 1.0);
        assert_eq!(rects[1].lower, bytes(strain_colour(-1.0, 1.0), 1.0));
        assert_eq!(rects[11].lower, bytes(strain_colour(0.0, 1.0), 1.0));
        assert_eq!(rects[20].upper, bytes(strain_colour(1.0, 1.0), 1.0));
    }
    #[test]
    fn the_bar_of_what_has_one_direction_runs_from_nothing_to_much() {
        let rects = legend(Scale { quantity: Quantity::Speed, full: 5.0 }, 1.0);
        assert_eq!(rects[1].lower, bytes(share_colour(0.0), 1.0));
        assert_eq!(rects[20].upper, bytes(share_colour(1.0), 1.0));
    }
}
