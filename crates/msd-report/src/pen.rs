//! A pen that draws lines, polygons, words and axes in pixels of a page, whatever the surface.

use crate::units::Tick;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Width of a figure on a page, pixels.
pub const WIDTH: f64 = 960.0;
/// Letters of the reader's machine.
const FAMILY: &str = "system-ui, -apple-system, Segoe UI, Roboto, Ubuntu, sans-serif";

/// Result of drawing.
pub type Drawn<DB, T = ()> = Result<T, DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// A point on the page, pixels from the upper left corner.
pub type Point = (f64, f64);

/// A pen on a surface [`WIDTH`] wide, of however many dots.
pub struct Pen<DB: DrawingBackend> {
    area: DrawingArea<DB, Shift>,
    dots: f64,
}

/// Setting of words.
#[derive(Clone, Copy)]
pub struct Type {
    /// Height of the letters, pixels.
    pub size: f64,
    /// Their colour.
    pub colour: RGBColor,
    /// Which part of the words is at the point.
    pub anchor: HPos,
    /// Whether they are heavy.
    pub bold: bool,
}

impl Type {
    /// Words that start at their point.
    pub fn new(size: f64, colour: RGBColor) -> Self {
        Type { size, colour, anchor: HPos::Left, bold: false }
    }

    /// Words centred on their point.
    pub fn centred(self) -> Self {
        Type { anchor: HPos::Center, ..self }
    }

    /// Words that end at their point.
    pub fn ending(self) -> Self {
        Type { anchor: HPos::Right, ..self }
    }
}

impl<DB: DrawingBackend> Pen<DB> {
    /// Takes a surface and clears it.
    ///
    /// # Errors
    /// The error of the surface, as for all others here.
    pub fn new(backend: DB, ground: RGBColor) -> Drawn<DB, Self> {
        let dots = f64::from(backend.get_size().0) / WIDTH;
        let area = backend.into_drawing_area();
        area.fill(&ground)?;
        Ok(Pen { area, dots })
    }

    /// Ends the drawing.
    pub fn finish(self) -> Drawn<DB> {
        self.area.present()
    }

    fn dot(&self, (x, y): Point) -> (i32, i32) {
        ((x * self.dots).round() as i32, (y * self.dots).round() as i32)
    }

    /// Draws a line through points.
    pub fn line(&self, points: &[Point], colour: RGBColor, width: f64) -> Drawn<DB> {
        if points.len() < 2 {
            return Ok(());
        }
        let width = (width * self.dots).round().max(1.0) as u32;
        let dots: Vec<_> = points.iter().map(|&point| self.dot(point)).collect();
        self.area.draw(&PathElement::new(dots, colour.stroke_width(width)))
    }

    /// Draws a line of dashes and gaps, pixels, from one point to another.
    pub fn dashes(&self, ends: [Point; 2], dash: (f64, f64), colour: RGBColor) -> Drawn<DB> {
        let [(x, y), (to_x, to_y)] = ends;
        let length = libm::hypot(to_x - x, to_y - y);
        let at = |along: f64| {
            let part = (along / length).min(1.0);
            (x + part * (to_x - x), y + part * (to_y - y))
        };
        let count = (length / (dash.0 + dash.1)).ceil() as usize;
        for start in (0..count).map(|row| row as f64 * (dash.0 + dash.1)) {
            self.line(&[at(start), at(start + dash.0)], colour, 1.2)?;
        }
        Ok(())
    }

    /// Fills a polygon.
    pub fn fill(&self, points: &[Point], colour: RGBColor) -> Drawn<DB> {
        let dots: Vec<_> = points.iter().map(|&point| self.dot(point)).collect();
        self.area.draw(&Polygon::new(dots, colour.filled()))
    }

    /// Fills the box between two corners.
    pub fn block(&self, from: Point, to: Point, colour: RGBColor) -> Drawn<DB> {
        let corners = [self.dot(from), self.dot(to)];
        self.area.draw(&Rectangle::new(corners, colour.filled()))
    }

