//! Words as the pixels that their letters cover.

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

/// A pixel: its lower left corner, and how much of it is covered, from 0 to 1.
pub(crate) type Pixel = ([f32; 2], f32);

/// Sets words in letters of `size` pixels from a point on their baseline on; y points up.
///
/// The baseline is moved to the next whole pixel, so that level strokes are sharp.
pub(crate) fn pixels(words: &str, size: f32, at: [f32; 2]) -> Vec<Pixel> {
    let Ok(font) = FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR) else {
        return Vec::new();
    };
    // A scale is the height of a line, not of an em.
    let em = font.units_per_em().unwrap_or(1000.0);
    let scale = PxScale::from(size * font.height_unscaled() / em);
    let mut pixels = Vec::new();
    let mut x = at[0];
    for letter in words.chars() {
        let id = font.glyph_id(letter);
        let glyph = id.with_scale_and_position(scale, point(x, -at[1].round()));
        if let Some(outline) = font.outline_glyph(glyph) {
            let corner = outline.px_bounds().min;
            outline.draw(|column, row, cover| {
                let lower = -(corner.y + row as f32 + 1.0);
                pixels.push(([corner.x + column as f32, lower], cover));
            });
        }
        x += font.as_scaled(scale).h_advance(id);
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_stand_on_their_baseline_side_by_side() {
        let ink = |words: &str| {
            let pixels = pixels(words, 16.0, [10.0, 20.0]);
            let inked = pixels.into_iter().filter(|(_, cover)| 0.5 < *cover);
            inked.map(|(at, _)| at).collect::<Vec<_>>()
        };
        let one = ink("1");
        let lowest = one.iter().map(|at| at[1]).fold(f32::INFINITY, f32::min);
        assert_eq!(lowest, 20.0);
        assert!(one.iter().all(|at| 10.0 <= at[0] && at[0] < 20.0), "{one:?}");
        assert_eq!(ink("1 ").len(), one.len());
        assert!(ink("11").iter().any(|at| 20.0 <= at[0]));
        assert!(ink("").is_empty());
    }
}
