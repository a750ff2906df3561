//! The status line: pace, cost of a step, size of the scene, simulated time; and a summary below a
//! panel that is longer than the window.

use super::live_error::is_fresh;
use super::{energy, solver, theme};
use crate::session::{ErrorNow, Pace, Session};
use crate::viewer::Viewer;
use egui::{Color32, Frame, Label, Margin, Panel, RichText, ScrollArea, Ui};
use msd_core::Energy;
use msd_render::Quality;
use msd_run::Kind;
use msd_study::quantity::{estimate, quantity};
use msd_study::space::Verdict;

/// Shows the status line.
pub(super) fn show(ui: &mut Ui, viewer: &Viewer) {
    let session = &viewer.session;
    let pace = session.pace();
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 14.0;
        let mut item = |text: String, colour: Color32, hover: &str| {
            let label = Label::new(RichText::new(text).small().color(colour)).extend();
            ui.add(label).on_hover_text(hover);
        };
        let factor = pace.map(|pace| pace.real_time_factor);
        let (state, colour) = state(session.is_paused(), factor, session.speed());
        item(state, colour, "Simulated seconds per second");
        if let Some(pace) = pace
            && 0.05 <= pace.dropped
        {
            let text = format!("{:.1} s behind", pace.dropped);
            item(text, theme::WARN, "Simulated time dropped because the machine was busy");
        }
        let number = |decimals: usize, value: fn(&Pace) -> f64| {
            let text = |pace| format!("{:.decimals$}", value(&pace));
            pace.map_or(theme::VOID.to_owned(), text)
        };
        let text = format!("{} steps/frame", number(1, |pace| pace.steps_per_frame));
        item(text, theme::TEXT, "Steps per frame");
        let text = format!("{} ms/step", number(2, |pace| pace.step_ms));
        item(text, theme::TEXT, "Wall-clock time per step");
        let text = format!("{} frames/s", number(0, |pace| pace.frame_rate));
        item(text, theme::TEXT, "Frames per second");
        if viewer.quality == Quality::Fast {
            let hover = "No GPU: software rendering, with hard shadows, without anti-aliasing \
                         and ground grid";
            item("no GPU: reduced graphics".to_owned(), theme::FAINT, hover);
        }
        if viewer.sharpness.is_automatic() {
            let hover =
                "A frame took longer than 1/20 s: \"Half resolution\" under Show switches this off";
            item("half resolution".to_owned(), theme::FAINT, hover);
        }
        if let Some(text) = errors(session) {
            let hover = "Errors of the positions. Time: estimate over the last half second; \
                         space: error of the spacing, from msd study --mesh";
            item(text, theme::TEXT, hover);
        }
        let runner = session.runner();
        let text = format!("{} particles", grouped(runner.particle_count()));
        item(text, theme::FAINT, "Particles");
        item(format!("{} springs", grouped(runner.spring_count())), theme::FAINT, "Springs");
        let text = format!("t = {:.2} s", runner.time());
        item(text, theme::TEXT, "Simulated time");
        item(format!("step {}", grouped(runner.steps() as usize)), theme::FAINT, "Steps so far");
        findings(ui, session);
    });
}

/// Shows the findings in the run, with advice.
fn findings(ui: &mut Ui, session: &Session) {
    for finding in session.findings() {
        let colour = match finding.kind {
            Kind::EnergyAdded => theme::BAD,
            Kind::Damped => theme::TEXT,
            _ => theme::WARN,
        };
        let label = Label::new(RichText::new(finding.sentence()).small().color(colour)).wrap();
        let since = quantity(finding.since, "s");
        ui.add(label).on_hover_text(format!("Since {since}: {}", finding.advice()));
    }
}

/// Shows scrolling contents; if they do not fit, the main numbers stay visible below.
pub(super) fn scrolled(ui: &mut Ui, viewer: &mut Viewer, show: impl FnOnce(&mut Ui, &mut Viewer)) {
    let room = ui.available_height();
    if viewer.layout.is_folded {
        let frame = Frame::new().inner_margin(Margin { top: 5, ..Margin::ZERO });
        let panel = Panel::bottom("summary").resizable(false).frame(frame);
        panel.show(ui, |ui| main_numbers(ui, &viewer.session));
    } else {
        // As many ids as the panel takes: widgets above keep theirs, so that a drag continues.
        ui.skip_ahead_auto_ids(1);
    }
    let area = ScrollArea::vertical().id_salt("right").auto_shrink([false, false]);
    let shown = super::scroll(ui, area, |ui| show(ui, viewer));
    let is_folded = room + 1.0 < shown.content_size.y;
    if is_folded != viewer.layout.is_folded {
        viewer.layout.is_folded = is_folded;
        ui.ctx().request_repaint();
    }
}

