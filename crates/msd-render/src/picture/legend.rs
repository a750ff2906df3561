//! The legend of strain: a small scale with labels in a corner of the picture.

use crate::picture::colour::{bytes, strain_colour};
use crate::picture::text;
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
pub(crate) const SIZE: [f32; 2] = [96.0, 150.0];
const INK: [u8; 4] = [38, 44, 56, 255];
const PAPER: [u8; 4] = [255, 255, 255, 190];

/// Draws the scale from compression to stretch by `full_scale` with `scale` pixels per point.
pub(crate) fn legend(full_scale: f32, scale: f32) -> Vec<Rect> {
    let mut rects = Vec::new();
    let mut add = |area: [f32; 4], lower: [u8; 4], upper: [u8; 4]| {
        rects.push(Rect { area: area.map(|length| length * scale), lower, upper });
    };
    let (left, bottom) = (12.0, 12.0);
    add([left, bottom, SIZE[0], SIZE[1]], PAPER, PAPER);
    let (bar_left, bar_bottom, bar_width, bar_height) = (left + 12.0, bottom + 14.0, 14.0, 100.0);
    let slices = 20;
    for slice in 0..slices {
        let colour =
            |step: i32| bytes(strain_colour(2.0 * step as f32 / slices as f32 - 1.0, 1.0), 1.0);
        let height = bar_height / slices as f32;
        let area = [bar_left, bar_bottom + slice as f32 * height, bar_width, height];
        add(area, colour(slice), colour(slice + 1));
    }
    let mut words = Vec::new();
    for tick in 0..=2 {
        let share = tick as f32 * 0.5;
        let y = bar_bottom + share * bar_height;
        add([bar_left + bar_width, y - 0.5, 4.0, 1.0], INK, INK);
        let text = percent(full_scale * (2.0 * share - 1.0));
        words.push((text, [bar_left + bar_width + 9.0, y - 0.5 * DIGIT * LETTERS]));
    }
    words.push(("strain".to_owned(), [bar_left, bottom + SIZE[1] - 22.0]));
    for (words, at) in words {
        let pixels = text::pixels(&words, LETTERS * scale, at.map(|place| place * scale));
        rects.extend(pixels.into_iter().map(dot));
    }
    rects
}

/// A strain as a person reads it: as few digits as tell the ticks apart.
fn percent(strain: f32) -> String {
    let value = strain * 100.0;
    let size = value.abs();
    if !value.is_finite() {
        "-".to_owned()
    } else if 1e5 <= size || (size < 0.01 && size != 0.0) {
        format!("{value:.0e} %")
    } else if (value - value.round()).abs() < 1e-3 * size.max(1e-3) {
        format!("{value:.0} %")
    } else {
        let digits = if size < 1.0 { 2 } else { 1 };
        format!("{value:.digits$} %")
    }
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

    #[test]
    fn labels_are_short_and_exact_enough() {
        assert_eq!(percent(0.0), "0 %");
        assert_eq!(percent(0.2), "20 %");
        assert_eq!(percent(-0.2), "-20 %");
        assert_eq!(percent(0.025), "2.5 %");
        assert_eq!(percent(0.0005), "0.05 %");
        assert_eq!(percent(1e-6), "1e-4 %");
        assert_eq!(percent(f32::NAN), "-");
    }

    #[test]
    fn the_legend_stays_in_its_area_at_any_scale() {
        for scale in [1.0, 2.0] {
            for rect in legend(0.025, scale) {
                let [left, lower, width, height] = rect.area;
                assert!(12.0 * scale <= left && left + width <= (12.0 + SIZE[0]) * scale);
                assert!(12.0 * scale <= lower && lower + height <= (12.0 + SIZE[1]) * scale);
            }
        }
    }

    #[test]
    fn the_bar_runs_from_the_colour_of_compression_to_that_of_stretch() {
        let rects = legend(0.5, 1.0);
        assert_eq!(rects[1].lower, bytes(strain_colour(-1.0, 1.0), 1.0));
        assert_eq!(rects[11].lower, bytes(strain_colour(0.0, 1.0), 1.0));
        assert_eq!(rects[20].upper, bytes(strain_colour(1.0, 1.0), 1.0));
    }
}
