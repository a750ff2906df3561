//! How wrong is it right now?

use crate::accuracy::Reading;
use crate::session::Session;
use crate::theme;
use crate::viewer::Viewer;
use egui::{Color32, RichText, Ui};
use msd_lab::on;
use msd_lab::trade::words::{metres, short};

/// How long an estimate counts as fresh, simulated seconds.
const FRESH: f64 = 4.0;

/// How it is estimated.
const METHOD: &str = "For half a second at a time a copy of the run goes along in double \
    precision, with twice the substeps (of an adaptive method: at a hundredth of the tolerance). \
    How far the two are apart at the end tells the error made in that time: step doubling. It \
    costs about three quarters of the run. docs/trade.md compares it with true errors.";

/// The switch, and the last estimate.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let session = &mut viewer.session;
    let mut on = session.accuracy().is_some();
    if ui.checkbox(&mut on, "Estimate error").on_hover_text(METHOD).changed() {
        session.set_estimating(on);
    }
    if let Some((text, colour)) = told(session) {
        ui.label(RichText::new(text).small().color(colour)).on_hover_text(METHOD);
    }
}

/// The estimate in words; nothing while none is asked for.
fn told(session: &Session) -> Option<(String, Color32)> {
    let accuracy = session.accuracy()?;
    let Some(last) = accuracy.last() else {
        let text = if accuracy.is_lost() {
            "no estimate: the finer copy blew up or gave up"
        } else {
            "measuring…"
        };
        return Some((text.to_owned(), theme::FAINT));
    };
    let size = on!(session.runner(), simulation => simulation.model().size());
    let colour = if is_fresh(session, last) { theme::TEXT } else { theme::FAINT };
    Some((sentence(last, size), colour))
}

/// Whether an estimate is of about now.
pub(super) fn is_fresh(session: &Session, reading: &Reading) -> bool {
    session.time() - reading.error.at <= FRESH
}

/// An estimate in words, for a scene of a size in metres.
fn sentence(reading: &Reading, size: f64) -> String {
    let (particle, error) = reading.worst;
    let over = seconds(reading.error.over);
    if error == 0.0 {
        // As of a scene at rest, or of an adaptive method whose substeps fill whole steps.
        return format!(
            "error over the last {over} s: none seen, the copy ended at the same place"
        );
    }
    format!(
        "error over the last {over} s: {} ({} of the size); worst particle {particle}: {}",
        metres(reading.error.rms),
        share(reading.error.rms / size),
        metres(error)
    )
}

/// A part of a whole, as a percentage while that has few zeros.
fn share(part: f64) -> String {
    if part < 1e-5 { short(part) } else { format!("{} %", short(100.0 * part)) }
}

/// A time with at most two digits after the point, where it has any there.
fn seconds(time: f64) -> String {
    if time < 0.01 { short(time) } else { ((100.0 * time).round() / 100.0).to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_lab::trade::estimate::LiveError;

    #[test]
    fn an_estimate_is_told_in_units_that_read_well() {
        let error = LiveError { over: 0.5, at: 2.0, rms: 1.23e-3, particles: vec![] };
        let reading = Reading { error, worst: (417, 4.5e-3) };
        assert_eq!(
            sentence(&reading, 4.0),
            "error over the last 0.5 s: 1.2 mm (0.031 % of the size); worst particle 417: 4.5 mm"
        );
        let none =
            Reading { error: LiveError { over: 0.5, ..LiveError::default() }, worst: (0, 0.0) };
        assert!(sentence(&none, 4.0).contains("none seen"));
        assert_eq!([0.125, 0.0025, 2.0].map(seconds), ["0.13", "0.0025", "2"]);
    }
}
