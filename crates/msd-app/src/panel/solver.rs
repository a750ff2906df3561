//! By which method is it stepped, and how near is that to the limit of stability?

use super::{heading, slider};
use crate::session::{MOST_SUBSTEPS, Session};
use crate::theme;
use crate::viewer::Viewer;
use egui::{Color32, ComboBox, RichText, Slider, SliderClamping, Ui};
use msd_core::Integrator;
use msd_lab::Precision;

/// Integrator, substeps, precision and the margin.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    heading(ui, "Solver");
    let session = &mut viewer.session;
    integrator(ui, session);
    let mut substeps = session.runner().settings().substeps;
    let widget = Slider::new(&mut substeps, 1..=MOST_SUBSTEPS)
        .logarithmic(true)
        .clamping(SliderClamping::Edits)
        .suffix(" / step");
    if slider(ui, "Substeps", widget).changed() {
        session.set_substeps(substeps);
    }
    precision(ui, session);
    margin(ui, session);
}

fn integrator(ui: &mut Ui, session: &mut Session) {
    ui.horizontal(|ui| {
        let name = super::left_label(ui, "Method");
        let now = session.runner().integrator();
        let combo = ComboBox::from_id_salt("integrator").width(180.0).selected_text(now.name());
        let shown = combo.show_ui(ui, |ui| {
            for integrator in Integrator::ALL {
                if ui.selectable_label(integrator == now, integrator.name()).clicked() {
                    session.set_integrator(integrator);
                }
            }
        });
        shown.response.labelled_by(name.id);
    });
}

fn precision(ui: &mut Ui, session: &mut Session) {
    ui.horizontal(|ui| {
        super::left_label(ui, "Precision");
        let now = session.runner().precision();
        for (precision, hover) in
            [(Precision::F32, "Single, 24 bits"), (Precision::F64, "Double, 53 bits")]
        {
            let label = ui.selectable_label(precision == now, precision.name());
            if label.on_hover_text(hover).clicked() && precision != now {
                session.set_precision(precision);
            }
        }
    });
}

fn margin(ui: &mut Ui, session: &Session) {
    let h = session.runner().settings().substep() * 1e3;
    let (text, colour) = describe(session.margin());
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.label(format!("h = {h:.3} ms"));
        ui.label(RichText::new(text).color(colour))
            .on_hover_text("The longest stable substep is predicted from the fastest motion");
    });
}

fn describe(share: Option<f64>) -> (String, Color32) {
    let Some(share) = share else { return (String::new(), theme::FAINT) };
    let percent = share * 100.0;
    if share == f64::INFINITY {
        ("no step is stable".to_owned(), theme::BAD)
    } else if share == 0.0 {
        ("any step is stable".to_owned(), theme::GOOD)
    } else if 1.0 < share {
        (format!("is {percent:.0} % of the limit"), theme::BAD)
    } else if 0.9 < share {
        (format!("is {percent:.0} % of the limit"), theme::WARN)
    } else {
        (format!("is {percent:.0} % of the limit"), theme::GOOD)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_margin_is_coloured_from_nine_tenths_on() {
        assert_eq!(describe(Some(0.43)), ("is 43 % of the limit".to_owned(), theme::GOOD));
        assert_eq!(describe(Some(0.95)).1, theme::WARN);
        assert_eq!(describe(Some(1.3)).1, theme::BAD);
        assert_eq!(describe(Some(f64::INFINITY)).0, "no step is stable");
        assert_eq!(describe(Some(0.0)).0, "any step is stable");
    }
}
