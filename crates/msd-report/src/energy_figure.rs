//! The figure of energy over time: of the reference, and of one trial per method.

use crate::figure::fineness;
use crate::pen::{Axis, Drawn, Pen, Point, Type, WIDTH};
use crate::{ink, labels, units};
use msd_core::Integrator;
use msd_study::Study;
use msd_study::trial::Trial;
use plotters::prelude::{DrawingBackend, RGBColor};

/// Height of the figure, pixels of a page [`WIDTH`] wide.
pub const HEIGHT: f64 = 400.0;
/// Left, top, right and bottom of the ground, pixels.
const GROUND: [f64; 4] = [70.0, 52.0, WIDTH - 236.0, HEIGHT - 48.0];

/// Draws kinetic, elastic and gravitational energy over time.
///
/// # Errors
/// The error of the surface.
pub fn energy_over_time<DB: DrawingBackend>(study: &Study, surface: DB) -> Drawn<DB> {
    let pen = Pen::new(surface, ink::PAPER.light)?;
    let [left, top, right, bottom] = GROUND;
    let shown = chosen(study);
    let last = study.times.iter().copied().filter(|time| time.is_finite()).fold(0.0, f64::max);
    let until = if 0.0 < last { last } else { 1.0 };
    let time = Axis { values: (0.0, until), pixels: (left, right), log: false };
    let energy = Axis { values: extent(study, &shown), pixels: (bottom, top), log: false };
    draw_axes(&pen, &time, &energy)?;
    // The reference lies below the trials: where they cover it they are right.
    draw_course(&pen, &study.times, &study.energies, (&time, &energy), (ink::FRONT.light, 6.0))?;
    let mut names = Vec::new();
    if let Some((end, _)) = end(study, &study.energies, (&time, &energy)) {
        names.push((end, "reference".to_owned(), ink::TEXT.light, ink::FRONT.light));
    }
    for trial in shown {
        let integrator = trial.choice.integrator;
        let (line, text) = (ink::line(integrator).light, ink::name(integrator).light);
        draw_course(&pen, &study.times, &trial.energies, (&time, &energy), (line, 1.8))?;
        let Some(((x, y), off)) = end(study, &trial.energies, (&time, &energy)) else { continue };
        if trial.diverged.is_some() {
            pen.cross((x, y), line)?;
        }
        let said = format!("{integrator}, {}{off}", trial.choice.fineness());
        names.push(((x, y), said, text, line));
    }
    let mut heights: Vec<f64> = names.iter().map(|((_, y), ..)| *y).collect();
    labels::spread(&mut heights, 17.0, (top, bottom));
    for (((x, y), said, text, line), height) in names.into_iter().zip(heights) {
        let leader = [(x.max(right - 2.0) + 4.0, y), (right + 22.0, height)];
        pen.line(&leader, line, 1.0)?;
        pen.words(&said, (right + 27.0, height), Type::new(12.5, text))?;
    }
    pen.finish()
}

/// One trial per method: the one whose error is nearest to the wanted one. Where none stayed in the
/// world, the one that left it last.
pub fn chosen(study: &Study) -> Vec<&Trial> {
    let of = |integrator| {
        let off = |trial: &Trial| (trial.error().max(1e-300) / study.wanted).ln().abs();
        let stayed = study.of(integrator).filter(|trial| trial.errors.is_some());
        let nearest = stayed.min_by(|a, b| off(a).total_cmp(&off(b)));
        let left = study.of(integrator).filter(|trial| !trial.energies.is_empty());
        let longest = |trial: &&Trial| (trial.energies.len(), -fineness(&trial.choice));
        nearest.or_else(|| {
            left.max_by(|a, b| {
                let (a, b) = (longest(a), longest(b));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            })
        })
    };
    Integrator::ALL.into_iter().filter_map(of).collect()
}

/// Least and greatest energy to show: a trial that explodes may not flatten all others.
fn extent(study: &Study, shown: &[&Trial]) -> (f64, f64) {
    let finite = |energies: &[f64]| {
        let sound = energies.iter().copied().filter(|energy| energy.is_finite());
        sound.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), energy| {
            (energy.min(least), energy.max(greatest))
        })
    };
    let (least, greatest) = finite(&study.energies);
    // None is finite: then the greatest is below the least.
    if greatest < least {
        return (0.0, 1.0);
    }
    // Rounding alone must not look like a change of energy.
    let span = (greatest - least).max(1e-3 * greatest.abs().max(least.abs())).max(1e-12);
    let (mut from, mut to) = (least, greatest);
    for trial in shown {
        let (low, high) = finite(&trial.energies);
        from = from.min(low.max(least - span));
        to = to.max(high.min(greatest + span));
    }
    (from - 0.06 * span, to + 0.06 * span)
}