/// Shows the stable substep, the error, the distance of the twin and the energy.
fn main_numbers(ui: &mut Ui, session: &Session) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let mut item = |text: String, colour| {
            // A name and its number stay on one line.
            ui.label(RichText::new(text.replace(' ', "\u{a0}")).small().color(colour));
        };
        if !session.runner().integrator().is_adaptive() {
            let (text, colour) = solver::light(session);
            item(format!("substep: {text}"), colour);
        }
        if let Some(error) = session.error() {
            item(format!("error {}", error_words(error)), theme::TEXT);
        }
        if let Some(twin) = session.twin() {
            let text = match twin.failure() {
                None => format!("twin {} apart", estimate(twin.apart().rms, "m")),
                Some(_) => "twin has stopped".to_owned(),
            };
            item(text, super::twin::GHOST);
        }
        // A graphics device does not measure what it dissipates.
        let joules = |joules: Option<f64>| match joules {
            Some(joules) if joules.is_nan() => "not measured".to_owned(),
            Some(joules) => estimate(joules, "J"),
            None => theme::VOID.to_owned(),
        };
        let total = session.energy().map(|energy: Energy| energy.total());
        item(format!("energy {}", joules(total)), theme::TEXT);
        item(format!("energy error {}", energy::imbalance(session)), theme::TEXT);
    });
}

fn error_words(error: ErrorNow<'_>) -> String {
    match error {
        ErrorNow::Measuring => theme::VOID.to_owned(),
        ErrorNow::Lost => "unknown".to_owned(),
        ErrorNow::Known(reading) if reading.error.rms <= reading.error.rounding => {
            format!("below {}", estimate(reading.error.rounding, "m"))
        }
        ErrorNow::Known(reading) => estimate(reading.error.rms, "m"),
    }
}

/// Describes the known errors of time and space.
fn errors(session: &Session) -> Option<String> {
    let time = match session.error() {
        Some(ErrorNow::Known(reading)) if is_fresh(session, reading) => {
            Some(format!("time {}", estimate(reading.error.rms, "m")))
        }
        _ => None,
    };
    let space = session.space().map(|space| {
        let over = quantity(space.duration, "s");
        match space.verdict {
            Verdict::Below { error } => format!("space below {} over {over}", estimate(error, "m")),
            _ => format!("space {} over {over}", estimate(space.error().unwrap_or(0.0), "m")),
        }
    });
    let known: Vec<String> = time.into_iter().chain(space).collect();
    (!known.is_empty()).then(|| format!("error: {}", known.join(", ")))
}

/// Describes the pace; a placeholder if it is not measured.
fn state(paused: bool, factor: Option<f64>, speed: f64) -> (String, Color32) {
    match factor {
        _ if paused => ("paused".to_owned(), theme::WARN),
        None => (format!("{} × real time", theme::VOID), theme::FAINT),
        // A tenth below the target is noise of the frame rate.
        Some(factor) => {
            let is_late = speed.is_finite() && factor < 0.9 * speed;
            let colour = if is_late { theme::WARN } else { theme::GOOD };
            (format!("{factor:.2} × real time"), colour)
        }
    }
}

/// Formats a number with narrow spaces between groups of three digits.
fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if 0 < place && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped_from_the_right() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(1000), "1\u{2009}000");
        assert_eq!(grouped(12_345_678), "12\u{2009}345\u{2009}678");
    }

    #[test]
    fn falling_behind_is_marked() {
        assert_eq!(state(false, Some(0.98), 1.0).1, theme::GOOD);
        assert_eq!(state(false, Some(0.5), 1.0).1, theme::WARN);
        assert_eq!(state(false, Some(0.1), 0.1).1, theme::GOOD);
        assert_eq!(state(false, None, 1.0), ("… × real time".to_owned(), theme::FAINT));
    }
}
