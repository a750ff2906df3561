//! Figures as pictures of pixels, drawn three times too large, then averaged; the letters come with
//! the program, so that a machine without fonts sets the same.

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};
use plotters::style::text_anchor::HPos;
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
    FontStyle,
};
use std::convert::Infallible;

/// Dots per pixel of the picture, each way.
const OVERSAMPLING: u32 = 3;

type Outcome = Result<(), DrawingErrorKind<Infallible>>;

/// A surface of opaque dots.
pub struct Raster<'a> {
    dots: &'a mut [[u8; 3]],
    size: (u32, u32),
}

/// Draws on a picture of a size in pixels and returns its rows, red, green, blue.
pub fn picture(size: (u32, u32), draw: impl FnOnce(Raster<'_>)) -> Vec<u8> {
    let fine = (size.0 * OVERSAMPLING, size.1 * OVERSAMPLING);
    let mut dots = vec![[255; 3]; fine.0 as usize * fine.1 as usize];
    draw(Raster { dots: &mut dots, size: fine });
    let mut pixels = Vec::with_capacity(3 * size.0 as usize * size.1 as usize);
    for y in 0..size.1 {
        for x in 0..size.0 {
            let mut sum = [0u32; 3];
            for row in y * OVERSAMPLING..(y + 1) * OVERSAMPLING {
                let from = (row * fine.0 + x * OVERSAMPLING) as usize;
                for dot in &dots[from..from + OVERSAMPLING as usize] {
                    (0..3).for_each(|channel| sum[channel] += u32::from(dot[channel]));
                }
            }
            pixels.extend(sum.map(|sum| (sum / (OVERSAMPLING * OVERSAMPLING)) as u8));
        }
    }
    pixels
}

impl DrawingBackend for Raster<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Outcome {
        Ok(())
    }

    fn present(&mut self) -> Outcome {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Outcome {
        let (width, height) = (self.size.0 as i32, self.size.1 as i32);
        if (0..width).contains(&x) && (0..height).contains(&y) {
            let dot = &mut self.dots[y as usize * width as usize + x as usize];
            let (red, green, blue) = colour.rgb;
            for (channel, new) in dot.iter_mut().zip([red, green, blue]) {
                let old = f64::from(*channel);
                *channel = (old + colour.alpha * (f64::from(new) - old)).round() as u8;
            }
        }
        Ok(())
    }

    /// Draws with a round brush: the joints of plotters' own thick lines show.
    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Outcome {
        let points: Vec<BackendCoord> = path.into_iter().collect();
        let radius = 0.5 * f64::from(style.stroke_width());
        for ends in points.windows(2) {
            let (dx, dy) = (f64::from(ends[1].0 - ends[0].0), f64::from(ends[1].1 - ends[0].1));
            let count = (1.0 + libm::hypot(dx, dy)).ceil() as i32;
            for step in 0..=count {
                let part = f64::from(step) / f64::from(count);
                let at = (f64::from(ends[0].0) + part * dx, f64::from(ends[0].1) + part * dy);
                self.stamp(at, radius, style.color())?;
            }
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        at: BackendCoord,
    ) -> Outcome {
        let size = style.size() / 1.24;
        let shift = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => 0.5,
            HPos::Right => 1.0,
        };
        let mut x = f64::from(at.0) - shift * width(text, size);
        // Half the height of an x below the middle, as browsers do it.
        let baseline = f64::from(at.1) + 0.26 * size;
        // The letters are light: they are struck twice, heavy ones four times.
        let strikes = if matches!(style.style(), FontStyle::Bold) { 4 } else { 2 };
        for letter in text.chars() {
            for strike in 0..strikes {
                let off = f64::from(strike) * 0.025 * size;
                self.letter(letter, size, (x + off, baseline), style.color())?;
            }
            x += advance(letter, size);
        }
        Ok(())
    }
}

impl Raster<'_> {
    fn stamp(&mut self, (x, y): (f64, f64), radius: f64, colour: BackendColor) -> Outcome {
        let reach =
            |centre: f64| (centre - radius).ceil() as i32..=(centre + radius).floor() as i32;
        for row in reach(y) {
            for column in reach(x) {
                let (dx, dy) = (f64::from(column) - x, f64::from(row) - y);
                if dx * dx + dy * dy <= radius * radius {
                    self.draw_pixel((column, row), colour)?;
                }
            }
        }
        Ok(())
    }

    fn letter(
        &mut self,
        letter: char,
        size: f64,
        (x, y): (f64, f64),
        colour: BackendColor,
    ) -> Outcome {
        let Some(font) = font(letter) else { return Ok(()) };
        let glyph = font
            .glyph_id(letter)
            .with_scale_and_position(scale(&font, size), point(x as f32, y as f32));
        let Some(outline) = font.outline_glyph(glyph) else { return Ok(()) };
        let corner = outline.px_bounds().min;
        let mut dots = Vec::new();
        outline.draw(|x, y, cover| {
            dots.push(((corner.x as i32 + x as i32, corner.y as i32 + y as i32), cover));
        });
        for (dot, cover) in dots {
            let alpha = colour.alpha * f64::from(cover.clamp(0.0, 1.0));
            self.draw_pixel(dot, BackendColor { alpha, ..colour })?;
        }
        Ok(())
    }
}

/// Width of words set in letters of a size, in the same unit.
pub fn width(text: &str, size: f64) -> f64 {
    text.chars().map(|letter| advance(letter, size)).sum()
}

/// Words cut so that they are no wider than `room`.
pub fn fitted(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.into();
    }
    let mut used = width("…", size);
    let fits = |letter: &char| {
        used += advance(*letter, size);
        used <= room
    };
    let kept: String = text.chars().take_while(fits).collect();
    kept + "…"
}

fn advance(letter: char, size: f64) -> f64 {
    let Some(font) = font(letter) else { return 0.6 * size };
    let id = font.glyph_id(letter);
    f64::from(font.as_scaled(scale(&font, size)).h_advance(id))
}

/// The scale at which an em of a font is `size` dots.
fn scale(font: &FontRef<'_>, size: f64) -> PxScale {
    let em = font.units_per_em().unwrap_or(1000.0);
    PxScale::from(size as f32 * font.height_unscaled() / em)
}

/// The font that has a letter: Hack knows the raised digits that Ubuntu lacks.
fn font(letter: char) -> Option<FontRef<'static>> {
    let load = |bytes| FontRef::try_from_slice(bytes).ok();
    let ubuntu = load(epaint_default_fonts::UBUNTU_LIGHT)?;
    if ubuntu.glyph_id(letter).0 != 0 {
        return Some(ubuntu);
    }
    load(epaint_default_fonts::HACK_REGULAR)
}

/// Rows of pixels, red, green, blue, as a file.
pub fn png((width, height): (u32, u32), pixels: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    // Memory refuses nothing.
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels));
    debug_assert!(written.is_ok());
    file
}
