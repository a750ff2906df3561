//! The solver: method, substeps or tolerance, precision, and the stability light.

use super::{heading, slider, theme};
use crate::session::{MOST_SUBSTEPS, Session};
use crate::viewer::Viewer;
use egui::{
    Color32, ComboBox, Response, RichText, Sense, Slider, SliderClamping, Stroke, Ui, WidgetInfo,
    vec2,
};
use msd_core::{Integrator, Settings};
use msd_scene::Precision;
use msd_scene::schema::SolverRow;
use msd_study::quantity::{quantity, rounded};
use std::ops::RangeInclusive;

/// Bounds of the tolerance slider, as fractions of the size of the scene.
const TOLERANCES: RangeInclusive<f64> = 1e-10..=1e-1;
/// Bounds of the slider of Newton iterations: in no known case do more of them help.
const NEWTON: RangeInclusive<u32> = 1..=10;

/// Share of the longest stable substep where the meter turns amber.
const AMBER: f64 = 0.8;
/// Full length of the meter, as a share of the longest stable substep.
const FULL: f64 = 1.25;
/// Height of the meter, points.
const METER: f32 = 8.0;

/// Shows method, substeps or tolerance, precision and the stability light.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    heading(ui, "Solver");
    let session = &mut viewer.session;
    integrator(ui, session);
    let method = session.runner().integrator();
    if method.is_adaptive() {
        tolerance(ui, session);
    } else {
        substeps(ui, session);
    }
    if method.is_implicit() {
        newton(ui, session);
    }
    precision(ui, viewer);
    device_checks(ui, &viewer.session);
    stability_light(ui, &viewer.session);
}

fn integrator(ui: &mut Ui, session: &mut Session) {
    let now = session.runner().integrator();
    ui.horizontal(|ui| {
        let name = super::left_label(ui, "Method");
        let combo = ComboBox::from_id_salt("integrator").width(180.0).selected_text(now.name());
        let shown = combo.show_ui(ui, |ui| {
            for integrator in Integrator::ALL {
                let choice = super::listed(ui, integrator == now, integrator.name());
                if choice.on_hover_text(integrator.purpose()).clicked() {
                    session.tune(SolverRow::integrator(integrator));
                }
            }
        });
        shown.response.labelled_by(name.id);
    });
    ui.label(RichText::new(now.purpose()).small().color(theme::FAINT));
}

fn substeps(ui: &mut Ui, session: &mut Session) {
    ui.horizontal(|ui| {
        let mut substeps = session.runner().settings().substeps;
        let mut widget = Slider::new(&mut substeps, 1..=MOST_SUBSTEPS)
            .logarithmic(true)
            .clamping(SliderClamping::Edits);
        if session.runner().is_open() {
            widget = widget.custom_formatter(|_, _| "…".into());
        }
        let hover = "Number of substeps per step";
        if slider(ui, ("Substeps", hover), widget).changed() {
            session.tune(SolverRow::substeps(substeps));
        }
        let mut automatic = session.runner().is_automatic();
        let hover = "Automatic: nine tenths of the longest stable substep (seven if dampers set \
                     it), renewed during the run and after each change; shorter where particles \
                     would tunnel or go far round a solid";
        let response = ui.checkbox(&mut automatic, "auto").on_hover_text(hover);
        let name = "Automatic substeps";
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
        if response.changed() {
            let fixed = SolverRow::substeps(substeps);
            session.tune(if automatic { SolverRow::automatic() } else { fixed });
        }
    });
}

fn tolerance(ui: &mut Ui, session: &mut Session) {
    let mut tolerance = session.runner().settings().tolerance;
    let widget = Slider::new(&mut tolerance, TOLERANCES)
        .logarithmic(true)
        .smallest_positive(*TOLERANCES.start())
        .clamping(SliderClamping::Edits)
        .custom_formatter(|value, _| rounded(value, 2))
        .suffix(" × size");
    let hover = "Error allowed in each substep, relative to the size of the scene.\nIn f32, \
                 rounding limits it to about 1e-5.";
    if slider(ui, ("Tolerance", hover), widget).changed() {
        session.tune(SolverRow::tolerance(tolerance));
    }
}

