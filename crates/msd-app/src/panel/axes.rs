//! Plots that the pointer does not move, with ticks that have a number and a unit.

use egui::{Rangef, Sense};
use egui_plot::{AxisHints, GridInput, GridMark, Plot};
use msd_study::quantity::rounded;
use std::ops::RangeInclusive;

/// The part of the time axis, at its end, where half of a number would be out of the panel.
const ROOM: f64 = 0.1;

/// A plot that the pointer does not move; it is a picture, so that the keyboard passes it by.
pub(super) fn still_plot(name: &'static str) -> Plot<'static> {
    let plot = Plot::new(name).allow_drag(false).allow_zoom(false).allow_scroll(false);
    plot.allow_boxed_zoom(false).allow_double_click_reset(false).sense(Sense::hover())
}

/// A plot over time, seconds; `words` tells a number of the other axis.
pub(super) fn plot_over_time<'a>(
    name: &'static str,
    words: impl Fn(f64) -> String + 'a,
) -> Plot<'a> {
    still_plot(name)
        .show_x(false)
        .show_y(false)
        .set_margin_fraction(egui::vec2(0.0, 0.12))
        .x_grid_spacer(ticks)
        .y_grid_spacer(ticks)
        .custom_x_axes(vec![axis(
            AxisHints::new_x(),
            |time| format!("{} s", rounded(time, 3)),
            ROOM,
        )])
        .custom_y_axes(vec![axis(AxisHints::new_y(), words, 0.0).min_thickness(54.0)])
}

/// An axis whose ticks have words, but for those in a last part of it.
fn axis<'a>(hints: AxisHints<'a>, words: impl Fn(f64) -> String + 'a, room: f64) -> AxisHints<'a> {
    let number = move |mark: GridMark, range: &RangeInclusive<f64>| {
        let left = range.end() - mark.value;
        let is_cut = left < room * (range.end() - range.start());
        if is_cut { String::new() } else { words(mark.value) }
    };
    // Points between ticks from which on numbers are shown, faint and in full.
    hints.formatter(number).label_spacing(Rangef::new(12.0, 18.0))
}

/// Ticks at multiples of 1, 2 or 5 times a power of ten: as few as can be, but two at least.
fn ticks(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let span = high - low;
    if !span.is_finite() || span <= 0.0 {
        return Vec::new();
    }
    let power = 10f64.powf((span / 2.0).log10().floor());
    let steps = [5.0, 2.0].map(|part| part * power);
    let step_size = steps.into_iter().find(|step| 2.0 * step <= span).unwrap_or(power);
    let rows = (low / step_size).ceil() as i64..=(high / step_size).floor() as i64;
    rows.map(|row| GridMark { value: row as f64 * step_size, step_size }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_has_ticks_whatever_its_bounds() {
        for bounds in [(0.0, 12.0), (-3.0, 0.4), (999.0, 1001.0), (-1e9, 7e8), (0.0, 1e-7)] {
            let marks = ticks(GridInput { bounds, base_step_size: 1.0 });
            assert!((2..=6).contains(&marks.len()), "{bounds:?}: {marks:?}");
            assert!(marks.iter().all(|mark| (bounds.0..=bounds.1).contains(&mark.value)));
        }
        assert!(ticks(GridInput { bounds: (1.0, 1.0), base_step_size: 1.0 }).is_empty());
    }
}