/// The end of a course, and an arrow where that is off the page.
fn end(
    study: &Study,
    energies: &[f64],
    (time, energy): (&Axis, &Axis),
) -> Option<(Point, &'static str)> {
    let rows = study.times.iter().zip(energies).rev();
    let (&at, &value) = rows.into_iter().find(|(_, value)| !value.is_nan())?;
    let (from, to) = energy.values;
    let off = if value < from { " ↓" } else { "" };
    let off = if to < value { " ↑" } else { off };
    Some(((time.at(at), energy.at(value)), off))
}

/// Draws the parts of a course that are on the page.
fn draw_course<DB: DrawingBackend>(
    pen: &Pen<DB>,
    times: &[f64],
    energies: &[f64],
    (time, energy): (&Axis, &Axis),
    (colour, width): (RGBColor, f64),
) -> Drawn<DB> {
    let (from, to) = energy.values;
    // An infinitely distant point leaves the page as a very distant one does.
    let far = 1e3 * (to - from);
    let rows: Vec<Point> = times
        .iter()
        .zip(energies)
        .map(|(&at, &value)| (at, value.clamp(from - far, to + far)))
        .collect();
    let mut piece: Vec<Point> = Vec::new();
    for ends in rows.windows(2) {
        let clipped = clipped([ends[0], ends[1]], energy.values);
        let clipped = clipped.map(|ends| ends.map(|(at, value)| (time.at(at), energy.at(value))));
        match clipped {
            Some([from, to]) if piece.last() == Some(&from) => piece.push(to),
            other => {
                pen.line(&piece, colour, width)?;
                piece = other.map_or(Vec::new(), Vec::from);
            }
        }
    }
    pen.line(&piece, colour, width)
}

/// The part of a line whose heights are in a range.
fn clipped([a, b]: [Point; 2], (low, high): (f64, f64)) -> Option<[Point; 2]> {
    if a.1.max(b.1) < low || high < a.1.min(b.1) || a.1.is_nan() || b.1.is_nan() {
        return None;
    }
    let at = |height: f64| (a.0 + (height - a.1) / (b.1 - a.1) * (b.0 - a.0), height);
    let cut = |end: Point| {
        if end.1 < low {
            at(low)
        } else if high < end.1 {
            at(high)
        } else {
            end
        }
    };
    Some([cut(a), cut(b)])
}

fn draw_axes<DB: DrawingBackend>(pen: &Pen<DB>, time: &Axis, energy: &Axis) -> Drawn<DB> {
    let [left, _, right, bottom] = GROUND;
    let style = Type::new(12.0, ink::MUTED.light);
    let ticks = energy.ticks(5);
    // All marks of an axis in one unit, with enough digits to differ.
    let stride = if let [first, second, ..] = ticks[..] { second - first } else { 1.0 };
    for &tick in &ticks {
        let y = energy.at(tick);
        pen.line(&[(left, y), (right, y)], ink::GRID.light, 1.0)?;
        pen.words(&marked(tick, stride), (left - 8.0, y), style.ending())?;
    }
    let ticks = time.ticks(8);
    let stride = if let [first, second, ..] = ticks[..] { second - first } else { 1.0 };
    for &tick in &ticks {
        let x = time.at(tick);
        pen.line(&[(x, bottom), (x, bottom + 4.0)], ink::GUIDE.light, 1.0)?;
        pen.words(&marked(tick, stride), (x, bottom + 14.0), style.centred())?;
    }
    pen.line(&[(left, bottom), (right, bottom)], ink::GUIDE.light, 1.0)?;
    let title = Type::new(13.0, ink::TEXT.light);
    pen.words("Time, s", (0.5 * (left + right), bottom + 34.0), title.centred())?;
    pen.words("Kinetic, elastic and gravitational energy, J", (8.0, 24.0), title)
}

/// A value on an axis with as many decimals as its stride needs.
fn marked(value: f64, stride: f64) -> String {
    let decimals = -stride.log10().floor();
    let value = if value.abs() < 1e-9 * stride { 0.0 } else { value };
    if (-5.0..=6.0).contains(&decimals) {
        units::grouped(&format!("{value:.*}", decimals.max(0.0) as usize).replace('-', "−"))
    } else {
        units::number(value)
    }
}