fn newton(ui: &mut Ui, session: &mut Session) {
    let mut newton = session.runner().settings().newton;
    let unit = if newton == 1 { " iteration" } else { " iterations" };
    let widget = Slider::new(&mut newton, NEWTON).clamping(SliderClamping::Edits).suffix(unit);
    let hover = "Newton iterations per substep: 1 linearizes the forces, which is mostly enough; \
                 more resolve large rotations within a substep";
    if slider(ui, ("Newton", hover), widget).changed() {
        session.tune(SolverRow::newton(newton));
    }
}

fn precision(ui: &mut Ui, viewer: &mut Viewer) {
    ui.horizontal(|ui| {
        super::left_label(ui, "Precision");
        let session = &mut viewer.session;
        let now = session.runner().precision();
        for (precision, hover) in
            [(Precision::F32, "Single, 24 bits"), (Precision::F64, "Double, 53 bits")]
        {
            let label = ui.selectable_label(precision == now, precision.name());
            if label.on_hover_text(hover).clicked() && precision != now {
                session.tune(SolverRow::precision(precision));
            }
        }
        device(ui, viewer);
    });
}

/// Shows the switch to the graphics device.
fn device(ui: &mut Ui, viewer: &mut Viewer) {
    let is_opening = viewer.session.is_gpu_opening();
    let obstacle = viewer.session.gpu_obstacle();
    let device = viewer.session.device();
    let mut is_on = is_opening || device.is_some();
    let name = device.map_or(String::new(), |device| format!("{}. ", device.name()));
    let hover = format!(
        "{name}Steps on the graphics card, with the same bits as the processor. The processor \
         repeats some of the steps and compares"
    );
    let text = if is_opening { "GPU …" } else { "GPU" };
    let widget = egui::Checkbox::new(&mut is_on, text);
    let response = ui.add_enabled(!is_opening && obstacle.is_none(), widget).on_hover_text(hover);
    let response = response.on_disabled_hover_text(obstacle.unwrap_or("msd checks its bits"));
    viewer.layout.landmarks.insert("gpu", response.rect);
    if is_opening {
        // A paused run shows no frames by itself.
        ui.ctx().request_repaint();
    }
    if response.changed() {
        viewer.session.use_gpu(is_on);
    }
}

/// Shows how many steps of the graphics device were checked, if it takes them.
fn device_checks(ui: &mut Ui, session: &Session) {
    let Some(device) = session.device() else { return };
    let tally = device.tally();
    let [checked, steps, left] =
        [tally.checked, tally.device, tally.processor].map(|steps| rounded(steps as f64, 7));
    let text = format!("GPU, same bits ({checked} of {steps} steps checked)");
    let label = ui.label(RichText::new(text).small().color(theme::FAINT));
    label.on_hover_text(format!("It left {left} steps to the processor"));
}

fn stability_light(ui: &mut Ui, session: &Session) {
    let settings = session.runner().settings();
    if settings.integrator.is_adaptive() {
        let hover = "Each substep is as long as its error allows, and ends at every impact";
        let text = RichText::new("the step follows the tolerance").color(theme::GOOD);
        ui.label(text).on_hover_text(hover);
        return;
    }
    let share = session.stability().map(|(share, _)| share);
    let warns = warns(session);
    let (text, colour) = describe(share, warns);
    let hover = if Integrator::EXPLICIT.contains(&settings.integrator) {
        let age = session.stability().map_or(0.0, |(_, age)| age);
        format!(
            "{}The longest stable substep is predicted from the fastest motion, for the state \
             {age:.1} s ago.",
            share
                .filter(|share| warns < *share)
                .map_or(String::new(), |share| advice(settings, share))
        )
    } else {
        "Stable at any step; switch on the error estimate to check the accuracy".to_owned()
    };
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let substep = match session.runner().is_open() {
            true => "…".into(),
            false => quantity(settings.substep(), "s"),
        };
        ui.label(format!("substep {substep}:"));
        ui.label(RichText::new(text).color(colour)).on_hover_text(&hover);
    });
    if share != Some(0.0) {
        meter(ui, share, (colour, warns)).on_hover_text(hover);
    }
}

