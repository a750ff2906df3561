//! The timeline under the view: undo, and a slider over the recent states, with marks.

use super::theme;
use crate::session::{Mark, MarkKind};
use crate::viewer::{Command, Viewer};
use egui::{Button, Color32, Rect, RichText, Slider, Stroke, Ui, pos2, vec2};
use msd_study::quantity::quantity;

/// Shows undo, the slider over the earlier states, and its position.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    ui.horizontal(|ui| {
        undo(ui, viewer);
        let session = &viewer.session;
        let (back, ahead) = (session.steps_back(), session.steps_ahead());
        let settings = session.runner().settings();
        let behind = ahead as f64 * settings.step;
        let text = match ahead {
            0 => "now".to_owned(),
            _ => format!("{} ago; resume from here", quantity(-behind, "s").replace('-', "")),
        };
        ui.spacing_mut().slider_width = (ui.available_width() - 190.0).max(60.0);
        let mut at = -(ahead as i64);
        let whole = -((back + ahead).max(1) as i64);
        let slider = Slider::new(&mut at, whole..=0).show_value(false);
        let hover = "Drag to look back; resuming drops the later states. Marks: impacts blue, \
                     warnings red, your edits yellow";
        let shown = ui.add_enabled(0 < back + ahead, slider);
        let shown = shown.on_hover_text(hover).on_disabled_hover_text(hover);
        shown.widget_info(|| egui::WidgetInfo::slider(true, at as f64, "Timeline"));
        viewer.layout.landmarks.insert("timeline", shown.rect);
        let marks: Vec<Mark> = session.marks().collect();
        let latest = session.runner().steps() + ahead as u64;
        draw(ui, shown.rect, &marks, (latest, whole.unsigned_abs()));
        if shown.changed() {
            viewer.look_back(at.unsigned_abs() as usize);
        }
        ui.label(RichText::new(text).small().color(theme::FAINT));
    });
}

fn undo(ui: &mut Ui, viewer: &mut Viewer) {
    let (last, next) = (viewer.session.undoes(), viewer.session.redoes());
    let buttons =
        [("Undo", last, "Ctrl+Z", Command::Undo), ("Redo", next, "Ctrl+Shift+Z", Command::Redo)];
    for (name, deed, key, command) in buttons {
        let what = deed.map_or(String::new(), |deed| format!(": {}", deed.words()));
        let button = Button::new(name);
        let button = if viewer.layout.by_touch { button } else { button.small() };
        let button = ui.add_enabled(deed.is_some(), button);
        if button.on_hover_text(format!("{name}{what} ({key})")).clicked() {
            viewer.command(command);
        }
    }
}

/// Draws the marks on a slider with its left end `whole` steps before the latest.
fn draw(ui: &Ui, rect: Rect, marks: &[Mark], (latest, whole): (u64, u64)) {
    let painter = ui.painter();
    // The handle stays inside the slider by its own radius.
    let track = rect.shrink2(vec2(0.4 * rect.height(), 0.0));
    for mark in marks {
        let Some(back) = latest.checked_sub(mark.step).filter(|&back| back <= whole) else {
            continue;
        };
        let share = 1.0 - back as f32 / whole as f32;
        let x = egui::lerp(track.x_range(), share);
        let ends = [pos2(x, rect.top()), pos2(x, rect.top() + 5.0)];
        painter.line_segment(ends, Stroke::new(2.0, colour(mark.kind)));
    }
}

fn colour(kind: MarkKind) -> Color32 {
    match kind {
        MarkKind::Impact => theme::ACCENT,
        MarkKind::Warning => theme::BAD,
        MarkKind::Edit => theme::WARN,
    }
}
