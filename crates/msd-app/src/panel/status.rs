//! The status line: pace, cost of a step, size of the scene, simulated time. And the main numbers
//! in short, below a panel that is longer than the window.

use super::live_error::is_fresh;
use super::{solver, theme};
use crate::session::{ErrorNow, Pace, Session};
use crate::viewer::Viewer;
use egui::{Color32, Frame, Label, Margin, Panel, RichText, ScrollArea, Ui};
use msd_core::{Energy, Integrator};
use msd_render::Quality;
use msd_run::Pierced;
use msd_study::quantity::{estimate, quantity};
use msd_study::space::Verdict;

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
        if let Some((text, colour, hover)) = wrong_energy(session) {
            item(text, colour, hover);
        }
        for (text, hover) in passed(session) {
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
        if viewer.quality == Quality::Fast {
            let hover = "There is no graphics processor: the processor draws, with hard shadows, \
                         without smoothed edges and without the grid on the ground, to keep up";
            item("no GPU: plain pictures".to_owned(), theme::FAINT, hover);
        }
        if viewer.sharpness.is_automatic() {
            let hover =
                "Drawing took longer than 1/20 s: \"Half resolution\" under Show turns it off";
            item("half resolution".to_owned(), theme::FAINT, hover);
        }
        if let Some(text) = errors(session) {
            let hover = "Errors of where the particles are. Time: of the last half a second, as \
                         estimated; space: of the spacing, by msd study --mesh";
            item(text, theme::TEXT, hover);
        }
        let runner = session.runner();
        let text = format!("{} particles", grouped(runner.particle_count()));
        item(text, theme::FAINT, "Particles");
        item(format!("{} springs", grouped(runner.spring_count())), theme::FAINT, "Springs");
        let text = format!("t = {:.2} s", runner.time());
        item(text, theme::TEXT, "Simulated time");
        item(format!("step {}", grouped(runner.steps() as usize)), theme::FAINT, "Steps so far");
    });
}

/// Failures of contact: bodies that may have crossed, surfaces that cross, and solids that went
/// through a surface.
fn passed(session: &Session) -> impl Iterator<Item = (String, &'static str)> {
    let passes = (0 < session.passes()).then(|| {
        let text = format!("bodies may have crossed {}", counted(session.passes(), "time"));
        let hover = "Since the start: bodies went through each other, or were too fast for msd to \
                     find all contacts. Shorten the step";
        (text, hover)
    });
    let went = session.runner().went_through().into_iter().map(|went| {
        let hover = "In one place or more, since the start. Shorten the step, or use a larger \
                     thickness";
        (format!("{went} at {:.2} s", went.time), hover)
    });
    let crossings = session.crossings().filter(|&crossings| 0 < crossings).map(|crossings| {
        let text = format!("{} of triangles cross", counted(crossings, "pair"));
        let hover = "Surfaces pass through each other, counted within the last second. Use more \
                     substeps, a larger thickness or a finer spacing";
        (text, hover)
    });
    let pierced = session.pierced().map(|Pierced { solid, body, time }| {
        let text = format!("solid {solid} went through body {body}");
        let hover = "Between particles: more substeps, a finer spacing, stiffer springs or a \
                     slower solid prevent that, or `springs = true` of a thin one in a scene file";
        (format!("{text} at {time:.2} s"), hover)
    });
    went.chain(passes).chain(crossings).chain(pierced)
}

/// What is wrong with the energy, if anything is, in what colour, and what to do.
fn wrong_energy(session: &Session) -> Option<(String, Color32, &'static str)> {
    if session.runner().contacts().squeezed {
        let hover = "Obstacles left particles no room: their energy means nothing; start again, or \
                     lift what closes on them";
        return Some(("squeezed between obstacles".to_owned(), theme::WARN, hover));
    }
    if session.energy_gain().is_some() {
        let hover = "The energy has grown although nothing supplied any: shorten the step or use \
                     another method";
        return Some(("the integrator is adding energy".to_owned(), theme::BAD, hover));
    }
    let change = session.unexplained_energy()?;
    let joules = estimate(change.abs(), "J");
    let integrator = session.runner().integrator();
    if 0.0 < change {
        let hover =
            "The energy balance does not close (dissipation overestimated): shorten the step";
        return Some((format!("the energy balance is {joules} too high"), theme::WARN, hover));
    }
    if matches!(integrator, Integrator::BackwardEuler | Integrator::Xpbd) {
        let hover = "This method damps motion by design, beside dampers and contact: less with \
                     more substeps";
        return Some((format!("{integrator} has damped {joules}"), theme::TEXT, hover));
    }
    let hover = "Energy is missing that no damper and no contact dissipated: shorten the step or \
                 use another method";
    Some((format!("{joules} of energy is missing"), theme::WARN, hover))
}

/// Contents that scroll; where they are longer than the room for them, the numbers stay in sight
/// below them.
pub(super) fn scrolled(ui: &mut Ui, viewer: &mut Viewer, show: impl FnOnce(&mut Ui, &mut Viewer)) {
    let room = ui.available_height();
    if viewer.is_folded {
        let frame = Frame::new().inner_margin(Margin { top: 5, ..Margin::ZERO });
        let panel = Panel::bottom("summary").resizable(false).frame(frame);
        panel.show(ui, |ui| main_numbers(ui, &viewer.session));
    } else {
        // As many as the panel takes: what is above keeps its name, and a drag goes on.
        ui.skip_ahead_auto_ids(1);
    }
    let area = ScrollArea::vertical().id_salt("right").auto_shrink([false, false]);
    let shown = super::scroll(ui, area, |ui| show(ui, viewer));
    let is_folded = room + 1.0 < shown.content_size.y;
    if is_folded != viewer.is_folded {
        viewer.is_folded = is_folded;
        ui.ctx().request_repaint();
    }
}

/// The stable substep, the error, the distance of the twin and the energy.
fn main_numbers(ui: &mut Ui, session: &Session) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let mut item = |text: String, colour| {
            // A name and its number stay together.
            ui.label(RichText::new(text.replace(' ', "\u{a0}")).small().color(colour));
        };
        if !session.runner().integrator().is_adaptive() {
            let (text, colour) = solver::light(session);
            item(format!("h {text}"), colour);
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
        let joules = |joules: Option<f64>| {
            joules.map_or(theme::VOID.to_owned(), |joules| estimate(joules, "J"))
        };
        let total = session.energy().map(|energy: Energy| energy.total());
        item(format!("energy {}", joules(total)), theme::TEXT);
        item(format!("wrong by {}", joules(session.energy_imbalance())), theme::TEXT);
        if let Some(gain) = session.energy_gain() {
            item(format!("integrator added {}", estimate(gain, "J")), theme::BAD);
        }
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

/// The errors of time and space that are known, in words.
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

/// So many things, in words.
fn counted(number: u64, thing: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {thing}{plural}", grouped(number as usize))
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