/// Draws the substep on a scale with the limit at four fifths, with marks where amber and red
/// begin; empty until there is a prediction.
fn meter(ui: &mut Ui, share: Option<f64>, (colour, warns): (Color32, f64)) -> Response {
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), METER), Sense::hover());
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(rect, 2.0, theme::FIELD);
    let x = |share: f64| rect.left() + (share / FULL).min(1.0) as f32 * rect.width();
    let filled = egui::Rect::from_x_y_ranges(rect.left()..=x(share.unwrap_or(0.0)), rect.y_range());
    painter.rect_filled(filled, 2.0, colour);
    for (mark, width) in [(warns, 1.0), (1.0, 2.0)] {
        painter.vline(x(mark), rect.y_range(), Stroke::new(width, theme::TEXT));
    }
    let name = "Stability";
    response.widget_info(|| WidgetInfo::labeled(egui::Role::ProgressIndicator, true, name));
    response
}

/// Returns advice on how to make the meter green. The limit is proportional to the root of mass
/// over stiffness if springs set it, and to mass over damping if dampers do.
fn advice(settings: Settings, share: f64) -> String {
    if share <= AMBER {
        return String::new();
    }
    if share == f64::INFINITY {
        return "Unstable with any number of substeps: choose another method. ".to_owned();
    }
    let substeps = (f64::from(settings.substeps) * share / AMBER).ceil();
    let heavier = share / AMBER;
    format!(
        "For a green meter: {} substeps, or masses {} times as large if springs set the limit \
         ({} times if dampers do), or stiffness or damping smaller by the same factor, or an \
         implicit method. ",
        rounded(substeps, 7),
        rounded(heavier * heavier, 2),
        rounded(heavier, 2)
    )
}

/// Returns the share of the longest stable substep where the meter turns amber: automatic substeps
/// should be close to the limit.
fn warns(session: &Session) -> f64 {
    if session.runner().is_automatic() { 1.0 } else { AMBER }
}

/// Describes the substep of a session relative to the longest stable one, and returns a colour.
pub(super) fn light(session: &Session) -> (String, Color32) {
    describe(session.stability().map(|(share, _)| share), warns(session))
}

/// Describes a substep relative to the longest stable one; `warns` is where amber begins.
fn describe(share: Option<f64>, warns: f64) -> (String, Color32) {
    let Some(share) = share else { return ("predicting…".to_owned(), theme::FAINT) };
    let colour = match share {
        _ if 1.0 < share => theme::BAD,
        _ if warns < share => theme::WARN,
        _ => theme::GOOD,
    };
    let text = match share {
        0.0 => "any step is stable".to_owned(),
        f64::INFINITY => "no step is stable".to_owned(),
        _ if 10.0 < share => format!("{} × the stable limit", rounded(share, 2)),
        _ => format!("{:.0} % of the stable limit", 100.0 * share),
    };
    (text, colour)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_light_changes_from_four_fifths_on() {
        let describe = |share| super::describe(share, AMBER);
        assert_eq!(describe(Some(0.43)), ("43 % of the stable limit".to_owned(), theme::GOOD));
        assert_eq!(describe(None), ("predicting…".to_owned(), theme::FAINT));
        assert_eq!(describe(Some(0.85)).1, theme::WARN);
        assert_eq!(super::describe(Some(0.9), 1.0).1, theme::GOOD);
        assert_eq!(describe(Some(1234.0)).0, "1234 × the stable limit");
        assert_eq!(describe(Some(1.3)).1, theme::BAD);
        assert_eq!(describe(Some(f64::INFINITY)).0, "no step is stable");
        assert_eq!(describe(Some(0.0)).0, "any step is stable");
    }

    #[test]
    fn the_advice_takes_the_meter_to_green() {
        let settings = Settings { substeps: 10, ..Settings::default() };
        assert_eq!(advice(settings, 0.8), "");
        let told = advice(settings, 1.6);
        assert!(told.contains("20 substeps") && told.contains("masses 4 times"), "{told}");
        assert!(advice(settings, f64::INFINITY).contains("another method"));
    }

    #[test]
    fn the_purpose_of_every_method_fits_into_a_line() {
        for integrator in Integrator::ALL {
            assert!(integrator.purpose().chars().count() <= 50, "{integrator}");
        }
    }
}
