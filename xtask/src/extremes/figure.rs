//! The figure of a method: two rows of maps, one per precision, with the limit that theory draws.

use crate::extremes::colours;
use crate::extremes::conduct::{Extremes, PRECISIONS};
use crate::extremes::map::{Across, Map};
use crate::extremes::outcome::Outcome;
use msd_core::Integrator;
use msd_report::pen::{Axis, Drawn, Pen, Point, Type};
use msd_report::{drawing, ink, units};
use plotters::prelude::{DrawingBackend, RGBColor};

/// Height of the figure, pixels.
const HEIGHT: f64 = 620.0;
/// Left and top of the first map, pixels.
const CORNER: Point = (74.0, 62.0);
/// Width and height of a map, pixels.
const SIZE: Point = (204.0, 210.0);
/// From one map to the next, pixels.
const STRIDE: Point = (219.0, 226.0);

/// The maps of a method as a drawing.
pub fn svg(extremes: &Extremes, integrator: Integrator) -> String {
    let label = format!("What becomes of a spring under {integrator}");
    drawing(HEIGHT, &label, |surface| {
        // Text refuses nothing.
        let drawn = draw(extremes, integrator, surface);
        debug_assert!(drawn.is_ok());
    })
}

fn draw<DB: DrawingBackend>(extremes: &Extremes, integrator: Integrator, surface: DB) -> Drawn<DB> {
    let pen = Pen::new(surface, ink::PAPER.light)?;
    let title = Type { bold: true, ..Type::new(16.0, ink::TEXT.light) };
    pen.words(integrator.name(), (CORNER.0, 22.0), title)?;
    let said = "two masses on a spring, let go: what 320 steps come to";
    pen.words(said, (CORNER.0 + 172.0, 22.0), Type::new(12.5, ink::MUTED.light))?;
    for (row, precision) in PRECISIONS.into_iter().enumerate() {
        let top = CORNER.1 + row as f64 * STRIDE.1;
        let middle = top + 0.5 * SIZE.1;
        let style = Type::new(13.0, ink::TEXT.light);
        if row == 0 {
            pen.words("Step, s", (8.0, top - 14.0), style)?;
        }
        pen.words(precision.name(), (8.0, middle), Type { bold: true, ..style })?;
        for (column, across) in Across::ALL.into_iter().enumerate() {
            let mut maps = extremes.maps_of(integrator);
            let wanted = |map: &&Map| map.across == across && map.precision == precision;
            if let Some(map) = maps.find(wanted) {
                let left = CORNER.0 + column as f64 * STRIDE.0;
                let chart = Chart::new(map, (left, top));
                chart.draw(&pen, (row == 0, column == 0))?;
            }
        }
    }
    draw_legend(&pen)?;
    pen.finish()
}

/// A map on the page.
struct Chart<'a> {
    map: &'a Map,
    corner: Point,
    /// Size of a cell, pixels.
    cell: Point,
}

impl<'a> Chart<'a> {
    fn new(map: &'a Map, corner: Point) -> Self {
        let cell = (SIZE.0 / map.values.len() as f64, SIZE.1 / map.steps.len() as f64);
        Chart { map, corner, cell }
    }

    fn draw<DB: DrawingBackend>(&self, pen: &Pen<DB>, (titled, marked): (bool, bool)) -> Drawn<DB> {
        (0..self.map.steps.len()).try_for_each(|row| self.draw_row(pen, row))?;
        self.draw_limit(pen)?;
        self.draw_failures(pen)?;
        self.draw_axes(pen, (titled, marked))
    }

    /// Draws neighbours of one colour as one block.
    fn draw_row<DB: DrawingBackend>(&self, pen: &Pen<DB>, row: usize) -> Drawn<DB> {
        let colour = |column| colours::of(self.map.cell(column, row));
        let columns = self.map.values.len();
        let mut from = 0;
        while from < columns {
            let same = |&column: &usize| colour(column) == colour(from);
            let to = (from..columns).take_while(same).last().unwrap_or(from) + 1;
            let y = self.y(row as f64 + 1.0);
            // A little beyond its lower edge, or the ground would show between two rows.
            let lower = self.y(row as f64) + if row == 0 { 0.0 } else { 0.4 };
            pen.block((self.x(from), y), (self.x(to), lower), colour(from))?;
            from = to;
        }
        Ok(())
    }

    fn draw_failures<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn<DB> {
        for row in 0..self.map.steps.len() {
            for column in 0..self.map.values.len() {
                if self.map.cell(column, row).outcome.is_failure() {
                    let middle = (self.x(column) + 0.5 * self.cell.0, self.y(row as f64 + 0.5));
                    pen.cross(middle, ink::PAPER.light)?;
                }
            }
        }
        Ok(())
    }

    /// Draws the largest stable step from theory: white below black, to be seen on any colour.
    fn draw_limit<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn<DB> {
        let Map { steps, limits, .. } = self.map;
        let [Some(&first), Some(&last)] = [steps.first(), steps.last()] else { return Ok(()) };
        let stride = (last / first).log10() / (steps.len() - 1) as f64;
        let mut points: Vec<Point> = Vec::new();
        for (column, &limit) in limits.iter().enumerate() {
            if limit <= 0.0 || limit.is_infinite() {
                continue;
            }
            // A cell stands for the step at its middle.
            let at = (limit / first).log10() / stride + 0.5;
            let x = self.x(column) + 0.5 * self.cell.0;
            if (0.0..=steps.len() as f64).contains(&at) {
                points.push((x, self.y(at)));
            }
        }
        pen.line(&points, ink::PAPER.light, 4.0)?;
        pen.line(&points, ink::TEXT.light, 1.8)
    }

