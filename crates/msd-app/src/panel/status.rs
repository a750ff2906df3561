//! The status line: pace, cost of a step, size of the scene, simulated time.

use super::theme;
use crate::session::Pace;
use crate::viewer::Viewer;
use egui::{Color32, Label, RichText, Ui};
use msd_study::quantity::estimate;

/// The status line.
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
            let text = format!("dropped {:.1} s", pace.dropped);
            item(text, theme::WARN, "Simulated time given up because the machine was busy");
        }
        if session.energy_gain().is_some() {
            let hover = "The energy has grown although nothing supplied any: shorten the step or \
                         use another method";
            item("the integrator is adding energy".to_owned(), theme::BAD, hover);
        } else if let Some(surplus) = session.energy_surplus() {
            let text = format!("the energy balance is {} too high", estimate(surplus, "J"));
            let hover = "Of what dampers and contact took, more is booked than was taken: shorten \
                         the step";
            item(text, theme::WARN, hover);
        }
        let number = |decimals: usize, value: fn(&Pace) -> f64| {
            let text = |pace| format!("{:.decimals$}", value(&pace));
            pace.map_or(theme::VOID.to_owned(), text)
        };
        let text = format!("{} steps/frame", number(1, |pace| pace.steps_per_frame));
        item(text, theme::TEXT, "Steps per picture");
        let text = format!("{} ms/step", number(2, |pace| pace.step_ms));
        item(text, theme::TEXT, "Wall clock for a step");
        let text = format!("{} frames/s", number(0, |pace| pace.frame_rate));
        item(text, theme::TEXT, "Pictures per second");
        let runner = session.runner();
        let text = format!("{} particles", grouped(runner.particle_count()));
        item(text, theme::FAINT, "Particles");
        item(format!("{} springs", grouped(runner.spring_count())), theme::FAINT, "Springs");
        let text = format!("t = {:.2} s", runner.time());
        item(text, theme::TEXT, "Simulated time");
        item(format!("step {}", grouped(runner.steps() as usize)), theme::FAINT, "Steps so far");
    });
}

/// The pace in words: nothing where it is not measured.
fn state(paused: bool, factor: Option<f64>, speed: f64) -> (String, Color32) {
    match factor {
        _ if paused => ("paused".to_owned(), theme::WARN),
        None => (format!("{} × real time", theme::VOID), theme::FAINT),
        // A tenth below what was asked for is noise of the frame rate.
        Some(factor) => {
            let is_late = speed.is_finite() && factor < 0.9 * speed;
            let colour = if is_late { theme::WARN } else { theme::GOOD };
            (format!("{factor:.2} × real time"), colour)
        }
    }
}

/// A number with narrow spaces between groups of three digits.
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
