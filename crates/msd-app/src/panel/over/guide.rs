//! The tour in a corner of the 3D view: the sentence of the current step.

use crate::panel::theme;
use crate::viewer::{GuideStep, Viewer};
use egui::{Align2, Area, Frame, RichText, Ui, vec2};
use std::time::Duration;

/// Width of the sentence, points.
const WIDTH: f32 = 250.0;

/// Shows the tour, if it is open.
pub(super) fn show(ui: &Ui, viewer: &mut Viewer) {
    let Some(mut guide) = viewer.layout.guide else { return };
    let real = f64::from(ui.input(|input| input.unstable_dt));
    if let Some(left) = guide.follow(&viewer.session, real) {
        ui.ctx().request_repaint_after(Duration::from_secs_f64(left));
    }
    viewer.layout.guide = Some(guide);
    let at = viewer.layout.rect.right_bottom() - vec2(14.0, 14.0);
    let area = Area::new(egui::Id::unique("guide")).fixed_pos(at).pivot(Align2::RIGHT_BOTTOM);
    let mut is_over = false;
    area.show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).fill(theme::PANEL).inner_margin(10.0).show(ui, |ui| {
            ui.set_width(WIDTH.min(viewer.layout.rect.width() - 50.0));
            let count = GuideStep::ALL.len();
            let (title, text, button) = match guide.text() {
                Some(text) => (format!("{} of {count}", guide.done() + 1), text, "Skip the tour"),
                None => {
                    let text = "That is the trade-off: a longer step is cheaper and less accurate, \
                                until it blows up. Help (F1) lists the controls.";
                    ("Done".to_owned(), text, "Close the tour")
                }
            };
            ui.label(RichText::new(title).small().color(theme::FAINT));
            ui.label(text);
            is_over = ui.button(button).clicked();
        });
    });
    if is_over {
        viewer.end_guide();
    }
}
