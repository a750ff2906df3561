//! The live estimate of the error: a switch, and the estimate in words.

use super::theme;
use crate::session::{ErrorNow, ErrorReading, Session};
use crate::viewer::Viewer;
use egui::{Checkbox, Color32, RichText, Ui, vec2};
use msd_render::Quantity;
use msd_run::on;
use msd_study::quantity::{estimate, rounded};

/// Age up to which an estimate counts as fresh, simulated seconds.
const FRESH: f64 = 4.0;

/// Height of the text, at most three lines, points.
const HEIGHT: f32 = 44.0;

/// Explanation of the estimate.
const METHOD: &str = "For half a second at a time, a copy of the run steps along in double \
                      precision with twice the substeps (adaptive methods: a hundredth of the \
                      tolerance). Their distance at the end estimates the error made in that \
                      time (step doubling). It costs about three quarters as much as the run \
                      itself. In nine of ten windows of built-in and generated scenes the true \
                      error is between a third and three times the estimate \
                      (docs/measured/trade.md).";
/// Factor within which nine of ten estimates are correct.
const BAND: f64 = 3.0;

/// Shows the switch, and the last estimate.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let mut on = viewer.session.error().is_some();
    ui.horizontal(|ui| {
        let estimate = ui.checkbox(&mut on, "Estimate error").on_hover_text(METHOD);
        viewer.layout.landmarks.insert("estimate", estimate.rect);
        if estimate.changed() {
            viewer.session.set_estimating(on);
        }
        let mut coloured = viewer.style.colour_by == Some(Quantity::Error);
        let hover = "Surfaces and particles coloured by error, dark to light; body colours until \
                     there is an estimate";
        let colour = Checkbox::new(&mut coloured, "Colour by error");
        let colour = ui.add_enabled(on, colour).on_hover_text(hover);
        if colour.changed() || (coloured && !on) {
            viewer.colour_by((coloured && on).then_some(Quantity::Error));
        }
    });
    if !on {
        return;
    }
    // At full height: the controls below must not move when the text changes.
    ui.allocate_ui(vec2(ui.available_width(), HEIGHT), |ui| {
        ui.set_min_height(HEIGHT);
        if let Some((text, colour)) = describe(&viewer.session) {
            ui.label(RichText::new(text).small().color(colour)).on_hover_text(METHOD);
        }
    });
}

/// Describes the estimate; `None` while it is off.
fn describe(session: &Session) -> Option<(String, Color32)> {
    let last = match session.error()? {
        ErrorNow::Measuring => return Some(("measuring…".to_owned(), theme::FAINT)),
        ErrorNow::Lost => {
            return Some(("no estimate: the finer copy diverged".to_owned(), theme::FAINT));
        }
        ErrorNow::Known(last) => last,
    };
    let size = on!(session.runner(), simulation => simulation.model().size());
    let colour = if is_fresh(session, last) { theme::TEXT } else { theme::FAINT };
    Some((sentence(last, size), colour))
}

/// Returns whether an estimate is recent.
pub(super) fn is_fresh(session: &Session, reading: &ErrorReading) -> bool {
    session.runner().time() - reading.error.at <= FRESH
}

/// Describes an estimate; `size` is that of the scene, metres.
fn sentence(reading: &ErrorReading, size: f64) -> String {
    let (particle, error) = reading.worst;
    let over = rounded(reading.error.over, 2);
    if error == 0.0 {
        // As in a scene at rest, or with an adaptive method whose substeps fill whole steps.
        return format!(
            "error over the last {over} s: none, the finer copy ended in the same state"
        );
    }
    if reading.error.rms <= reading.error.rounding {
        return format!(
            "error over the last {over} s: less than {}, the rounding of the coordinates",
            estimate(reading.error.rounding, "m")
        );
    }
    format!(
        "error over the last {over} s: {}, likely {} to {} ({} of the size); largest: particle \
         {particle}, {}",
        estimate(reading.error.rms, "m"),
        estimate(reading.error.rms / BAND, "m"),
        estimate(reading.error.rms * BAND, "m"),
        share(reading.error.rms / size),
        estimate(error, "m")
    )
}

/// Formats a fraction, as a percentage unless that has many zeros.
fn share(part: f64) -> String {
    if part < 1e-5 { rounded(part, 2) } else { format!("{} %", rounded(100.0 * part, 2)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_study::live_error::LiveError;

    #[test]
    fn an_estimate_is_worded_in_units_that_read_well() {
        let error = LiveError { over: 0.5, at: 2.0, rms: 1.23e-3, ..LiveError::default() };
        let reading = ErrorReading { error, worst: (417, 4.5e-3) };
        assert_eq!(
            sentence(&reading, 4.0),
            "error over the last 0.5 s: 1.2 mm, likely 410 µm to 3.7 mm (0.031 % of the size); \
             largest: particle 417, 4.5 mm"
        );
        let error = LiveError { over: 0.5, rms: 1e-8, rounding: 1e-7, ..LiveError::default() };
        let small = ErrorReading { error, worst: (3, 2e-8) };
        assert!(sentence(&small, 4.0).contains("less than 100 nm"), "{}", sentence(&small, 4.0));
        let none = ErrorReading {
            error: LiveError { over: 0.5, ..LiveError::default() },
            worst: (0, 0.0),
        };
        assert!(sentence(&none, 4.0).contains("the same state"));
    }
}
