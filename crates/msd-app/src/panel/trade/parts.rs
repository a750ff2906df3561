//! The worth of each part of the scene: how much it changes the answer and what it costs, with a
//! switch where the session can switch it off.

use super::super::{heading, theme};
use super::small;
use crate::session::{MaterialEdit, STUDY_DURATION, Session, Tuning};
use egui::{Checkbox, RichText, Ui};
use msd_scene::Precision;
use msd_study::quantity::{estimate, rounded};
use msd_study::terms::TermRow;

/// The parts, each with its effect and its price.
pub(super) fn show(ui: &mut Ui, session: &mut Session) {
    heading(ui, "What matters here");
    switches(ui, session);
    let Some(report) = session.terms() else { return small(ui, theme::VOID, theme::FAINT) };
    if let Some(failure) = &report.failure {
        return small(ui, &format!("cannot be told: {failure}"), theme::FAINT);
    }
    let Some(rows) = report.found else {
        let text = if session.trade().is_paused() {
            "resting"
        } else {
            "switching off one part at a time, after the first points…"
        };
        return small(ui, text, theme::FAINT);
    };
    let hover = format!(
        "Without it, after {} s: how far the particles are from where they would be, root mean \
         square, and how much less time a step takes",
        rounded(STUDY_DURATION, 2)
    );
    for row in rows.iter() {
        let text = format!("{}: {}", row.term, worth(row));
        ui.label(RichText::new(text).small()).on_hover_text(&hover);
    }
}

/// Effect and price of a part, in words.
fn worth(row: &TermRow) -> String {
    let (Some(change), Some(relative), Some(cost)) = (row.change, row.relative, row.cost_percent)
    else {
        return "without it the run fails".into();
    };
    let change = match change {
        0.0 => "nothing".to_owned(),
        _ => format!("{} ({} %)", estimate(change, "m"), rounded(100.0 * relative, 2)),
    };
    // Costs of a run repeat within one or two percent.
    let cost = match cost {
        cost if cost.abs() < 2.0 => "no time".to_owned(),
        cost if cost < 0.0 => format!("{:.0} % less than without", -cost),
        cost => format!("{cost:.0} % of the time"),
    };
    format!("{change}; {cost}")
}

/// The switches of what can be switched off while it runs.
fn switches(ui: &mut Ui, session: &mut Session) {
    let scene = &session.loaded().scene;
    let damping = scene.springs.first().map_or(0.0, |spring| spring.damping);
    let is_uniform = scene.springs.iter().all(|spring| spring.damping == damping);
    let gravity = scene.world.gravity.length();
    let shown = *session.material().values();
    ui.horizontal(|ui| {
        if let Some(now) = shown.damping
            && (now.first != 0.0 || damping != 0.0)
        {
            let mut on = now.first != 0.0 || now.mixed;
            // What differs from spring to spring could not be given back.
            let can = !now.mixed && is_uniform;
            let hover = "Off, or as the scene has it";
            if ui.add_enabled(can, Checkbox::new(&mut on, "Damping")).on_hover_text(hover).changed()
            {
                session.edit(MaterialEdit::Damping(if on { damping } else { 0.0 }));
            }
        }
        if shown.gravity != 0.0 || gravity != 0.0 {
            let mut on = shown.gravity != 0.0;
            let hover = "Off, or as the scene has it";
            if ui.checkbox(&mut on, "Weight").on_hover_text(hover).changed() {
                session.edit(MaterialEdit::Gravity(if on { gravity } else { 0.0 }));
            }
        }
        let mut on = session.runner().precision() == Precision::F64;
        let hover = "Double precision, f64, or single, f32";
        if ui.checkbox(&mut on, "Double").on_hover_text(hover).changed() {
            let precision = if on { Precision::F64 } else { Precision::F32 };
            session.tune(Tuning::Precision(precision));
        }
    });
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
        assert_eq!(worth(&row(Some(0.02), Some(-20.0))), "20 mm (1 %); 20 % less than without");
        assert_eq!(worth(&row(None, None)), "without it the run fails");
    }
}