    /// Draws the outline of a polygon, its inside filled with another colour.
    pub fn shape(&self, points: &[Point], line: RGBColor, inside: RGBColor) -> Drawn<DB> {
        self.fill(points, inside)?;
        let closed: Vec<Point> = points.iter().chain(&points[..2]).copied().collect();
        self.line(&closed, line, 1.5)
    }

    /// Draws a cross.
    pub fn cross(&self, (x, y): Point, colour: RGBColor) -> Drawn<DB> {
        self.line(&[(x - 4.0, y - 4.0), (x + 4.0, y + 4.0)], colour, 1.6)?;
        self.line(&[(x - 4.0, y + 4.0), (x + 4.0, y - 4.0)], colour, 1.6)
    }

    /// Sets words, their middle at the height of the point.
    pub fn words(&self, words: &str, at: Point, style: Type) -> Drawn<DB> {
        // Plotters divides the size by 1.24.
        let font = FontDesc::new(FontFamily::Name(FAMILY), 1.24 * style.size * self.dots, {
            if style.bold { FontStyle::Bold } else { FontStyle::Normal }
        });
        let place = Pos::new(style.anchor, VPos::Center);
        let style = TextStyle::from(font).color(&style.colour).pos(place);
        // A letter that cannot be seen does not belong in a drawing; a line break is a blank there
        // anyway.
        let words: String = words.chars().map(shown).collect();
        self.area.draw_text(&words, &style, self.dot(at))
    }
}

/// A letter, or the sign of one that no document may hold.
pub fn shown(letter: char) -> char {
    match letter {
        '\t' | '\n' | '\r' => ' ',
        '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
        _ => letter,
    }
}

/// Map from values to places on the page.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// The least and the greatest value.
    pub values: (f64, f64),
    /// The places of those, pixels.
    pub pixels: (f64, f64),
    /// Whether equal factors, not equal differences, are equally far apart.
    pub log: bool,
}

impl Axis {
    /// The place of a value, pixels; of one beyond an end, that end.
    pub fn at(&self, value: f64) -> f64 {
        let scale = |value: f64| if self.log { value.log10() } else { value };
        let (from, to) = (scale(self.values.0), scale(self.values.1));
        let part = (scale(value) - from) / (to - from);
        // Not a number only where the value is not: it goes to the end as well.
        let part = if part.is_nan() { 1.0 } else { part.clamp(0.0, 1.0) };
        self.pixels.0 + part * (self.pixels.1 - self.pixels.0)
    }

    /// Returns whether a value is on the axis.
    pub fn holds(&self, value: f64) -> bool {
        self.values.0 <= value && value <= self.values.1
    }

    /// The powers of ten on the axis: where they crowd, every second, third...; where they are
    /// few, twice and five times them as well.
    pub fn decades(&self, most: usize) -> Vec<Tick> {
        let (from, to) = (self.values.0.log10(), self.values.1.log10());
        let (first, last) = ((from - 1e-9).ceil() as i32, (to + 1e-9).floor() as i32);
        let count = (last - first + 1).max(0) as usize;
        if count < 3 {
            let exponents = first - 1..=last;
            let ticks = exponents.flat_map(|exponent| [1, 2, 5].map(|times| Tick(times, exponent)));
            return ticks.filter(|tick| self.holds(tick.value())).collect();
        }
        let stride = count.div_ceil(most.max(1)) as i32;
        let shown = (first..=last).filter(|exponent| exponent % stride == 0);
        shown.map(|exponent| Tick(1, exponent)).collect()
    }

    /// Round values on an axis that is not logarithmic, about so many.
    pub fn ticks(&self, wanted: usize) -> Vec<f64> {
        let (from, to) = self.values;
        let rough = (to - from) / wanted.max(1) as f64;
        let decade = 10f64.powf(rough.log10().floor());
        let round = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * decade);
        let stride = round.into_iter().find(|&stride| rough <= stride).unwrap_or(rough);
        let (first, last) = ((from / stride).ceil(), (to / stride).floor());
        // Values so close that no number separates them have no marks between them.
        if !rough.is_normal() || 100.0 < last - first {
            return Vec::new();
        }
        (0..=(last - first) as usize).map(|row| (first + row as f64) * stride).collect()
    }
}
