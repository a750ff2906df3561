//! Effect and cost of each model term, with a switch for the terms that can change during a run.

use super::super::{heading, theme};
use super::small;
use crate::session::{Report, Session};
use egui::{Label, RichText, Ui};
use msd_scene::Precision;
use msd_scene::schema::SolverRow;
use msd_study::quantity::{estimate, rounded};
use msd_study::terms::TermRow;

/// Shows the terms, each with a switch, its effect and its cost.
pub(super) fn show(ui: &mut Ui, session: &mut Session) {
    heading(ui, "Model terms");
    session.look_at_parts();
    ui.spacing_mut().item_spacing.y = 2.0;
    let report = session.terms();
    let now = report.as_ref().and_then(|report| report.found.clone());
    let former = session.former_terms().filter(|_| now.is_none());
    let rows = now.as_ref().or(former.as_ref().map(|former| &former.rows));
    let worth_of =
        |term: &str| rows.and_then(|rows| rows.iter().find(|row| row.term == term)).map(worth);
    for (part, is_on) in session.parts().to_vec() {
        let price = if is_on { worth_of(part.name()) } else { Some("off".to_owned()) };
        if switch(ui, part.name(), is_on, (OFF_AND_ON, price)) {
            session.switch(part, !is_on);
        }
    }
    let is_double = session.runner().precision() == Precision::F64;
    let price = worth_of(if is_double { "double precision" } else { "single precision" });
    if switch(ui, "double precision", is_double, (PRECISION, price)) {
        let other = if is_double { Precision::F32 } else { Precision::F64 };
        session.tune(SolverRow::precision(other));
    }
    // This term cannot be switched during a run.
    if let Some(price) = worth_of(EACH_SPRING) {
        small(ui, &format!("{EACH_SPRING}: {price}"), theme::TEXT);
    }
    if let Some(former) = &former {
        small(ui, &format!("costs of the previous solver, {}", former.of), theme::WARN);
    }
    if now.is_none() {
        small(ui, &waiting(session, report.as_ref()), theme::FAINT);
    }
}

/// The term without a switch.
const EACH_SPRING: &str = "values of each spring";
const OFF_AND_ON: &str = "Switch the term off, or on with the values of scene and sliders. \
                          Switched-off springs stay in the run without stiffness and damping; to \
                          save their time, leave them out of the scene";
const PRICE: &str = "Without it, after the studied time: deviation of the particles, root mean \
                     square, and change of the time per step";
const PRECISION: &str = "Double precision, f64, or single, f32";

/// Shows a switch with the cost beside it; returns whether it was clicked.
fn switch(ui: &mut Ui, name: &str, is_on: bool, (hover, price): (&str, Option<String>)) -> bool {
    let mut on = is_on;
    let text = price.unwrap_or_else(|| theme::VOID.into());
    let text = RichText::new(text).small().color(theme::FAINT);
    // The cost is beside the switch if there is space.
    ui.horizontal_wrapped(|ui| {
        let is_clicked = ui.checkbox(&mut on, name).on_hover_text(hover).changed();
        ui.add(Label::new(text).extend()).on_hover_text(PRICE);
        is_clicked
    })
    .inner
}

/// Explains why there are no costs yet.
fn waiting(session: &Session, report: Option<&Report<Vec<TermRow>>>) -> String {
    match report {
        Some(Report { failure: Some(failure), .. }) => format!("no costs: {failure}"),
        _ if session.trade().is_paused() => "paused".into(),
        _ => "waiting for the first points, then switching off one term at a time…".into(),
    }
}

/// Describes effect and cost of a term: the deviation without it after the time of a study, root
/// mean square, and its share of a step.
fn worth(row: &TermRow) -> String {
    let (Some(change), Some(relative), Some(cost)) = (row.change, row.relative, row.cost_percent)
    else {
        return "without it the run fails".into();
    };
    let change = match change {
        0.0 => "nothing".to_owned(),
        _ => format!("{} ({} %)", estimate(change, "m"), rounded(100.0 * relative, 2)),
    };
    // Costs repeat to within one or two percent.
    let cost = match cost {
        cost if cost.abs() < 2.0 => "no time".to_owned(),
        cost if cost < 0.0 => format!("saves {:.0} %", -cost),
        cost => format!("{cost:.0} % of the time"),
    };
    format!("{change}; {cost}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_worth_an_effect_and_a_price() {
        let row = |change, cost_percent| TermRow {
            term: "damping".into(),
            change,
            worst: change,
            relative: change.map(|change| change / 2.0),
            cost_percent,
            words: String::new(),
        };
        assert_eq!(worth(&row(Some(0.02), Some(38.7))), "20 mm (1 %); 39 % of the time");
        assert_eq!(worth(&row(Some(0.0), Some(-1.0))), "nothing; no time");
        assert_eq!(worth(&row(Some(0.02), Some(-20.0))), "20 mm (1 %); saves 20 %");
        assert_eq!(worth(&row(None, None)), "without it the run fails");
    }
}
