//! Plots without pan or zoom, with tick labels that have a number and a unit.

use egui::{Rangef, Sense};
use egui_plot::{AxisHints, GridInput, GridMark, Plot};
use msd_study::quantity::rounded;
use std::ops::RangeInclusive;

/// Share of the time axis, at its end, where a label would be cut off by the edge of the panel.
const ROOM: f64 = 0.1;

/// Returns a plot without pan or zoom; keyboard focus skips it.
pub(super) fn still_plot(name: &'static str) -> Plot<'static> {
    let plot = Plot::new(name).allow_drag(false).allow_zoom(false).allow_scroll(false);
    plot.allow_boxed_zoom(false).allow_double_click_reset(false).sense(Sense::hover())
}

/// Returns a plot over time, seconds; `words` formats a number of the other axis.
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

/// Returns an axis with formatted tick labels, except in a share `room` at its end.
fn axis<'a>(hints: AxisHints<'a>, words: impl Fn(f64) -> String + 'a, room: f64) -> AxisHints<'a> {
    let number = move |mark: GridMark, range: &RangeInclusive<f64>| {
        let left = range.end() - mark.value;
        let is_cut = left < room * (range.end() - range.start());
        if is_cut { String::new() } else { words(mark.value) }
    };
    // Distances between ticks, points, at which labels appear faint and in full.
    hints.formatter(number).label_spacing(Rangef::new(9.0, 12.0))
}

/// Returns ticks at multiples of 1, 2 or 5 times a power of ten: as few as possible, at least two.
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
