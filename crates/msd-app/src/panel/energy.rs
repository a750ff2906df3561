//! The energy plot, and its legend with the present values.

use super::{heading, theme};
use crate::session::{Sample, TRACE_WINDOW as WINDOW};
use crate::viewer::Viewer;
use egui::{Color32, RichText, Ui};
use egui_plot::{Line, Plot, PlotPoints};
use msd_core::Energy;
use msd_study::quantity::{estimate, quantity};

/// A curve: its name, its colour, and how it is read.
type Curve = (&'static str, Color32, fn(&Energy) -> f64);

const CURVES: [Curve; 5] = [
    ("kinetic", Color32::from_rgb(90, 160, 240), |energy| energy.kinetic),
    ("elastic", Color32::from_rgb(110, 196, 132), |energy| energy.elastic),
    ("gravity", Color32::from_rgb(180, 140, 230), |energy| energy.gravitational),
    ("dissipated", Color32::from_rgb(240, 150, 90), |energy| energy.dissipated),
    ("total", Color32::from_rgb(225, 228, 235), Energy::total),
];

/// The plot and its legend with the present values.
pub(super) fn show(ui: &mut Ui, viewer: &Viewer) {
    heading(ui, "Energy");
    let session = &viewer.session;
    let (now, trace) = (session.runner().time(), session.trace());
    let largest = trace.samples().map(magnitude).fold(0.0, f64::max);
    let (unit, scale) = unit(largest);
    let height = (ui.available_height() - 48.0).clamp(110.0, 220.0);
    Plot::new("energy")
        .height(height)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .show_x(false)
        .show_y(false)
        .set_margin_fraction(egui::vec2(0.0, 0.06))
        .y_axis_min_width(34.0)
        .default_x_bounds((now - WINDOW).max(0.0), now.max(WINDOW))
        .show(ui, |plot| {
            for (name, colour, value) in CURVES {
                let point = |sample: &Sample| [sample.time, value(&sample.energy) / scale];
                let points: PlotPoints<'_> = trace.samples().map(point).collect();
                plot.line(Line::new(name, points).color(colour).width(1.5));
            }
            plot.set_plot_bounds_x((now - WINDOW).max(0.0)..=now.max(WINDOW));
        });
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        for (name, colour, value) in CURVES {
            // Space that does not break: a name and its number stay together.
            let value = session.energy().map(|energy| short(value(&energy) / scale));
            let text = format!("{name}\u{a0}{}", value.as_deref().unwrap_or(theme::VOID));
            ui.label(RichText::new(text).small().color(colour));
        }
        ui.label(RichText::new(format!("{unit}, over time in s")).small().color(theme::FAINT));
        let imbalance = session.energy_imbalance().map(|change| estimate(change, "J"));
        let text = format!("by error\u{a0}{}", imbalance.as_deref().unwrap_or(theme::VOID));
        let hover = "The change of the total since the run was changed or handled last: what the \
                     method and its contacts got wrong";
        ui.label(RichText::new(text).small().color(theme::TEXT)).on_hover_text(hover);
        if let Some(gain) = session.energy_gain() {
            let text = format!("{} added by the integrator", quantity(gain, "J"));
            ui.label(RichText::new(text).small().color(theme::BAD));
        }
    });
}

/// With a fixed number of decimals, so that the legend keeps still while it runs.
fn short(value: f64) -> String {
    if value.abs() < 1e5 { format!("{value:.1}") } else { format!("{value:.1e}") }
}

fn magnitude(sample: &Sample) -> f64 {
    CURVES.iter().map(|(_, _, value)| value(&sample.energy).abs()).fold(0.0, f64::max)
}

/// The unit in which a value has at most four digits before the point, and that unit in joules.
fn unit(largest: f64) -> (&'static str, f64) {
    let units = [("mJ", 1e-3), ("J", 1.0), ("kJ", 1e3), ("MJ", 1e6), ("GJ", 1e9)];
    let fits = |&&(_, scale): &&(&str, f64)| largest < 2e3 * scale;
    *units.iter().find(fits).unwrap_or(&("TJ", 1e12))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_keeps_numbers_short() {
        assert_eq!(unit(0.3).0, "mJ");
        assert_eq!(unit(1500.0).0, "J");
        assert_eq!(unit(98_200.0).0, "kJ");
        assert_eq!(unit(f64::INFINITY).0, "TJ");
    }
}