    fn draw_axes<DB: DrawingBackend>(
        &self,
        pen: &Pen<DB>,
        (titled, marked): (bool, bool),
    ) -> Drawn<DB> {
        let (left, top) = self.corner;
        let (right, bottom) = (left + SIZE.0, top + SIZE.1);
        let style = Type::new(11.5, ink::MUTED.light);
        if titled {
            let heading = Type::new(13.0, ink::TEXT.light).centred();
            pen.words(self.map.across.title(), (0.5 * (left + right), top - 14.0), heading)?;
        } else {
            for (column, exponent) in self.decades(&self.map.values, 4) {
                let x = self.x(column) + 0.5 * self.cell.0;
                pen.line(&[(x, bottom), (x, bottom + 4.0)], ink::GUIDE.light, 1.0)?;
                pen.words(&units::power(exponent), (x, bottom + 14.0), style.centred())?;
            }
            if self.map.values.first() == Some(&0.0) {
                let x = self.x(0) + 0.5 * self.cell.0;
                pen.line(&[(x, bottom), (x, bottom + 4.0)], ink::GUIDE.light, 1.0)?;
                pen.words("0", (x, bottom + 14.0), style.centred())?;
            }
        }
        if marked {
            for (row, exponent) in self.decades(&self.map.steps, 5) {
                let y = self.y(row as f64 + 0.5);
                pen.line(&[(left - 4.0, y), (left, y)], ink::GUIDE.light, 1.0)?;
                pen.words(&units::power(exponent), (left - 8.0, y), style.ending())?;
            }
        }
        let frame = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        pen.line(&frame, ink::GUIDE.light, 1.0)
    }

    /// The cells that hold whole powers of ten, at most so many, and the powers.
    fn decades(&self, values: &[f64], most: usize) -> Vec<(usize, i32)> {
        let positive = |value: &&f64| 0.0 < **value;
        let Some(&least) = values.iter().find(positive) else { return Vec::new() };
        let greatest = values.iter().copied().fold(least, f64::max);
        let axis = Axis { values: (least, greatest), pixels: (0.0, 1.0), log: true };
        let near = |tick: units::Tick| {
            let off = |value: f64| (value / tick.value()).ln().abs();
            let cells = values.iter().enumerate().filter(|(_, value)| 0.0 < **value);
            cells.min_by(|a, b| off(*a.1).total_cmp(&off(*b.1))).map(|(row, _)| (row, tick.1))
        };
        axis.decades(most).into_iter().filter_map(near).collect()
    }

    fn x(&self, column: usize) -> f64 {
        self.corner.0 + column as f64 * self.cell.0
    }

    fn y(&self, row: f64) -> f64 {
        self.corner.1 + SIZE.1 - row * self.cell.1
    }
}

fn draw_legend<DB: DrawingBackend>(pen: &Pen<DB>) -> Drawn<DB> {
    let (upper, lower) = (HEIGHT - 58.0, HEIGHT - 30.0);
    let style = Type::new(12.0, ink::TEXT.light);
    pen.words("off by", (CORNER.0, upper), style)?;
    let mut x = CORNER.0 + 52.0;
    for (level, said) in ["≤ 10⁻⁶", "≤ 10⁻⁴", "≤ 1 %", "≤ 10 %"].into_iter().enumerate()
    {
        draw_key(pen, (x, upper), (colours::shade(level), said))?;
        x += 82.0;
    }
    draw_key(
        pen,
        (x, upper),
        (colours::colour(Outcome::Bounded), "of the amplitude; further off, but bounded"),
    )?;
    pen.line(&[(x + 290.0, upper), (x + 316.0, upper)], ink::TEXT.light, 1.8)?;
    pen.words("limit, predicted", (x + 322.0, upper), style)?;
    let mut x = CORNER.0;
    for (outcome, width) in [
        (Outcome::Growing, 150.0),
        (Outcome::Diverged, 125.0),
        (Outcome::Unreachable, 200.0),
        (Outcome::Refused, 90.0),
    ] {
        draw_key(pen, (x, lower), (colours::colour(outcome), outcome.name()))?;
        x += width;
    }
    let failure = "failure: panic, hang, NaN, hidden gain";
    draw_key(pen, (x, lower), (colours::colour(Outcome::Panic), failure))?;
    pen.cross((x + 7.0, lower), ink::PAPER.light)
}

fn draw_key<DB: DrawingBackend>(
    pen: &Pen<DB>,
    (x, y): Point,
    (colour, said): (RGBColor, &str),
) -> Drawn<DB> {
    pen.block((x, y - 7.0), (x + 14.0, y + 7.0), colour)?;
    let frame = [(x, y - 7.0), (x + 14.0, y - 7.0), (x + 14.0, y + 7.0), (x, y + 7.0)];
    pen.line(&[frame[0], frame[1], frame[2], frame[3], frame[0]], ink::GUIDE.light, 1.0)?;
    pen.words(said, (x + 20.0, y), Type::new(12.0, ink::TEXT.light))
}
