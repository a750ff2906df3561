//! The diagram of error against cost: the trials, the Pareto front as a line, the current setting
//! as a ring.

use crate::panel::axes::still_plot;
use crate::panel::theme;
use egui::{Color32, Rangef, RichText, Ui};
use egui_plot::{
    AxisHints, GridInput, GridMark, HLine, HoverPosition, Line, LineStyle, MarkerShape, Points,
};
use msd_core::Integrator;
use msd_scene::Precision;
use msd_study::Study;
use msd_study::choice::{Choice, FRAME};
use msd_study::clock::CpuClock;
use msd_study::quantity::{estimate, rounded};
use msd_study::trial::Trial;
use msd_study::words::told;

/// Returns the colour of a method, the same as in a report on a dark background.
pub(super) fn colour(integrator: Integrator) -> Color32 {
    let (red, green, blue) = match integrator {
        Integrator::ExplicitEuler => (150, 150, 151),
        Integrator::SymplecticEuler => (240, 173, 30),
        Integrator::VelocityVerlet => (60, 155, 215),
        Integrator::Rk4 => (235, 120, 40),
        Integrator::DormandPrince => (220, 140, 184),
        Integrator::BackwardEuler => (110, 195, 242),
        Integrator::ImplicitMidpoint => (30, 180, 138),
        Integrator::Xpbd => (184, 172, 60),
        _ => (160, 168, 176),
    };
    Color32::from_rgb(red, green, blue)
}

/// Shows the measured methods, each in its colour.
pub(super) fn legend(ui: &mut Ui, study: &Study) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        for method in Integrator::ALL {
            if study.of(method).any(|trial| trial.errors.is_some()) {
                ui.label(RichText::new(method.name()).small().color(colour(method)));
            }
        }
        ui.label(RichText::new("open = f32, filled = f64").small().color(theme::FAINT));
    });
}

/// Shows the diagram; empty axes before the first trial.
pub(super) fn show(ui: &mut Ui, study: Option<&Study>, now: Option<Choice>) {
    let trials = study.map_or(&[][..], |study| &study.trials);
    let names: Vec<String> = trials.iter().map(told).collect();
    let hover = |position: &HoverPosition<'_>| match position {
        HoverPosition::NearDataPoint { plot_name, position, .. } => Some(format!(
            "{plot_name}\nerror {}, {} per frame",
            estimate(10f64.powf(position.y), "m"),
            estimate(1e-3 * 10f64.powf(position.x), "s")
        )),
        HoverPosition::Elsewhere { .. } => None,
    };
    let plot = still_plot("error against cost")
        .set_margin_fraction(egui::vec2(0.06, 0.08))
        .x_grid_spacer(decades)
        .y_grid_spacer(decades)
        .custom_x_axes(vec![
            axis(AxisHints::new_x(), |value| rounded(value, 1))
                .label(format!("{} per frame (ms)", CpuClock::MEASURES)),
        ])
        .custom_y_axes(vec![
            axis(AxisHints::new_y(), |value| estimate(value, "m"))
                .label("error")
                .min_thickness(52.0),
        ])
        .label_formatter(hover);
    plot.show(ui, |plot| {
        let Some(study) = study else { return };
        let least = study.reference.uncertainty;
        if 0.0 < least && trials.iter().any(|trial| trial.error() < 30.0 * least) {
            let line = HLine::new("uncertainty of the reference", least.log10());
            plot.hline(line.color(theme::LINE).style(LineStyle::dashed_loose()));
        }
        let at = |trial| place(trial, least);
        let front = study.front().into_iter().map(|row| at(&trials[row]));
        let line = Line::new("Pareto front", front.collect::<Vec<_>>());
        plot.line(line.color(theme::FAINT).width(1.5).allow_hover(false));
        for (trial, name) in trials.iter().zip(&names) {
            if trial.errors.is_none() {
                continue;
            }
            let points = Points::new(name.clone(), vec![at(trial)]);
            let points = points.color(colour(trial.choice.integrator)).radius(3.2);
            plot.points(points.filled(trial.choice.precision == Precision::F64));
        }
        let now = now.and_then(|now| trials.iter().find(|trial| trial.choice == now));
        if let Some(trial) = now.filter(|trial| trial.errors.is_some()) {
            let ring = Points::new(format!("current: {}", told(trial)), vec![at(trial)]);
            let ring = ring.shape(MarkerShape::Circle).filled(false).radius(8.0);
            plot.points(ring.color(Color32::WHITE));
        }
    });
}

/// Returns a logarithmic axis with formatted tick labels.
fn axis(hints: AxisHints<'_>, words: fn(f64) -> String) -> AxisHints<'_> {
    // Distances between ticks, points, at which labels appear faint and in full.
    let hints = hints.label_spacing(Rangef::new(9.0, 14.0));
    hints.formatter(move |mark, _| words(10f64.powf(mark.value)))
}

/// Returns the coordinates of a trial: decades of milliseconds per frame, and of metres, at least
/// the uncertainty of the reference.
fn place(trial: &Trial, least: f64) -> [f64; 2] {
    // With an exact reference, an error may be zero, which has no logarithm.
    [(1e3 * FRAME * trial.cost).log10(), trial.error().max(least).max(1e-18).log10()]
}

/// Returns lines at every power of ten, and at 2 and 5 times it if there is space.
fn decades(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let mut marks = Vec::new();
    for decade in low.floor() as i32..=high.ceil() as i32 {
        let value = f64::from(decade);
        marks.push(GridMark { value, step_size: 1.0 });
        if high - low < 4.0 {
            let between = [2f64, 5.0].map(|part| value + part.log10());
            marks.extend(between.map(|value| GridMark { value, step_size: 0.3 }));
        }
    }
    marks.retain(|mark| (low..=high).contains(&mark.value));
    marks
}
