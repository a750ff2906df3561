//! The box over a diverged run: cause and recovery options.

use crate::panel::{solver, theme};
use crate::session::Session;
use crate::viewer::Viewer;
use egui::{Align2, Area, Frame, Order, RichText, Ui, pos2};
use msd_run::rescue::{LASTING, Offer, Origin, Remedy};
use msd_study::quantity::{estimate, quantity, rounded};

/// Shows the cause, the substep relative to the limit, and the recovery options.
pub(super) fn show(ui: &Ui, viewer: &mut Viewer) {
    viewer.layout.landmarks.remove("way out");
    let Some(failure) = viewer.session.failure().cloned() else { return };
    let at = pos2(viewer.layout.rect.center().x, viewer.layout.rect.top() + 16.0);
    let width = (viewer.layout.rect.width() - 80.0).clamp(200.0, 560.0);
    let area = Area::new(egui::Id::unique("failure")).order(Order::Foreground).fixed_pos(at);
    area.pivot(Align2::CENTER_TOP).show(ui.ctx(), |ui| {
        let frame = Frame::popup(ui.style()).fill(theme::ALARM).inner_margin(12.0);
        frame.show(ui, |ui| {
            ui.set_width(width);
            let adaptive = viewer.session.runner().integrator().is_adaptive();
            let what = if adaptive { "cannot continue" } else { "blew up" };
            ui.label(RichText::new(format!("The simulation {what} and is paused")).strong());
            ui.label(RichText::new(failure.text).color(theme::TEXT));
            if !adaptive {
                limit(ui, &viewer.session);
            }
            offers(ui, viewer);
        });
    });
}

/// Shows the substep and the limit, as in the panel.
fn limit(ui: &mut Ui, session: &Session) {
    let substep = quantity(session.runner().settings().substep(), "s");
    let (text, colour) = solver::light(session);
    let marked = if session.fastest_springs().is_empty() {
        ""
    } else {
        ". The fastest springs are highlighted."
    };
    let text = format!("Substep {substep}: {text}{marked}");
    ui.label(RichText::new(text).color(colour));
}

/// Shows a button for each recovery option.
fn offers(ui: &mut Ui, viewer: &mut Viewer) {
    let offers = viewer.session.offers().to_vec();
    let mut chosen = None;
    ui.horizontal_wrapped(|ui| {
        for &offer in &offers {
            let button = ui.button(title(&viewer.session, &offer));
            viewer.layout.landmarks.entry("way out").or_insert(button.rect);
            if button.on_hover_text(explanation(&offer)).clicked() {
                chosen = Some(offer);
            }
        }
    });
    if let Some(offer) = chosen {
        viewer.take(offer);
    } else if viewer.session.is_searching() {
        ui.label(RichText::new("trying recovery options…").color(theme::FAINT));
    } else if offers.is_empty() {
        let text = "No recovery option found: check for a force, a speed or a stiffness that is \
                    too large, or open a scene again";
        ui.label(RichText::new(text).color(theme::FAINT));
    }
}

/// Returns the label of a button.
fn title(session: &Session, offer: &Offer) -> String {
    let what = match offer.remedy {
        Remedy::Back => format!("Back {}", estimate(session.way_back(), "s")),
        Remedy::Substeps(substeps) => format!("{substeps} substeps"),
        Remedy::Tolerance(tolerance) => format!("Tolerance {}", rounded(tolerance, 2)),
        Remedy::Method(method, substeps) => {
            let more = substeps != session.runner().settings().substeps;
            let more = if more { format!(", {substeps} substeps") } else { String::new() };
            method.name().to_owned() + &more
        }
        Remedy::SceneValues => "Reset to the scene's values".to_owned(),
    };
    let price = offer.cost.filter(|_| offer.remedy != Remedy::Back).map(price);
    what + &price.unwrap_or_default() + if offer.is_tried { "" } else { ", predicted" }
}

/// Formats the cost of an option, seconds of work per simulated second: an absolute one, as there
/// is no valid cost of the diverged run.
fn price(cost: f64) -> String {
    let share = rounded(100.0 * cost, 2);
    let late = if cost <= 1.0 { "" } else { ": slower than real time" };
    format!(" ({share} % of real time{late})")
}

/// Explains an option, and whether it was tried.
fn explanation(offer: &Offer) -> String {
    let what = match offer.remedy {
        Remedy::Back => "Earlier state, current settings",
        Remedy::Substeps(_) => "Current method, more substeps",
        Remedy::Tolerance(_) => "Current method, achievable tolerance",
        Remedy::Method(..) => "Another method, with the substeps it needs",
        Remedy::SceneValues => "Solver, material and world of the scene",
    };
    let from = match offer.origin {
        Origin::Start | Origin::Scene => "restarts",
        Origin::Here | Origin::Earlier => "resumes",
    };
    let sure = if offer.is_tried {
        format!("A trial of {} was stable.", quantity(LASTING, "s"))
    } else {
        "Predicted to be stable; a trial took too long.".to_owned()
    };
    format!("{what}; {from}. {sure}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_price_names_what_it_is_a_part_of_and_what_is_too_slow_says_so() {
        assert_eq!(price(0.13), " (13 % of real time)");
        assert_eq!(price(1.8), " (180 % of real time: slower than real time)");
    }
}
